"""The motion while contour friction holds the roll rate at zero: the contact point rests, the disk tilts and turns.

Such a motion is holonomic: the disk turns about a point of the plane. Its state is (S, C, K, w, L), with the vertical
angular momentum L about that point, which pivoting friction alone changes; it has no roll rate that could drift.
"""

from kernels.jit import internal, kernel
from kernels.lossy_disk.rk4 import _entered


@internal
def vertical_inertia(S, C, K, inertia):
    """Moment of inertia about the vertical through the contact point, over m R^2.

    With 1/K in place of C: the angular momentum of `extended` is then that of `reduced` to rounding, whatever the error
    of the steps in K C = 1.
    """
    return inertia.i_roll * S * S + inertia.i_spin * C / K


@kernel
def pull_at_rest(S, C, turning, inertia):
    """Torque that tilts a disk which turns with the rate v = `turning` about its contact point, over m g R.

    Gravity and the centrifugal and gyroscopic torque: S (1 + (1 + alpha/2) v^2 C).
    """
    return S * (1.0 + turning * turning * C / inertia.i_tilt)


@internal
def held_rates(held, senses, inertia, losses):
    """How a held motion and its ledger change.

    Parameters
    ----------
    held : tuple of 5 floats
        S, C, K, w, L.
    senses : tuple of 2 floats
        Sign of w, which rolling friction opposes; sign of v, or 0 where pivoting friction holds that.
    inertia : kernels.lossy_disk.rk4.Inertia
    losses : kernels.lossy_disk.loss_laws.Losses

    Returns
    -------
    derivatives, ledger, normal
        As of `kernels.lossy_disk.rk4.rates`; the normal force over m g.
    """
    S, C, K, w, L = held
    tilting, turning = senses
    v = L / vertical_inertia(S, C, K, inertia)
    free = inertia.i_tilt * pull_at_rest(S, C, v, inertia)
    arm = losses.rolling * tilting
    normal = (1.0 - (S * free + w * w * C)) / (1.0 - inertia.i_tilt * S * arm)
    changes = (
        C * w,
        -(S * w),
        K * K * (S * w),
        free - inertia.i_tilt * (arm * normal),
        -losses.pivoting * turning * normal,
    )
    ledger = v, 0.0, arm * normal * w, losses.pivoting * normal * (turning * v), 0.0, 0.0, 0.0
    return changes, ledger, normal


@internal
def _moved(held, h, change):
    S, C, K, w, L = held
    dS, dC, dK, dw, dL = change
    return S + h * dS, C + h * dC, K + h * dK, w + h * dw, L + h * dL


@internal
def reduced(state, inertia):
    """State (S, C, K, w, L) of a disk whose roll rate is zero."""
    S, C, K, w, o, p = state
    return S, C, K, w, p * S + inertia.i_spin * o * C


@internal
def extended(held, inertia):
    """State (S, C, K, w, o, p) of a held one: without roll rate o = v C and p = (1+alpha) v S."""
    S, C, K, w, L = held
    v = L / vertical_inertia(S, C, K, inertia)
    # the error of the step in C and K would leave a roll rate in place of rounding
    return S, C, K, w, v / K, inertia.i_roll * (v * S)


@internal
def held_turning_rate(state, inertia):
    """Turning rate about the vertical of a state (S, C, K, w, o, p) whose roll rate is zero."""
    S, C, K, _, o, p = state
    return (p * S + inertia.i_spin * o * C) / vertical_inertia(S, C, K, inertia)


@kernel
def held_step(state, senses, inertia, losses, h):
    """State and gain of the ledger after one RK4 step of scaled length h with the roll rate held.

    Parameters
    ----------
    state : tuple of 6 floats
        S, C, K, w, o, p of a disk whose roll rate is zero.
    senses, inertia, losses
        As of `held_rates`.
    """
    held = reduced(state, inertia)
    total, gained, _ = held_rates(held, senses, inertia, losses)
    change, more, _ = held_rates(_moved(held, 0.5 * h, total), senses, inertia, losses)
    total, gained = _moved(total, 2.0, change), _entered(gained, 2.0, more)
    change, more, _ = held_rates(_moved(held, 0.5 * h, change), senses, inertia, losses)
    total, gained = _moved(total, 2.0, change), _entered(gained, 2.0, more)
    change, more, _ = held_rates(_moved(held, h, change), senses, inertia, losses)
    sixth = h / 6.0
    after = _moved(held, sixth, _moved(total, 1.0, change))
    nothing = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return extended(after, inertia), _entered(nothing, sixth, _entered(gained, 1.0, more))
