"""What happens at the contact point: the forces that keep the disk rolling, and the angular momentum about it.

All in scaled form (`kernels.disk`): forces over m g, angular momentum over m R^2/sqrt(R/g).
"""

import math

from numba import njit, prange

from kernels.disk import CONTRACT, inertia, scaled_state
from kernels.endings import BOUNDED, FELL, HORIZON, STEADY
from kernels.rk4 import land_on_tilt, land_on_turning_point, step, tilt_acceleration

#: Step times the fastest frequency of the state; the extremes of the forces are then good to about 1e-6.
_PACE = 0.06

_MOST_STEPS = 10_000_000


@njit(error_model="numpy", fastmath=CONTRACT)
def contact_forces(state, constants, alpha):
    """Force of the plane on the disk, over m g.

    Parameters
    ----------
    state : tuple of 6 floats
        Scaled state (`kernels.disk`).
    constants : tuple of 4 floats
        `kernels.disk.inertia` of alpha.
    alpha : float

    Returns
    -------
    (normal, across, along)
        Vertical; horizontal across the track, towards (cos heading, sin heading), where a positive tilt leans;
        horizontal along the track, towards (-sin heading, cos heading).

    Notes
    -----
    Newton on the centre of mass, which is at R (sin tilt, 0, cos tilt) from the contact point in the precessing frame;
    the horizontal components are the Lagrange multipliers of the two rolling constraints (`kernels.lagrange`).
    """
    S, C, T, w, o, s = state
    turning, rolling, climb = o / C, s - o * T, o * T
    normal = 1.0 - (tilt_acceleration(state, constants) * S + w * w * C)
    across = (
        2.0 * S * C
        - (2.0 + alpha) * S * (w * w + climb * climb)
        + rolling * turning * (alpha - 2.0 * (1.0 + alpha) * S * S)
    ) / (2.0 + alpha)
    return normal, across, alpha * o * w / (1.0 + alpha)


@njit(error_model="numpy", fastmath=CONTRACT)
def friction_needed(normal, across, along):
    """Friction coefficient without which the disk slips; NaN where it does not press on the plane (normal <= 0)."""
    if not normal > 0.0:
        return math.nan
    return math.sqrt(across * across + along * along) / normal


@njit(error_model="numpy", fastmath=CONTRACT)
def vertical_momentum(state, alpha):
    """Vertical angular momentum about the contact point, over m R^2/sqrt(R/g), and its rate of change.

    It is not conserved: the contact point moves, and not along the velocity of the centre of mass, so that
    d(H.e3)/dt = m R^2 (roll rate) (tilt rate) cos(tilt), although the contact force has no moment about that point.
    """
    S, C, T, w, o, s = state
    return (1.0 + alpha) * S * s + 0.5 * alpha * o * C, (s - o * T) * w * C


@njit(error_model="numpy", fastmath=CONTRACT)
def suitable_step(state, constants, pace):
    """Scaled step: `pace` over the fastest frequency of the linearised motion, shorter like cos(tilt) near flat."""
    _, C, _, w, o, s = state
    return pace * C / math.sqrt(constants[0] * (1.0 + 2.0 * constants[1] * s * s) + o * o + w * w)


@njit(error_model="numpy", fastmath=CONTRACT)
def _vertex(before, middle, after, first, second):
    """Extreme of the parabola through three values `first` and `second` apart; `middle` if it has none between."""
    rising, falling = (middle - before) / first, (after - middle) / second
    if not rising * falling < 0.0:
        return middle
    slope = (rising * second + falling * first) / (first + second)
    return middle - 0.25 * slope * slope * (first + second) / (falling - rising)


@njit(error_model="numpy", fastmath=CONTRACT)
def _demand(state, constants, alpha):
    normal, across, along = contact_forces(state, constants, alpha)
    return normal, friction_needed(normal, across, along)


@njit(error_model="numpy", fastmath=CONTRACT)
def _follow(state, constants, alpha, ending, end, fall_tilt):
    """(least normal force over m g, largest friction needed) along the motion that the ending speaks of."""
    least, most = _demand(state, constants, alpha)
    if ending == STEADY:
        return least, most
    normal_2, friction_2 = normal_1, friction_1 = least, most
    w = state[3]
    heading = math.copysign(1.0, tilt_acceleration(state, constants) if w == 0.0 else w)
    # forces do not depend on the sense of the tilt rate: from turning point to turning point is the whole motion
    turns_left = 1 if w == 0.0 else 2
    t, h_1 = 0.0, math.inf
    for _ in range(_MOST_STEPS):
        h = suitable_step(state, constants, _PACE)
        state = step(state, constants, min(h, end - t))
        normal, friction = _demand(state, constants, alpha)
        least = min(least, normal, _vertex(normal_2, normal_1, normal, h_1, h))
        most = max(most, friction, _vertex(friction_2, friction_1, friction, h_1, h))
        normal_2, normal_1, friction_2, friction_1, h_1 = normal_1, normal, friction_1, friction, h
        t += h
        turned, out = heading * state[3] < 0.0, not state[1] >= math.cos(fall_tilt)
        if not (turned or out or t >= end):
            continue
        there = state
        if turned:
            there, _ = land_on_turning_point(state, constants, 2.0 * h)
        elif out:
            there, _ = land_on_tilt(state, constants, math.copysign(fall_tilt, state[0]), 2.0 * h)
        normal, friction = _demand(there, constants, alpha)
        least, most = min(least, normal), max(most, friction)
        turns_left -= 1
        heading = -heading
        if not turned or turns_left == 0:
            return least, (most if least > 0.0 else math.nan)
    return math.nan, math.nan


@njit(error_model="numpy", fastmath=CONTRACT, parallel=True, nogil=True)
def contact_extremes(starts, settings, endings, extremes):
    """Follow every cell once more and record what rolling without slip asks of the contact.

    Parameters
    ----------
    starts : float64[7, n]
        As in `kernels.lanes.integrate`.
    settings : float64[2]
        duration [s]; fall_tilt [rad].
    endings : int32[n]
        How each cell ended. Bounded: the motion is periodic, and half a nutation is all of it. Fell: until
        fall_tilt. Horizon: until the duration. Steady: the start alone.
    extremes : float64[2, n], written
        Least normal force over m g [1], and largest friction coefficient needed [1], NaN where the normal force is
        zero or less on the way. Both NaN for the other endings.

    Notes
    -----
    Never raises. What is written for a cell follows from the cell alone.
    """
    for cell in prange(starts.shape[1]):
        ending = endings[cell]
        extremes[0, cell] = extremes[1, cell] = math.nan
        if ending == BOUNDED or ending == STEADY or ending == FELL or ending == HORIZON:
            unit = math.sqrt(starts[5, cell] / starts[6, cell])
            state = scaled_state(starts[0, cell], starts[1, cell], starts[2, cell], starts[3, cell], unit)
            # a bounded motion is followed to its turning points, however late
            end = math.inf if ending == BOUNDED else settings[0] / unit
            extremes[0, cell], extremes[1, cell] = _follow(
                state, inertia(starts[4, cell]), starts[4, cell], ending, end, settings[1]
            )
