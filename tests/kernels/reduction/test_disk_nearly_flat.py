"""Nearly flat motions that turn beyond the expansion about their start, compared with 50 digits."""

import math

import numpy as np
import pytest
import referee
import turning_reference as digits
from disk_reduction import ENDING, extremes

from kernels.bodies.arrays import REDUCED_ERROR, REDUCED_MAX, REDUCED_MIN, REDUCED_PERIOD
from kernels.disk.endings import BOUNDED

# takes minutes without compilation
pytestmark = pytest.mark.compiled

FALL = math.radians(89.0)
NAMES = ("tilt", "tilt_rate", "precession_rate", "roll_rate", "alpha")


def starts(*columns):
    """Return scaled starts with the columns of NAMES."""
    return referee.starts(**dict(zip(NAMES, columns, strict=True)), radius=1.0, gravity=1.0)


# via the rates at upright, periods were wrong by 4e-10 to 1e-9, up to 63 times the stated error
@pytest.mark.slow_lane
def test_nearly_flat_periods(pick):
    """Period and turning points agree with 50 digits, although the rates at upright would keep only a few."""
    starts_near = [
        (
            1.5317363539513269,
            0.011795524080107969,
            0.24446100304012713,
            -15.96739237171019,
            0.10318850982468465,
        ),
        (
            -1.5401979403520902,
            0.093014560553457415,
            -0.015642285590791134,
            54.29551719043846,
            0.73290660351746273,
        ),
        (
            1.5402141308469131,
            -0.16955036109373642,
            -0.74658849722578668,
            78.968095223337045,
            0.19802718249637419,
        ),
    ]
    for start in pick(starts_near, 1):
        given = starts(*start)
        found = extremes(given, FALL, True)[0][:, 0]
        with digits.mp.workdps(50):
            exact = [float(x) for x in given[:, 0]]
            low, high = digits.extremes(exact, FALL)
            period, doubt = digits.period(exact, FALL)
            assert doubt < 1e-20, start
        assert found[REDUCED_PERIOD] == pytest.approx(float(period), rel=5e-11), start
        assert abs(found[REDUCED_MIN] - float(low)) < 3e-15, start
        assert abs(found[REDUCED_MAX] - float(high)) < 3e-15, start


@pytest.mark.slow_lane
def test_stated_errors_of_nearly_flat_motions(rng, count):
    """For random motions within 5 degrees of flat, no turning point is beyond its stated error."""
    n = 400
    given = starts(
        rng.choice((-1.0, 1.0), n) * (0.5 * np.pi - 10.0 ** rng.uniform(-1.6, -1.1, n)),
        rng.choice((-1.0, 1.0), n) * 10.0 ** rng.uniform(-3.0, -0.5, n),
        10.0 ** rng.uniform(-2.0, 0.5, n),
        rng.choice((-1.0, 1.0), n) * 10.0 ** rng.uniform(1.0, 2.0, n),
        # with one alpha, the 50 digits of the basis are computed only once
        0.5,
    )
    measures, counts = extremes(given, FALL)
    cells = np.flatnonzero(counts[ENDING] == BOUNDED)[: count(5, 15)]
    assert cells.size == count(5, 15)
    with digits.mp.workdps(50):
        ends = [digits.extremes([float(x) for x in given[:, cell]], FALL) for cell in cells]
    low, high = np.array(ends, dtype=float).T
    for found, truth in ((measures[REDUCED_MIN, cells], low), (measures[REDUCED_MAX, cells], high)):
        assert (np.abs(found - truth) <= measures[REDUCED_ERROR, cells]).all(), given
