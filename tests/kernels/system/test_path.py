"""Each sample of a motion equals a sweep cell that is followed to its time, with the same passes and bits."""

from dataclasses import replace

import numpy as np
import pytest

from kernels.system.endings import FIRST_EVENT, RUNS_ON, UNRESOLVED
from kernels.system.lanes import LEGS
from sweep.model.system.model import model_of
from sweep.request.system_file import read_system

PENDULUM = """
@system(duration="12", ends={"past": "abs(angle) > level"}, measures={"top": "max abs(angle)"})
def pendulum(angle=0.2, speed=0.0, *, damping=0.0, torque=0.3, drive=0.7, level=1e300, t):
    return speed, torque*cos(drive*t) - damping*speed - sin(angle)
"""


#: The same with moments, and an integral.
WATCHED = PENDULUM.replace(
    '"top": "max abs(angle)"',
    '"turns": "count abs(angle) > 0.3", "began": "value of speed at first angle > 0.3",'
    '"ended": "value of speed at last angle > 0.3", "when": "value of speed at max angle", "area": "integral angle**2"',
)


def followed(times, text=PENDULUM, **given):
    """Return measures and counts of one motion at the times, and those of the sweep kernel for its duration."""
    model = model_of(read_system(text))
    starts = np.array([[given.get(name, row.default)] for name, row in model.parameters.items()], np.float64)
    found = []
    for kernel, where in (("kernels.system.path", (times,)), ("kernels.system.integrate", ())):
        n = times.size if where else 1
        measures = np.full((len(model.measures), n), np.nan)
        counts = np.full((len(model.counts), n), UNRESOLVED, np.int32)
        settings = np.array([times[-1], 0.0, given.get("tolerance", 1e-11)])
        replace(model.integrate, module=kernel).load()(starts, settings, *where, measures, counts)
        found += [measures, counts]
    return found


@pytest.mark.slow_lane
@pytest.mark.parametrize("level", [pytest.param(1e300, marks=pytest.mark.release), 0.9])
def test_the_end_has_the_bits_of_a_sweep(level, rng):
    """All passes, endings and steps agree bit for bit; samples in between change nothing."""
    for count in (2, 50):
        times = np.concatenate([[0.0], np.sort(rng.uniform(0.0, 12.0, count - 2)), [12.0]])
        measures, counts, whole, counted = followed(times, level=level)
        assert measures[:, -1].tobytes() == whole[:, 0].tobytes()
        assert counts[:, -1].tobytes() == counted[:, 0].tobytes()
        assert counts[0, -1] == (RUNS_ON if level > 1.0 else FIRST_EVENT)


@pytest.mark.compiled
def test_a_sample_is_what_a_shorter_sweep_finds():
    """States, largest values and sizes of each pass agree to 1e-13 of a step's error; steps add up."""
    times = np.linspace(0.0, 12.0, 37)
    measures, counts, _, _ = followed(times, tolerance=1e-13)
    rows = measures.shape[0] // len(LEGS)
    for i, time in enumerate(times[1:], 1):
        short, _, whole, counted = followed(np.linspace(0.0, time, 5), tolerance=1e-13)
        # also for a motion of one step
        assert np.isfinite(short).all()
        assert np.abs(measures[-rows:, i] - whole[-rows:, 0]).max() <= 1e-12
        # the shorter sweep's last step is not a step of the longer one
        assert np.all(np.abs(counts[len(LEGS), i] - counted[len(LEGS), 0]) <= len(LEGS))
    assert np.all(np.diff(counts[len(LEGS)]) >= 0)
    assert np.all(measures[-rows + 2, :] == times)


def test_a_motion_that_touches_an_event():
    """A step that a simple bound does not prove free of an event continues, with the same samples as without it."""
    times = np.linspace(0.0, 12.0, 200)
    free, _, _, _ = followed(times)
    rows = free.shape[0] // len(LEGS)
    top = free[-rows + 3 : -rows + 5, -1].max()
    measures, counts, _, _ = followed(times, level=top * (1.0 + 1e-6))
    assert np.all(counts[len(LEGS) + 1] == 0)
    # except the sizes, which are taken at the ends of steps
    same = slice(-rows, -rows + 5)
    assert np.abs(measures[same] - free[same]).max() <= 1e-9


def test_passes_that_ended_stay_where_they_did():
    """After an event, every sample has its place and time; a sample before it has its own."""
    times = np.linspace(0.0, 12.0, 200)
    measures, counts, _, _ = followed(times, level=0.9)
    rows = measures.shape[0] // len(LEGS)
    for leg in range(len(LEGS)):
        end = measures[leg * rows + 2, -1]
        after = times >= end
        assert 1.0 < end < 12.0
        assert np.all(
            measures[leg * rows : (leg + 1) * rows, -1] == measures[leg * rows : (leg + 1) * rows, after].T
        )
        assert np.all(counts[leg, after] == FIRST_EVENT)
        assert np.all(counts[leg, ~after] == RUNS_ON)
        assert abs(measures[leg * rows, -1]) == pytest.approx(0.9, rel=1e-12)
        assert measures[leg * rows + 3 : leg * rows + 5, -1].max() == pytest.approx(0.9, rel=1e-12)


@pytest.mark.slow_lane
def test_moments_until_a_sample():
    """Counts, times and values so far are those of a shorter sweep, and samples in between change nothing."""
    times = np.linspace(0.0, 12.0, 241)
    measures, _, whole, _ = followed(times, WATCHED)
    assert measures[:, -1].tobytes() == whole[:, 0].tobytes()
    rows = measures.shape[0] // len(LEGS)
    found = measures[-rows:].copy()
    assert list(np.unique(found[7])) == [0.0, 1.0, 2.0, 3.0]
    for i in range(1, times.size, 8):
        _, _, shorter, _ = followed(times[: i + 1], WATCHED)
        short = shorter[-rows:, 0]
        # the distance of a condition from its limit is taken at the ends of steps, which differ
        compared = [row for row in range(rows) if row not in (8, 12, 16)]
        assert found[compared, i] == pytest.approx(short[compared], abs=1e-10, nan_ok=True), i
