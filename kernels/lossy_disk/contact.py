"""The force of the plane on a disk with losses, whatever dry friction holds."""

import math

from kernels.jit import internal, kernel
from kernels.lossy_disk.dry_friction import force_that_holds_roll
from kernels.lossy_disk.held_roll import held_rates, held_turning_rate, reduced, vertical_inertia
from kernels.lossy_disk.rk4 import rates


@internal
def _held_changes(state, senses, inertia, losses):
    """w', s' and normal force of a disk whose roll rate is held."""
    S, C, K, w, _, _ = state
    v = held_turning_rate(state, inertia)
    if senses.tilt == 0.0:
        # tilt and roll rate are held: the forces on roll and turn change s = v S
        pivoted = -losses.pivoting * senses.turn
        along = force_that_holds_roll(state, senses.turn, 1.0, inertia, losses)
        return 0.0, inertia.i_inverse * (along + pivoted * S), 1.0
    held = reduced(state, inertia)
    (_, _, _, dw, dL), _, normal = held_rates(held, (senses.tilt, senses.turn), inertia, losses)
    # L = v (I_v of the tilt), and I_v' = 2 S C w (1 + alpha/2)
    turning = (dL - 2.0 * S * C * w * v / inertia.i_tilt) / vertical_inertia(S, C, K, inertia)
    return dw, turning * S + v * C * w, normal


@kernel
def contact_forces(state, senses, inertia, losses):
    """Force of the plane on the disk, over m g.

    Parameters
    ----------
    state : tuple of 6 floats
        S, C, K, w, o, p.
    senses : kernels.lossy_disk.dry_friction.Senses
    inertia : kernels.lossy_disk.rk4.Inertia
    losses : kernels.lossy_disk.loss_laws.Losses

    Returns
    -------
    (normal, across, along)
        As of `kernels.disk.contact.contact_forces`.

    Notes
    -----
    The centre of mass moves with the velocity (C w, s, -S w) across, along and up in the frame that turns with the
    heading: Newton's law for it holds with every law of friction.
    """
    S, C, K, w, o, p = state
    if senses.roll == 0.0:
        tilting, rolling, normal = _held_changes(state, senses, inertia, losses)
    else:
        (_, _, _, tilting, _, dp), _, (normal, _) = rates(state, (senses.roll, senses.turn), inertia, losses)
        rolling = inertia.i_inverse * dp
    across = C * tilting - S * w * w - o * K * (inertia.i_inverse * p)
    return normal, across, rolling + o * w


@internal
def slipping(normal, across, along):
    """Horizontal force over m g that the friction of the contact has to give."""
    return math.sqrt(across * across + along * along)
