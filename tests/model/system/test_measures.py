"""Counts, moments, means and integrals compared with closed forms, a fine scan and quadrature; what is undecided."""

import re
from itertools import product

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

import sweep
from sweep.checks.explain import explain
from sweep.checks.verify import findings
from sweep.model.quantity import STABLE, UNDECIDED, UNKNOWN_ERROR, UNSTABLE
from sweep.model.system import sample
from sweep.model.system.model import model_of
from sweep.request.system_file import read_system

OSCILLATOR = """
@system(duration="20 s", stable="turns > 1", measures={
    "turns": "count x > 0.3 m", "began": "time of first x > 0.3 m", "settled": "time of last abs(x) < 0.1 m",
    "pace": "value of v at first x > 0.3 m", "upward": "count x > 0 m and v > 0.2 m/s",
    "power": "mean damping*v**2", "path": "integral x", "when": "time of max x", "lowest": "time of min x",
})
def oscillator(x: "m" = 1.0, v: "m/s" = 0.3, *, damping: "1/s" = 0.05, stiffness: "1/s2" = 1.0):
    return v, -stiffness*x - 2*damping*v
"""
#: A pendulum that is driven into chaos, and one that swings as far as it began.
PENDULUM = """
@system(duration="100", measures={"turns": "count angle > 1", "began": "time of first angle > 1",
    "ended": "time of last angle > 1", "when": "time of max angle"})
def pendulum(angle=1.0, speed=0.0, *, torque=0.0, t):
    return speed, torque*cos(2*t/3) - speed*torque/3 - sin(angle)
"""


@pytest.fixture(scope="module")
def atlas():
    """Return an atlas of oscillators, some of which grow."""
    spec = sweep.SweepSpec(model=model_of(read_system(OSCILLATOR)), x="-1 m:1 m:12", damping="-0.05:0.1:13")
    return sweep.run(spec)


def closed_form(x, damping):
    """Return position and speed of an oscillator as functions of time."""
    own = np.sqrt(1.0 - damping**2)
    b = (0.3 + damping * x) / own

    def position(t):
        return np.exp(-damping * t) * (x * np.cos(own * t) + b * np.sin(own * t))

    def speed(t):
        return -damping * position(t) + np.exp(-damping * t) * own * (
            b * np.cos(own * t) - x * np.sin(own * t)
        )

    return position, speed


def test_counts_and_moments_of_a_fine_scan(atlas):
    """Counts are those of a scan of the closed form; times and values agree with its interpolation."""
    times = np.linspace(0.0, 20.0, 40_001)
    step = times[1]
    for x, damping in product(atlas["x"].values, atlas["damping"].values[::3]):
        cell = atlas.sel(x=x, damping=damping)
        position, speed = (function(times) for function in closed_form(x, damping))
        rises = {}
        for name, level in (
            ("turns", position - 0.3), ("settled", 0.1 - np.abs(position)),
            ("upward", np.minimum(position, speed - 0.2)),
        ):  # fmt: skip
            before = np.flatnonzero((level[1:] > 0.0) & (level[:-1] <= 0.0))
            rises[name] = times[before] - step * level[before] / (level[before + 1] - level[before])
        assert cell["turns"] == rises["turns"].size
        assert cell["upward"] == rises["upward"].size
        if rises["turns"].size:
            first = rises["turns"][0]
            assert cell["began"] == pytest.approx(first, abs=1e-6)
            assert cell["pace"] == pytest.approx(closed_form(x, damping)[1](first), abs=1e-6)
        else:
            assert np.isnan([cell["began"], cell["began_error"], cell["pace"], cell["pace_error"]]).all()
        assert cell["settled"] == pytest.approx(rises["settled"][-1], abs=1e-6)
        for name, place in (("when", position.argmax()), ("lowest", position.argmin())):
            if cell[f"{name}_error"] < UNKNOWN_ERROR:
                assert cell[name] == pytest.approx(times[place], abs=step)


def test_a_mean_and_an_integral_of_quadrature(atlas):
    """They agree with SciPy's quadrature of the closed form, within their stated errors and its own."""
    for x in atlas["x"].values[::3]:
        for damping in atlas["damping"].values[::4]:
            cell, (position, speed) = atlas.sel(x=x, damping=damping), closed_form(x, damping)
            for name, integrand, share in (
                ("power", lambda t, d=damping, v=speed: d * v(t) ** 2, 1.0 / 20.0), ("path", position, 1.0)
            ):  # fmt: skip
                parts = [quad(integrand, k, k + 1, epsabs=1e-12, epsrel=1e-12) for k in range(20)]
                truth, off = np.sum(parts, axis=0)
                room = share * off + 2.0 * float(cell[f"{name}_error"]) + 1e-13
                assert abs(float(cell[name]) - share * truth) <= room, (name, x, damping)
                assert cell[f"{name}_error"] < 1e-10


def test_units_in_files(atlas):
    """A count has none, a time the second, an integral its unit times the second."""
    units = {name: atlas[name].attrs["units"] for name in ("turns", "began", "pace", "power", "path")}
    assert units == {"turns": "1", "began": "s", "pace": "m s-1", "power": "m2 s-3", "path": "m s"}


def test_verdicts_on_counts(atlas):
    """A criterion on a count is decided where the count is."""
    turns = atlas["turns"].values
    assert np.all(atlas["turns_error"] == 0.0)
    assert np.array_equal(atlas["stability"].values, np.where(turns > 1.0, STABLE, UNSTABLE))
    assert {STABLE, UNSTABLE} <= set(atlas["stability"].values.ravel().tolist())


def test_a_comparison_with_a_missing_time_is_false(atlas):
    """What never happened is neither before nor after a time; this is decided."""
    for text in ("began > 3 s", "began < 3 s"):
        judged = sweep.reclassify(atlas, text)
        never = np.isnan(atlas["began"].values)
        assert never.any()
        assert np.all(judged["stability"].values[never] == STABLE)


def pendulum(**words):
    """Return an atlas of pendulums."""
    return sweep.run(sweep.SweepSpec(model=model_of(read_system(PENDULUM)), **words))


def test_a_motion_that_returns_to_the_limit_is_undecided():
    """Each return to the angle at the start may or may not pass it by rounding: nothing of it is decided."""
    atlas = pendulum(angle="0.8:1.2:5")
    for name in ("turns", "began", "ended"):
        undecided = atlas[f"{name}_error"].values == UNKNOWN_ERROR
        assert list(undecided) == [False, False, True, False, False], name
    assert re.search(r"turns_error +undecided", explain(atlas, {"angle": 1.0}).text)
    assert re.search(r"turns_error +0 ", explain(atlas, {"angle": 0.8}).text)
    assert np.isfinite(atlas["began"].values[2:]).all()
    assert np.isnan(atlas["began"].values[:2]).all()
    assert list(atlas["turns"].values[:2]) == [0.0, 0.0]
    # one turn each period, and the last one may come within the duration
    assert np.all(np.abs(atlas["turns"].values[3:] - 14.0) <= 1.0)
    # all maxima are as great as the first one
    assert np.all(atlas["when_error"] == UNKNOWN_ERROR)
    judged = sweep.reclassify(atlas, "turns > 3")
    assert list(judged["stability"].values) == [STABLE, STABLE, UNDECIDED, UNSTABLE, UNSTABLE]


@pytest.mark.slow_lane
def test_what_is_decided_in_chaos():
    """Counts of sensitive motions are undecided; a first time before chaos is known, and right."""
    atlas = pendulum(angle="0:0.9:40", torque=1.5, duration=200.0)
    sensitive = atlas["ending"].values == 2
    assert sensitive.mean() > 0.5
    assert np.all(atlas["turns_error"].values[sensitive] == UNKNOWN_ERROR)
    assert np.all(atlas["ended_error"].values[sensitive] == UNKNOWN_ERROR)
    known = atlas["began_error"].values < UNKNOWN_ERROR
    assert known.mean() > 0.9
    for angle, time, error in zip(
        atlas["angle"].values[known],
        atlas["began"].values[known],
        atlas["began_error"].values[known],
        strict=True,
    ):

        def rates(t, y):
            return [y[1], 1.5 * np.cos(2 * t / 3) - y[1] / 2 - np.sin(y[0])]

        def above(t, y):
            return y[0] - 1.0

        above.direction = 1.0
        solved = solve_ivp(
            rates, (0.0, time + 1.0), [angle, 0.0], "DOP853", rtol=1e-12, atol=1e-13, events=above
        )
        assert solved.t_events[0][0] == pytest.approx(time, abs=1e-9 + float(error))


@pytest.mark.slow_lane
def test_verify_follows_all_of_them(monkeypatch):
    """DOP853 has the same counts, times, values, means and integrals, and finds each change of one of them."""
    monkeypatch.setattr(sample, "SECONDS", np.inf)
    model = model_of(read_system(OSCILLATOR))
    atlas = sweep.run(sweep.SweepSpec(model=model, x="-1 m:1 m:6", damping="-0.05:0.1:4"))
    assert findings(sweep.verify(atlas, seed=1)).passed
    place = {"x": 4, "damping": 2}
    for name, change in {
        "turns": lambda value: value + 1.0, "upward": lambda value: value - 1.0, "began": lambda value: value + 1e-7,
        "settled": lambda value: value - 3.0, "pace": lambda value: -value, "power": lambda value: value * 1.00001,
        "path": lambda value: value + 1e-6, "when": lambda value: value + 1e-6, "lowest": lambda value: np.nan,
    }.items():  # fmt: skip
        changed = atlas.copy(deep=True)
        # as if other code had computed it: its cells are not computed again
        changed.attrs["kernel_hash"] = "0" * 64
        changed[name][place] = change(float(changed[name].isel(place)))
        if name == "lowest":
            # both are missing where nothing happened
            changed[f"{name}_error"][place] = np.nan
        found = findings(sweep.verify(changed, seed=1))
        assert not found.passed, name
        assert name in {each.name for each in found.statements if each.wrong}
