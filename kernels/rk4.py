"""One classical Runge-Kutta step, and the short finishing steps that land exactly on an event.

A turning point sampled at step ends is only second order in the step. Henon's trick (Physica D 5 (1982) 412) makes
it as good as the method: from the first state past the event take a short step whose length is Newton's correction.
"""

import math

from numba import njit

from kernels.disk import CONTRACT, derivatives

#: Scaled time and angle [rad] from a turning point below which its last correction needs no step any more.
_SHORT, _NEAR = 3.0e-4, 1.0e-7


@njit(error_model="numpy", fastmath=CONTRACT, inline="always")
def lane_step(S, C, T, w, o, s, i_tilt, i_roll, i_spin, i_inverse, h):
    """State after one RK4 step of scaled length `h`; written to be inlined into a vectorised loop over lanes.

    Parameters
    ----------
    S, C, T, w, o, s : float
        Scaled state (`kernels.disk`).
    i_tilt, i_roll, i_spin, i_inverse : float
        Constants of `kernels.disk.inertia`.
    h : float
        Step in scaled time; may be negative.

    Returns
    -------
    tuple of 6 floats

    Notes
    -----
    The classical method of order 4 (Kutta 1901); local error O(h^5).
    """
    # The slopes are summed as they come: all four together would not fit the vector registers.
    half = 0.5 * h
    dS, dC, dT, dw, do, ds = derivatives(S, C, T, w, o, s, i_tilt, i_roll, i_spin, i_inverse)
    sS, sC, sT, sw, so, ss = dS, dC, dT, dw, do, ds
    dS, dC, dT, dw, do, ds = derivatives(
        S + half * dS, C + half * dC, T + half * dT, w + half * dw, o + half * do, s + half * ds,
        i_tilt, i_roll, i_spin, i_inverse,
    )  # fmt: skip
    sS, sC, sT = sS + 2.0 * dS, sC + 2.0 * dC, sT + 2.0 * dT
    sw, so, ss = sw + 2.0 * dw, so + 2.0 * do, ss + 2.0 * ds
    dS, dC, dT, dw, do, ds = derivatives(
        S + half * dS, C + half * dC, T + half * dT, w + half * dw, o + half * do, s + half * ds,
        i_tilt, i_roll, i_spin, i_inverse,
    )  # fmt: skip
    sS, sC, sT = sS + 2.0 * dS, sC + 2.0 * dC, sT + 2.0 * dT
    sw, so, ss = sw + 2.0 * dw, so + 2.0 * do, ss + 2.0 * ds
    dS, dC, dT, dw, do, ds = derivatives(
        S + h * dS, C + h * dC, T + h * dT, w + h * dw, o + h * do, s + h * ds,
        i_tilt, i_roll, i_spin, i_inverse,
    )  # fmt: skip
    sixth = h * (1.0 / 6.0)  # a division would cost a tenth of the step
    return (
        S + sixth * (sS + dS),
        C + sixth * (sC + dC),
        T + sixth * (sT + dT),
        w + sixth * (sw + dw),
        o + sixth * (so + do),
        s + sixth * (ss + ds),
    )


@njit(error_model="numpy", fastmath=CONTRACT)
def step(state, constants, h):
    """`lane_step` for one trajectory: state (6 floats), constants (4 floats) -> state."""
    S, C, T, w, o, s = state
    i_tilt, i_roll, i_spin, i_inverse = constants
    return lane_step(S, C, T, w, o, s, i_tilt, i_roll, i_spin, i_inverse, h)


@njit(error_model="numpy", fastmath=CONTRACT)
def tilt_acceleration(state, constants):
    """Scaled second derivative of the tilt in `state`."""
    S, _, T, _, o, s = state
    return constants[0] * (S + o * (constants[1] * s - constants[2] * (o * T)))


@njit(error_model="numpy", fastmath=CONTRACT)
def land_on_turning_point(state, constants, longest):
    """Finish on the nearby state whose tilt rate is zero.

    Parameters
    ----------
    state : tuple of 6 floats
        A scaled state at most about one step from the turning point.
    constants : tuple of 4 floats
    longest : float
        Bound on one correction (scaled time). Where the acceleration vanishes too (a grazed separatrix) Newton's
        step means nothing; the caller sees it in the tilt rate that is left.

    Returns
    -------
    (state, elapsed)
        The finished state and the scaled time from the given one (usually negative).
    """
    elapsed = 0.0
    for _ in range(4):
        h = -state[3] / tilt_acceleration(state, constants)
        if not abs(h) <= longest:
            h = math.copysign(longest, h)
        state = step(state, constants, h)
        elapsed += h
        # About its turning point a motion is even in time, so Newton's error is of third order: a time of 3e-4 leaves
        # 1e-11 and less. Usually one step comes as near as that.
        h = -state[3] / tilt_acceleration(state, constants)
        if abs(h) < _SHORT and abs(state[3] * h) < _NEAR:
            return _carried(state, constants, 0.5 * state[3] * h), elapsed + h
    return state, elapsed


@njit(error_model="numpy", fastmath=CONTRACT)
def _carried(state, constants, angle):
    """Rest at a tilt that differs by a small angle: first order, for by then the second is rounding."""
    S, C, T, _, o, s = state
    return (
        S + angle * C,
        C - angle * S,
        T + angle * (1.0 + T * T),
        0.0,
        o + angle * (o * T - 2.0 * s),
        s - angle * constants[3] * o,
    )


@njit(error_model="numpy", fastmath=CONTRACT)
def land_on_tilt(state, constants, tilt, longest):
    """Finish on the nearby state with the given tilt [rad]; arguments and result as in `land_on_turning_point`."""
    elapsed = 0.0
    for _ in range(4):
        h = (tilt - math.atan2(state[0], state[1])) / state[3]
        if not abs(h) <= longest:
            h = math.copysign(longest, h)
        state = step(state, constants, h)
        elapsed += h
    return state, elapsed
