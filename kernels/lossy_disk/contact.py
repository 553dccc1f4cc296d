"""The force of the plane on a disk with losses, sliding or held by dry friction."""

from kernels.jit import kernel
from kernels.lossy_disk.contact_motion import Forces, compliance, contact_rates


@kernel
def all_held(senses):
    """Return whether friction holds both tilt and roll rate: the disk can then only turn about the vertical."""
    return senses.roll == 0.0 and senses.tilt == 0.0


@kernel
def _forces(state, senses, inertia, losses):
    """Return the acceleration of the tilt, and `Forces`."""
    if all_held(senses):
        S, C, _, _, _ = state
        pivoted = -losses.pivoting * senses.turn
        G_ff, G_fv, _ = compliance(S, C, inertia)
        return 0.0, Forces(1.0, -G_fv * pivoted / G_ff, pivoted)
    (_, _, tilting, _, _), _, forces = contact_rates(state, senses, inertia, losses)
    return tilting, forces


@kernel
def contact_forces(state, senses, inertia, losses):
    """Return the force of the plane on the disk, over m g.

    Parameters
    ----------
    state : tuple of 5 floats
        S, C, w, f, v.
    senses, inertia, losses
        As for `kernels.lossy_disk.contact_motion.contact_rates`.

    Returns
    -------
    (across, along, Forces)
        Horizontal forces as in `kernels.bodies.trajectory.Forces`, and the other forces.

    Notes
    -----
    The centre of mass moves with the velocity (C w, s, -S w) across, along and up in the frame that turns with the
    heading. Newton's law for it holds for any law of friction. s' = (F_f + F_v S - w o) / (1+alpha).
    """
    S, C, w, f, v = state
    tilting, forces = _forces(state, senses, inertia, losses)
    heading = v - f * S
    o, s = C * heading, f * C * C + v * S
    rolling = inertia.i_inverse * (forces.roll + forces.turn * S - w * o)
    return C * tilting - S * w * w - heading * s, rolling + o * w, forces
