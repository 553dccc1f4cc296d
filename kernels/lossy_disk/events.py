"""Steps that end at the first event: a rate vanishes, friction lets go, or the motion ends.

Each event has a margin, a function of the state that is positive before the event. If the margin is negative after a
step, the step is repeated from its beginning with the length at which the margin vanishes. This root over the step
length is found by the Illinois variant of the rule of false position (Dowell and Jarratt, BIT 11 (1971) 168). A step
of any length has only the error of the method, so the state there is as good as any other.
"""

import math
from typing import NamedTuple

from kernels.jit import kernel
from kernels.lossy_disk.contact import contact_forces
from kernels.lossy_disk.contact_motion import contact_rates, contact_step, horizontal_rate, losses_here
from kernels.lossy_disk.dry_friction import HOLDS_ON
from kernels.lossy_disk.loss_coefficients import Losses
from kernels.lossy_disk.loss_laws import EDGED
from kernels.lossy_disk.rk4 import Inertia

#: Events, in the order of `_margins`: the tilt rate changes its sign; roll rate or turning rate vanishes; friction
#: lets go of either; the tilt rate vanishes while the roll rate is held; the disk is flat; it lifts off; it slips; a
#: body with two edges stands on both; the criterion is broken. Events without a margin: all rates that rolling
#: friction opposes have vanished; all rates have vanished; a number is not finite, or friction almost holds the disk.
(
    TURNS,
    ROLL_VANISHES,
    TURN_VANISHES,
    ROLL_LET_GO,
    TURN_LET_GO,
    TILTING_VANISHES,
    FLATTENS,
    LIFTS,
    SLIPS,
    EDGES,
    BREACHES,
) = range(11)
CONTACT_RESTS, RESTS, FAILS, NO_EVENT = 11, 12, 13, -1

#: Scaled horizontal turning rate below which it counts as vanished, if it decreases.
_REST = 1.0e-13

_MOST_TRIALS, _MOST_HALVINGS = 80, 40

#: Relative distance to its limit below which a force is checked in the middle of a step too.
_NEAR = 0.2

#: Precision of the time of an event, over the step.
_SHARP = 1.0e-14


class Case(NamedTuple):
    """Constants of a motion.

    Attributes
    ----------
    inertia : kernels.lossy_disk.rk4.Inertia
    losses : kernels.lossy_disk.loss_coefficients.Losses
    flat_tilt, cos_flat : float
        flat_tilt [rad] and its cosine.
    friction : float
        Coefficient of friction; infinite where the disk cannot slip.
    reference : float
        Tilt from which the criterion measures [rad].
    relative_step : float
        Step over the time scale of the motion.
    longest : float
        Longest step in scaled time.
    """

    inertia: Inertia
    losses: Losses
    flat_tilt: float
    cos_flat: float
    friction: float
    reference: float
    relative_step: float
    longest: float


@kernel
def _margins(state, senses, heading, case, reach):
    """Return the margins of all events; infinite for impossible events.

    `heading` is the sign of the tilt rate before the step. The criterion is broken if the tilt is farther than
    `reach` [rad] from its reference.
    """
    losses, none = case.losses, math.inf
    S, C, w, f, v = state
    across, along, forces = contact_forces(state, senses, case.inertia, losses)
    rolls, lets_roll, turns, lets_turn, tilts = none, none, none, none, none
    if senses.roll == 0.0:
        most = losses_here(S, C, case.inertia, losses).contour
        lets_roll = HOLDS_ON * most * forces.normal - abs(forces.roll)
        tilts = senses.tilt * w if losses.rolling > 0.0 else none
    else:
        rolls = senses.roll * f
        if senses.turn == 0.0:
            lets_turn = HOLDS_ON * losses.pivoting * forces.normal - abs(forces.turn)
    if senses.turn != 0.0 and losses.pivoting > 0.0:
        turns = senses.turn * v
    slips = none
    if case.friction < math.inf:
        slips = case.friction * forces.normal - math.sqrt(across * across + along * along)
    breaches = none
    if reach < math.inf:
        breaches = reach - abs(math.atan2(S, C) - case.reference)
    return (
        heading * w if heading != 0.0 else none,
        rolls, turns, lets_roll, lets_turn, tilts, C - case.cos_flat, forces.normal, slips,
        case.inertia.side * S if EDGED and case.inertia.side != 0.0 else none, breaches,
    )  # fmt: skip


@kernel
def beyond(state, senses, case, reach):
    """Return the ending or breach that the state itself is beyond, from FLATTENS to BREACHES, or NO_EVENT."""
    margins = _margins(state, senses, 0.0, case, reach)
    for event in (FLATTENS, LIFTS, SLIPS, EDGES, BREACHES):
        if margins[event] <= 0.0:
            return event
    return NO_EVENT


@kernel
def _time_of(event, state, senses, heading, case, reach, h):
    """Return the length of the step, at most h, after which the margin of an event is just negative.

    It is negative after h. The length is zero if no shorter step leaves a positive margin.

    Zero if no shorter step leaves a positive margin.
    """
    before, after, side = 0.0, h, 0
    low = _margins(state, senses, heading, case, reach)[event]
    there, _ = contact_step(state, senses, case.inertia, case.losses, h)
    high = _margins(there, senses, heading, case, reach)[event]
    for _ in range(_MOST_HALVINGS):
        if low > _SHARP * -high:
            break
        # a rate that has just started and returns to zero within this step
        before = 0.5 * after
        there, _ = contact_step(state, senses, case.inertia, case.losses, before)
        low = _margins(there, senses, heading, case, reach)[event]
        if low < 0.0:
            after, high = before, low
    if not low > 0.0:
        return 0.0
    for _ in range(_MOST_TRIALS):
        trial = after - high * (after - before) / (high - low)
        if not before < trial < after:
            trial = 0.5 * (before + after)
        there, _ = contact_step(state, senses, case.inertia, case.losses, trial)
        margin = _margins(there, senses, heading, case, reach)[event]
        if margin > 0.0:
            before, low = trial, margin
            high = 0.5 * high if side == 1 else high
            side = 1
        else:
            after, high = trial, margin
            low = 0.5 * low if side == -1 else low
            side = -1
        if after - before <= _SHARP * h:
            break
    return after


@kernel
def _until_touched(event, state, senses, margin, case, h):
    """Return the length of a step of at most h after which a force exceeds its limit; infinite if it never does.

    `margin` is the margin at the end of the step. If it and the margin at the beginning are positive, the parabola
    through both and the margin in the middle gives the time of the minimum.
    """
    before = _margins(state, senses, 0.0, case, math.inf)[event]
    if before < 0.0:
        # friction has just changed its sign, and the force with it
        return 0.0
    if margin < 0.0:
        return h
    there, _ = contact_step(state, senses, case.inertia, case.losses, 0.5 * h)
    middle = _margins(there, senses, 0.0, case, math.inf)[event]
    if middle < 0.0:
        return 0.5 * h
    curvature = 2.0 * (before + margin - 2.0 * middle)
    slope = margin - before - curvature
    # as a share of the step
    share = -0.5 * slope / curvature if curvature > 0.0 else 1.0
    if not 0.0 < share < 1.0:
        return math.inf
    there, _ = contact_step(state, senses, case.inertia, case.losses, share * h)
    return share * h if _margins(there, senses, 0.0, case, math.inf)[event] < 0.0 else math.inf


@kernel
def _contact_rests(state, senses, case):
    """Return whether the horizontal turning rate has almost vanished and still decreases."""
    if senses.roll == 0.0 or not case.losses.rolling > 0.0:
        return False
    size, change, _ = horizontal_rate(state, senses, case.inertia, case.losses)
    return size < _REST and change < 0.0


@kernel
def _heading(state, senses, case):
    """Return the sign of the tilt rate, or of a disk at rest, its initial tilting; 0 if nothing tilts it."""
    rate = state[2]
    if rate == 0.0:
        (_, _, rate, _, _), _, _ = contact_rates(state, senses, case.inertia, case.losses)
    return 0.0 if rate == 0.0 else math.copysign(1.0, rate)


@kernel
def step_to_event(state, senses, case, reach, h):
    """Make one step, cut at its first event.

    Parameters
    ----------
    state : tuple of 5 floats
        S, C, w, f, v.
    senses : kernels.lossy_disk.contact_motion.Senses
    case : Case
    reach : float
        Distance of the tilt from the reference [rad] that breaks the criterion; infinite where it has been broken.
    h : float
        The longest length of the step, scaled.

    Returns
    -------
    (state, gain, h, event)
        State and gain of the ledger after the step; its length; the event that ended it, or NO_EVENT.
    """
    heading = _heading(state, senses, case)
    found = NO_EVENT
    after, gain = contact_step(state, senses, case.inertia, case.losses, h)
    # the tilt is monotone between turning points; a value passed twice in a step is found from the turning point
    if heading * after[2] < 0.0:
        turn = _time_of(TURNS, state, senses, heading, case, reach, h)
        if turn > 0.0:
            h, found = turn, TURNS
            after, gain = contact_step(state, senses, case.inertia, case.losses, h)
        else:
            # it turns right here: a step that ended here would be followed by another one of no length
            heading = 0.0
    margins, least = _margins(after, senses, heading, case, reach), h
    for event in range(ROLL_VANISHES, BREACHES + 1):
        if margins[event] < 0.0:
            time = _time_of(event, state, senses, heading, case, reach, h)
            if time <= least:
                found, least = event, time
    if least < h:
        h = least
        after, gain = contact_step(state, senses, case.inertia, case.losses, h)
        margins = _margins(after, senses, heading, case, reach)
    for event, near in ((SLIPS, _NEAR * case.friction * margins[LIFTS]), (LIFTS, _NEAR)):
        if found != LIFTS and found != SLIPS and margins[event] < near:
            touched = _until_touched(event, state, senses, margins[event], case, h)
            time = _time_of(event, state, senses, heading, case, reach, touched) if touched <= h else math.inf
            if time <= least:
                found, least = event, time
    if least < h:
        h = least
        after, gain = contact_step(state, senses, case.inertia, case.losses, h)
    # if all rates vanish at once, the roll rate does too
    if (found == NO_EVENT or found == TURNS or found == ROLL_VANISHES) and _contact_rests(
        after, senses, case
    ):
        found = CONTACT_RESTS
    return after, gain, h, found
