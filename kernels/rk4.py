"""One classical Runge-Kutta step, and the short finishing steps that land exactly on an event.

A turning point sampled at step ends is only second order in the step. Henon's trick (Physica D 5 (1982) 412) makes
it as good as the method: from the first state past the event take a short step whose length is Newton's correction.
"""

import math

from numba import njit

from kernels.disk import CONTRACT, derivatives


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
    half = 0.5 * h
    S1, C1, T1, w1, o1, s1 = derivatives(S, C, T, w, o, s, i_tilt, i_roll, i_spin, i_inverse)
    S2, C2, T2, w2, o2, s2 = derivatives(
        S + half * S1, C + half * C1, T + half * T1, w + half * w1, o + half * o1, s + half * s1,
        i_tilt, i_roll, i_spin, i_inverse,
    )  # fmt: skip
    S3, C3, T3, w3, o3, s3 = derivatives(
        S + half * S2, C + half * C2, T + half * T2, w + half * w2, o + half * o2, s + half * s2,
        i_tilt, i_roll, i_spin, i_inverse,
    )  # fmt: skip
    S4, C4, T4, w4, o4, s4 = derivatives(
        S + h * S3, C + h * C3, T + h * T3, w + h * w3, o + h * o3, s + h * s3,
        i_tilt, i_roll, i_spin, i_inverse,
    )  # fmt: skip
    sixth = h * (1.0 / 6.0)  # a division would cost a tenth of the step
    return (
        S + sixth * (S1 + 2.0 * (S2 + S3) + S4),
        C + sixth * (C1 + 2.0 * (C2 + C3) + C4),
        T + sixth * (T1 + 2.0 * (T2 + T3) + T4),
        w + sixth * (w1 + 2.0 * (w2 + w3) + w4),
        o + sixth * (o1 + 2.0 * (o2 + o3) + o4),
        s + sixth * (s1 + 2.0 * (s2 + s3) + s4),
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
        # Newton squares the error: after a step of 1e-3 the time is off by 1e-6 and the tilt, flat there, by 1e-12
        # of the acceleration at most. Usually that is the second step.
        if abs(h) < 1e-3:
            break
    return state, elapsed


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
