"""Static friction, and the release of dry friction: the set-valued part of the laws, at vanishing rates.

Coulomb's law bounds the force of static friction. A rate stays exactly zero as long as the force needed to hold it is
within the bound; there is no regularisation. Three rates can be held: the roll rate f (by contour friction), the
turning rate about the vertical v (by pivoting friction), and the horizontal turning rate (w, C f) as a whole (by
rolling friction, with the help of contour friction along f).
"""

import math

from kernels.jit import kernel
from kernels.lossy_disk.contact_motion import (
    Senses,
    compliance,
    contact_rates,
    lever,
    losses_here,
    per_inertia,
    pull_at_rest,
)

#: A disk that breaks away is moved over a first instant of this scaled length (over 1 + |v|) with its initial
#: acceleration, because rolling friction has no direction at rest. The error is of second order in this length.
_INSTANT = 1.0e-7

#: Factors on the bound of friction when it seizes, and when it has held before: they are slightly above 1, and the
#: second is larger, so that rounding cannot make friction release and seize again forever.
SEIZES, HOLDS_ON = 1.0 + 1.0e-12, 1.0 + 2.0e-12
LETS_GO = 0.0

#: Bisections for the direction in which a disk breaks away: down to the last bit of an angle.
_HALVINGS = 60


@kernel
def sign(x):
    """Return the sign of a number: -1, 0 or 1."""
    return 0.0 if x == 0.0 else math.copysign(1.0, x)


@kernel
def beginning_roll(state, inertia):
    """Return the sign of a roll rate that starts without a force: it comes with the tilting, as f' = -w v C (...)."""
    S, C, w, _, v = state
    tilting = w if w != 0.0 else pull_at_rest(S, C, v, inertia)
    return -1.0 if tilting * v > 0.0 else 1.0


@kernel
def _tilting(state, inertia):
    """Return the sign of the tilt rate, or if it vanishes, of the direction in which the disk will tilt."""
    S, C, w, _, v = state
    return sign(w) if w != 0.0 else sign(pull_at_rest(S, C, v, inertia))


@kernel
def _roll_held_or_let_go(state, turn, strength, inertia, losses):
    """Return state and senses after the roll rate has vanished while the tilt rate has not."""
    S, C, w, _, v = state
    still, held = (S, C, w, 0.0, v), Senses(0.0, turn, _tilting(state, inertia))
    _, _, forces = contact_rates(still, held, inertia, losses)
    needed = forces.roll
    most = losses_here(S, C, inertia, losses).contour
    if 0.0 < most and abs(needed) <= strength * most * forces.normal:
        return still, held
    sense = -sign(needed) if needed != 0.0 else beginning_roll(still, inertia)
    return state, Senses(sense, turn, 0.0)


@kernel
def _turn_held_or_let_go(state, roll, strength, inertia, losses):
    """Return state and senses after the turning rate has vanished while the roll rate has not."""
    S, C, w, f, _ = state
    still, held = (S, C, w, f, 0.0), Senses(roll, 0.0, 0.0)
    _, _, forces = contact_rates(still, held, inertia, losses)
    needed = forces.turn
    if abs(needed) <= strength * losses.pivoting * forces.normal:
        return still, held
    return state, Senses(roll, -sign(needed), 0.0)


@kernel
def is_held(S, C, turning, pivoted, inertia, losses):
    """Return whether friction holds tilt and roll rate of a disk that has neither rate.

    Parameters
    ----------
    S, C, turning : float
        Sine and cosine of the tilt; turning rate about the vertical v.
    pivoted : float
        Force of pivoting friction on v.

    Notes
    -----
    The torque of rolling friction lies in a disc. The part of its arm that the pull on the tilt does not use helps
    contour friction to hold the roll rate against pivoting friction. The normal force is the weight.
    """
    pull = pull_at_rest(S, C, turning, inertia)
    if not abs(pull) <= losses.rolling:
        return False
    G_ff, G_fv, _ = compliance(S, C, inertia)
    left = C * math.sqrt((losses.rolling - pull) * (losses.rolling + pull))
    return abs(G_fv * pivoted) <= G_ff * (losses_here(S, C, inertia, losses).contour + left)


@kernel
def _balance(angle, pull, push, disk, losses):
    """Return the mismatch between an angle and the direction in which a disk breaking away at it accelerates.

    Parameters
    ----------
    angle : float
        Direction of (w, C f), from 0 (only tilting) to a right angle.
    pull, push : float
        Torque on the tilt, and |F_v G_fv| of pivoting friction per normal force; both at least 0.
    disk : tuple of 4 floats
        Lever arm of the weight in the direction of the pull, reciprocal inertia of the tilt, C, G_ff.

    Returns
    -------
    (excess, w', f', normal)
        The excess is positive if the angle is too large.
    """
    lean, per, C, G_ff = disk
    across, along = math.cos(angle), math.sin(angle)
    tipped = per * lean
    normal = (1.0 - tipped * pull) / (1.0 - tipped * losses.rolling * across)
    tilting = per * (pull - losses.rolling * normal * across)
    rolling = normal * (push - G_ff * (losses.rolling * C * along + losses.contour))
    return along * tilting - across * C * rolling, tilting, rolling, normal


@kernel
def breaking_away(S, C, turning, turn, inertia, losses):
    """Return the accelerations with which a disk without tilt rate and roll rate breaks away from rolling friction.

    Parameters
    ----------
    S, C, turning : float
        The tilt, and the turning rate about the vertical.
    turn : float
        Sign of the turning rate, which pivoting friction opposes.

    Returns
    -------
    (w', f', normal)

    Notes
    -----
    Rolling friction opposes the direction in which the disk starts, and the inertia depends on the direction. So the
    start has to be parallel to the acceleration that results. Exactly one direction between only tilting and only
    rolling fulfils this; bisection finds it.
    """
    pull, (G_ff, G_fv, _) = pull_at_rest(S, C, turning, inertia), compliance(S, C, inertia)
    tilt_sense, push = math.copysign(1.0, pull), -G_fv * losses.pivoting * turn
    size, along = abs(pull), sign(push)
    disk = lever(S, C, inertia) * tilt_sense, per_inertia(S, C, inertia), C, G_ff
    here = losses_here(S, C, inertia, losses)
    least, most = 0.0, 0.5 * math.pi
    _, tilting, rolling, normal = _balance(0.0, size, abs(push), disk, here)
    if rolling <= 0.0:
        return tilt_sense * tilting, 0.0, normal
    for _ in range(_HALVINGS):
        angle = 0.5 * (least + most)
        excess, tilting, rolling, normal = _balance(angle, size, abs(push), disk, here)
        if excess < 0.0:
            least = angle
        else:
            most = angle
    return tilt_sense * tilting, along * rolling, normal


@kernel
def _set_going(state, turn, inertia, losses):
    """Return state and senses an instant after a disk at rest on its contact has broken away, and the instant.

    If contour friction holds the roll rate, only the tilt moves, and no instant is needed.
    """
    S, C, _, _, v = state
    tilting, rolling, normal = breaking_away(S, C, v, turn, inertia, losses)
    if rolling == 0.0 and losses.contour > 0.0:
        return state, Senses(0.0, turn, sign(tilting)), 0.0
    h, pivoted = _INSTANT / (1.0 + abs(v)), -losses.pivoting * turn * normal
    G_ff, G_fv, G_vv = compliance(S, C, inertia)
    along = (rolling - G_fv * pivoted) / G_ff
    angle, turning = 0.5 * h * h * tilting, G_fv * along + G_vv * pivoted
    there = (
        S + angle * C, C - angle * S, h * tilting, h * rolling,
        v + h * (turning if turn != 0.0 else 0.0),
    )  # fmt: skip
    sense = sign(rolling) if rolling != 0.0 else beginning_roll(there, inertia)
    return there, Senses(sense, turn, 0.0), h


@kernel
def decided(state, senses, vanished, strength, inertia, losses):
    """Return state and senses after rates have vanished: dry friction holds them, or lets the disk move.

    Parameters
    ----------
    state : tuple of 5 floats
        S, C, w, f, v; rates that vanished are zero to rounding.
    senses : kernels.lossy_disk.contact_motion.Senses
        Senses of the motion before: a rate that was held and is not among `vanished` stays held.
    vanished : tuple of 3 bools
        Whether roll rate, turning rate about the vertical, and tilt rate vanish, including held rates.
    strength : float
        Share of its bound up to which friction holds a single rate: SEIZES, or LETS_GO if it has just let go.
    inertia, losses
        As for `kernels.lossy_disk.contact_motion.contact_rates`.

    Returns
    -------
    (state, senses, instant)
        Held rates are exactly zero in the state. The instant is the scaled time that has passed.
    """
    no_roll, no_turn, no_tilting = vanished
    turn = 0.0 if no_turn and losses.pivoting > 0.0 else senses.turn
    S, C, w, f, v = state
    if no_roll and no_turn:
        # the disk falls straight, and no force turns it
        v = 0.0
    if no_roll and no_tilting:
        still = S, C, 0.0, 0.0, v
        if is_held(S, C, v, -losses.pivoting * turn, inertia, losses):
            return still, Senses(0.0, turn, 0.0), 0.0
        if losses.rolling > 0.0:
            return _set_going(still, turn, inertia, losses)
        w = 0.0
    state = S, C, w, f, v
    if no_roll and no_turn and turn == 0.0:
        held = 0.0 if losses.contour > 0.0 else senses.roll
        return (S, C, w, 0.0, v), Senses(held, turn, _tilting(state, inertia)), 0.0
    if no_roll:
        state, senses = _roll_held_or_let_go(state, turn, strength, inertia, losses)
    elif no_turn:
        state, senses = _turn_held_or_let_go(state, senses.roll, strength, inertia, losses)
    return state, senses, 0.0
