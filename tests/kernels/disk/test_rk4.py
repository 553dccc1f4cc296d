import math

import kernel_runner
import numpy as np
import pytest
import referee
from scipy.integrate import solve_ivp

from kernels.disk import equations as disk
from kernels.disk import rk4

#: A start in general position, without zero rates or symmetries.
START = (0.4, 0.3, 1.1, 0.7)
ALPHA = 0.5


def exact(start, times):
    """Return states of the scaled form at scaled times, from the equations with sines and cosines (R = g = 1)."""

    def slope(_, y):
        tilting, turning, rolling = referee.accelerations(y, ALPHA, 1.0, 1.0)
        return y[1], tilting, turning, rolling

    span = (0.0, times[-1])
    run = solve_ivp(slope, span, start, method="DOP853", rtol=1e-13, atol=1e-15, t_eval=times)
    return [disk.scaled_state(*state, 1.0) for state in run.y.T]


def walk(state, h, steps):
    """Return the state after a number of equal steps."""
    constants = disk.inertia(ALPHA)
    for _ in range(steps):
        state = rk4.step(state, constants, h)
    return np.array(state)


def order(steps, errors):
    """Return the slope of the error over the step, both logarithmic."""
    return np.polyfit(np.log(steps), np.log(errors), 1)[0]


def test_the_method_is_of_fourth_order():
    """Over a fixed time and ten starts, the error of each component falls like step^4: slope 4 +- 0.1."""
    rng = np.random.default_rng(1)
    lengths = np.array([1 / 64, 1 / 128, 1 / 256])
    squares = np.zeros((3, 6))
    for start in rng.uniform(-1.0, 1.0, (10, 4)) * [0.5, 0.3, 1.5, 1.5]:
        (end,) = exact(start, [1.0])
        begin = disk.scaled_state(*start, 1.0)
        squares += [(walk(begin, h, round(1.0 / h)) - end) ** 2 for h in lengths]
    for component in np.sqrt(squares).T:
        assert order(lengths, component) == pytest.approx(4.0, abs=0.1)


def test_a_negative_step_goes_back():
    """A step and its reverse cancel up to the method's error, which falls at least like step^5."""
    begin = np.array(disk.scaled_state(*START, 1.0))
    constants = disk.inertia(ALPHA)
    lengths = np.array([0.1, 0.05, 0.025])
    errors = []
    for h in lengths:
        there = rk4.step(tuple(begin), constants, h)
        assert np.abs(np.array(there) - begin).max() > 0.1 * h
        errors.append(np.abs(np.array(rk4.step(there, constants, -h)) - begin).max())
    assert errors[-1] < 1e-8
    assert order(lengths, errors) > 4.9


def test_tilt_acceleration_is_the_slope_of_the_tilt_rate():
    """The acceleration used for landing is the derivative of the tilt rate."""
    state = disk.scaled_state(*START, 1.0)
    tilting, _, _ = referee.accelerations(START, ALPHA, 1.0, 1.0)
    assert rk4.tilt_acceleration(state, disk.inertia(ALPHA)) == pytest.approx(tilting, rel=1e-14)


def test_landing_on_a_turning_point():
    """From either side of a turning point, landing finds its tilt with one step's error (offset^5) and zero rate."""
    for offset in [0.04, -0.04, 0.01, -0.01, 0.0]:
        turn = (0.4, 0.0, 1.1, 0.7)
        there = exact(turn, [abs(offset)])[0] if offset else disk.scaled_state(*turn, 1.0)
        # in reversed time the same tilts are passed with reversed rates
        there = there if offset >= 0.0 else (*there[:3], *(-rate for rate in there[3:]))
        state, elapsed = rk4.land_on_turning_point(there, disk.inertia(ALPHA), 0.1)
        one_step = 0.01 * abs(offset) ** 5 + 1e-15
        assert math.atan2(state[0], state[1]) == pytest.approx(0.4, abs=one_step), offset
        assert elapsed == pytest.approx(-offset, abs=10.0 * one_step), offset
        assert abs(state[3]) < 1e-12, offset


def test_landing_is_as_good_as_the_method():
    """The error of a landed turning point is at least of fourth order in the distance to it."""
    offsets = np.array([0.4, 0.2, 0.1])
    errors = []
    for there in exact((0.4, 0.0, 1.1, 0.7), offsets[::-1])[::-1]:
        state, _ = rk4.land_on_turning_point(there, disk.inertia(ALPHA), 1.0)
        errors.append(abs(math.atan2(state[0], state[1]) - 0.4))
    assert order(offsets, errors) > 3.9


def test_landing_never_leaps():
    """With little acceleration, Newton's huge correction is limited to the longest step."""
    state, elapsed = rk4.land_on_turning_point(
        disk.scaled_state(1e-3, 10.0, 0.0, 0.0, 1.0), disk.inertia(ALPHA), 1e-3
    )
    assert abs(elapsed) <= 3.0001e-3
    assert state[3] == pytest.approx(10.0, rel=1e-3)


def test_landing_on_a_tilt():
    """From either side of a tilt, landing finds it to 1e-14 and its time to 1e-9."""
    for offset in [0.02, -0.02]:
        fall = 1.2
        passing = (fall, 1.5, 1.1, 0.7)
        if offset > 0.0:
            there = exact(passing, [offset])[0]
        else:
            reverse = exact((fall, -1.5, -1.1, -0.7), [-offset])[0]
            there = (*reverse[:3], *(-rate for rate in reverse[3:]))
        state, elapsed = rk4.land_on_tilt(there, disk.inertia(ALPHA), fall, 0.1)
        assert math.atan2(state[0], state[1]) == pytest.approx(fall, abs=1e-14), offset
        assert elapsed == pytest.approx(-offset, abs=1e-7), offset


@pytest.mark.slow_lane
@pytest.mark.compiled
def test_the_peaks_of_the_lane_kernel_are_of_fourth_order():
    """With a fixed step and no refinement, the error of peaks over many starts falls like step^4: 4 +- 0.1."""
    rng = np.random.default_rng(4)
    given = referee.starts(
        tilt=rng.uniform(0.05, 0.5, 300),
        tilt_rate=rng.uniform(0.1, 1.0, 300),
        precession_rate=rng.uniform(-2.0, 2.0, 300),
        roll_rate=rng.uniform(3.0, 6.0, 300),
    )
    truth = referee.extremes(given)
    easy = (truth.peak < 0.9) & ~truth.fell
    assert easy.sum() > 200
    lengths = np.array([0.004, 0.002, 0.001])
    errors = []
    for h in lengths:
        found = kernel_runner.run(given, step=h, tolerance=0.1)
        assert not found.refinements[easy].any()
        errors.append(np.sqrt(np.mean((found.peak - truth.peak)[easy] ** 2)))
    assert errors[-1] > 1e-12
    assert order(lengths, errors) == pytest.approx(4.0, abs=0.1)
