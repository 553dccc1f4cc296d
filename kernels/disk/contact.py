"""Contact forces that keep the disk rolling, and the angular momentum about the contact point.

All in scaled form (`kernels.disk.equations`): forces over m g, angular momentum over m R^2/sqrt(R/g).
"""

import math

from kernels.disk.rk4 import tilt_acceleration
from kernels.jit import kernel


@kernel
def contact_forces(state, constants, alpha):
    """Return the force of the plane on the disk, over m g.

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
        Vertical; horizontal across the track, towards (cos heading, sin heading), the direction in which a positive
        tilt leans; horizontal along the track, towards (-sin heading, cos heading).

    Notes
    -----
    Newton's law for the centre of mass, which is at R (sin tilt, 0, cos tilt) from the contact point in the
    precessing frame. The horizontal components are the Lagrange multipliers of the two rolling constraints.
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
    """Return the least friction coefficient for rolling without slip; NaN if the normal force is not positive."""
    if not normal > 0.0:
        return math.nan
    return math.sqrt(across * across + along * along) / normal


@kernel
def vertical_momentum(state, alpha):
    """Return the vertical angular momentum about the contact point, over m R^2/sqrt(R/g), and its rate of change.

    It is not conserved. The contact point does not move along the velocity of the centre of mass, so that
    d(H.e3)/dt = m R^2 (roll rate) (tilt rate) cos(tilt), although the contact force has no moment about that point.
    """
    S, C, T, w, o, s = state
    return (1.0 + alpha) * S * s + 0.5 * alpha * o * C, (s - o * T) * w * C


@kernel
def suitable_step(state, constants, relative_step):
    """Return the scaled step: `relative_step` over the fastest frequency of the linearised motion, times cos(tilt)."""
    _, C, _, w, o, s = state
    return relative_step * C / math.sqrt(constants[0] * (1.0 + 2.0 * constants[1] * s * s) + o * o + w * w)
