"""What happens at the contact point: the forces that keep the disk rolling, and the angular momentum about it.

All in scaled form (`kernels.disk.equations`): forces over m g, angular momentum over m R^2/sqrt(R/g).
"""

import math

from numba import prange

from kernels.disk.arrays import (
    ALPHA,
    GRAVITY,
    PRECESSION_RATE,
    RADIUS,
    ROLL_RATE,
    TILT,
    TILT_MAX,
    TILT_MIN,
    TILT_RATE,
)
from kernels.disk.equations import inertia, scaled_state
from kernels.disk.motion_arrays import CONTACT_FRICTION_NEEDED, CONTACT_LEAST_NORMAL_FORCE
from kernels.disk.rk4 import tilt_acceleration
from kernels.jit import internal, kernel, parallel

#: Step in the tilt [rad] over cos(tilt), and the fewest steps from one extreme tilt to the other: the extremes of the
#: forces, on parabolas through three steps, are then good to about 1e-6.
_TILT_STEP, _FEWEST = 0.01, 32.0

#: No step is shorter than this [rad]: at tilts near 90 deg the loop would not end.
_SMALLEST = 1e-7


@kernel
def contact_forces(state, constants, alpha):
    """Force of the plane on the disk, over m g.

    Parameters
    ----------
    state : tuple of 6 floats
        Scaled state (`kernels.disk.equations`).
    constants : tuple of 4 floats
        `kernels.disk.equations.inertia` of alpha.
    alpha : float

    Returns
    -------
    (normal, across, along)
        Vertical; horizontal across the track, towards (cos heading, sin heading), where a positive tilt leans;
        horizontal along the track, towards (-sin heading, cos heading).

    Notes
    -----
    Newton on the centre of mass, which is at R (sin tilt, 0, cos tilt) from the contact point in the precessing frame;
    the horizontal components are the Lagrange multipliers of the two rolling constraints.
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


@kernel
def friction_needed(normal, across, along):
    """Least friction coefficient for rolling without slip; NaN where the normal force is not positive."""
    if not normal > 0.0:
        return math.nan
    return math.sqrt(across * across + along * along) / normal


@kernel
def vertical_momentum(state, alpha):
    """Vertical angular momentum about the contact point, over m R^2/sqrt(R/g), and its rate of change.

    It is not conserved: the contact point moves, and not along the velocity of the centre of mass, so that
    d(H.e3)/dt = m R^2 (roll rate) (tilt rate) cos(tilt), although the contact force has no moment about that point.
    """
    S, C, T, w, o, s = state
    return (1.0 + alpha) * S * s + 0.5 * alpha * o * C, (s - o * T) * w * C


@internal
def suitable_step(state, constants, relative_step):
    """Scaled step: `relative_step` over the fastest frequency of the linearised motion, times cos(tilt)."""
    _, C, _, w, o, s = state
    return relative_step * C / math.sqrt(constants[0] * (1.0 + 2.0 * constants[1] * s * s) + o * o + w * w)


@internal
def _vertex(before, middle, after, first, second):
    """Extreme of the parabola through three values `first` and `second` apart; `middle` if it has none between."""
    rising, falling = (middle - before) / first, (after - middle) / second
    if not rising * falling < 0.0:
        return middle
    slope = (rising * second + falling * first) / (first + second)
    return middle - 0.25 * slope * slope * (first + second) / (falling - rising)


@internal
def _slopes(tilt, s, o, constants):
    """Derivatives by the tilt of s, o and the kinetic energy of the tilt (over m g R)."""
    S, C = math.sin(tilt), math.cos(tilt)
    oT = o * S / C
    return -constants[3] * o, oT - 2.0 * s, S + o * (constants[1] * s - constants[2] * oT)


@internal
def _along(tilt, s, o, kinetic, constants, h):
    """(s, o, kinetic) at tilt + h: one RK4 step in the tilt."""
    s1, o1, k1 = _slopes(tilt, s, o, constants)
    s2, o2, k2 = _slopes(tilt + 0.5 * h, s + 0.5 * h * s1, o + 0.5 * h * o1, constants)
    s3, o3, k3 = _slopes(tilt + 0.5 * h, s + 0.5 * h * s2, o + 0.5 * h * o2, constants)
    s4, o4, k4 = _slopes(tilt + h, s + h * s3, o + h * o3, constants)
    sixth = h / 6.0
    return (
        s + sixth * (s1 + 2.0 * (s2 + s3) + s4),
        o + sixth * (o1 + 2.0 * (o2 + o3) + o4),
        kinetic + sixth * (k1 + 2.0 * (k2 + k3) + k4),
    )


@internal
def _tilt_step(tilt, left, whole):
    """Step [rad] in the tilt: short near the pole of tan(tilt) and for a small range; it ends exactly at `left`."""
    longest = max(min(_TILT_STEP * math.cos(tilt), abs(whole) / _FEWEST), _SMALLEST)
    return left if abs(left) <= longest else math.copysign(longest, left)


@internal
def _contact_at(tilt, s, o, kinetic, constants, alpha):
    """(normal force over m g, friction needed) at a tilt of the motion; they do not depend on the sign of its rate."""
    S, C = math.sin(tilt), math.cos(tilt)
    w = math.sqrt(max(0.0, 2.0 * constants[0] * kinetic))
    normal, across, along = contact_forces((S, C, S / C, w, o, s), constants, alpha)
    return normal, friction_needed(normal, across, along)


@internal
def _extremes(start, constants, alpha, least_tilt, greatest_tilt):
    """(least normal force over m g, largest friction needed) between two tilts of the motion of a scaled start."""
    tilt = math.atan2(start[0], start[1])
    s, o, kinetic = start[5], start[4], 0.5 * start[3] * start[3] / constants[0]
    whole = greatest_tilt - least_tilt
    while tilt > least_tilt:
        h = _tilt_step(tilt, least_tilt - tilt, whole)
        s, o, kinetic = _along(tilt, s, o, kinetic, constants, h)
        tilt = max(tilt + h, least_tilt)
    normal_1, friction_1 = _contact_at(tilt, s, o, kinetic, constants, alpha)
    least, most, normal_2, friction_2, h_1 = normal_1, friction_1, normal_1, friction_1, math.inf
    while tilt < greatest_tilt:
        h = _tilt_step(tilt, greatest_tilt - tilt, whole)
        s, o, kinetic = _along(tilt, s, o, kinetic, constants, h)
        tilt = min(tilt + h, greatest_tilt)
        normal, friction = _contact_at(tilt, s, o, kinetic, constants, alpha)
        least = min(least, normal, _vertex(normal_2, normal_1, normal, h_1, h))
        most = max(most, friction, _vertex(friction_2, friction_1, friction, h_1, h))
        normal_2, normal_1, friction_2, friction_1, h_1 = normal_1, normal, friction_1, friction, h
    return least, (most if least > 0.0 else math.nan)


@parallel
def contact_extremes(starts, tilts, extremes):
    """Find the extremes of the contact forces that rolling without slip needs along the motion of every cell.

    Parameters
    ----------
    starts : float64[len(PARAMETERS), n]
    tilts : float64[len(EXTREME_TILTS), n]
        Least and greatest tilt [rad] of the motion; NaN where they are not known.
    extremes : float64[len(CONTACT), n], written
        Least normal force over m g [1], and largest friction coefficient needed [1], NaN where the normal force is
        zero or less on the way. Both NaN where the tilts are.

    Notes
    -----
    Never raises. The integration is one in the tilt, not in time: along a motion s, o and the kinetic energy of the
    tilt are functions of the tilt (Chaplygin 1897), and so are the forces. An integration in time can take a motion
    that returns to the saddle from which it was kicked past the saddle, on the wrong side.
    """
    for cell in prange(starts.shape[1]):
        least, greatest = tilts[TILT_MIN, cell], tilts[TILT_MAX, cell]
        normal = friction = math.nan
        if least <= greatest:
            unit = math.sqrt(starts[RADIUS, cell] / starts[GRAVITY, cell])
            state = scaled_state(
                starts[TILT, cell], starts[TILT_RATE, cell], starts[PRECESSION_RATE, cell], starts[ROLL_RATE, cell],
                unit,
            )  # fmt: skip
            alpha = starts[ALPHA, cell]
            normal, friction = _extremes(state, inertia(alpha), alpha, least, greatest)
        extremes[CONTACT_LEAST_NORMAL_FORCE, cell] = normal
        extremes[CONTACT_FRICTION_NEEDED, cell] = friction
