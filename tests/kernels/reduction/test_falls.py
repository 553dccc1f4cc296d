"""Fall times of disks and other bodies, compared with integrations in time."""

import math

import numpy as np
import pytest
import referee
from body_referee import Body, start_of
from scipy.integrate import solve_ivp

from kernels.bodies.shapes import NAMES, TORUS
from kernels.disk.arrays import PARAMETERS
from kernels.reduction.falls import fall_times
from sweep.model.disk.path import rows_of_disk

#: Released at rest, kicked outward, kicked inward so that it turns or passes upright first, kicked minimally.
STARTS = [
    {"tilt": 0.5},
    {"tilt": -0.5, "roll_rate": 0.3},
    {"tilt": 0.2, "tilt_rate": 1.0, "precession_rate": 0.5},
    {"tilt": 0.4, "tilt_rate": -0.5, "alpha": 1.0},
    {"tilt": -0.4, "tilt_rate": 3.0, "roll_rate": 0.3},
    {"tilt": 0.4, "tilt_rate": -3.5, "gravity": 1.62},
    {"tilt": 0.9, "tilt_rate": 1e-4, "radius": 0.01},
    {"tilt": 1e-4},
]


def fall_time(start):
    """Return the time at which SciPy's integration reaches fall_tilt."""

    def fallen(_, state):
        return abs(state[0]) - referee.FALL_TILT

    fallen.terminal = True

    def slope(_, state):
        return state[1], *referee.accelerations(state, *start[4:])

    run = solve_ivp(slope, (0.0, 100.0), start[:4], method="DOP853", rtol=1e-12, atol=1e-13, events=fallen)
    return run.t_events[0][0]


def fall_times_of(rows, kind, fall_tilt=referee.FALL_TILT):
    """Return the fall times of starts."""
    times = np.empty(rows.shape[1])
    fall_times(np.ascontiguousarray(rows), float(kind), fall_tilt, times)
    return times


def test_fall_times_of_disks():
    """Every kind of fall agrees to 1e-10; no fall gives no time, and a start beyond fall_tilt gives 0."""
    given = np.concatenate([referee.starts(**start) for start in STARTS], axis=1)
    rows = rows_of_disk(dict(zip(PARAMETERS, given, strict=True)))
    found = fall_times_of(rows, TORUS)
    assert found == pytest.approx([fall_time(start) for start in given.T], rel=1e-10)
    others = np.concatenate([referee.starts(tilt=0.1, roll_rate=4.0), referee.starts(tilt=1.55)], axis=1)
    times = fall_times_of(rows_of_disk(dict(zip(PARAMETERS, others, strict=True))), TORUS)
    assert np.isnan(times[0])
    assert times[1] == 0.0


@pytest.mark.parametrize(
    ("name", "lengths", "body"),
    [
        ("torus", {"tube": 0.25}, Body(0.75, 0.0, 0.25, 0.609375, 0.3203125)),
        ("rim", {"thickness": 0.3, "fillet": 0.05}, Body(0.95, 0.1, 0.05, 0.5, 0.26)),
        ("arc", {"fillet": 0.1, "offset": -0.2}, Body(0.9, -0.2, 0.1, 0.5, 0.3)),
    ],
)
def test_fall_times_of_other_bodies(name, lengths, body):
    """Bodies kicked outward or inward agree with the same body followed in space, to 1e-9."""
    fall_tilt, compared = math.radians(80.0), 0
    for tilt, w, o, s in (
        (0.5, 0.3, 0.02, 0.0),
        (0.5, -0.2, 0.01, 0.3),
        (0.9, 0.0, 0.0, 0.1),
        (0.4, -0.05, 0.0, 0.0),
    ):
        rows, kind = start_of(name, tilt, w, o, s, body.axial, body.transverse, **lengths)

        def falls(_, y):
            return y[2] - math.sin(fall_tilt)

        falls.terminal = True
        found = solve_ivp(
            body.right_side,
            (0.0, 60.0),
            body.start(tilt, w, o, s),
            "DOP853",
            rtol=1e-12,
            atol=1e-14,
            events=falls,
        )
        (time,) = fall_times_of(rows, kind, fall_tilt)
        assert NAMES[kind] == name
        if found.t_events[0].size and not np.isnan(time):
            assert time == pytest.approx(found.t_events[0][0], rel=1e-9), (tilt, w, o, s)
            compared += 1
    assert compared >= 2
