import numpy as np
import pytest
import referee
from scipy.integrate import solve_ivp

from kernels.disk.arrays import GRAVITY, RADIUS
from kernels.disk.exact.extremes import extremes
from kernels.disk.exact.fall_time import fall_times

pytestmark = pytest.mark.compiled

#: Released at rest, kicked outward, kicked inward so that it turns or passes upright first, kicked by next to nothing.
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
    """Return the time at which SciPy's integration of the equations of motion reaches fall_tilt."""

    def fallen(_, state):
        return abs(state[0]) - referee.FALL_TILT

    fallen.terminal = True

    def slope(_, state):
        return state[1], *referee.accelerations(state, *start[4:])

    run = solve_ivp(slope, (0.0, 100.0), start[:4], method="DOP853", rtol=1e-12, atol=1e-13, events=fallen)
    return run.t_events[0][0]


def test_fall_times_are_those_of_an_integration_in_time():
    """Of every way to fall, to 1e-8; a motion that does not fall has none."""
    given = np.concatenate([referee.starts(**start) for start in STARTS], axis=1)
    tilts = extremes(given, referee.FALL_TILT)[0][:2]
    found = fall_times(given, tilts, referee.FALL_TILT)
    expected = [fall_time(start) for start in given.T]
    assert found == pytest.approx(expected, rel=1e-8)
    stays = referee.starts(tilt=0.1, roll_rate=4.0)
    assert np.isnan(fall_times(stays, extremes(stays, referee.FALL_TILT)[0][:2], referee.FALL_TILT)).all()
    # time goes with the square root of radius over gravity
    scaled = given.copy()
    scaled[RADIUS] *= 4.0
    scaled[GRAVITY] *= 4.0
    assert fall_times(scaled, tilts, referee.FALL_TILT) == pytest.approx(found, rel=1e-12)
