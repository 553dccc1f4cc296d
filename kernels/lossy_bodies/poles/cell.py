"""A cell of a ball or a spheroid with losses: its start, its motion, its results.

Each motion is followed twice or more in scalar code, with half the step each time, and what two of them differ by is
stated as the error: it knows how late a motion is that passes a maximum of its potential slowly, and how far beside a
pole it passes.
"""

import math
from typing import NamedTuple

from kernels.bodies import arrays as body_row
from kernels.bodies.shapes import BALL, Body
from kernels.bodies.stages import body_of, is_possible
from kernels.jit import kernel
from kernels.lossy_bodies import arrays as row
from kernels.lossy_bodies.poles.equations import energy_of, tilt_of
from kernels.lossy_bodies.poles.follow import begun
from kernels.lossy_bodies.stages import RunSettings, losses_allowed, losses_of, undisturbed
from kernels.lossy_bodies.stages import prepared_settings as settings_of_bodies
from kernels.lossy_disk.arrays import NO_AIR
from kernels.lossy_disk.endings import HORIZON, INVALID, UNDISTURBED, UNRESOLVED
from kernels.lossy_disk.events import BREACHES, Case
from kernels.lossy_disk.follow import MOVING, Motion, Record, ending_of, follow
from kernels.lossy_disk.leg_control import _MOST_LOST, _write, _write_at_once
from kernels.lossy_disk.loss_laws import Losses
from kernels.lossy_disk.step_control import lost_energy
from kernels.simd_math import sine_cosine_of_tilt

#: How often the step is halved at most, after the second motion.
_MOST_REFINEMENTS = 5

#: The step of the first motion over that which the tolerance asks for.
_FIRST = 2.0


class Start(NamedTuple):
    """A start, scaled.

    Attributes
    ----------
    first : tuple of 5 floats
        As of `kernels.lossy_bodies.poles.follow.begun`.
    unit, radius : float
        sqrt(R/g) [s]; the radius [m].
    body : kernels.bodies.shapes.Body
    losses : kernels.lossy_disk.loss_laws.Losses
    friction : float
        Friction coefficient.
    reference, reach : float
        Tilt from which the criterion measures, distance that breaks it [rad].
    """

    first: tuple
    unit: float
    radius: float
    body: Body
    losses: Losses
    friction: float
    reference: float
    reach: float


class Outcome(NamedTuple):
    """What a motion comes to.

    Attributes
    ----------
    motion : kernels.lossy_disk.follow.Motion
    record : kernels.lossy_disk.follow.Record
    ending : int
    imbalance : float
        Of the energy over m g R, and of the length of the axis.
    """

    motion: Motion
    record: Record
    ending: int
    imbalance: float


@kernel
def prepared_settings(settings):
    """Return the `kernels.lossy_bodies.stages.RunSettings`; no tilt is flat."""
    run = settings_of_bodies(settings)
    return RunSettings(
        run.duration, run.step, math.pi, run.tolerance, run.limited, run.limit, run.from_start, run.air_law,
        -1.0, run.relative_step, run.body,
    )  # fmt: skip


@kernel
def _criterion(tilt, scaled_rate, body, run):
    """Tilt from which the criterion measures and distance that breaks it [rad]."""
    reference = tilt if run.from_start == 1.0 else 0.0
    # as of `sweep.model.bodies.shape.on_end`
    is_on_end = run.body == BALL or body.shift != 0.0 or abs(tilt) > 0.25 * math.pi
    if run.from_start != 1.0 and is_on_end:
        reference = math.copysign(0.5 * math.pi, tilt)
    if run.limited == 0.0:
        return reference, math.inf
    away = tilt - reference
    size = math.sqrt(away * away + (1.0 + body.transverse) * scaled_rate * scaled_rate)
    return reference, run.limit * (size if run.limited == 2.0 else 1.0)


@kernel
def _start_of(cell, starts, run, body):
    """Return the `Start` of a cell."""
    tilt, radius = starts[body_row.TILT, cell], starts[body_row.RADIUS, cell]
    unit, (S, C) = math.sqrt(radius / starts[body_row.GRAVITY, cell]), sine_cosine_of_tilt(tilt)
    w = unit * starts[body_row.TILT_RATE, cell]
    turning, f = unit * starts[body_row.PRECESSION_RATE, cell], unit * starts[body_row.ROLL_RATE, cell]
    reference, reach = _criterion(tilt, w, body, run)
    return Start(
        (S, C, w, turning, f), unit, radius, body, losses_of(cell, starts, run.air_law, 1.0),
        starts[row.FRICTION, cell], reference, reach,
    )  # fmt: skip


@kernel
def _case_of(start, relative_step, run):
    """Return what does not change along a motion with this step over its time scale."""
    # a longest step is halved as well
    share = relative_step / run.relative_step
    longest = share * run.step / start.unit if run.step > 0.0 else math.inf
    return Case(
        start.body, start.losses, run.flat_tilt, run.cos_flat_tilt, start.friction, start.reference,
        relative_step, longest,
    )  # fmt: skip


@kernel
def _breach(first, record, case, end, reach):
    """Time when a motion first breaks the criterion, on which no other result may depend; NaN if it does not."""
    if max(record.greatest - case.reference, case.reference - record.least) <= reach:
        return math.nan
    motion, event = begun(first, case, reach)
    if event == BREACHES:
        return 0.0
    tilt = tilt_of(motion.state)
    found = Record(tilt, tilt, math.nan, 0.0, 0.0)
    if ending_of(event) == MOVING:
        _, found, _ = follow(motion, found, case, end, reach, math.inf)
    # a tilt may reach the limit by less than an error
    return found.breach if found.breach == found.breach else end


@kernel
def _outcome(start, relative_step, run):
    """Follow a motion to its ending, whatever the criterion."""
    case = _case_of(start, relative_step, run)
    motion, event = begun(start.first, case, math.inf)
    tilt, ending, end = tilt_of(motion.state), ending_of(event), run.duration / start.unit
    record = Record(tilt, tilt, math.nan, 0.0, 0.0)
    if ending == MOVING:
        motion, record, ending = follow(motion, record, case, end, math.inf, math.inf)
    n1, n2, S, _, _, _ = motion.state
    S0, C0, w, turning, f = start.first
    begin = energy_of((-C0, 0.0, S0, -C0 * f, w, turning + f * S0), case.inertia)
    won = energy_of(motion.state, case.inertia) - begin + lost_energy(motion.ledger)
    return Outcome(motion, record, ending, abs(won) + abs(n1 * n1 + n2 * n2 + S * S - 1.0))


@kernel
def treat(cell, starts, run, measures, counts):
    """Write what becomes of a cell: an impossible one and one without a motion at once."""
    body = body_of(starts, cell, run.body)
    possible = is_possible(starts, cell, run.body, body) and losses_allowed(cell, starts, run)
    # a ball is disturbed from its end, however it lies
    rests = run.body != BALL and undisturbed(cell, starts, body)
    if not possible or run.air_law != NO_AIR or rests:
        ending = UNDISTURBED if possible and run.air_law == NO_AIR else INVALID
        _write_at_once(cell, ending, math.nan, math.nan, measures, counts)
    else:
        _follow_and_write(cell, _start_of(cell, starts, run, body), run, measures, counts)


@kernel
def _follow_and_write(cell, start, run, measures, counts):
    """Follow the motion of a cell, with half the step each time until it is known well enough, and write it."""
    relative_step, refinements = _FIRST * run.relative_step, 0.0
    before = after = _outcome(start, relative_step, run)
    # many steps that do not end a motion will not with more of them
    known, goes_on = False, before.ending != UNRESOLVED or before.record.steps < _MOST_LOST
    while goes_on:
        relative_step *= 0.5
        after = _outcome(start, relative_step, run)
        known = after.ending == before.ending and after.imbalance <= run.tolerance
        known = known and after.ending != UNRESOLVED
        goes_on = not known and refinements < _MOST_REFINEMENTS and after.record.steps < _MOST_LOST
        if goes_on:
            before, refinements = after, refinements + 1.0
    if known:
        case = _case_of(start, relative_step, run)
        breach = _breach(start.first, after.record, case, after.motion.time, start.reach)
        _finish(cell, start, before, after, (refinements, breach), run, measures, counts)
    else:
        _write_lost(cell, after, refinements, measures, counts)


@kernel
def _write_lost(cell, after, refinements, measures, counts):
    """Write a cell that could not be resolved."""
    nan = math.nan
    ledger, errors = (nan, nan, nan, nan, nan, nan, nan), (nan, nan, nan, nan, nan)
    taken = after.record.steps, refinements, after.record.switches
    _write(cell, UNRESOLVED, (nan, nan), (nan, nan, nan), ledger, errors, taken, measures, counts)


@kernel
def _finish(cell, start, before, after, found, run, measures, counts):
    """Write a cell, with what its last two motions differ by as its errors."""
    (refinements, breach), unit, radius = found, start.unit, start.radius
    motion, record = after.motion, after.record
    turned, path, rolled, pivoted, rubbed, damped, blown = motion.ledger
    turned_before, path_before, _, _, _, _, _ = before.motion.ledger
    tilt = tilt_of(motion.state)
    apart = max(
        abs(record.least - before.record.least), abs(record.greatest - before.record.greatest),
        abs(tilt - tilt_of(before.motion.state)),
    )  # fmt: skip
    # two steps may err alike
    tilt_error, share = apart + run.tolerance, run.tolerance
    late = abs(motion.time - before.motion.time) + share * motion.time
    time_error = 0.0 if after.ending == HORIZON else late
    heading_error = abs(turned - turned_before) + share * (1.0 + abs(turned) + motion.time)
    # a motion that passes a pole within its error may pass it on the other side
    if max(abs(record.least), abs(record.greatest)) + tilt_error > 0.5 * math.pi:
        heading_error += 2.0 * math.pi
    path_error = abs(path - path_before) + share * (1.0 + path)
    ledger = turned, radius * path, rolled, pivoted, rubbed, damped, blown
    errors = after.imbalance, tilt_error, unit * time_error, heading_error, radius * path_error
    _write(
        cell, after.ending, (unit * motion.time, unit * breach),
        (record.least, record.greatest, tilt), ledger, errors,
        (record.steps, refinements, record.switches), measures, counts,
    )  # fmt: skip
