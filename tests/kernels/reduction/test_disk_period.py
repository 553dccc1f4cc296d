import math

import numpy as np
import pytest
import referee
from disk_reduction import ENDING, extremes
from scipy.integrate import quad, solve_ivp

from kernels.bodies.arrays import REDUCED_MAX, REDUCED_MIN, REDUCED_PERIOD, REDUCED_SEPARATRIX
from kernels.disk.arrays import TILT_RATE
from kernels.disk.endings import BOUNDED

# takes minutes without compilation
pytestmark = pytest.mark.compiled

FALL = math.radians(88.0)


def integrated(start, low, high):
    """Return the period by SciPy: integrate the kinetic energy along the tilt, then 2 int dtilt/w."""
    tilt, w, precession, roll, alpha = (float(x) for x in start[:5])
    s, o = roll + precession * math.sin(tilt), precession * math.cos(tilt)

    def slopes(x, y):
        force = math.sin(x) + y[1] * ((1.0 + alpha) * y[0] - 0.5 * alpha * y[1] * math.tan(x))
        return -y[1] / (1.0 + alpha), -2.0 * y[0] + y[1] * math.tan(x), force

    middle = 0.5 * (low + high)
    begin = solve_ivp(
        slopes,
        (tilt, middle),
        (s, o, 0.5 * (1.0 + 0.5 * alpha) * w * w),
        rtol=3e-14,
        atol=1e-16,
        method="DOP853",
    )
    halves = [
        solve_ivp(
            slopes, (middle, end), begin.y[:, -1], rtol=3e-14, atol=1e-16, method="DOP853", dense_output=True
        )
        for end in (low, high)
    ]

    def integrand(angle):
        x = middle + 0.5 * (high - low) * math.sin(angle)
        kinetic = halves[int(x > middle)].sol(x)[2]
        return 0.5 * (high - low) * math.cos(angle) / math.sqrt(2.0 * kinetic / (1.0 + 0.5 * alpha))

    # near the turning points, the kinetic energy is a difference
    edge = 0.5 * math.pi - 0.02
    total = sum(
        quad(integrand, *part, epsabs=0.0, epsrel=1e-11, limit=200)[0] for part in ((-edge, 0.0), (0.0, edge))
    )
    ends = 0.0
    for side, end in ((-1.0, low), (1.0, high)):
        pull = slopes(end, halves[int(side > 0.0)].y[:, -1])[2]
        ends += 0.02 * math.sqrt(0.5 * (high - low) * (1.0 + 0.5 * alpha) / abs(pull))
    return 2.0 * (total + ends)


def test_random_periods_by_another_quadrature(rng):
    """Periods of random starts, wide and narrow, agree with SciPy within its accuracy."""
    n = 30
    given = referee.starts(
        tilt=rng.uniform(-1.3, 1.3, n), tilt_rate=rng.normal(0.0, 1.0, n), precession_rate=rng.normal(0.0, 2.0, n),
        roll_rate=rng.normal(0.0, 2.0, n), alpha=rng.choice((1e-6, 0.25, 0.5, 1.0), n), radius=1.0, gravity=1.0,
    )  # fmt: skip
    measures, counts = extremes(given, FALL, True)
    height = measures[REDUCED_SEPARATRIX]
    plain = (counts[ENDING] == BOUNDED) & ~(np.abs(height) < 1e-2)
    assert plain.sum() >= 5
    for i in np.flatnonzero(plain):
        truth = integrated(given[:, i], measures[REDUCED_MIN, i], measures[REDUCED_MAX, i])
        assert measures[REDUCED_PERIOD, i] == pytest.approx(truth, rel=1e-5), given[:, i]


@pytest.mark.parametrize("width", [1e-3, 1e-5, 1e-7])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_small_swings_of_a_rolling_disk(width, side):
    """A fast upright rolling disk has the frequency of linear theory, however small its swing."""
    given = referee.starts(tilt_rate=side * width, roll_rate=3.0, radius=1.0, gravity=1.0)
    measures, _ = extremes(given, FALL, True)
    # scaled: (1 + alpha/2) w'' = -(2 (1 + alpha) roll^2 - 1) w; the neglected terms go like the square of the
    # width
    frequency = math.sqrt((2.0 * 1.5 * 9.0 - 1.0) / 1.25)
    assert measures[REDUCED_PERIOD, 0] == pytest.approx(2.0 * math.pi / frequency, rel=max(1e-9, width**2))


#: Scaled starts (tilt, its rate, precession and roll rate, alpha) of motions that linger at a maximum of
#: their potential, and their periods by scripts/quadruple.py, the last one to 40 digits
#: (tests/turning_reference.py).
LINGERING = [
    (
        0.00140424408265361,
        2.985808741512125e-12,
        -0.15348250861759202,
        0.008201022620099602,
        0.14378554315946895,
    ),
    (
        -0.18862856306142153,
        -2.5630464098761853e-07,
        -0.6641794414993488,
        -0.3101607247187455,
        0.4106671623115227,
    ),
    (
        -0.035593015805694954,
        2.561146326229011e-08,
        0.7948066549052099,
        0.06141664981030043,
        0.24680867281259003,
    ),
    (-0.6128676939608386, 2.293569200025711, 0.5833722759236682, 0.7648911062986228, 0.39471761780091774),
    (-9.949950591813094e-08, 1.2257633217818012e-07, 0.0, 0.11205993353727813, 0.77),
]
PERIODS = [42.871139186380034, 118.95439556462193, 138.967020294028, 2.6505869868040657, 83.262574890437121]


@pytest.mark.parametrize(("start", "period"), list(zip(LINGERING, PERIODS, strict=True)))
def test_periods_of_motions_that_linger(start, period):
    """Periods have ten digits; sums that agreed by accident gave errors of 3e-9, lost digits 1.3e-9."""
    names = ("tilt", "tilt_rate", "precession_rate", "roll_rate", "alpha")
    given = referee.starts(**dict(zip(names, start, strict=True)), radius=1.0, gravity=1.0)
    assert extremes(given, FALL, True)[0][REDUCED_PERIOD, 0] == pytest.approx(period, rel=1e-10)


def test_bits_of_a_period_depend_on_the_cell_alone(rng):
    """Order, other cells and chunks do not change a bit of a period, nor do motions that need more intervals."""
    n = 3000
    given = referee.starts(
        tilt=rng.uniform(-1.4, 1.4, n), tilt_rate=rng.normal(0.0, 1.0, n) * (rng.random(n) < 0.7),
        precession_rate=rng.normal(0.0, 1.5, n), roll_rate=rng.normal(0.0, 1.5, n),
        alpha=rng.choice((0.25, 0.5), n), radius=1.0, gravity=1.0,
    )  # fmt: skip
    # half of the starts near a separatrix, where the sums differ most in length
    height = extremes(given, FALL)[0][REDUCED_SEPARATRIX]
    below = np.flatnonzero(height > 1e-3)
    near = given[:, below]
    near[TILT_RATE] = np.sqrt(
        near[TILT_RATE] ** 2
        + 2.0 * height[below] / (1.0 + 0.5 * near[4]) * (1.0 + 10.0 ** rng.uniform(-9, -1, below.size))
    )
    given = np.concatenate([given, near], axis=1)
    together = extremes(given, FALL, True)[0][REDUCED_PERIOD]
    order = rng.permutation(given.shape[1])
    np.testing.assert_array_equal(extremes(given[:, order], FALL, True)[0][REDUCED_PERIOD], together[order])
    for cell in rng.choice(order, 25, replace=False):
        alone = extremes(given[:, [cell]], FALL, True)[0][REDUCED_PERIOD]
        np.testing.assert_array_equal(alone, together[[cell]])
