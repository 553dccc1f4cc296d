"""One motion of a ball or a spheroid with losses: what `kernels.lossy_disk.follow` and `events` ask of it."""

import math

from kernels.jit import kernel
from kernels.lossy_bodies.poles.creeping import creeps, rolls_straight, stiffness
from kernels.lossy_bodies.poles.dry_friction import STILL_AT_REST, is_held
from kernels.lossy_bodies.poles.equations import (
    arm_of,
    contact_forces,
    contact_rates,
    horizontal_rate,
    shape,
    tilt_of,
    tilting_of,
    time_scale,
    whole_of_vertical,
    yielding,
)
from kernels.lossy_disk.contact import all_held
from kernels.lossy_disk.contact_motion import Senses, contact_step
from kernels.lossy_disk.creeping import creeping_step
from kernels.lossy_disk.dry_friction import HOLDS_ON, SEIZES, sign
from kernels.lossy_disk.events import _REST, beyond
from kernels.lossy_disk.follow import (
    _ROUNDING,
    _SHARE_OF_RELAXING,
    _SHARE_UNTIL_REST,
    MOVING,
    Motion,
    _switched,
    ending_of,
)


@kernel
def grips(losses):
    """Whether dry friction acts on the horizontal turning rate."""
    return losses.rolling > 0.0 or losses.contour > 0.0


@kernel
def _turned_by(before, after):
    """Angle by which the horizontal part of the axis has turned; half a turn through a pole counts as positive."""
    n1, n2, _, _, _, _ = before
    m1, m2, _, _, _, _ = after
    beside, ahead = n1 * m2 - n2 * m1, n1 * m1 + n2 * m2
    return math.pi if beside == 0.0 and ahead < 0.0 else math.atan2(beside, ahead)


@kernel
def next_state(state, senses, body, losses, h):
    """State and gain of the ledger after one step; the heading is that of the axis, before and after."""
    if creeps(state, senses, body, losses):
        after, gain = creeping_step(state, senses, body, losses, h)
    else:
        after, gain = contact_step(state, senses, body, losses, h)
    _, path, rolled, pivoted, rubbed, damped, blown = gain
    return after, (_turned_by(state, after), path, rolled, pivoted, rubbed, damped, blown)


@kernel
def margins(state, senses, heading, case, reach):
    """See `kernels.lossy_disk.events._margins`: there is no flat, no edge, and no law of the roll rate alone."""
    losses, none, v = case.losses, math.inf, state[5]
    first, second, forces = contact_forces(state, senses, case.inertia, losses)
    turns, lets_turn, slips, breaches = none, none, none, none
    if losses.pivoting > 0.0 and not all_held(senses):
        if senses.turn == 0.0:
            lets_turn = HOLDS_ON * losses.pivoting * forces.normal - abs(forces.turn)
        else:
            turns = senses.turn * v
    if case.friction < math.inf:
        slips = case.friction * forces.normal - math.sqrt(first * first + second * second)
    if reach < math.inf:
        breaches = reach - abs(tilt_of(state) - case.reference)
    tilts = heading * tilting_of(state) if heading != 0.0 else none
    return tilts, none, turns, none, lets_turn, none, none, forces.normal, slips, none, breaches


@kernel
def heading(state, senses, case):
    """Sign of the rate of the sine of the tilt, of a body at rest that with which it begins; 0 if nothing tilts it."""
    rate = tilting_of(state)
    if rate == 0.0:
        n1, n2, _, p1, p2, _ = state
        (dn1, dn2, _, dp1, dp2, _), _, _ = contact_rates(state, senses, case.inertia, case.losses)
        rate = dp1 * n2 - dp2 * n1 + p1 * dn2 - p2 * dn1
    return sign(rate)


@kernel
def contact_rests(state, senses, case):
    """Whether the horizontal turning rate has all but vanished, and still falls."""
    _, _, _, p1, p2, _ = state
    if not grips(case.losses) or p1 * p1 + p2 * p2 > _REST * _REST:
        return False
    size, change, _ = horizontal_rate(state, senses, case.inertia, case.losses)
    return size < _REST and change < 0.0


@kernel
def step_length(state, senses, case):
    """See `kernels.lossy_disk.follow.step_length`."""
    S = state[2]
    body, losses, share = case.inertia, case.losses, case.relative_step
    h, (n, _, radius) = share * time_scale(state, body), shape(S, body)
    wide = max(n, radius)
    if grips(losses) or losses.damping > 0.0:
        yields = yielding(S, body)
        relaxing = losses.damping * wide * wide * yields
        if relaxing * h > _SHARE_OF_RELAXING * share:
            h = _SHARE_OF_RELAXING * share / relaxing
        if grips(losses):
            size, _, change = horizontal_rate(state, senses, body, losses)
            slow = creeps(state, senses, body, losses)
            if change * h > _SHARE_UNTIL_REST * share * size and not slow:
                h = _SHARE_UNTIL_REST * share * size / change
            # friction turns its direction; one that rolls straight has nothing across
            stiff = stiffness(S, body, losses)
            if stiff * h > size and not rolls_straight(state) and not slow:
                h = size / stiff
    return min(h, case.longest)


@kernel
def begun(start, case, reach):
    """Return the `Motion` of a start, and an event that it is beyond, or NO_EVENT.

    Parameters
    ----------
    start : tuple of 5 floats
        Sine and cosine of the tilt, scaled tilt rate, precession rate and roll rate.
    case : kernels.lossy_disk.events.Case
    reach : float
        As of `kernels.lossy_disk.events.step_to_event`.
    """
    S, C, w, turning, f = start
    v = turning + f * S
    # no sum of zeros has a sign
    state = -C, 0.0, S, -C * f, w, v
    no_turn = abs(v) <= _ROUNDING * (abs(turning) + abs(f * S))
    no_rolling = w == 0.0 and f == 0.0 and grips(case.losses)
    nothing = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    motion = Motion(state, Senses(1.0, math.copysign(1.0, v), 0.0), 0.0, nothing)
    if no_rolling or no_turn:
        motion = _switched(motion, (no_rolling, no_turn, False), SEIZES, case)
    event = beyond(motion.state, motion.senses, case, reach)
    if ending_of(event) != MOVING:
        motion = Motion(motion.state, motion.senses, 0.0, nothing)
    return motion, event


@kernel
def inertia_of_turning(state, body):
    """Moment of inertia about the vertical through the contact point, in m R^2."""
    n1, n2, S, _, _, _ = state
    axis = n1, n2, S
    return whole_of_vertical(axis, arm_of(axis, body), body)[2]


@kernel
def still_held(state, later, turn, case):
    """See `kernels.lossy_disk.follow.still_held`."""
    n1, n2, S, _, _, _ = state
    return is_held((n1, n2, S, 0.0, 0.0, later), turn, STILL_AT_REST, case.inertia, case.losses)


@kernel
def turned_by(state, angle, later):
    """See `kernels.lossy_disk.follow.turned_by`."""
    n1, n2, S, _, _, _ = state
    cosine, sine = math.cos(angle), math.sin(angle)
    return n1 * cosine - n2 * sine, n1 * sine + n2 * cosine, S, 0.0, 0.0, later
