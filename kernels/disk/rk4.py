"""One classical Runge-Kutta step, and the short final steps that land exactly on an event.

A turning point sampled at the ends of steps is only of second order in the step. Henon's trick (Physica D 5 (1982)
412) makes it as accurate as the method: from the first state past the event, take a short step whose length is
Newton's correction.
"""

import math

from kernels.disk.equations import slopes
from kernels.jit import kernel, simd

#: Scaled time and angle [rad] from a turning point below which the last correction needs no step.
_SHORT, _NEAR = 3.0e-4, 1.0e-7


@simd
def _along(start, slope, angle):
    """Return `start` + angle * `slope`, of five numbers each."""
    S, C, T, o, p = start
    dS, lC, dT, do, lp = slope
    return S + angle * dS, C - angle * lC, T + angle * dT, o + angle * do, p - angle * lp


@simd
def _summed(total, slope, angle):
    """Return `total` + angle * `slope`; in `total` the second and the fifth number have the opposite sign."""
    S, C, T, o, p = total
    dS, lC, dT, do, lp = slope
    return S + angle * dS, C + angle * lC, T + angle * dT, o + angle * do, p + angle * lp


@simd
def lane_step(S, C, T, w, o, p, i_tilt, i_spin, drag, half):
    """Return the state after one RK4 step of scaled length 2 `half`; to be inlined into a vectorised loop over lanes.

    Parameters
    ----------
    S, C, T, w, o, p : float
        Scaled state (`kernels.disk.equations`), with p = (1+alpha) s.
    i_tilt, i_spin, drag : float
        1/(1 + alpha/2), alpha/2, 2/(1 + alpha).
    half : float
        Half the step in scaled time; may be negative.

    Returns
    -------
    tuple of 6 floats

    Notes
    -----
    The classical method of order 4 (Kutta 1901); local error O(h^5).
    """
    # Everything except w changes only with the tilt: by a slope times the change of the tilt. The slopes are summed
    # one by one, with three times the weights 1/6, 1/3, 1/3, 1/6, because all four would not fit into the vector
    # registers. For the same reason the argument is half the step: forming a sum twice costs less than a register.
    half_turn = half * i_tilt
    start = S, C, T, o, p
    slope, first = slopes(start, i_spin, drag)
    dS, lC, dT, do, lp = slope
    angle = half * w
    total = angle * dS, angle * lC, angle * dT, angle * do, angle * lp
    slope, second = slopes(_along(start, slope, angle), i_spin, drag)
    rate = w + half_turn * first
    total = _summed(total, slope, (half + half) * rate)
    slope, third = slopes(_along(start, slope, half * rate), i_spin, drag)
    angle = (half + half) * (w + half_turn * second)
    total = _summed(total, slope, angle)
    slope, fourth = slopes(_along(start, slope, angle), i_spin, drag)
    dS, lC, dT, do, lp = _summed(total, slope, half * (w + (half_turn + half_turn) * third))
    second += third
    part = 1.0 / 3.0  # a division would cost a tenth of the step
    return (
        S + part * dS,
        C - part * lC,
        T + part * dT,
        w + part * half_turn * ((first + fourth) + (second + second)),
        o + part * do,
        p - part * lp,
    )


@simd
def inlined_step(state, constants, h):
    """Return the state after a `step`; to be inlined."""
    S, C, T, w, o, s = state
    i_tilt, i_roll, i_spin, i_inverse = constants
    S, C, T, w, o, p = lane_step(S, C, T, w, o, i_roll * s, i_tilt, i_spin, 2.0 * i_inverse, 0.5 * h)
    return S, C, T, w, o, i_inverse * p


@kernel
def step(state, constants, h):
    """Return the state after a `lane_step` of scaled length h; state of 6 floats, constants of 4 floats."""
    return inlined_step(state, constants, h)


@simd
def tilt_acceleration(state, constants):
    """Return the scaled second derivative of the tilt in `state`."""
    S, C, T, _, o, s = state
    _, acceleration = slopes((S, C, T, o, constants[1] * s), constants[2], 2.0 * constants[3])
    return constants[0] * acceleration


@simd
def approach_turning_point(state, constants, longest):
    """Take one step towards the state whose tilt rate is zero.

    Parameters and the meaning of the step as in `land_on_turning_point`.

    Returns
    -------
    (state, elapsed, left, near)
        The state after the step and its scaled time; the scaled time left by Newton's correction; whether that is so
        short that `carried` can replace a step.
    """
    elapsed = -state[3] / tilt_acceleration(state, constants)
    if not abs(elapsed) <= longest:
        elapsed = math.copysign(longest, elapsed)
    there = inlined_step(state, constants, elapsed)
    # Near its turning point a motion is even in time, so Newton's error is of third order: a time of 3e-4 leaves at
    # most 1e-11. Usually one step is enough for that.
    left = -there[3] / tilt_acceleration(there, constants)
    return there, elapsed, left, (abs(left) < _SHORT) & (abs(there[3] * left) < _NEAR)


@kernel
def land_on_turning_point(state, constants, longest):
    """Finish on the nearby state whose tilt rate is zero.

    Parameters
    ----------
    state : tuple of 6 floats
        A scaled state at most about one step from the turning point.
    constants : tuple of 4 floats
    longest : float
        Bound on one correction (scaled time). If the acceleration vanishes too (at a separatrix), Newton's step is
        meaningless; the caller sees that from the remaining tilt rate.

    Returns
    -------
    (state, elapsed)
        The final state and the scaled time from the given one (usually negative).
    """
    elapsed = 0.0
    for _ in range(4):
        state, h, left, near = approach_turning_point(state, constants, longest)
        elapsed += h
        if near:
            return carried(state, constants, 0.5 * state[3] * left), elapsed + left
    return state, elapsed


@simd
def carried(state, constants, angle):
    """Return the state at rest at a slightly different tilt, to first order; the second order is below rounding."""
    S, C, T, _, o, s = state
    return (
        S + angle * C,
        C - angle * S,
        T + angle * (1.0 + T * T),
        0.0,
        o + angle * (o * T - 2.0 * s),
        s - angle * constants[3] * o,
    )


@kernel
def land_on_tilt(state, constants, tilt, longest):
    """Finish on the nearby state with the given tilt [rad]; arguments and result as in `land_on_turning_point`."""
    elapsed, sine, cosine = 0.0, math.sin(tilt), math.cos(tilt)
    for _ in range(4):
        # the sine of the remaining angle in place of the angle: convergence is equally fast
        h = (sine * state[1] - cosine * state[0]) / state[3]
        if not abs(h) <= longest:
            h = math.copysign(longest, h)
        state = step(state, constants, h)
        elapsed += h
    return state, elapsed
