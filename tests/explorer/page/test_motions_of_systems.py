"""The page's motions of a user's system compared with SciPy's DOP853."""

from pathlib import Path

import numpy as np
import pytest
from explorer_client import post
from messages import assert_facts
from scipy.integrate import solve_ivp

import sweep
from sweep.explorer.about import sides
from sweep.request.spec import SweepSpec

from .asking import Refused, ask

pytestmark = pytest.mark.slow_lane

#: Lorenz's equations, which end if z is too high, and a state that may diverge.
LORENZ = """
from sweep.systems import system


@system(duration=60, ends={"too_high": "z > top"}, stable="runs on")
def lorenz(x=1.0, y=1.0, z=1.0, width=1.0, *, rho=28.0, top=1000.0, growth=0.0):
    return 10*(y - x), x*(rho - z) - y, x*y - 8/3*z, growth*width**2
"""


def rates(_, state, rho):
    """Return the rates of x, y and z."""
    x, y, z = state
    return 10 * (y - x), x * (rho - z) - y, x * y - 8 / 3 * z


@pytest.fixture
def lorenz(tmp_path, monkeypatch):
    """Return the spec of the system, in its own folder."""
    monkeypatch.chdir(tmp_path)
    Path("lorenz.py").write_text(LORENZ, encoding="utf-8")
    return SweepSpec.read("lorenz.py", rho="0.5:30:3", top="20:1000:3")


def test_a_motion_is_that_of_scipy(lorenz, served_with, opened):
    """Known states agree to 1e-6 with SciPy; ending and loss of accuracy are at the right times."""
    explorer = served_with("lorenz.py")
    page = opened(explorer.url)
    view = {**sides(lorenz), "base": "", "words": {}}
    assert (view["x"]["name"], view["y"]["name"]) == ("top", "rho")

    def motion(rho, top, **words):
        return ask(page, "motion", view={**view, "words": words}, x=top, y=rho, losses={})

    head, samples = motion(28.0, 40.0)
    times = samples["time"]
    solved = solve_ivp(
        rates, (0.0, times[-1]), [1.0, 1.0, 1.0], "DOP853", times, args=(28.0,), rtol=1e-12, atol=1e-12
    )
    assert head["ended"]
    assert_facts(head["ending"], "too high")
    assert times.size > 200
    for name, values in zip("xyz", solved.y, strict=True):
        assert np.abs(samples[name] - values).max() < 1e-6
    assert samples["z"][-1] == pytest.approx(40.0, abs=1e-9)
    assert head["doubtful"] is None
    assert head["note"] == ""

    head, samples = motion(0.5, 1000.0)
    assert (head["ended"], head["doubtful"], samples["time"][-1]) == (False, None, 60.0)
    assert abs(samples["x"][-1]) < 1e-9

    # numbers with sixteen digits diverge after about 35 s, when exp(0.9 t) is 1e14
    head, samples = motion(28.0, 1000.0)
    program = sweep.simulate("lorenz.py", rho=28.0, top=1000.0)
    assert not head["ended"]
    assert 25.0 < head["doubtful"] < 40.0
    assert head["doubtful"] == pytest.approx(float(program["sensitive_from"]), abs=1.0)

    with pytest.raises(Refused):
        motion(28.0, 0.5)
    with pytest.raises(Refused) as refused:
        motion(28.0, 1000.0, growth=1.0)
    assert_facts(str(refused.value), "1")

    copied = post(explorer.url, "command", view=view, x=40.0, y=28.0, losses={})
    assert_facts(copied["command"], "eulerdisk simulate lorenz.py", "top=40.0")
    made = {}
    exec(copied["python"].replace("motion.eulerdisk.plot()", ""), made)
    assert float(made["motion"].end_time) == pytest.approx(times[-1], abs=1e-8)
