import math

import body_referee
import numpy as np
import pytest
import referee
from scipy.integrate import solve_ivp

from kernels.bodies.shapes import Body, thin_disk
from kernels.bodies.steady import steady_spin
from sweep.motion.theory import linear_motion

STARTS = {
    "rolling": (0.0, 1.0, 0.0, 3.0),
    "rolling, unstable": (0.0, 1.0, 0.0, 2.0),
    "spinning": (0.0, 1.0, 4.5, 0.0),
    "circling": (math.radians(10.0), 1.0, 0.5, None),
    "any": (0.3, 1.0, 1.0, 2.0),
}


def linear_disk(start, times):
    """Return the linear motion of a uniform disk of 0.5 m radius, from tilt and rates."""
    names = ("tilt", "tilt_rate", "precession_rate", "roll_rate")
    values = {**dict(zip(names, start, strict=True)), "radius": 0.5, "gravity": 9.81}
    return linear_motion(values, thin_disk(0.5), times)


def motion(start, times):
    """Return tilt and contact point by DOP853 from the referee's equations."""

    def slope(_, y):
        tilting, turning, rolling = referee.accelerations(y[:4], 0.5, 0.5, 9.81)
        return [
            y[1],
            tilting,
            turning,
            rolling,
            y[2],
            -0.5 * y[3] * math.sin(y[4]),
            0.5 * y[3] * math.cos(y[4]),
        ]

    run = solve_ivp(slope, (0.0, times[-1]), [*start, 0.0, 0.0, 0.0], "DOP853", times, rtol=1e-12, atol=1e-15)
    return run.y[0], run.y[5], run.y[6]


def test_linear_theory_is_the_limit_of_small_kicks():
    """With a tenth of the kick, motion and linear theory differ by a hundredth or less."""
    for name in ["rolling", "rolling, unstable", "spinning", "circling"]:
        from kernels.disk.steady import steady_roll_rate

        tilt, rate, turning, rolling = STARTS[name]
        rolling = float(steady_roll_rate(tilt, turning, 0.5, 0.5, 9.81)) if rolling is None else rolling
        times = np.linspace(0.0, 1.5, 3001)
        differences = []
        for kick in (1e-2, 1e-3):
            start = (tilt, kick * rate, turning, rolling)
            linear = linear_disk(start, times)
            exact = motion(start, times)
            found = (linear.tilt, linear.x, linear.y)
            differences.append([np.abs(one - other).max() for one, other in zip(found, exact, strict=True)])
        coarse, fine = np.array(differences)
        # The trapezoid sum of the path leaves an error of 3e-7 for any kick.
        assert (fine <= 0.013 * coarse + 3e-7).all(), name


def test_a_start_that_is_not_steady_is_followed_at_first():
    """Acceleration and its slope are right for any start, so the tilt is accurate to fourth order."""
    times = np.array([0.0, 0.005, 0.01])
    start = STARTS["any"]
    linear = linear_disk(start, times)
    exact, _, _ = motion(start, times)
    error = np.abs(linear.tilt - exact)
    assert error[2] <= 1e-6
    assert 11.0 < error[2] / error[1] < 24.0


def test_coefficient_tells_stable_from_unstable():
    """The coefficient k is positive above the critical roll rate sqrt(g/3R) = 2.557 rad/s, negative below."""
    for roll_rate, sign in [(3.0, 1.0), (2.0, -1.0)]:
        linear = linear_disk((0.0, 0.01, 0.0, roll_rate), np.array([0.0, 1.0]))
        assert math.copysign(1.0, linear.coefficient) == sign, (roll_rate, sign)


@pytest.mark.slow_lane
def test_linear_theory_of_bodies():
    """A tenth of the kick leaves 1 % of the error."""
    times = np.linspace(0.0, 1.5, 1501)
    for arc in ((0.75, 0.0, 0.25, 1.0), (0.9, 0.1, 0.02, 1.0), (0.0, -0.2, 1.0, 0.3)):
        moments = (0.5, 0.3)
        tilt, o = 0.3, 0.6
        spin = float(steady_spin(tilt, o, Body(*arc, *moments, moments[0] / moments[1])))
        differences = []
        for kick in (1e-2, 1e-3):
            found = body_referee.Body(*arc[:3], *moments, arc[3]).path(tilt, kick, o, spin, times)
            start = {
                "tilt": tilt, "tilt_rate": kick, "precession_rate": o / math.cos(tilt),
                "roll_rate": spin - o * math.tan(tilt), "radius": 1.0, "gravity": 1.0,
            }  # fmt: skip
            linear = linear_motion(start, Body(*arc, *moments, moments[0] / moments[1]), times)
            exact = (np.arcsin(found["axis"][:, 2]), *found["contact"][:, :2].T)
            right = (linear.tilt, linear.x, linear.y)
            differences.append([np.abs(one - other).max() for one, other in zip(right, exact, strict=True)])
        coarse, fine = np.array(differences)
        assert (fine <= 0.013 * coarse + 1e-6).all(), arc
