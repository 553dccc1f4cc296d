"""The scalar stages of a cell (`kernels.lanes.interface`): reading its start, ending its legs, writing its results.

`lanes` is the flat array of `kernels.disk.layout`.

A start that is not at rest lies between its two turning points. The first leg goes forward in time to one of them;
the second leg goes from the start again, backward in time, to the other one. Integrating forward through both turning
points fails for a start near the maximum of the potential, because the motion would have to cross that maximum again
by less than the error of a step. A nutation is symmetric in time about each of its turning points, so the two legs
give its period too.
"""

import math

from kernels.disk import arrays as row
from kernels.disk import layout as at
from kernels.disk.endings import BOUNDED, EDGE_CHANGE, FELL, HORIZON, INVALID, STEADY, UNRESOLVED
from kernels.disk.error_estimate import MOST_LOSS, drift, estimated_error, uncertain_energy
from kernels.disk.rk4 import land_on_tilt, land_on_turning_point, step, tilt_acceleration
from kernels.disk.simd_stages import (
    EDGED,
    MOST_STEPS,
    constants_of,
    longest,
    most_steps,
    scale_of,
    set_off,
    start_of,
    state_of,
    time_left,
)
from kernels.disk.step_size import share_near_maximum
from kernels.disk.summit import doubtful_pass, is_long
from kernels.jit import inlined, kernel, simd
from kernels.simd_math import angle_of

#: A result is accepted if its estimated error is within this share of the tolerance; for fast motions see `_allowed`.
_ACCEPTED_SHARE = 0.125

#: The largest divisor of that share, and the largest square of a tangent in it (at 88 degrees).
_LARGEST_DIVISOR, _STEEPEST = 65536.0, 820.0

#: Maximum number of steps if it is doubtful whether a motion passes a maximum of its potential.
_MOST_STEPS_IN_DOUBT = 1.0e5

#: Whether the steps of a cell shrink near a tilt of 90 degrees, where its rates grow without bound.
GRADED = True

_MOST_REFINEMENTS = 6
_SMALLEST_SHRINK = 1.0 / 8.0


@kernel
def _impossible(tilt, tilt_rate, precession_rate, roll_rate, alpha, radius, gravity):
    finite = math.isfinite(tilt_rate) and math.isfinite(precession_rate) and math.isfinite(roll_rate)
    possible = abs(tilt) < 0.5 * math.pi and 0.0 < alpha <= 1.0
    return not (finite and possible and 0.0 < radius < math.inf and 0.0 < gravity < math.inf)


@inlined
def _write(
    cell, ending, least, greatest, fall_time, period, drift, error, steps, refinements, measures, counts
):
    measures[row.TILT_MIN, cell] = least
    measures[row.TILT_MAX, cell] = greatest
    measures[row.FALL_TIME, cell] = fall_time
    measures[row.NUTATION_PERIOD, cell] = period
    measures[row.ENERGY_DRIFT, cell] = drift
    measures[row.TILT_ERROR, cell] = error
    counts[row.ENDING, cell] = ending
    counts[row.STEPS, cell] = steps
    counts[row.REFINEMENTS, cell] = refinements


@inlined
def _write_at_once(cell, ending, least, greatest, fall_time, measures, counts):
    error = math.nan if ending == INVALID or ending == UNRESOLVED else 0.0
    _write(cell, ending, least, greatest, fall_time, math.nan, error, error, 0, 0, measures, counts)


@simd
def _store_start(lane, tilt, tilt_rate, precession_rate, roll_rate, alpha, unit, lanes):
    lanes[at.LEAST + lane], lanes[at.GREATEST + lane] = tilt, tilt
    lanes[at.W_0 + lane], lanes[at.O_RATE_0 + lane] = tilt_rate, precession_rate
    lanes[at.S_RATE_0 + lane], lanes[at.ALPHA + lane], lanes[at.UNIT + lane] = roll_rate, alpha, unit


@simd
def read_start(cell, lane, starts, run, lanes, measures, counts):
    """Put a start into a lane, in SI units; write impossible starts and starts beyond fall_tilt at once."""
    tilt, tilt_rate = starts[row.TILT, cell], starts[row.TILT_RATE, cell]
    precession_rate, roll_rate = starts[row.PRECESSION_RATE, cell], starts[row.ROLL_RATE, cell]
    alpha, radius, gravity = starts[row.ALPHA, cell], starts[row.RADIUS, cell], starts[row.GRAVITY, cell]
    if _impossible(tilt, tilt_rate, precession_rate, roll_rate, alpha, radius, gravity):
        _write_at_once(cell, INVALID, math.nan, math.nan, math.nan, measures, counts)
        fill_idle(lane, lanes)
        return False
    if abs(tilt) >= run.fall_tilt:
        _write_at_once(cell, FELL, tilt, tilt, 0.0, measures, counts)
        fill_idle(lane, lanes)
        return False
    unit = math.sqrt(radius / gravity)
    _store_start(lane, tilt, tilt_rate, precession_rate, roll_rate, alpha, unit, lanes)
    return True


@kernel
def fill_idle(lane, lanes):
    """Put an upright disk at rest into a lane without a cell."""
    _store_start(lane, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, lanes)


@simd
def needs_integration(cell, lane, run, lanes, measures, counts):
    """Write a steady motion or a cell with too many steps at once; shorten the step near a maximum of the potential."""
    if lanes[at.STEADY + lane] == 1.0:
        tilt = lanes[at.LEAST + lane]
        _write_at_once(cell, STEADY, tilt, tilt, math.nan, measures, counts)
        return False
    if run.step > 0.0:
        if not run.duration / run.step <= MOST_STEPS:
            _write_at_once(cell, UNRESOLVED, math.nan, math.nan, math.nan, measures, counts)
            return False
    else:
        lanes[at.STEP + lane] *= share_near_maximum(lanes[at.CURVATURE + lane])
    return True


@simd
def _beyond(lane, state, run, lanes):
    """Return the ending of a motion whose state is beyond its limits, otherwise BOUNDED."""
    if EDGED and lanes[at.SIDE + lane] * state[0] < 0.0:
        return EDGE_CHANGE
    return BOUNDED if state[1] >= run.cos_fall_tilt else FELL


@simd
def _limit(ending, run):
    """Return the magnitude of the tilt [rad] at which a motion ends."""
    return 0.0 if ending == EDGE_CHANGE else run.fall_tilt


@kernel
def _event(lane, run, lanes):
    """Land on the event of a leg; return (ending so far, state, scaled time), with BOUNDED for a turning point."""
    state, constants = state_of(lane, lanes), constants_of(lane, lanes)
    t, end, most = lanes[at.TIME + lane], lanes[at.END + lane], longest(lane, lanes)
    there, elapsed, ending = state, 0.0, HORIZON
    if lanes[at.HEADING + lane] * state[3] < 0.0:
        there, elapsed = land_on_turning_point(state, constants, most)
        ending = BOUNDED
        ending = _beyond(lane, there, run, lanes)
        if ending != BOUNDED:
            # the disk turned back only beyond that tilt: go back to the passage
            beyond = abs(abs(math.atan2(there[0], there[1])) - _limit(ending, run))
            back = -math.sqrt(2.0 * beyond / abs(tilt_acceleration(there, constants)))
            there, elapsed = step(there, constants, back), elapsed + back
    elif _beyond(lane, state, run, lanes) != BOUNDED:
        ending = _beyond(lane, state, run, lanes)
    if ending in (FELL, EDGE_CHANGE):
        there, more = land_on_tilt(there, constants, math.copysign(_limit(ending, run), there[0]), most)
        elapsed += more
    if ending == HORIZON or t + elapsed > end:
        return HORIZON, step(state, constants, end - t), end
    return ending, there, t + elapsed


@kernel
def _allowed(lane, run, lanes):
    """Return the estimated error [rad] up to which a result is accepted.

    The estimate includes the loss of energy of a motion, but not the changes of its two other constants. If a fast
    disk sweeps through large tilts, the true error can be ten thousand times the estimate. With this divisor all of
    six million random starts with scaled rates from 0.01 to 1000 were within the tolerance, or unresolved (one in two
    thousand). Starts steeper than 88 degrees need no larger divisor, and rounding would exceed a smaller limit.
    """
    w, o, s = lanes[at.W_0 + lane], lanes[at.O_RATE_0 + lane], lanes[at.S_RATE_0 + lane]
    T = lanes[at.S_0 + lane] / lanes[at.C_0 + lane]
    divisor = (1.0 + w * w + (o * o + s * s) / 24.0) * (1.0 + min(T * T, _STEEPEST) / 8.0)
    divisor = min(_LARGEST_DIVISOR, divisor)
    return _ACCEPTED_SHARE * run.tolerance / divisor


@kernel
def _end_leg(lane, run, lanes):
    """Measure the end of a leg that `kernels.disk.simd_stages.land` has not finished; return the ending so far."""
    ending, state, t = _event(lane, run, lanes)
    whole, alpha, steps = lanes[at.ENERGY_0 + lane], lanes[at.ALPHA + lane], lanes[at.STEPS + lane]
    start, constants, h = start_of(lane, lanes), constants_of(lane, lanes), scale_of(lane, lanes)
    drifts = drift(state, start, whole, alpha, constants, steps)
    uncertain = uncertain_energy(drifts, state, start, constants, h, abs(state[0] - start[0]), steps)
    estimate, stated = estimated_error(ending, state, drifts, uncertain, constants)
    lanes[at.TILT_END + lane], lanes[at.TIME_END + lane] = angle_of(state[0], state[1]), t
    lanes[at.ESTIMATE_END + lane], lanes[at.ERROR_END + lane] = estimate, stated
    lanes[at.CHANGE_END + lane] = drifts[3]
    return ending


@kernel
def _passed_in_doubt(lane, lanes):
    """Return whether a leg passed a maximum of the potential without enough energy (`kernels.disk.summit`)."""
    constants = constants_of(lane, lanes)
    if not is_long(lanes[at.TIME_END + lane], constants):
        return False
    S, C, w, o, s = start_of(lane, lanes)
    sense = 1.0 - 2.0 * lanes[at.BACKWARD + lane]
    state = S, C, S / C, sense * w, sense * o, sense * s
    leg = (
        angle_of(S, C), lanes[at.TILT_END + lane], lanes[at.STEPS + lane], lanes[at.HEADING + lane],
        2.0 * lanes[at.HALF_UNIFORM + lane], 2.0 * lanes[at.HALF_GRADED + lane],
    )  # fmt: skip
    whole, alpha = lanes[at.ENERGY_0 + lane], lanes[at.ALPHA + lane]
    return doubtful_pass(state, constants, leg, whole, alpha)


@kernel
def _refine(lane, error, allowed, run, lanes):
    """Restart the cell with a smaller step, if there is one left to try; return whether there is."""
    # a shorter step leaves at most a quarter of an error of the method; rounding errors stay
    hopeless = lanes[at.FAILED + lane] < MOST_LOSS and 0.5 * lanes[at.FAILED + lane] < error < math.inf
    lanes[at.FAILED + lane] = error
    shrink = 0.8 * math.sqrt(math.sqrt(allowed / error))
    if not shrink >= _SMALLEST_SHRINK:
        shrink = _SMALLEST_SHRINK
    shrink = min(0.7, shrink)
    most = most_steps(lanes[at.S_0 + lane], lanes[at.W_0 + lane], run)
    if error == math.inf:
        # next to a maximum of the potential, only rounding errors remain after one or two refinements
        most = min(most, _MOST_STEPS_IN_DOUBT)
    too_long = lanes[at.STEPS + lane] > most * shrink
    if hopeless or too_long or lanes[at.REFINED + lane] >= _MOST_REFINEMENTS:
        return False
    lanes[at.STEP + lane] *= shrink
    lanes[at.REFINED + lane] += 1.0
    set_off(lane, run, lanes)
    return True


@simd
def finish_leg(cell, lane, run, lanes, measures, counts):
    """Restart a cell with a smaller step or backward in time; or write it."""
    ending = BOUNDED if lanes[at.LANDED + lane] == 1.0 else _end_leg(lane, run, lanes)
    error, t, steps = lanes[at.ESTIMATE_END + lane], lanes[at.TIME_END + lane], lanes[at.STEPS + lane]
    out_of_steps = ending == HORIZON and lanes[at.END + lane] < time_left(lane, run, lanes)
    allowed, stated = _allowed(lane, run, lanes), lanes[at.ERROR_END + lane]
    if run.step > 0.0:
        if GRADED:
            # a uniform step does not shrink near flat, where the rates change fastest
            stated /= math.cos(lanes[at.TILT_END + lane])
        # and it may be long: then the estimate is not sufficient
        if allowed * stated > error * run.tolerance:
            error = allowed * stated / run.tolerance
    if not out_of_steps and error <= allowed and _passed_in_doubt(lane, lanes):
        error = math.inf
    if out_of_steps or not error <= allowed:
        if not out_of_steps and _refine(lane, error, allowed, run, lanes):
            return True
        nan, taken = math.nan, lanes[at.STEPS_KEPT + lane] + steps
        _write(
            cell, UNRESOLVED, nan, nan, nan, nan, nan, nan, taken, lanes[at.REFINED + lane], measures, counts
        )
        return False
    tilt = lanes[at.TILT_END + lane]
    if ending in (FELL, EDGE_CHANGE):
        # no negative zero
        tilt = math.copysign(_limit(ending, run), tilt) + 0.0
    lanes[at.LEAST + lane] = min(lanes[at.LEAST + lane], tilt)
    lanes[at.GREATEST + lane] = max(lanes[at.GREATEST + lane], tilt)
    # accepted results have kept the tolerance in all trials, even if the estimate was larger in one motion of a
    # thousand
    lanes[at.ERROR + lane] = max(lanes[at.ERROR + lane], min(stated, run.tolerance))
    lanes[at.CHANGE + lane] = max(lanes[at.CHANGE + lane], lanes[at.CHANGE_END + lane])
    lanes[at.STEPS_KEPT + lane] += steps
    at_rest = lanes[at.W_0 + lane] == 0.0
    if ending == BOUNDED and not at_rest and lanes[at.BACKWARD + lane] == 0.0:
        lanes[at.BACKWARD + lane], lanes[at.FIRST_TURN + lane] = 1.0, t
        lanes[at.FAILED + lane] = math.nan
        if time_left(lane, run, lanes) > 0.0:
            set_off(lane, run, lanes)
            return True
        ending = HORIZON
    _finish(cell, lane, ending, t, lanes, measures, counts)
    return False


@kernel
def _finish(cell, lane, ending, t, lanes, measures, counts):
    """Write a cell whose last leg ended at the scaled time t."""
    unit, before = lanes[at.UNIT + lane], lanes[at.FIRST_TURN + lane]
    fall_time = unit * (2.0 * before + t) if ending == FELL else math.nan
    period = 2.0 * unit * (before + t) if ending == BOUNDED else math.nan
    drift = lanes[at.CHANGE + lane] / lanes[at.ENERGY_0 + lane]
    _write(
        cell, ending, lanes[at.LEAST + lane], lanes[at.GREATEST + lane], fall_time, period, drift,
        lanes[at.ERROR + lane], lanes[at.STEPS_KEPT + lane], lanes[at.REFINED + lane], measures, counts,
    )  # fmt: skip
