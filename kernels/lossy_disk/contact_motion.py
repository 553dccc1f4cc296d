"""The motion in terms of the contact rates: the state holds the roll rate f and the turning rate v about the vertical.

The lanes use o and p (`kernels.lossy_disk.equations`). When friction is about to hold f = s - o T or v = o C + s S,
these are small differences of o and s. Here a held rate is exactly zero, and a rate that starts has full precision:
o = C (v - f S) and s = f C^2 + v S. The tangent is computed from sine and cosine, because an integrated tangent would
gain error with each pass near flat. The laws are the same as in the lanes (`kernels.lossy_disk.loss_laws`).
"""

import math
from typing import NamedTuple

from kernels.jit import kernel, simd
from kernels.lossy_disk.equations import roll_rate, turning_rate
from kernels.lossy_disk.loss_laws import (
    Load,
    drag,
    dry_force,
    normal_force,
    rolling_friction,
    rub_force,
)
from kernels.lossy_disk.loss_laws import horizontal_rate as size_of_horizontal_rate


class Senses(NamedTuple):
    """Directions that dry friction opposes during a leg of a motion.

    Attributes
    ----------
    roll : float
        Sign of the roll rate f; 0 where friction holds it.
    turn : float
        Sign of the turning rate about the vertical v; 0 where pivoting friction holds it.
    tilt : float
        While f is held, the sign of the tilt rate w, or 0 if w is held too; unused otherwise.
    """

    roll: float
    turn: float
    tilt: float


class Forces(NamedTuple):
    """Forces of the plane on a disk.

    Attributes
    ----------
    normal : float
        Normal force over m g.
    roll, turn : float
        Generalised forces of all laws on f and v, over m g R. For a held rate, the force that holds it.
    """

    normal: float
    roll: float
    turn: float


@kernel
def contact_state(state, inertia):
    """Return the state (S, C, w, f, v) of a state (S, C, K, w, o, p)."""
    S, C, _, w, _, _ = state
    return S, C, w, roll_rate(state, inertia.i_inverse), turning_rate(state, inertia.i_inverse)


@kernel
def spin_state(state, inertia):
    """Return the state (S, C, K, w, o, p) of a state (S, C, w, f, v)."""
    S, C, w, f, v = state
    # exact inverse of `contact_state` even if S^2 + C^2 deviates from 1, because motions are converted often
    square = S * S + C * C
    return S, C, 1.0 / C, w, C * (v - f * S) / square, inertia.i_roll * (f * C * C + v * S) / square


# The following functions are all that friction needs from the equations. Other bodies replace them by functions of
# the same names (`kernels.lossy_bodies.integrate`).


@simd
def per_inertia(S, C, inertia):
    """Return the reciprocal moment of inertia of tilting about the contact point, in units of 1/(m R^2)."""
    return inertia.i_tilt


@simd
def lever(S, C, inertia):
    """Return the lever arm of the weight about the contact point, over R: decrease of the height per tilt."""
    return S


@simd
def losses_here(S, C, inertia, losses):
    """Return the coefficients of the laws as forces on the rates f, v and (w, C f), at the present contact point."""
    return losses


@kernel
def turning_inertia(S, C, inertia):
    """Return the moment of inertia about the vertical through the contact point, in m R^2."""
    return inertia.i_roll * S * S + inertia.i_spin * C * C


@kernel
def compliance(S, C, inertia):
    """Return the inverse inertia of f and v: G_ff, G_fv, G_vv; a force on either rate changes both."""
    T = S / C
    return (
        inertia.i_inverse + inertia.inverse_spin * T * T,
        S * (inertia.i_inverse - inertia.inverse_spin),
        inertia.i_inverse * S * S + inertia.inverse_spin * C * C,
    )


@kernel
def pull_at_rest(S, C, turning, inertia):
    """Return the torque, over m g R, that tilts a disk which turns with the rate v = `turning` about its contact point.

    The sum of gravity, centrifugal and gyroscopic torque: S (1 + (1 + alpha/2) v^2 C).
    """
    return S * (1.0 + turning * turning * C / inertia.i_tilt)


@simd
def circle(S, C, inertia):
    """Return the radius, over R, of the circle on the body along which the contact runs."""
    return 1.0


@kernel
def unforced(state, inertia):
    """Return the motion without friction: torque on the tilt, its `Load`, and f' and v'.

    `state` is S, C, w, f, v.
    """
    S, C, w, f, v = state
    T, heading = S / C, v - f * S
    o, s = C * heading, f * C * C + v * S
    free = S + o * (inertia.i_roll * s - inertia.i_spin * (S * heading))
    free_roll = w * (2.0 * f * T - (1.0 + inertia.i_inverse) * o)
    free_turn = -w * (s * C + inertia.i_inverse * o * S)
    return free, Load(1.0 - w * w * C, S, inertia.i_tilt), free_roll, free_turn


@kernel
def contact_rates(state, senses, inertia, losses):
    """Return the derivatives of a motion and its ledger in scaled time, if friction does not hold the tilt.

    Parameters
    ----------
    state : tuple of 5 floats
        S, C, w, f, v.
    senses : Senses
    inertia : kernels.lossy_disk.rk4.Inertia
    losses : kernels.lossy_disk.loss_coefficients.Losses

    Returns
    -------
    derivatives, ledger, Forces
        Derivatives of held rates are zero; the ledger as in `kernels.lossy_disk.rk4.rates`.

    Notes
    -----
    Chaplygin's equations for o and s (`kernels.disk.equations.slopes`), written for f and v, plus the forces on them.
    The force that holds a rate is the force that makes its derivative zero.
    """
    S, C, w, f, v = state
    T, heading = S / C, v - f * S
    free, load, free_roll, free_turn = unforced(state, inertia)
    laws = losses_here(S, C, inertia, losses)
    # while f is held, the sign of the tilt rate is kept for the whole step, as is the sign of f otherwise
    pace, opposed = (senses.tilt * w, senses.tilt) if senses.roll == 0.0 else (1.0, w)
    turning = size_of_horizontal_rate((C, opposed, f))
    torque, _, rolled, slid, _ = rolling_friction((C, opposed, f), turning, free, load, laws.rolling, 1.0)
    normal, (blown, _) = normal_force(load, torque), drag(f, (S, C, T), laws)
    rubbed = dry_force(f, senses.roll, load, torque, laws)
    roll = -(rub_force(f, rubbed, laws) + blown + slid)
    turn = -laws.pivoting * normal * senses.turn
    G_ff, G_fv, G_vv = compliance(S, C, inertia)
    if senses.roll == 0.0:
        roll = -(free_roll + G_fv * turn) / G_ff
    elif senses.turn == 0.0:
        turn = -(free_turn + G_fv * roll) / G_vv
    rolling = free_roll + G_ff * roll + G_fv * turn if senses.roll != 0.0 else 0.0
    turning = free_turn + G_fv * roll + G_vv * turn if senses.turn != 0.0 else 0.0
    changes = C * w, -(S * w), load.i_tilt * torque, rolling, turning
    ledger = (
        heading, circle(S, C, inertia) * (senses.roll * f), pace * rolled,
        laws.pivoting * normal * (senses.turn * v), rubbed * f, laws.damping * f * f, blown * f,
    )  # fmt: skip
    return changes, ledger, Forces(normal, roll, turn)


@kernel
def time_scale(state, inertia):
    """Return the reciprocal of the fastest rate of the linearised motion without friction (near flat: precession)."""
    S, C, w, f, v = state
    s, o = f * C * C + v * S, C * (v - f * S)
    own = inertia.i_tilt * (1.0 + 2.0 * inertia.i_roll * s * s)
    return C / math.sqrt(C * C * own + o * o + w * w)


@kernel
def horizontal_rate(state, senses, inertia, losses):
    """Return the magnitude of the horizontal turning rate (w, C f), its derivative, and the magnitude of (w, C f)'."""
    S, C, w, f, _ = state
    (_, _, dw, df, _), _, _ = contact_rates(state, senses, inertia, losses)
    across, changing = C * f, C * df - S * w * f
    size = math.sqrt(w * w + across * across)
    falling = (w * dw + across * changing) / size if size > 0.0 else 0.0
    return size, falling, math.sqrt(dw * dw + changing * changing)


@kernel
def moved(state, h, change):
    """Return `state` + h * `change`, of five numbers each."""
    S, C, w, f, v = state
    dS, dC, dw, df, dv = change
    return S + h * dS, C + h * dC, w + h * dw, f + h * df, v + h * dv


@kernel
def entered(ledger, h, change):
    """Return `ledger` + h * `change`, of seven numbers each."""
    a0, a1, a2, a3, a4, a5, a6 = ledger
    b0, b1, b2, b3, b4, b5, b6 = change
    return (
        a0 + h * b0, a1 + h * b1, a2 + h * b2, a3 + h * b3, a4 + h * b4, a5 + h * b5, a6 + h * b6,
    )  # fmt: skip


@kernel
def contact_step(state, senses, inertia, losses, h):
    """Return the state and the gain of the ledger after one classical Runge-Kutta step of scaled length h (Kutta 1901).

    Parameters
    ----------
    state, senses, inertia, losses
        As for `contact_rates`.
    h : float
    """
    total, gained, _ = contact_rates(state, senses, inertia, losses)
    change, more, _ = contact_rates(moved(state, 0.5 * h, total), senses, inertia, losses)
    total, gained = moved(total, 2.0, change), entered(gained, 2.0, more)
    change, more, _ = contact_rates(moved(state, 0.5 * h, change), senses, inertia, losses)
    total, gained = moved(total, 2.0, change), entered(gained, 2.0, more)
    change, more, _ = contact_rates(moved(state, h, change), senses, inertia, losses)
    sixth, nothing = h / 6.0, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return moved(state, sixth, moved(total, 1.0, change)), entered(nothing, sixth, entered(gained, 1.0, more))
