"""The contact forces of a cell from its motion in time, and what `explain` makes of them."""

import math
import sys

import numpy as np
import pytest
from messages import assert_facts

import sweep
from kernels.disk.endings import BOUNDED, FELL, HORIZON, UNRESOLVED
from sweep.checks import explain as explaining
from sweep.checks.explain import explain
from sweep.cli import main
from sweep.engine.compute import compute
from sweep.motion.contact import contact_in_time

pytestmark = pytest.mark.compiled

SPEC = sweep.SweepSpec(contact="yes", duration=100.0)
START = {"tilt": 0.0, "tilt_rate": 0.0, "precession_rate": 0.0, "roll_rate": 0.0}
DISK = {"alpha": 0.5, "radius": 0.5, "gravity": 9.81}


#: Changes of the start, the duration, and the ending.
CELLS = (
    ({"tilt": 0.06, "roll_rate": 3.2875}, 100.0, BOUNDED),
    # Past the saddle from which it was kicked, a motion in time might take the wrong side.
    ({"tilt_rate": 1e-7, "roll_rate": 2.0}, 100.0, BOUNDED),
    ({"tilt": 0.8, "tilt_rate": -1.5, "precession_rate": 0.3}, 100.0, FELL),
    ({"tilt": 0.5, "tilt_rate": 30.0}, 100.0, FELL),
)


def test_the_motion_in_time_has_the_forces_of_the_cell():
    """Bounded and falling cells agree with it within its stated error."""
    for changed, duration, ending in CELLS:
        spec, start = SPEC.replace(duration=duration), {**START, **DISK, **changed}
        cell = compute(spec, {name: np.array([value]) for name, value in start.items()})
        stored = {name: float(values[0]) for name, values in cell.items()}
        assert stored["ending"] == ending, changed
        found = contact_in_time(spec, start, stored)
        assert set(found) == {"least_normal_force", "friction_needed"}, changed
        for name, (value, error) in found.items():
            assert value == pytest.approx(stored[name], rel=1e-9, abs=1e-9, nan_ok=True), changed
            assert math.isnan(value) or error < 1e-4, changed
        assert math.isnan(found["friction_needed"][0]) == (stored["least_normal_force"] <= 0.0), changed
    assert contact_in_time(spec, start, {**stored, "ending": float(HORIZON)}) == {}


def test_where_there_is_no_motion_there_is_nothing_to_follow():
    """Cells without a motion, starts that have already fallen, and atlases without forces have none."""
    start = {**START, **DISK}
    assert contact_in_time(SPEC, start, {"ending": UNRESOLVED}) == {}
    assert contact_in_time(SPEC, start, {"ending": FELL, "fall_time": 0.0}) == {}
    assert contact_in_time(SPEC.replace(contact="no"), start, {"ending": HORIZON}) == {}


def test_an_explanation_holds_the_forces_against_the_motion_in_time(monkeypatch, tmp_path):
    """A wrong force is reported and changes the exit status, even if a new run repeats it bit for bit."""
    atlas = sweep.run(SPEC.replace(tilt=0.06, roll_rate=3.2875))
    found = explain(atlas, {})
    assert found.confirmed
    assert_facts(found.text, "no stored value contradicts")
    assert "contact_state     presses" in found.text

    def wrong(spec, starts):
        columns = compute(spec, starts)
        return {**columns, "friction_needed": columns["friction_needed"] * 1.03}

    monkeypatch.setattr(explaining, "compute", wrong)
    changed = atlas.assign(friction_needed=atlas["friction_needed"] * 1.03)
    sweep.save(changed, tmp_path / "changed.nc")
    monkeypatch.setattr(sys, "argv", ["eulerdisk", "explain", str(tmp_path / "changed.nc")])
    with pytest.raises(SystemExit) as caught:
        main()
    assert caught.value.code == 1
    found = explain(changed, {})
    assert found.repeated
    assert not found.confirmed
    assert_facts(found.text, "friction_needed", "DIFFER")
    monkeypatch.undo()
    found = explain(sweep.run(SPEC.replace(tilt=0.06, roll_rate=3.2875, contact="no")), {})
    assert found.confirmed
    assert "in time" not in found.text


@pytest.mark.parametrize("words", [{}, {"body": "torus", "tube": 0.2}, {"contour_friction": "1mm"}])
def test_forces_are_those_that_accelerate_the_centre_of_mass(words):
    """Second differences of its path (up, along and across the heading) satisfy Newton's law."""
    start = {"tilt": "5deg", "precession_rate": 1.0, "roll_rate": 5.0, "tilt_rate": 0.2}
    motion = sweep.simulate(**start, **words, duration="1s", interval="1ms", mass="2kg")
    path = np.stack([motion[f"centre_{axis}"].values for axis in "xyz"])
    step = float(motion["elapsed_time"][1])
    x, y, z = 2.0 * np.diff(path, 2) / step**2
    sine, cosine = np.sin(motion["heading"].values[1:-1]), np.cos(motion["heading"].values[1:-1])
    expected = {"friction_across": x * cosine + y * sine, "friction_along": y * cosine - x * sine,
                "normal_force": z + 2.0 * 9.81}  # fmt: skip
    for name, values in expected.items():
        assert motion[name].values[1:-1] == pytest.approx(values, abs=2e-4), name
    assert all(np.ptp(values) > 0.1 for values in expected.values())
