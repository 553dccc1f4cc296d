import math

import kernel_runner
import numpy as np
import pytest
import referee
from hypothesis import given, settings
from hypothesis import strategies as st
from kernel_runner import coarse, errors, scattered

from kernels.disk.arrays import PARAMETERS, STATE
from kernels.disk.endings import BOUNDED, FELL, HORIZON, INVALID, STEADY, UNRESOLVED
from kernels.disk.steady import steady_roll_rate
from kernels.lanes.schedule import CHUNK

compiled = pytest.mark.compiled
FALL = referee.FALL_TILT


# --- endings --------------------------------------------------------------------------------------------------------

ENDED = {
    "a rolling disk turns": (BOUNDED, {"tilt": 0.3, "tilt_rate": 0.2, "roll_rate": 3.0}, {}),
    "a released disk turns": (BOUNDED, {"tilt": 0.3, "roll_rate": 4.0}, {}),
    "upright at rest": (STEADY, {}, {}),
    "upright and rolling": (STEADY, {"roll_rate": 1.0}, {}),
    "upright and spinning": (STEADY, {"precession_rate": 1.0}, {}),
    "a disk circles": (
        STEADY,
        {"tilt": 0.3, "precession_rate": 1.1, "roll_rate": steady_roll_rate(0.3, 1.1, 0.5, 0.5, 9.81)},
        {},
    ),
    "time runs out": (HORIZON, {"tilt": 0.3, "roll_rate": 4.0}, {"duration": 0.1}),
    "a disk at rest falls": (FELL, {"tilt": 0.3}, {}),
    "a disk is thrown down": (FELL, {"tilt": 0.3, "tilt_rate": -9.0}, {}),
    "beyond fall_tilt": (FELL, {"tilt": 1.5}, {}),
    "at fall_tilt": (FELL, {"tilt": FALL}, {}),
    "a step longer than any motion": (UNRESOLVED, {"tilt": 0.1}, {"duration": 1e6, "step": 1e5}),
    "more steps than anyone waits for": (UNRESOLVED, {"tilt": 0.1}, {"duration": 300.0, "step": 1e-9}),
    "rates beyond all bounds": (UNRESOLVED, {"tilt": 0.1, "roll_rate": 1e200}, {}),
    "no tilt": (INVALID, {"tilt": math.nan}, {}),
    "flat": (INVALID, {"tilt": math.pi / 2}, {}),
    "infinite roll": (INVALID, {"roll_rate": math.inf}, {}),
    "infinite precession": (INVALID, {"precession_rate": -math.inf}, {}),
    "no tilt rate": (INVALID, {"tilt_rate": math.nan}, {}),
    "alpha 0": (INVALID, {"alpha": 0.0}, {}),
    "alpha above 1": (INVALID, {"alpha": 1.0000001}, {}),
    "alpha nan": (INVALID, {"alpha": math.nan}, {}),
    "no radius": (INVALID, {"radius": 0.0}, {}),
    "no gravity": (INVALID, {"gravity": -1.0}, {}),
    "infinite radius": (INVALID, {"radius": math.inf}, {}),
}


def test_every_ending_is_reached():
    """Each start reaches the ending it was made for."""
    for case in ENDED:
        ending, start, settings = ENDED[case]
        slow = {"tolerance": 1e-4} if ending != UNRESOLVED else {}
        found = kernel_runner.run(referee.starts(**start), **(slow | settings))
        assert found.ending[0] == ending, case


def test_what_an_ending_measures():
    """Each measure is a number exactly for the endings that have one."""
    cases = [case for case, (_, _, settings) in ENDED.items() if not settings]
    given = np.concatenate([referee.starts(**ENDED[case][1]) for case in cases], axis=1)
    found = kernel_runner.run(given, tolerance=1e-4)
    assert list(found.ending) == [ENDED[case][0] for case in cases]
    extremes = np.isin(found.ending, (BOUNDED, STEADY, HORIZON, FELL))
    assert list(np.isfinite(found.least)) == list(np.isfinite(found.greatest)) == list(extremes)
    assert list(np.isfinite(found.tilt_error)) == list(np.isfinite(found.energy_drift)) == list(extremes)
    assert list(np.isfinite(found.fall_time)) == list(found.ending == FELL)
    assert list(np.isfinite(found.period)) == list(found.ending == BOUNDED)


def test_beyond_fall_tilt_nothing_happens():
    """A start beyond fall_tilt has fallen at time zero, without a step, on its own side."""
    found = kernel_runner.run(referee.starts(tilt=[1.5, -1.5, FALL]))
    assert list(found.fall_time) == [0.0, 0.0, 0.0]
    assert list(found.least) == list(found.greatest) == [1.5, -1.5, FALL]
    assert list(found.steps) == [0, 0, 0]


# --- against the motion in time -------------------------------------------------------------------------------------


def test_the_nutation_period():
    """The period is the time between every other turning point of the equations with sines and cosines."""
    for start in [
        {"tilt": 0.3, "roll_rate": 4.0},
        {"tilt": -0.3, "tilt_rate": 0.4, "roll_rate": 3.0, "precession_rate": 0.7},
        {"tilt": 0.1, "tilt_rate": 0.1, "precession_rate": 5.0, "alpha": 1.0, "radius": 0.1},
        {"tilt_rate": 0.01, "roll_rate": 2.0},
    ]:
        given = referee.starts(**start)
        found = kernel_runner.run(given)
        turns = referee.motion(given[:, 0], 3.1 * found.period[0])
        assert len(turns.turn_times) >= 4, start
        assert found.period[0] == pytest.approx(turns.turn_times[3] - turns.turn_times[1], rel=1e-6), start
        extremes = sorted(turns.turn_tilts[:2])
        assert [found.least[0], found.greatest[0]] == pytest.approx(extremes, abs=1e-6), start


def test_the_fall_time():
    """Fall time and side agree with the equations with sines and cosines."""
    for case in [
        ({"tilt": 0.01}, 1.0),
        ({"tilt": 0.3, "tilt_rate": -9.0}, -1.0),
        ({"tilt": -0.3, "precession_rate": 0.1, "roll_rate": 0.3, "alpha": 1.0}, -1.0),
        ({"tilt": 0.3, "tilt_rate": -0.2, "gravity": 1.6}, 1.0),
    ]:
        start, side = case
        given = referee.starts(**start)
        found = kernel_runner.run(given, tolerance=1e-6)
        fall = referee.motion(given[:, 0], 20.0)
        assert found.fall_time[0] == pytest.approx(fall.fall_time, rel=1e-6), case
        assert found.greatest[0] == FALL if side > 0.0 else found.least[0] == -FALL, case
        # the extreme on the other side: the start or an earlier turning point
        passed = fall.turn_tilts[0] if fall.turn_tilts.size else given[0, 0]
        assert (found.least if side > 0.0 else found.greatest)[0] == pytest.approx(passed, abs=1e-6), case


def test_extremes_when_time_runs_out():
    """At the end of the duration, the extremes include the tilt of the last moment."""
    for duration in [0.2, 0.7, 1.0, 1.3]:
        given = referee.starts(tilt=0.2, tilt_rate=-0.3, roll_rate=3.5, precession_rate=0.2)
        found = kernel_runner.run(given, duration=duration, tolerance=1e-6)
        tilts = referee.motion(given[:, 0], duration)
        everything = np.concatenate([tilts.states[0][[0, -1]], tilts.turn_tilts])
        assert found.ending[0] == (HORIZON if len(tilts.turn_tilts) < 2 else BOUNDED), duration
        if found.ending[0] == HORIZON:
            assert found.least[0] == pytest.approx(everything.min(), abs=1e-6), duration
            assert found.greatest[0] == pytest.approx(everything.max(), abs=1e-6), duration


# --- symmetries -----------------------------------------------------------------------------------------------------

#: Factors on the start under which the equations of motion keep their form.
MIRRORS = {
    "left-right": {"tilt": -1, "tilt_rate": -1, "precession_rate": -1},
    "backward rolling": {"tilt": -1, "tilt_rate": -1, "roll_rate": -1},
    "both": {"precession_rate": -1, "roll_rate": -1},
}


def times(given, factors):
    """Return the starts with the named rows multiplied."""
    return given * np.array([[factors.get(name, 1)] for name in PARAMETERS])


def assert_mirrored(found, mirrored, flipped):
    """Every measure is the same to the last bit, with the extremes exchanged if the tilt changes sign."""
    changed = {"least": -mirrored.greatest, "greatest": -mirrored.least} if flipped else {}
    for name, column in vars(found).items():
        assert np.array_equal(column, changed.get(name, getattr(mirrored, name)), equal_nan=True), name


def test_mirrored_starts_have_mirrored_motions():
    """Sign changes that keep the equations only change signs, to the last bit."""
    for mirror in MIRRORS:
        cases = [
            ({"tilt": 0.3, "tilt_rate": -0.5, "roll_rate": 3.0, "precession_rate": 0.7}),
            {"tilt": 0.2, "tilt_rate": 1.0},
        ]
        given = np.concatenate([referee.starts(**case) for case in cases], axis=1)
        other = times(given, MIRRORS[mirror])
        settings = {"tolerance": 1e-4}
        assert_mirrored(
            kernel_runner.run(given, **settings),
            kernel_runner.run(other, **settings),
            "tilt" in MIRRORS[mirror],
        )


@compiled
def test_all_mirrored_starts_have_mirrored_motions(crowd):
    """The same holds for random starts with compiled kernels."""
    for mirror in MIRRORS:
        given, _ = crowd
        other = times(given, MIRRORS[mirror])
        assert_mirrored(kernel_runner.run(given), kernel_runner.run(other), "tilt" in MIRRORS[mirror])


@compiled
def test_a_motion_run_backward_has_the_same_extremes(crowd):
    """With the tilt rate reversed, a bounded motion has the same extremes within both errors."""
    given, truth = crowd
    given = given[:, ~truth.fell]
    found, back = (
        kernel_runner.run(given),
        kernel_runner.run(times(given, {"tilt_rate": -1})),
    )
    assert np.array_equal(found.ending, back.ending)
    assert errors(found, back).max() <= 2e-7
    gentle = found.peak < 1.0
    assert found.period[gentle] == pytest.approx(back.period[gentle], rel=1e-5)


@compiled
def test_size_and_gravity_only_set_the_clock(crowd):
    """With half the rates, 4 times the radius or 1/4 of the gravity gives the same tilts and twice the times."""
    given, _ = crowd
    found = kernel_runner.run(given)
    for rates, masses in ((0.5, {"radius": 4}), (0.5, {"gravity": 0.25}), (2, {"radius": 0.5, "gravity": 2})):
        clock = 1.0 / rates
        other = kernel_runner.run(
            times(given, dict.fromkeys(STATE[1:], rates) | masses), duration=300.0 * clock
        )
        # powers of two cause no rounding, so the bits are the same
        for name in ("least", "greatest", "ending", "steps", "energy_drift", "tilt_error"):
            assert np.array_equal(getattr(found, name), getattr(other, name), equal_nan=True), name
        for name in ("fall_time", "period"):
            assert np.array_equal(clock * getattr(found, name), getattr(other, name), equal_nan=True), name


# --- a cell is alone ------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def mixed():
    """Return more starts than fit into two chunks, of all endings, with easy and hard ones mixed."""
    rng = np.random.default_rng(11)
    given = np.concatenate(
        [scattered(3600, 7), coarse("circling"), referee.starts(tilt=rng.uniform(-1.6, 1.6, 200))], axis=1
    )
    odd = [start for ending, start, settings in ENDED.values() if not settings]
    given = np.concatenate([given, *(referee.starts(**start) for start in odd)], axis=1)
    return np.ascontiguousarray(given[:, rng.permutation(given.shape[1])])


@compiled
def test_the_bits_of_a_cell_depend_on_the_cell_alone(mixed):
    """Threads, order, number of cells and position in a chunk do not change the bits of a cell."""
    n = mixed.shape[1]
    assert n > 2 * CHUNK
    found = kernel_runner.run(mixed, threads=1)
    assert set(found.ending) == {BOUNDED, STEADY, FELL, UNRESOLVED, INVALID}
    bits = found.bits()
    assert np.array_equal(kernel_runner.run(mixed, threads=2).bits(), bits)
    rng = np.random.default_rng(2)
    order = rng.permutation(n)
    assert np.array_equal(kernel_runner.run(np.ascontiguousarray(mixed[:, order])).bits(), bits[order])
    for start, stop in ((0, 1), (5, 22), (n - 1, n), (100, 2200), (CHUNK - 1, CHUNK + 1)):
        part = kernel_runner.run(np.ascontiguousarray(mixed[:, start:stop]))
        assert np.array_equal(part.bits(), bits[start:stop])
    for cell in rng.choice(n, 60, replace=False):
        alone = kernel_runner.run(np.ascontiguousarray(mixed[:, cell : cell + 1]))
        assert np.array_equal(alone.bits(), bits[cell : cell + 1])


@compiled
@settings(max_examples=25)
@given(st.data())
def test_impossible_neighbours_disturb_nobody(data):
    """NaN and infinite starts are invalid, and the cells between them keep their bits."""
    given = scattered(64, 3)
    bits = kernel_runner.run(given).bits()
    cells = data.draw(st.lists(st.integers(0, 63), min_size=1, max_size=40, unique=True))
    broken = given.copy()
    for cell in cells:
        row = data.draw(st.integers(0, len(PARAMETERS) - 1))
        broken[row, cell] = data.draw(st.sampled_from([math.nan, math.inf, -math.inf]))
    found = kernel_runner.run(broken)
    assert (found.ending[cells] == INVALID).all()
    others = np.setdiff1d(np.arange(64), cells)
    assert np.array_equal(found.bits(others), bits[others])


def test_no_cells_at_all():
    """An empty block is valid."""
    assert kernel_runner.run(np.empty((len(PARAMETERS), 0))).ending.size == 0
