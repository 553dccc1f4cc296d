"""One motion in scalar code: steps, events, static friction, the ledger, until an ending.

The lanes step sliding motions. This module handles their events, and follows motions that friction holds until they
slide again.
"""

import math
from typing import NamedTuple

from kernels.disk.equations import energy
from kernels.jit import kernel
from kernels.lossy_disk.contact import all_held
from kernels.lossy_disk.contact_motion import (
    Senses,
    compliance,
    contact_rates,
    contact_state,
    contact_step,
    entered,
    horizontal_rate,
    losses_here,
    moved,
    per_inertia,
    spin_state,
    time_scale,
    turning_inertia,
)
from kernels.lossy_disk.dry_friction import _HALVINGS, LETS_GO, SEIZES, decided, is_held
from kernels.lossy_disk.endings import EDGE_CHANGE, FLAT, HORIZON, LIFT_OFF, REST, SLIP, UNRESOLVED
from kernels.lossy_disk.events import (
    BREACHES,
    CONTACT_RESTS,
    EDGES,
    FAILS,
    FLATTENS,
    LIFTS,
    NO_EVENT,
    RESTS,
    ROLL_LET_GO,
    ROLL_VANISHES,
    SLIPS,
    TILTING_VANISHES,
    TURN_LET_GO,
    TURN_VANISHES,
    TURNS,
    beyond,
    step_to_event,
)
from kernels.lossy_disk.loss_laws import viscosity

#: Code of a motion without an ending so far.
MOVING = -1

#: Horizontal turning rate below which a motion with rolling friction is followed here; lanes take it over at twice
#: that.
SLOW_CONTACT = 1.0e-3

#: Largest steps, over the relative step: as a share of the time in which the horizontal turning rate would vanish,
#: and of the time in which viscous friction damps the roll rate.
_SHARE_UNTIL_REST, _SHARE_OF_RELAXING = 2.0, 4.0

#: Longest scaled time over which the rest of the horizontal turning rate vanishes.
_LAST = 1.0e-6

#: Number of steps here after which a motion is abandoned.
MOST_STEPS = 1.0e7

#: Number of switches of friction, minus half the steps, after which a motion is abandoned: it would switch forever.
_MOST_SWITCHES = 1000.0

#: A step that gains more energy (of m g R) than this has failed: it is ten times the largest tolerance.
_MOST_WON = 1.0

#: A motion is almost held if friction turns its direction within this share of all other time scales; explicit steps
#: would have to be that short.
_BRINK = 1.0e-4

#: A rate of a start below this relative rounding error counts as zero.
_ROUNDING = 8.0 * 2.0**-52


class Motion(NamedTuple):
    """State of a motion at an instant.

    Attributes
    ----------
    state : tuple of 5 floats
        S, C, w, f, v (`kernels.lossy_disk.contact_motion`).
    senses : kernels.lossy_disk.contact_motion.Senses
    time : float
        Scaled.
    ledger : tuple of 7 floats
        Heading, path over R, energy taken by rolling, pivoting and contour friction, damping and air, over m g R.
    """

    state: tuple
    senses: Senses
    time: float
    ledger: tuple


class Record(NamedTuple):
    """Results of a motion so far.

    Attributes
    ----------
    least, greatest : float
        Extreme tilts [rad].
    breach : float
        Scaled time when the criterion was first broken; NaN if it has not been.
    steps, switches : float
        Number of steps, and how often friction reversed, seized or let go.
    """

    least: float
    greatest: float
    breach: float
    steps: float
    switches: float


@kernel
def tilt_of(state):
    """Return the tilt [rad] of a state."""
    return math.atan2(state[0], state[1])


@kernel
def stiffness(S, C, inertia, losses):
    """Return the horizontal turning rate, divided by the time in which rolling friction turns its direction."""
    G_ff, _, _ = compliance(S, C, inertia)
    return losses.rolling * (per_inertia(S, C, inertia) + C * C * G_ff)


@kernel
def is_on_brink(state, senses, inertia, losses):
    """Return whether rolling friction almost holds a turning disk: it would start slowly and be stiff sideways."""
    S, C, w, f, v = state
    if not losses.rolling > 0.0 or senses.roll == 0.0 or (f == 0.0 and v == 0.0):
        # a disk that falls straight has no motion across
        return False
    fast = _BRINK * stiffness(S, C, inertia, losses)
    if w * w + C * C * f * f > (fast * time_scale(state, inertia)) ** 2:
        return False
    size, _, change = horizontal_rate(state, senses, inertia, losses)
    # a motion off its direction, or one that friction is stopping, is not slow
    return 0.0 < size and change < fast


@kernel
def step_length(state, senses, case):
    """Return the length of the next step, scaled: `case.relative_step` over the fastest rate of the state."""
    S, C, _, f, v = state
    inertia, losses = case.inertia, case.losses
    h = case.relative_step * time_scale(state, inertia)
    # near flat a roll rate relaxes fast, because the inertia is small
    here, (G_ff, _, _) = losses_here(S, C, inertia, losses), compliance(S, C, inertia)
    viscous = viscosity(f, (S, C, S / C), here)
    if viscous * G_ff * h > _SHARE_OF_RELAXING * case.relative_step:
        h = _SHARE_OF_RELAXING * case.relative_step / (viscous * G_ff)
    if losses.rolling > 0.0 and senses.roll != 0.0:
        size, _, change = horizontal_rate(state, senses, inertia, losses)
        share = _SHARE_UNTIL_REST * case.relative_step
        if change * h > share * size:
            h = share * size / change
        # a slow motion is stiff across its direction; a disk that falls straight has no motion across
        stiff = stiffness(S, C, inertia, losses)
        if stiff * h > size and not (f == 0.0 and v == 0.0):
            h = size / stiff
    return min(h, case.longest)


@kernel
def begun(state, case, reach):
    """Return the `Motion` of a start, and the event that it is beyond, or NO_EVENT.

    Parameters
    ----------
    state : tuple of 6 floats
        S, C, K, w, o, p.
    case : kernels.lossy_disk.events.Case
    reach : float
        As for `kernels.lossy_disk.events.step_to_event`.
    """
    S, C, K, w, o, p = state
    contact = contact_state(state, case.inertia)
    _, _, _, f, v = contact
    s = case.inertia.i_inverse * p
    no_roll = abs(f) <= _ROUNDING * (abs(s) + abs(o * S * K))
    no_turn = abs(v) <= _ROUNDING * (abs(o * C) + abs(s * S))
    senses = Senses(math.copysign(1.0, f), math.copysign(1.0, v), 0.0)
    nothing = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    motion = Motion(contact, senses, 0.0, nothing)
    if no_roll or no_turn:
        motion = _switched(motion, (no_roll, no_turn, w == 0.0), SEIZES, case)
    event = beyond(motion.state, motion.senses, case, reach)
    if ending_of(event) != MOVING:
        # the first instant, in which the disk broke away, does not count
        motion = Motion(motion.state, motion.senses, 0.0, nothing)
    return motion, event


@kernel
def _switched(motion, vanished, strength, case):
    """Return the motion after friction has decided about vanished rates."""
    state, senses, instant = decided(
        motion.state, motion.senses, vanished, strength, case.inertia, case.losses
    )
    _, _, _, _, v = state
    gain = (v, 0.0, 0.0, case.losses.pivoting * abs(v), 0.0, 0.0, 0.0)
    return Motion(state, senses, motion.time + instant, entered(motion.ledger, instant, gain))


@kernel
def _come_to_rest(motion, case, until):
    """Return the motion at the instant at which the rest of its horizontal turning rate has vanished."""
    state, senses = motion.state, motion.senses
    size, change, _ = horizontal_rate(state, senses, case.inertia, case.losses)
    h = min(size, -change * _LAST, -change * (until - motion.time)) / -change
    changes, gain, _ = contact_rates(state, senses, case.inertia, case.losses)
    # the loss of this rest ends with it
    return Motion(moved(state, h, changes), senses, motion.time + h, entered(motion.ledger, h, gain))


@kernel
def _still_held(motion, later, case):
    """Return whether friction still holds a disk that turns on its contact at the rate `later`."""
    S, C, _, _, _ = motion.state
    pivoted = -case.losses.pivoting * motion.senses.turn
    return is_held(S, C, later, pivoted, case.inertia, case.losses)


@kernel
def _let_go_after(motion, h, slowing, case):
    """Return the time within h at which friction lets go of a disk that slows down as it turns."""
    held, let = 0.0, h
    _, _, _, _, v = motion.state
    for _ in range(_HALVINGS):
        middle = 0.5 * (held + let)
        if _still_held(motion, v - slowing * middle, case):
            held = middle
        else:
            let = middle
    return let


@kernel
def _turned(motion, case, until):
    """Return a later motion of a disk that friction holds except for its turning about the vertical, and the event.

    The turning of another body may balance its weight, so that friction lets the body go when it slows down. The
    force that friction needs is linear in the square of the rate, and the force that it can give is convex: if it
    holds at both ends of an interval, it holds in between.
    """
    turn, arm, (S, C, _, _, v) = motion.senses.turn, case.losses.pivoting, motion.state
    I_v = turning_inertia(S, C, case.inertia)
    h, event, later = until - motion.time, NO_EVENT, v
    if v == 0.0 or turn == 0.0:
        return motion, RESTS
    if arm > 0.0:
        stop = abs(v) * I_v / arm
        if stop <= h:
            h, event, later = stop, RESTS, 0.0
        else:
            later = v - turn * arm * h / I_v
    if not _still_held(motion, later, case):
        h, event = _let_go_after(motion, h, turn * arm / I_v, case), CONTACT_RESTS
        later = v - turn * arm * h / I_v
    # pivoting friction is constant, and so is the deceleration
    mean = 0.5 * (v + later)
    gain = (mean, 0.0, 0.0, arm * abs(mean), 0.0, 0.0, 0.0)
    time = until if event == NO_EVENT else motion.time + h
    after = Motion((S, C, 0.0, 0.0, later), motion.senses, time, entered(motion.ledger, h, gain))
    if event == CONTACT_RESTS:
        after = _switched(after, (True, later == 0.0, True), SEIZES, case)
    return after, event


@kernel
def energy_of(state, inertia):
    """Return the energy (of m g R) of a state."""
    S, C, _, w, o, p = spin_state(state, inertia)
    return energy(S, C, w, o, inertia.i_inverse * p, 2.0 * inertia.i_spin)


@kernel
def leap(motion, case, until, reach):
    """Advance by one step, to the first event at most, where friction decides how the motion continues.

    Parameters
    ----------
    motion : Motion
    case : kernels.lossy_disk.events.Case
    until : float
        Scaled time at which the step ends at the latest.
    reach : float
        As for `kernels.lossy_disk.events.step_to_event`.

    Returns
    -------
    (motion, h, event)
        The motion after the step; the scaled length of the step, which has the senses of the motion before; the event
        at its end.
    """
    if all_held(motion.senses):
        after, event = _turned(motion, case, until)
        return after, after.time - motion.time, event
    if is_on_brink(motion.state, motion.senses, case.inertia, case.losses):
        return motion, 0.0, FAILS
    left = until - motion.time
    h = min(step_length(motion.state, motion.senses, case), left)
    state, gain, length, event = step_to_event(motion.state, motion.senses, case, reach, h)
    time = until if length == left else motion.time + length
    after = Motion(state, motion.senses, time, entered(motion.ledger, 1.0, gain))
    won = energy_of(state, case.inertia) - energy_of(motion.state, case.inertia)
    # written so that NaN fails too; with huge rates the next steps would be too short to end, and beyond flat they
    # would go back in time
    possible = won <= _MOST_WON and (state[1] > 0.0 or event == FLATTENS)
    if not (possible and math.isfinite(after.ledger[0])):
        return motion, 0.0, FAILS
    if event == CONTACT_RESTS:
        after = _come_to_rest(after, case, until)
    if is_switch(event):
        no_roll = event == ROLL_VANISHES or event == CONTACT_RESTS or motion.senses.roll == 0.0
        no_turn = event == TURN_VANISHES or motion.senses.turn == 0.0
        no_tilting = event == TILTING_VANISHES or event == CONTACT_RESTS or after.state[2] == 0.0
        strength = LETS_GO if event == ROLL_LET_GO or event == TURN_LET_GO else SEIZES
        after = _switched(after, (no_roll, no_turn, no_tilting), strength, case)
    return after, length, event


@kernel
def turns_early(motion, case, steps):
    """Return whether the tilt may turn within the first steps of a motion while its acceleration changes by half.

    The lanes see one turning point in a few steps, by a parabola about the state nearest to it. For a start that is
    almost at rest, this is the start itself. But near a steady wobble that friction slows down, the next turning
    point soon after it may have the least tilt of all.
    """
    h = steps * step_length(motion.state, motion.senses, case)
    _, _, w, _, _ = motion.state
    (_, _, acceleration, _, _), _, _ = contact_rates(motion.state, motion.senses, case.inertia, case.losses)
    (_, _, later, _, _), _ = contact_step(motion.state, motion.senses, case.inertia, case.losses, h)
    gain = h * abs(acceleration)
    change = abs(later - w - h * acceleration)
    return change > 0.5 * gain and abs(w) < gain + change


@kernel
def is_switch(event):
    """Return whether friction decides anew at an event."""
    return ROLL_VANISHES <= event <= TILTING_VANISHES or event == CONTACT_RESTS


@kernel
def ending_of(event):
    """Return the code of `kernels.lossy_disk.endings` of an event that ends a motion, otherwise MOVING."""
    if event == FLATTENS:
        return FLAT
    if event == LIFTS:
        return LIFT_OFF
    if event == SLIPS:
        return SLIP
    if event == RESTS:
        return REST
    if event == EDGES:
        return EDGE_CHANGE
    if event == FAILS:
        return UNRESOLVED
    return MOVING


@kernel
def recorded(record, motion, event, case):
    """Return the record after one more leap, which led to this motion and event."""
    tilt = tilt_of(motion.state)
    if event == FLATTENS:
        tilt = math.copysign(case.flat_tilt, tilt)
    switch = is_switch(event) and (event != ROLL_VANISHES or case.losses.contour > 0.0)
    return Record(
        min(record.least, tilt),
        max(record.greatest, tilt),
        motion.time if event == BREACHES else record.breach,
        record.steps + 1.0,
        record.switches + (1.0 if switch else 0.0),
    )


@kernel
def endless(record):
    """Return whether friction switches again and again without motion."""
    return record.switches > _MOST_SWITCHES + 0.5 * record.steps


@kernel
def follow(motion, record, case, until, reach, past):
    """Follow a motion to its ending, or until lanes can continue it.

    Parameters
    ----------
    motion : Motion
        As from `begun`, or from lanes one step before an event.
    record : Record
    case : kernels.lossy_disk.events.Case
    until : float
        Scaled time of the end of the duration.
    reach : float
        Distance of the tilt from the reference [rad] that breaks the criterion; infinite: no criterion.
    past : float
        Scaled time after which a sliding motion returns to lanes, unless its last step had an event; infinite: it
        never does.

    Returns
    -------
    (motion, record, ending)
        The ending is a code of `kernels.lossy_disk.endings`, or MOVING.
    """
    ending, most = MOVING, record.steps + MOST_STEPS
    while ending == MOVING and motion.time < until:
        left = math.inf if record.breach == record.breach else reach
        motion, _, event = leap(motion, case, until, left)
        record = recorded(record, motion, event, case)
        ending = UNRESOLVED if endless(record) or record.steps > most else ending_of(event)
        calm = event == NO_EVENT or event == TURNS
        if ending == MOVING and calm and motion.time > past and slides(motion, case):
            return motion, record, MOVING
    return motion, record, HORIZON if ending == MOVING else ending


@kernel
def slides(motion, case):
    """Return whether lanes can step a motion."""
    if motion.senses.roll == 0.0:
        return False
    if case.losses.rolling > 0.0:
        size, _, _ = horizontal_rate(motion.state, motion.senses, case.inertia, case.losses)
        return size > 2.0 * SLOW_CONTACT
    return True
