"""The scalar stages of a cell with losses (`kernels.lanes.interface`): reading its start, finishing legs, its results.

`lanes` is the flat array of `kernels.lossy_disk.layout`.

A leg ends with whatever a sliding motion in a lane cannot decide. The lane goes back by two of its steps, to a moment
before the event, and `kernels.lossy_disk.follow` goes on from there in scalar code: to the ending of the cell, or until
the disk slides again, when the lane takes it over.
"""

import math

from kernels.disk.equations import energy_change
from kernels.jit import inlined, internal, simd
from kernels.lossy_disk import layout as at
from kernels.lossy_disk.arrays import (
    AIR_DENSITY,
    AIR_LOSS,
    AIR_VISCOSITY,
    ALPHA,
    BREACH_TIME,
    CONTOUR_DAMPING,
    CONTOUR_FRICTION,
    CONTOUR_LOSS,
    DAMPING_LOSS,
    END_TILT,
    END_TIME,
    ENDING,
    ENERGY_IMBALANCE,
    FRICTION,
    GRAVITY,
    HEADING_TURNED,
    MASS,
    NO_AIR,
    PATH_LENGTH,
    PIVOTING_FRICTION,
    PIVOTING_LOSS,
    PRECESSION_RATE,
    RADIUS,
    REFINEMENTS,
    ROLL_RATE,
    ROLLING_FRICTION,
    ROLLING_LOSS,
    STEPS,
    SWITCHES,
    TILT,
    TILT_ERROR,
    TILT_MAX,
    TILT_MIN,
    TILT_RATE,
    TIME_ERROR,
)
from kernels.lossy_disk.endings import FLAT, HORIZON, INVALID, UNDISTURBED, UNRESOLVED
from kernels.lossy_disk.loss_laws import Losses, scaled_losses
from kernels.lossy_disk.rk4 import step
from kernels.lossy_disk.simd_stages import begin, inertia_of, losses_of, sense_of, set_off, state_of

#: The motion slides again, and goes on in its lane.
SLIDES = -1

_MOST_REFINEMENTS = 6
_SMALLEST_SHRINK = 1.0 / 8.0


@internal
def _not_negative(x):
    return 0.0 <= x < math.inf


@internal
def _possible(cell, starts, run):
    """Whether the numbers of a start are those of a disk."""
    tilt, alpha = starts[TILT, cell], starts[ALPHA, cell]
    radius, gravity, mass = starts[RADIUS, cell], starts[GRAVITY, cell], starts[MASS, cell]
    finite = (
        math.isfinite(starts[TILT_RATE, cell])
        and math.isfinite(starts[PRECESSION_RATE, cell])
        and math.isfinite(starts[ROLL_RATE, cell])
    )
    arms = (
        0.0 <= starts[ROLLING_FRICTION, cell] < radius
        and 0.0 <= starts[PIVOTING_FRICTION, cell] < radius
        and 0.0 <= starts[CONTOUR_FRICTION, cell] < radius
    )
    damping, viscosity, density = (
        starts[CONTOUR_DAMPING, cell],
        starts[AIR_VISCOSITY, cell],
        starts[AIR_DENSITY, cell],
    )
    air = run.air_law == NO_AIR or (_not_negative(viscosity) and _not_negative(density))
    # a law of forces that are not proportional to the weight needs the mass
    heavy = (damping == 0.0 and run.air_law == NO_AIR) or 0.0 < mass < math.inf
    size = 0.0 < alpha <= 1.0 and 0.0 < radius < math.inf and 0.0 < gravity < math.inf
    allowed = _not_negative(damping) and starts[FRICTION, cell] >= 0.0
    return abs(tilt) < 0.5 * math.pi and finite and size and arms and air and heavy and allowed


@inlined
def _write(cell, ending, times, tilts, ledger, errors, taken, measures, counts):
    end_time, breach_time = times
    least, greatest, end_tilt = tilts
    turned, path, rolled, pivoted, rubbed, damped, blown = ledger
    imbalance, tilt_error, time_error = errors
    steps, refinements, switches = taken
    measures[TILT_MIN, cell], measures[TILT_MAX, cell] = least, greatest
    measures[END_TIME, cell], measures[END_TILT, cell] = end_time, end_tilt
    measures[HEADING_TURNED, cell], measures[PATH_LENGTH, cell] = turned, path
    measures[ROLLING_LOSS, cell], measures[PIVOTING_LOSS, cell] = rolled, pivoted
    measures[CONTOUR_LOSS, cell], measures[DAMPING_LOSS, cell], measures[AIR_LOSS, cell] = (
        rubbed,
        damped,
        blown,
    )
    measures[BREACH_TIME, cell], measures[ENERGY_IMBALANCE, cell] = breach_time, imbalance
    measures[TILT_ERROR, cell], measures[TIME_ERROR, cell] = tilt_error, time_error
    counts[ENDING, cell], counts[STEPS, cell] = ending, int(steps)
    counts[REFINEMENTS, cell], counts[SWITCHES, cell] = int(refinements), int(switches)


@internal
def _write_at_once(cell, ending, tilt, time, measures, counts):
    """Write a cell without a motion."""
    # nothing where nothing is known
    zero = 0.0 * tilt
    ledger, tilts = (zero, zero, zero, zero, zero, zero, zero), (tilt, tilt, tilt)
    _write(
        cell, ending, (time, math.nan), tilts, ledger, (zero, zero, zero), (0.0, 0.0, 0.0), measures, counts
    )


@internal
def _write_unresolved(cell, lane, lanes, measures, counts):
    nan = math.nan
    taken = lanes[at.STEPS_KEPT + lane], lanes[at.REFINED + lane], lanes[at.SWITCHES + lane]
    ledger = nan, nan, nan, nan, nan, nan, nan
    _write(cell, UNRESOLVED, (nan, nan), (nan, nan, nan), ledger, (nan, nan, nan), taken, measures, counts)


@simd
def _store_start(lane, state, disk, losses, friction, limits, lanes):
    tilt, tilt_rate, precession_rate, roll_rate = state
    alpha, radius, unit = disk
    lanes[at.S_0 + lane], lanes[at.W_0 + lane] = tilt, tilt_rate
    lanes[at.O_RATE_0 + lane], lanes[at.P_0 + lane] = precession_rate, roll_rate
    lanes[at.ALPHA + lane], lanes[at.RADIUS + lane], lanes[at.UNIT + lane] = alpha, radius, unit
    lanes[at.CONTOUR + lane], lanes[at.DAMPING + lane] = losses.contour, losses.damping
    lanes[at.ROLLING + lane], lanes[at.PIVOTING + lane] = losses.rolling, losses.pivoting
    lanes[at.FILM + lane], lanes[at.LAYER + lane] = losses.film, losses.layer
    lanes[at.FRICTION + lane] = friction
    lanes[at.LOW_0 + lane], lanes[at.HIGH_0 + lane] = limits


@internal
def fill_idle(lane, lanes):
    """Put an upright disk at rest into a lane without a cell."""
    nothing = Losses(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    _store_start(lane, (0.0, 0.0, 0.0, 0.0), (1.0, 1.0, 1.0), nothing, math.inf, (-2.0, 2.0), lanes)


@internal
def _sine(tilt):
    """Sine of a tilt; beyond a right angle, where no disk comes, 2."""
    return math.sin(tilt) if abs(tilt) < 0.5 * math.pi else math.copysign(2.0, tilt)


@internal
def _limits(tilt, scaled_rate, alpha, run):
    """Sines of the tilts where the criterion is broken.

    The size of a perturbation is that of `sweep.model.lossy_disk`: a disk that stands still falls from upright like
    exp(t / sqrt(1 + alpha/2)), which says what tilt a tilt rate is worth.
    """
    if run.limited == 0.0:
        return -2.0, 2.0
    reference = tilt if run.from_start == 1.0 else 0.0
    reach = run.limit
    if run.limited == 2.0:
        away = tilt - reference
        reach *= math.sqrt(away * away + (1.0 + 0.5 * alpha) * scaled_rate * scaled_rate)
    return _sine(reference - reach), _sine(reference + reach)


@internal
def read_start(cell, lane, starts, run, lanes, measures, counts):
    """Put a start into a lane, in SI units; an impossible one and one without a motion are written at once."""
    tilt, tilt_rate = starts[TILT, cell], starts[TILT_RATE, cell]
    if not _possible(cell, starts, run):
        _write_at_once(cell, INVALID, math.nan, math.nan, measures, counts)
        fill_idle(lane, lanes)
        return False
    if abs(tilt) >= run.flat_tilt:
        _write_at_once(cell, FLAT, tilt, 0.0, measures, counts)
        fill_idle(lane, lanes)
        return False
    if tilt == 0.0 and tilt_rate == 0.0:
        _write_at_once(cell, UNDISTURBED, tilt, math.nan, measures, counts)
        fill_idle(lane, lanes)
        return False
    radius, gravity, alpha = starts[RADIUS, cell], starts[GRAVITY, cell], starts[ALPHA, cell]
    unit = math.sqrt(radius / gravity)
    losses = scaled_losses(
        (starts[ROLLING_FRICTION, cell], starts[PIVOTING_FRICTION, cell], starts[CONTOUR_FRICTION, cell]),
        starts[CONTOUR_DAMPING, cell],
        (starts[AIR_VISCOSITY, cell], starts[AIR_DENSITY, cell]),
        (starts[MASS, cell], radius, gravity),
        run.air_law,
    )
    state = tilt, tilt_rate, starts[PRECESSION_RATE, cell], starts[ROLL_RATE, cell]
    limits = _limits(tilt, unit * tilt_rate, alpha, run)
    _store_start(lane, state, (alpha, radius, unit), losses, starts[FRICTION, cell], limits, lanes)
    return True


@internal
def needs_integration(cell, lane, run, lanes, measures, counts):
    """Every start that `read_start` lets pass moves."""
    return True


@internal
def _ledger_of(lane, lanes):
    return (
        lanes[at.TURNED + lane], lanes[at.PATH + lane], lanes[at.ROLLED + lane], lanes[at.PIVOTED + lane],
        lanes[at.RUBBED + lane], lanes[at.DAMPED + lane], lanes[at.BLOWN + lane],
    )  # fmt: skip


@internal
def _added(ledger, gain):
    a0, a1, a2, a3, a4, a5, a6 = ledger
    b0, b1, b2, b3, b4, b5, b6 = gain
    return a0 + b0, a1 + b1, a2 + b2, a3 + b3, a4 + b4, a5 + b5, a6 + b6


@internal
def _imbalance(state, ledger, lane, lanes):
    """Energy (of m g R) that a state has lost or won without reason, and how far its other invariants are from it."""
    S, C, K, w, o, p = state
    S0, C0, w0, o0 = (
        lanes[at.S_0 + lane],
        lanes[at.C_0 + lane],
        lanes[at.W_0 + lane],
        lanes[at.O_RATE_0 + lane],
    )
    i_inverse, alpha = lanes[at.I_INVERSE + lane], lanes[at.ALPHA + lane]
    change = energy_change(S, C, w, o, i_inverse * p, S0, C0, w0, o0, i_inverse * lanes[at.P_0 + lane], alpha)
    _, _, rolled, pivoted, rubbed, damped, blown = ledger
    lost = rolled + pivoted + rubbed + damped + blown
    return abs(change + lost) + abs((S - 1.0) * (S + 1.0) + C * C) + abs(K * C - 1.0) * C


@internal
def _margin(event, state, roll_sense, cos_flat, i_inverse):
    S, C, K, w, o, p = state
    if event == 0:
        return C - cos_flat
    return roll_sense * (i_inverse * p - o * S * K)


@internal
def _cut(event, state, sense, cos_flat, inertia, losses, h):
    """Length of the step to an event."""
    before, after = 0.0, h
    for _ in range(60):
        middle = 0.5 * (before + after)
        there, _ = step(state, sense, inertia, losses, middle)
        if _margin(event, there, sense[0], cos_flat, inertia.i_inverse) >= 0.0:
            before = middle
        else:
            after = middle
    return after


@internal
def _followed(motion, sense, inertia, losses, end, cos_flat, h):
    """Step through the event of a leg: (code, state, signs, time, ledger, extreme sines)."""
    state, t, ledger, least, greatest = motion
    for _ in range(8):
        code = SLIDES
        length = h
        if t + length >= end:
            length, code = end - t, HORIZON
        there, gain = step(state, sense, inertia, losses, length)
        for event in range(2):
            if not _margin(event, there, sense[0], cos_flat, inertia.i_inverse) >= 0.0:
                length = _cut(event, state, sense, cos_flat, inertia, losses, length)
                there, gain = step(state, sense, inertia, losses, length)
                code = FLAT if event == 0 else -2
        state, t, ledger = there, t + length, _added(ledger, gain)
        least, greatest = min(least, state[0]), max(greatest, state[0])
        if code == -2:
            sense = -sense[0], sense[1]
        elif code != SLIDES:
            return code, state, sense, t, ledger, least, greatest
    return SLIDES, state, sense, t, ledger, least, greatest


@internal
def _gone_back(lane, lanes):
    """State, time and ledger of a lane by two of its steps before its end, at most to the beginning of the leg."""
    state, t, ledger = state_of(lane, lanes), lanes[at.TIME + lane], _ledger_of(lane, lanes)
    sense, inertia, losses = sense_of(lane, lanes), inertia_of(lane, lanes), losses_of(lane, lanes)
    back = 2.0 * lanes[at.LAST + lane]
    left = 0.5 * (t - lanes[at.LEG_TIME + lane])
    h = -(back if back < left else left)
    for _ in range(2):
        state, gain = step(state, sense, inertia, losses, h)
        t, ledger = t + h, _added(ledger, gain)
    return state, t, ledger


@internal
def _set_off_again(lane, state, sense, t, ledger, least, greatest, run, lanes):
    S, C, K, w, o, p = state
    turned, path, rolled, pivoted, rubbed, damped, blown = ledger
    lanes[at.LEG_S + lane], lanes[at.LEG_C + lane], lanes[at.LEG_K + lane] = S, C, K
    lanes[at.LEG_W + lane], lanes[at.LEG_O_RATE + lane], lanes[at.LEG_P + lane] = w, o, p
    lanes[at.LEG_ROLL_SENSE + lane], lanes[at.LEG_TURN_SENSE + lane] = sense
    lanes[at.LEG_TIME + lane], lanes[at.LEG_LEAST + lane], lanes[at.LEG_GREATEST + lane] = t, least, greatest
    lanes[at.LEG_TURNED + lane], lanes[at.LEG_PATH + lane], lanes[at.LEG_ROLLED + lane] = turned, path, rolled
    lanes[at.LEG_PIVOTED + lane], lanes[at.LEG_RUBBED + lane] = pivoted, rubbed
    lanes[at.LEG_DAMPED + lane], lanes[at.LEG_BLOWN + lane] = damped, blown
    set_off(lane, run, lanes)


@internal
def _refine(lane, error, run, lanes):
    """Set the cell off again from its start with a shorter step, if there is one left to try."""
    hopeless = 0.5 * lanes[at.FAILED + lane] < error < math.inf
    lanes[at.FAILED + lane] = error
    if hopeless or lanes[at.REFINED + lane] >= _MOST_REFINEMENTS:
        return False
    shrink = 0.8 * math.sqrt(math.sqrt(run.tolerance / error))
    if not shrink >= _SMALLEST_SHRINK:
        shrink = _SMALLEST_SHRINK
    lanes[at.SCALE + lane] *= min(0.7, shrink)
    lanes[at.REFINED + lane] += 1.0
    begin(lane, lanes)
    set_off(lane, run, lanes)
    return True


@internal
def finish_leg(cell, lane, run, lanes, measures, counts):
    """Go through the event of a leg; set the cell off again, or write it."""
    lanes[at.STEPS_KEPT + lane] += lanes[at.STEPS + lane]
    state, t, ledger = _gone_back(lane, lanes)
    sense, inertia, losses = sense_of(lane, lanes), inertia_of(lane, lanes), losses_of(lane, lanes)
    motion = state, t, ledger, lanes[at.LEAST + lane], lanes[at.GREATEST + lane]
    h = max(2.0 * lanes[at.LAST + lane], 1.0e-9)
    code, state, sense, t, ledger, least, greatest = _followed(
        motion, sense, inertia, losses, lanes[at.END + lane], run.cos_flat_tilt, h
    )
    error = max(lanes[at.IMBALANCE + lane], _imbalance(state, ledger, lane, lanes))
    lanes[at.IMBALANCE + lane] = error
    if lanes[at.LAST + lane] == 0.0:
        _write_unresolved(cell, lane, lanes, measures, counts)
        return False
    if not error <= run.tolerance:
        if _refine(lane, error, run, lanes):
            return True
        _write_unresolved(cell, lane, lanes, measures, counts)
        return False
    if code == SLIDES:
        _set_off_again(lane, state, sense, t, ledger, least, greatest, run, lanes)
        return True
    unit, tilt = lanes[at.UNIT + lane], math.atan2(state[0], state[1])
    turned, path, rolled, pivoted, rubbed, damped, blown = ledger
    ledger = turned, lanes[at.RADIUS + lane] * path, rolled, pivoted, rubbed, damped, blown
    _write(
        cell, code, (unit * t, math.nan), (math.asin(least), math.asin(greatest), tilt), ledger,
        (error, math.nan, math.nan),
        (lanes[at.STEPS_KEPT + lane], lanes[at.REFINED + lane], lanes[at.SWITCHES + lane]), measures, counts,
    )  # fmt: skip
    return False
