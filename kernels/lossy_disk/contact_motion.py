"""The motion in the rates of its contact: the roll rate f and the turning rate about the vertical v are its state.

The lanes carry o and p (`kernels.lossy_disk.equations`), of which f = s - o T and v = o C + s S are small differences
where friction is about to hold them. Here a rate that is held is zero, and a rate that begins has all its digits:
o = C (v - f S) and s = f C^2 + v S. The tangent comes from sine and cosine: carried
along, its error would grow with each pass near flat. The laws are those of the lanes (`kernels.lossy_disk.loss_laws`).
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
    """Against what dry friction acts during a leg of a motion.

    Attributes
    ----------
    roll : float
        Sign of the roll rate f; 0 where friction holds it.
    turn : float
        Sign of the turning rate about the vertical v; 0 where pivoting friction holds it.
    tilt : float
        While f is held, the sign of the tilt rate w, or 0 where that is held too; otherwise without meaning.
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
        Generalised forces on f and v, of all laws together, over m g R. Of a rate that is held it is what holds it.
    """

    normal: float
    roll: float
    turn: float


@kernel
def contact_state(state, inertia):
    """State (S, C, w, f, v) of a state (S, C, K, w, o, p)."""
    S, C, _, w, _, _ = state
    return S, C, w, roll_rate(state, inertia.i_inverse), turning_rate(state, inertia.i_inverse)


@kernel
def spin_state(state, inertia):
    """State (S, C, K, w, o, p) of a state (S, C, w, f, v)."""
    S, C, w, f, v = state
    # the inverse of `contact_state` for any error of the steps in S^2 + C^2 = 1: motions go to and fro often
    square = S * S + C * C
    return S, C, 1.0 / C, w, C * (v - f * S) / square, inertia.i_roll * (f * C * C + v * S) / square


# What follows is what friction asks of the equations. Other bodies have other functions under these names
# (`kernels.lossy_bodies.integrate`).


@simd
def per_inertia(S, C, inertia):
    """One over the moment of inertia of a rotation of the tilt about the contact point, in m R^2."""
    return inertia.i_tilt


@simd
def lever(S, C, inertia):
    """Lever of the weight about the contact point, over R: how fast the height falls with the tilt."""
    return S


@simd
def losses_here(S, C, inertia, losses):
    """Coefficients of the laws as forces on the rates f, v and (w, C f), where the contact is."""
    return losses


@kernel
def turning_inertia(S, C, inertia):
    """Moment of inertia about the vertical through the contact point, in m R^2."""
    return inertia.i_roll * S * S + inertia.i_spin * C * C


@kernel
def compliance(S, C, inertia):
    """Inverse inertia of f and v: G_ff, G_fv, G_vv; a force on one of them changes both."""
    T = S / C
    return (
        inertia.i_inverse + inertia.inverse_spin * T * T,
        S * (inertia.i_inverse - inertia.inverse_spin),
        inertia.i_inverse * S * S + inertia.inverse_spin * C * C,
    )


@kernel
def pull_at_rest(S, C, turning, inertia):
    """Torque that tilts a disk which turns with the rate v = `turning` about its contact point, over m g R.

    Gravity and the centrifugal and gyroscopic torque: S (1 + (1 + alpha/2) v^2 C).
    """
    return S * (1.0 + turning * turning * C / inertia.i_tilt)


@simd
def circle(S, C, inertia):
    """Radius of the circle along which the contact runs over what rolls, over R."""
    return 1.0


@kernel
def unforced(state, inertia):
    """What friction meets: the torque that tilts a motion without it, its `Load`, and f' and v'.

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
    """How a motion and its ledger change in scaled time, if friction does not hold the tilt.

    Parameters
    ----------
    state : tuple of 5 floats
        S, C, w, f, v.
    senses : Senses
    inertia : kernels.lossy_disk.rk4.Inertia
    losses : kernels.lossy_disk.loss_laws.Losses

    Returns
    -------
    derivatives, ledger, Forces
        The derivatives of a rate that is held are zero; ledger as of `kernels.lossy_disk.rk4.rates`.

    Notes
    -----
    Chaplygin's equations for o and s (`kernels.disk.equations.slopes`) in f and v, with the forces on these. What
    holds a rate is what leaves its derivative zero.
    """
    S, C, w, f, v = state
    T, heading = S / C, v - f * S
    free, load, free_roll, free_turn = unforced(state, inertia)
    laws = losses_here(S, C, inertia, losses)
    # while f is held the sign of the tilt rate holds for the whole step, as that of f does elsewhere
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
    """Scaled time over the fastest rate of the linearised motion without friction; near flat, the precession."""
    S, C, w, f, v = state
    s, o = f * C * C + v * S, C * (v - f * S)
    own = inertia.i_tilt * (1.0 + 2.0 * inertia.i_roll * s * s)
    return C / math.sqrt(C * C * own + o * o + w * w)


@kernel
def horizontal_rate(state, senses, inertia, losses):
    """Magnitude of the horizontal turning rate (w, C f), its rate of change, and how fast the vector changes."""
    S, C, w, f, _ = state
    (_, _, dw, df, _), _, _ = contact_rates(state, senses, inertia, losses)
    across, changing = C * f, C * df - S * w * f
    size = math.sqrt(w * w + across * across)
    falling = (w * dw + across * changing) / size if size > 0.0 else 0.0
    return size, falling, math.sqrt(dw * dw + changing * changing)


@kernel
def moved(state, h, change):
    """`state` + h * `change`, of five numbers each."""
    S, C, w, f, v = state
    dS, dC, dw, df, dv = change
    return S + h * dS, C + h * dC, w + h * dw, f + h * df, v + h * dv


@kernel
def entered(ledger, h, change):
    """`ledger` + h * `change`, of seven numbers each."""
    a0, a1, a2, a3, a4, a5, a6 = ledger
    b0, b1, b2, b3, b4, b5, b6 = change
    return (
        a0 + h * b0, a1 + h * b1, a2 + h * b2, a3 + h * b3, a4 + h * b4, a5 + h * b5, a6 + h * b6,
    )  # fmt: skip


@kernel
def contact_step(state, senses, inertia, losses, h):
    """State and gain of the ledger after one classical Runge-Kutta step of scaled length h (Kutta 1901).

    Parameters
    ----------
    state, senses, inertia, losses
        As of `contact_rates`.
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
