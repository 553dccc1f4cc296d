"""The scalar stages of a cell with losses (`kernels.lanes.interface`): reading its start, ending legs, its results.

`lanes` is the flat array of `kernels.lossy_disk.layout`.

A leg ends at an event that a lane cannot handle. The lane goes back by a few steps, to a time before the event, and
`kernels.lossy_disk.follow` continues from there in scalar code: until the ending of the cell, or until the disk
slides again and the lane takes it over.
"""

import math

from kernels.jit import inlined, kernel, simd
from kernels.lossy_disk import arrays as row
from kernels.lossy_disk import layout as at
from kernels.lossy_disk.contact_motion import Senses, contact_state, spin_state
from kernels.lossy_disk.endings import FLAT, INVALID, UNDISTURBED, UNRESOLVED
from kernels.lossy_disk.error_estimate import Outcome, stated_errors
from kernels.lossy_disk.events import BREACHES, Case
from kernels.lossy_disk.follow import (
    MOVING,
    Motion,
    Record,
    begun,
    ending_of,
    follow,
    slides,
    step_length,
    tilt_of,
    turns_early,
)
from kernels.lossy_disk.loss_coefficients import NOTHING_LOST, are_possible, scaled_losses, store_losses
from kernels.lossy_disk.rk4 import changes, step
from kernels.lossy_disk.simd_stages import (
    STEPS_OF_A_CALL,
    begin,
    inertia_of,
    losses_of,
    near_of,
    sense_of,
    set_off,
    slides_on,
    state_of,
    turning_sine,
)
from kernels.lossy_disk.step_control import (
    added,
    imbalance_of,
    next_pass,
    outcome_before,
    present,
    refined,
    slowed_down,
)

#: Steps after a start in which turning points are searched one by one: two calls of lanes.
_EARLY = 2.0 * STEPS_OF_A_CALL

#: State of a cell: its results are written, it continues in its lane, it restarts.
_WRITTEN, _GOES_ON, _AGAIN = range(3)

#: Steps that a lane goes back at an event.
_STEPS_BACK = int(STEPS_OF_A_CALL) + 1

#: Larger than any sine: the limits of a missing criterion, or of one that has been broken.
_NO_SINE = 2.0

#: Largest number of steps after which a failed motion restarts with shorter steps.
_MOST_LOST = 1.0e5


@kernel
def _possible(cell, starts, run):
    """Return whether the numbers of a start are possible for a disk."""
    tilt, alpha = starts[row.TILT, cell], starts[row.ALPHA, cell]
    radius, gravity = starts[row.RADIUS, cell], starts[row.GRAVITY, cell]
    finite = (
        math.isfinite(starts[row.TILT_RATE, cell])
        and math.isfinite(starts[row.PRECESSION_RATE, cell])
        and math.isfinite(starts[row.ROLL_RATE, cell])
    )
    size = 0.0 < alpha <= 1.0 and 0.0 < radius < math.inf and 0.0 < gravity < math.inf
    return abs(tilt) < 0.5 * math.pi and finite and size and are_possible(cell, starts, run.air_law)


@kernel
def _undisturbed(cell, starts):
    """Return whether a start is upright without any tilting torque: the gyroscopic torque (1+alpha) o s vanishes."""
    still = starts[row.TILT, cell] == 0.0 and starts[row.TILT_RATE, cell] == 0.0
    return still and (starts[row.PRECESSION_RATE, cell] == 0.0 or starts[row.ROLL_RATE, cell] == 0.0)


@inlined
def _write(cell, ending, times, tilts, ledger, errors, taken, measures, counts):
    end_time, breach_time = times
    least, greatest, end_tilt = tilts
    turned, path, rolled, pivoted, rubbed, damped, blown = ledger
    imbalance, tilt_error, time_error, heading_error, path_error = errors
    steps, refinements, switches = taken
    measures[row.TILT_MIN, cell], measures[row.TILT_MAX, cell] = least, greatest
    measures[row.END_TIME, cell], measures[row.END_TILT, cell] = end_time, end_tilt
    measures[row.HEADING_TURNED, cell], measures[row.PATH_LENGTH, cell] = turned, path
    measures[row.ROLLING_LOSS, cell], measures[row.PIVOTING_LOSS, cell] = rolled, pivoted
    measures[row.CONTOUR_LOSS, cell], measures[row.DAMPING_LOSS, cell], measures[row.AIR_LOSS, cell] = (
        rubbed,
        damped,
        blown,
    )
    measures[row.BREACH_TIME, cell], measures[row.ENERGY_IMBALANCE, cell] = breach_time, imbalance
    measures[row.TILT_ERROR, cell], measures[row.TIME_ERROR, cell] = tilt_error, time_error
    measures[row.HEADING_ERROR, cell], measures[row.PATH_ERROR, cell] = heading_error, path_error
    counts[row.ENDING, cell], counts[row.STEPS, cell] = ending, int(steps)
    counts[row.REFINEMENTS, cell], counts[row.SWITCHES, cell] = int(refinements), int(switches)


@kernel
def _write_at_once(cell, ending, tilt, time, measures, counts):
    """Write a cell without a motion: its losses are zero, or with a tilt of NaN everything is NaN."""
    zero = 0.0 * tilt
    ledger, tilts = (zero, zero, zero, zero, zero, zero, zero), (tilt, tilt, tilt)
    errors, taken = (zero, zero, zero, zero, zero), (0.0, 0.0, 0.0)
    _write(cell, ending, (time, math.nan), tilts, ledger, errors, taken, measures, counts)


@kernel
def _write_unresolved(cell, lane, record, lanes, measures, counts):
    nan = math.nan
    taken = record.steps, lanes[at.REFINED + lane], record.switches
    ledger = nan, nan, nan, nan, nan, nan, nan
    errors = nan, nan, nan, nan, nan
    _write(cell, UNRESOLVED, (nan, nan), (nan, nan, nan), ledger, errors, taken, measures, counts)


@simd
def _store_start(lane, state, disk, losses, friction, criterion, lanes):
    tilt, tilt_rate, precession_rate, roll_rate = state
    alpha, radius, unit = disk
    reference, reach, low, high = criterion
    lanes[at.S_0 + lane], lanes[at.W_0 + lane] = tilt, tilt_rate
    lanes[at.O_RATE_0 + lane], lanes[at.P_0 + lane] = precession_rate, roll_rate
    lanes[at.ALPHA + lane], lanes[at.RADIUS + lane], lanes[at.UNIT + lane] = alpha, radius, unit
    store_losses(lane, at.CONTOUR, losses, lanes)
    lanes[at.FRICTION + lane], lanes[at.REFERENCE + lane], lanes[at.REACH + lane] = friction, reference, reach
    lanes[at.LOW_0 + lane], lanes[at.HIGH_0 + lane] = low, high


@kernel
def fill_idle(lane, lanes):
    """Put an upright disk at rest into a lane without a cell."""
    never = 0.0, math.inf, -_NO_SINE, _NO_SINE
    _store_start(lane, (0.0, 0.0, 0.0, 0.0), (1.0, 1.0, 1.0), NOTHING_LOST, math.inf, never, lanes)


@kernel
def _sine(tilt):
    """Return the sine of a tilt, or beyond a right angle, which no disk reaches, a number larger than any sine."""
    return math.sin(tilt) if abs(tilt) < 0.5 * math.pi else math.copysign(_NO_SINE, tilt)


@kernel
def _criterion(tilt, scaled_rate, alpha, run):
    """Return the reference tilt of the criterion and the distance that breaks it [rad], and the sines of both limits.

    The size of a perturbation is defined as in `sweep.model.lossy_disk`: a disk at rest falls from upright like
    exp(t / sqrt(1 + alpha/2)), which makes a tilt rate equivalent to a tilt.
    """
    reference = tilt if run.from_start == 1.0 else 0.0
    if run.limited == 0.0:
        return reference, math.inf, -_NO_SINE, _NO_SINE
    reach = run.limit
    if run.limited == 2.0:
        away = tilt - reference
        reach *= math.sqrt(away * away + (1.0 + 0.5 * alpha) * scaled_rate * scaled_rate)
    return reference, reach, _sine(reference - reach), _sine(reference + reach)


@kernel
def read_start(cell, lane, starts, run, lanes, measures, counts):
    """Put a start into a lane, in SI units; write impossible starts and starts without a motion at once."""
    tilt, tilt_rate = starts[row.TILT, cell], starts[row.TILT_RATE, cell]
    ending, time = MOVING, math.nan
    if not _possible(cell, starts, run):
        ending, tilt = INVALID, math.nan
    elif abs(tilt) >= run.flat_tilt:
        ending, time = FLAT, 0.0
    elif _undisturbed(cell, starts):
        ending, tilt = UNDISTURBED, math.nan
    if ending != MOVING:
        _write_at_once(cell, ending, tilt, time, measures, counts)
        fill_idle(lane, lanes)
        return False
    radius, gravity, alpha = starts[row.RADIUS, cell], starts[row.GRAVITY, cell], starts[row.ALPHA, cell]
    unit = math.sqrt(radius / gravity)
    losses = scaled_losses(cell, starts, run.air_law, 1.0)
    state = tilt, tilt_rate, starts[row.PRECESSION_RATE, cell], starts[row.ROLL_RATE, cell]
    criterion = _criterion(tilt, unit * tilt_rate, alpha, run)
    _store_start(lane, state, (alpha, radius, unit), losses, starts[row.FRICTION, cell], criterion, lanes)
    return True


@kernel
def _case_of(lane, run, lanes):
    """Return the constants of the motion of a lane."""
    return Case(
        inertia_of(lane, lanes), losses_of(lane, lanes), run.flat_tilt, run.cos_flat_tilt,
        lanes[at.FRICTION + lane],
        lanes[at.REFERENCE + lane], 2.0 * lanes[at.SCALE + lane], 2.0 * lanes[at.LONGEST + lane],
    )  # fmt: skip


@kernel
def _start_of(lane, lanes):
    """Return the state at the beginning of the leg."""
    S, C, w = lanes[at.LEG_S + lane], lanes[at.LEG_C + lane], lanes[at.LEG_W + lane]
    return S, C, 1.0 / C, w, lanes[at.LEG_O_RATE + lane], lanes[at.LEG_P + lane]


@kernel
def _record_of(lane, lanes, least, greatest):
    """Return the record of a lane, from the sines of its extreme tilts, which coarse steps may take beyond 1."""
    return Record(
        math.asin(max(least, -1.0)), math.asin(min(greatest, 1.0)), lanes[at.BREACH + lane],
        lanes[at.STEPS_KEPT + lane], lanes[at.SWITCHES + lane],
    )  # fmt: skip


@kernel
def _store_leg(lane, motion, record, lanes):
    """Store the beginning of the next leg, and the record so far."""
    S, C, K, w, o, p = spin_state(motion.state, inertia_of(lane, lanes))
    turned, path, rolled, pivoted, rubbed, damped, blown = motion.ledger
    lanes[at.LEG_S + lane], lanes[at.LEG_C + lane], lanes[at.LEG_T + lane] = S, C, S / C
    lanes[at.LEG_W + lane], lanes[at.LEG_O_RATE + lane], lanes[at.LEG_P + lane] = w, o, p
    lanes[at.LEG_ROLL_SENSE + lane] = motion.senses.roll
    lanes[at.LEG_TURN_SENSE + lane], lanes[at.LEG_TIME + lane] = motion.senses.turn, motion.time
    lanes[at.LEG_LEAST + lane], lanes[at.LEG_GREATEST + lane] = (
        math.sin(record.least),
        math.sin(record.greatest),
    )
    lanes[at.LEG_TURNED + lane], lanes[at.LEG_PATH + lane], lanes[at.LEG_ROLLED + lane] = turned, path, rolled
    lanes[at.LEG_PIVOTED + lane], lanes[at.LEG_RUBBED + lane] = pivoted, rubbed
    lanes[at.LEG_DAMPED + lane], lanes[at.LEG_BLOWN + lane] = damped, blown
    lanes[at.BREACH + lane], lanes[at.STEPS_KEPT + lane] = record.breach, record.steps
    lanes[at.SWITCHES + lane] = record.switches
    if record.breach == record.breach:
        lanes[at.LOW + lane], lanes[at.HIGH + lane] = -_NO_SINE, _NO_SINE


@kernel
def _imbalance(motion, lane, lanes):
    """Return `imbalance_of` a motion."""
    return imbalance_of(spin_state(motion.state, inertia_of(lane, lanes)), motion.ledger, lane, lanes)


@kernel
def _judged(cell, lane, motion, record, ending, run, lanes, measures, counts):
    """Write a cell whose motion has ended or cannot be resolved; return the state of the cell."""
    error, most = _imbalance(motion, lane, lanes), lanes[at.IMBALANCE + lane]
    # written so that NaN stays
    error = most if most > error else error
    lanes[at.IMBALANCE + lane] = error
    # a third pass, after two with different endings, may meet the rounding of the energy
    if ending == UNRESOLVED or not error <= max(lanes[at.ALLOWED + lane], run.tolerance):
        # too long steps may lead nowhere; if many steps do not end a motion, more steps will not either
        lost = ending == UNRESOLVED
        if (not lost or record.steps < _MOST_LOST) and refined(lane, math.inf if lost else error, lanes):
            begin(lane, lanes)
            return _AGAIN
        _write_unresolved(cell, lane, record, lanes, measures, counts)
        return _WRITTEN
    if ending == MOVING:
        _store_leg(lane, motion, record, lanes)
        return _GOES_ON
    return _finished(cell, lane, motion, record, ending, run, lanes, measures, counts)


@kernel
def _outcome(motion, record, ending, run):
    """Return the `Outcome` of a pass that has ended."""
    tilt, least, greatest = tilt_of(motion.state), record.least, record.greatest
    if ending == FLAT:
        tilt = math.copysign(run.flat_tilt, tilt)
        least, greatest = min(least, tilt), max(greatest, tilt)
        # near flat, the sine used by the lanes determines the tilt poorly
        least, greatest = max(least, -run.flat_tilt), min(greatest, run.flat_tilt)
    turned, path, _, _, _, _, _ = motion.ledger
    return Outcome(float(ending), motion.time, tilt, least, greatest, turned, path)


@kernel
def _finished(cell, lane, motion, record, ending, run, lanes, measures, counts):
    """Begin the next pass of a cell whose motion has ended, or write the cell; return the state of the cell."""
    before, outcome = outcome_before(lane, lanes), _outcome(motion, record, ending, run)
    if before.ending != outcome.ending:
        if next_pass(lane, outcome, lanes):
            begin(lane, lanes)
            return _AGAIN
        _write_unresolved(cell, lane, record, lanes, measures, counts)
        return _WRITTEN
    errors = stated_errors(before, outcome, run.tolerance)
    turned, path, rolled, pivoted, rubbed, damped, blown = motion.ledger
    unit, radius = lanes[at.UNIT + lane], lanes[at.RADIUS + lane]
    ledger = turned, radius * path, rolled, pivoted, rubbed, damped, blown
    _write(
        cell, ending, (unit * motion.time, unit * record.breach),
        (outcome.least, outcome.greatest, outcome.tilt), ledger,
        (
            lanes[at.IMBALANCE + lane], errors.tilt, unit * errors.time, errors.heading, radius * errors.path
        ),
        (record.steps, lanes[at.REFINED + lane], record.switches), measures, counts,
    )  # fmt: skip
    return _WRITTEN


@kernel
def _begun(cell, lane, run, lanes, measures, counts):
    """Begin a cell; return whether it slides in its lane, from its start or after friction has let it slide."""
    state = _AGAIN
    while state == _AGAIN:
        case = _case_of(lane, run, lanes)
        motion, event = begun(_start_of(lane, lanes), case, lanes[at.REACH + lane])
        S, ending = lanes[at.LEG_S + lane], ending_of(event)
        record = _record_of(lane, lanes, S, S)
        if event == BREACHES:
            record = Record(record.least, record.greatest, 0.0, record.steps, record.switches)
        if ending == MOVING and not slides(motion, case):
            motion, record, ending = _followed(motion, record, case, lane, 0.0, lanes)
        elif ending == MOVING and turns_early(motion, case, _EARLY):
            past = _EARLY * step_length(motion.state, motion.senses, case)
            motion, record, ending = _followed(motion, record, case, lane, past, lanes)
        state = _judged(cell, lane, motion, record, ending, run, lanes, measures, counts)
    return state == _GOES_ON


@kernel
def needs_integration(cell, lane, run, lanes, measures, counts):
    """Let friction decide a start with vanishing rates; return whether the cell needs its lane."""
    return _begun(cell, lane, run, lanes, measures, counts)


@kernel
def _leg_ledger(lane, lanes):
    """Return the ledger at the beginning of the leg."""
    return (
        lanes[at.LEG_TURNED + lane], lanes[at.LEG_PATH + lane], lanes[at.LEG_ROLLED + lane],
        lanes[at.LEG_PIVOTED + lane], lanes[at.LEG_RUBBED + lane], lanes[at.LEG_DAMPED + lane],
        lanes[at.LEG_BLOWN + lane],
    )  # fmt: skip


@kernel
def _gone_back(lane, lanes):
    """Return the motion of a lane before its last call, or at the beginning of the leg if that is later.

    It goes back one step more than a call, because the turning point next to the beginning of the call may lie before
    it.
    """
    t, last, began = lanes[at.TIME + lane], lanes[at.LAST + lane], lanes[at.LEG_TIME + lane]
    sense, inertia, losses = sense_of(lane, lanes), inertia_of(lane, lanes), losses_of(lane, lanes)
    h = -2.0 * last
    if _STEPS_BACK * h <= began - t:
        # the steps back have errors like any step, which are large relative to an event early in the leg
        state, t, ledger = _start_of(lane, lanes), began, _leg_ledger(lane, lanes)
    else:
        state, ledger = present(lane, lanes)
        for _ in range(_STEPS_BACK):
            state, gain = step(state, sense, inertia, losses, h)
            t, ledger = t + h, added(ledger, gain, 1.0)
    S, C, w, f, v = contact_state(state, inertia)
    # along the leg, the rates that friction opposes have the signs of the leg; if one was zero at its beginning, the
    # steps back leave an error
    f = f if sense[0] * f >= 0.0 else 0.0
    v = v if sense[1] * v >= 0.0 or losses.pivoting == 0.0 else 0.0
    return Motion((S, C, w, f, v), Senses(sense[0], sense[1], 0.0), t, ledger)


@kernel
def _broken(record, lane, lanes):
    """Return whether a motion has exceeded the distance that the criterion allows."""
    reference, reach = lanes[at.REFERENCE + lane], lanes[at.REACH + lane]
    return max(record.greatest - reference, reference - record.least) > reach


@kernel
def _breach(motion, record, case, lane, past, lanes):
    """Return the time of the first breach; about `past`, if the breach there is smaller than an error."""
    _, found, _ = follow(motion, record, case, lanes[at.END + lane], lanes[at.REACH + lane], past)
    return found.breach if found.breach == found.breach else past


@kernel
def _followed(motion, record, case, lane, past, lanes):
    """`follow` a motion without a step that ends at a breach: no other result may depend on the criterion."""
    after, kept, ending = follow(motion, record, case, lanes[at.END + lane], math.inf, past)
    if record.breach == record.breach or not _broken(kept, lane, lanes):
        return after, kept, ending
    breach = _breach(motion, record, case, lane, after.time, lanes)
    return after, Record(kept.least, kept.greatest, breach, kept.steps, kept.switches), ending


@kernel
def _slides_on(lane, run, lanes):
    """Return whether a leg ended although the disk slides as before and has time left."""
    state, sense, friction = state_of(lane, lanes), sense_of(lane, lanes), lanes[at.FRICTION + lane]
    inertia, losses = inertia_of(lane, lanes), losses_of(lane, lanes)
    change, forces = changes(state, sense, inertia, losses)
    left = lanes[at.TIME + lane] < lanes[at.END + lane] and state[1] >= run.cos_flat_tilt
    slid = lanes[at.SLIDES + lane] > 0.0
    since = 2.0 * lanes[at.LAST + lane]
    return left and slid and slides_on(state, change, forces, sense, inertia, losses, friction, since)


@kernel
def _breaks_only(lane, run, lanes):
    """Return whether a leg ended only because of the criterion: then its lane continues unchanged."""
    if not _slides_on(lane, run, lanes):
        return False
    S, extreme = lanes[at.S + lane], turning_sine(near_of(lane, lanes))
    least, greatest = min(S, extreme), max(S, extreme)
    # beyond flat a step may lead anywhere; a value beyond any sine ends a leg without a criterion too
    if not (least >= -_NO_SINE and greatest <= _NO_SINE):
        return False
    return least < lanes[at.LOW + lane] or greatest > lanes[at.HIGH + lane]


@kernel
def _set_off_again(cell, lane, run, lanes, measures, counts):
    """Restart a cell; return whether it slides in its lane."""
    slides_again = _begun(cell, lane, run, lanes, measures, counts)
    if slides_again:
        set_off(lane, run, lanes)
    return slides_again


@kernel
def _slowed_down(cell, lane, run, lanes, measures, counts):
    """Restart a cell whose steps are too long for the rest of its motion, or write that it cannot be resolved."""
    if slowed_down(lane, lanes):
        begin(lane, lanes)
        return _set_off_again(cell, lane, run, lanes, measures, counts)
    S = lanes[at.S_0 + lane]
    _write_unresolved(cell, lane, _record_of(lane, lanes, S, S), lanes, measures, counts)
    return False


@kernel
def finish_leg(cell, lane, run, lanes, measures, counts):
    """Handle the event that ended a leg: continue the cell, or write it."""
    lanes[at.STEPS_KEPT + lane] += STEPS_OF_A_CALL * (lanes[at.STEPS + lane] - 1.0)
    if lanes[at.STEPS_LEFT + lane] <= 0.0:
        return _slowed_down(cell, lane, run, lanes, measures, counts)
    motion, case, past = _gone_back(lane, lanes), _case_of(lane, run, lanes), lanes[at.TIME + lane]
    record = _record_of(lane, lanes, lanes[at.LEAST + lane], lanes[at.GREATEST + lane])
    if _breaks_only(lane, run, lanes):
        lanes[at.BREACH + lane] = _breach(motion, record, case, lane, past, lanes)
        lanes[at.LOW + lane], lanes[at.HIGH + lane] = -_NO_SINE, _NO_SINE
        return True
    ending = MOVING
    if _imbalance(motion, lane, lanes) <= lanes[at.ALLOWED + lane]:
        # from a state without a valid step, as beyond flat, following might never end
        motion, record, ending = _followed(motion, record, case, lane, past, lanes)
    state = _judged(cell, lane, motion, record, ending, run, lanes, measures, counts)
    if state == _AGAIN:
        return _set_off_again(cell, lane, run, lanes, measures, counts)
    if state == _GOES_ON:
        set_off(lane, run, lanes)
    return state == _GOES_ON
