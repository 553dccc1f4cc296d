"""The derivatives of a sliding motion with losses, and one classical Runge-Kutta step of a single motion.

Inside a step the tangent T = S K replaces K = 1/cos(tilt), because its derivative takes one multiplication less; then
1/C = C + S T. The step of the lanes is in `kernels.lossy_disk.lane_step`.
"""

from typing import NamedTuple

from kernels.jit import kernel, simd
from kernels.lossy_disk.loss_laws import (
    Load,
    drag,
    drag_near,
    dry_force,
    horizontal_rate,
    normal_force,
    pivoting_force,
    pivoting_friction,
    rolling_friction,
    rolling_friction_near,
    rub_force,
)


class Inertia(NamedTuple):
    """Constants of the equations for one mass distribution: see `inertia`."""

    i_tilt: float
    i_roll: float
    i_spin: float
    i_inverse: float
    drag: float
    inverse_spin: float


@simd
def inertia(alpha):
    """Return 1/(1 + alpha/2), 1 + alpha, alpha/2, 1/(1 + alpha), 2/(1 + alpha), 2/alpha as `Inertia`."""
    i_inverse = 1.0 / (1.0 + alpha)
    return Inertia(
        1.0 / (1.0 + 0.5 * alpha), 1.0 + alpha, 0.5 * alpha, i_inverse, 2.0 * i_inverse, 2.0 / alpha
    )


class Forces(NamedTuple):
    """Forces at one instant of a sliding motion, all over m g or m g R.

    Attributes
    ----------
    f : float
        The roll rate.
    normal : float
        Normal force.
    dry, rub, blow : float
        Forces against the roll rate: of dry contour friction; of all contour friction; of the air.
    along : float
        Force of all laws against the roll rate.
    slowed, rolled : float
        Torque of rolling friction over the horizontal turning rate, and its power.
    held, pivoted : float
        Force of pivoting friction on the turning rate about the vertical, and its power.
    torque, slope : float
        Torque that accelerates the tilt; do/dtilt without forces.
    drag : tuple of 2 floats
        As returned by `loss_laws.drag`.
    near : tuple of 4 floats
        As used by `loss_laws.rolling_friction_near`.
    way : float
        Speed of the contact along its circle on the body, over R; signed as the roll rate.
    """

    f: float
    normal: float
    dry: float
    rub: float
    blow: float
    along: float
    slowed: float
    rolled: float
    held: float
    pivoted: float
    torque: float
    slope: float
    drag: tuple
    near: tuple
    way: float


@simd
def changes(state, sense, inertia, losses):
    """Return the derivatives of a sliding motion in scaled time.

    Parameters
    ----------
    state : tuple of 6 floats
        S, C, T, w, o, p (`kernels.lossy_disk.equations`, with T = S K).
    sense : tuple of 2 floats
        Signs of the roll rate and of the turning rate about the vertical; the second is 0 if friction holds that rate.
    inertia : Inertia
    losses : kernels.lossy_disk.loss_coefficients.Losses

    Returns
    -------
    (dS, dC, dT, torque, do, dp), forces
        Derivatives of the state, with the torque that accelerates the tilt in place of w'; the `Forces`.
    """
    now = instant(state, inertia)
    motion = state[1], state[3], now.f
    turning = horizontal_rate(motion)
    torque, slowed, rolled, slid, reciprocal = rolling_friction(
        motion, turning, now.free, now.load, losses.rolling, 1.0
    )
    near = turning[1], turning[2], slowed, reciprocal
    blow = drag(now.f, state[:3], losses)
    return _changes(state, now, (torque, slowed, rolled, slid), blow, near, sense, inertia, losses)


@simd
def changes_near(state, sense, inertia, losses, last):
    """Return `changes` near a stage, from its rolling friction and drag (`last` of `lane_step.lane_step`)."""
    now = instant(state, inertia)
    rolling = rolling_friction_near(
        (state[1], state[3], now.f), last[0], now.free, now.load, losses.rolling, 1.0
    )
    blow = drag_near(now.f, state[:3], losses, last[1], last[2])
    return _changes(state, now, rolling, blow, last[0], sense, inertia, losses)


class Instant(NamedTuple):
    """Quantities that follow from a state without any law.

    Attributes
    ----------
    f, slope, free : float
        Roll rate; do/dtilt; torque that accelerates the tilt.
    load : kernels.lossy_disk.loss_laws.Load
    """

    f: float
    slope: float
    free: float
    load: Load


@simd
def instant(state, inertia):
    """Return the `Instant` of a state."""
    S, C, T, w, o, p = state
    oT = o * T
    load = Load(1.0 - w * (C * w), S, inertia.i_tilt)
    free = S + o * (p - inertia.i_spin * oT)
    return Instant(inertia.i_inverse * p - oT, oT - inertia.drag * p, free, load)


@simd
def _changes(state, now, rolling, blow, near, sense, inertia, losses):
    """Return `changes`, given the rolling friction and the drag."""
    S, C, T, w, o, p = state
    f, slope, _, load = now
    torque, slowed, rolled, slid = rolling
    dS, minus_dC, wT = C * w, S * w, w * T
    dry = dry_force(f, sense[0], load, torque, losses)
    rub = rub_force(f, dry, losses)
    along, normal = rub + blow[0] + slid, normal_force(load, torque)
    unheld = along * (inertia.inverse_spin * T) + w * slope, -w * o - along
    inner = S, C, w, o, p
    held = pivoting_force(inner, unheld, normal, sense[1], inertia, losses.pivoting)
    do, dp, pivoted = pivoting_friction(inner, unheld, held, sense[1], inertia)
    return (dS, -minus_dC, w + wT * T, torque, do, dp), Forces(
        f, normal, dry, rub, blow[0], along, slowed, rolled, held, pivoted, torque, slope, blow, near, f
    )


@simd
def entries(state, sense, forces):
    """Return the rates of the ledger: heading, path over R, and the power of each law over m g R.

    Parameters
    ----------
    state : tuple of 6 floats
        S, C, T, w, o, p.
    sense : tuple of 2 floats
        As for `changes`.
    forces : Forces

    Returns
    -------
    (turn, roll, rolling, pivoting, contour, damping, air)
    """
    S, C, T, _, o, _ = state
    f = forces.f
    return (
        o * (C + S * T), sense[0] * forces.way, forces.rolled, forces.pivoted,
        forces.dry * f, (forces.rub - forces.dry) * f, forces.blow * f,
    )  # fmt: skip


@simd
def _moved(state, h, change):
    """Return `state` + h * `change`, of six numbers each."""
    S, C, T, w, o, p = state
    dS, dC, dT, dw, do, dp = change
    return S + h * dS, C + h * dC, T + h * dT, w + h * dw, o + h * do, p + h * dp


@simd
def _entered(ledger, h, rates):
    """Return `ledger` + h * `rates`, of seven numbers each."""
    a0, a1, a2, a3, a4, a5, a6 = ledger
    b0, b1, b2, b3, b4, b5, b6 = rates
    return (
        a0 + h * b0, a1 + h * b1, a2 + h * b2, a3 + h * b3, a4 + h * b4, a5 + h * b5, a6 + h * b6,
    )  # fmt: skip


@simd
def with_tangent(state):
    """Return the state with T in place of K."""
    S, C, K, w, o, p = state
    return S, C, S * K, w, o, p


@kernel
def rates(state, sense, inertia, losses):
    """Return the derivatives of a sliding motion and its ledger in scaled time.

    Parameters
    ----------
    state : tuple of 6 floats
        S, C, K, w, o, p.
    sense, inertia, losses
        As for `changes`.

    Returns
    -------
    (dS, dC, dK, dw, do, dp), (turn, roll, rolling, pivoting, contour, damping, air), (normal, held)
        Derivatives of the state; of heading, path (over R) and losses (over m g R); the normal force over m g and the
        force of pivoting friction on the turning rate.
    """
    inner = with_tangent(state)
    (dS, dC, _, torque, do, dp), forces = changes(inner, sense, inertia, losses)
    K = state[2]
    return (
        (dS, dC, -K * K * dC, inertia.i_tilt * torque, do, dp),
        entries(inner, sense, forces),
        (forces.normal, forces.held),
    )


@kernel
def _stage(state, sense, inertia, losses):
    (dS, dC, dT, torque, do, dp), forces = changes(state, sense, inertia, losses)
    return (dS, dC, dT, inertia.i_tilt * torque, do, dp), entries(state, sense, forces)


@kernel
def step(state, sense, inertia, losses, h):
    """Make one step of scaled length h, which may be negative, and integrate the ledger with the same weights.

    Parameters
    ----------
    state : tuple of 6 floats
        S, C, K, w, o, p.
    sense, inertia, losses
        As for `changes`.

    Returns
    -------
    (S, C, K, w, o, p), (turn, roll, rolling, pivoting, contour, damping, air)
        The state after the step, and the gain of the ledger.
    """
    inner = with_tangent(state)
    change, gain = _stage(inner, sense, inertia, losses)
    total, gained = change, gain
    for share in (0.5, 0.5, 1.0):
        change, gain = _stage(_moved(inner, share * h, change), sense, inertia, losses)
        weight = 1.0 / share
        total, gained = _moved(total, weight, change), _entered(gained, weight, gain)
    sixth = h / 6.0
    S, C, _, w, o, p = _moved(inner, sixth, total)
    nothing = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    return (S, C, 1.0 / C, w, o, p), _entered(nothing, sixth, gained)
