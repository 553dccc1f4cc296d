"""The life of one cell: how it begins, what its events mean, when it has ended, when it is integrated again.

The scalar side of `kernels.lanes`: everything that happens a few times per cell instead of once per step. `lanes` is
the flat array of `kernels.rows`, `lane` a column of it.

A start that is not at rest lies between its turning points. It is followed forward to the one and then, from the start
again, backward to the other. Forward through both would be as right in exact arithmetic, but a disk kicked off the
top of the potential has to pass that top again on its way, by a margin far below any error of a step. As a
nutation runs back from a turning point the way it came, times follow too.
"""

import math

from numba import njit

from kernels import rows as at
from kernels.disk import CONTRACT, energy, inertia, scaled_state
from kernels.endings import BOUNDED, FELL, HORIZON, INVALID, STEADY, UNRESOLVED
from kernels.gauge import EPS, estimated_error, loss
from kernels.pace import COS_FALL, DURATION, FALL_TILT, PACE, STEP, TOLERANCE, first_step
from kernels.rk4 import land_on_tilt, land_on_turning_point, step, tilt_acceleration

#: What became of a lane: it has a new cell, it is at its cell's start again, or its cell has ended.
BEGUN = 1
AFRESH = 2
DONE = 3

#: A result is accepted when its estimated error is within this share of the tolerance; of fast motions see `_allowed`.
_SHARE = 0.125

#: By how much that share may be divided.
_MOST_CARE = 256.0

_MOST_REFINEMENTS = 6
_SMALLEST_SHRINK = 1.0 / 8.0

#: The estimate is one of first order: where more than this is lost (of m g R) the state is beyond measuring.
_MOST_LOSS = 1.0e-3

#: A single cell may not hold a worker for ever: after about this many steps it is unresolved.
_MOST_STEPS = 1.0e8


@njit(error_model="numpy", fastmath=CONTRACT)
def _impossible(tilt, tilt_rate, precession_rate, roll_rate, alpha, radius, gravity):
    finite = math.isfinite(tilt_rate) and math.isfinite(precession_rate) and math.isfinite(roll_rate)
    possible = abs(tilt) < 0.5 * math.pi and 0.0 < alpha <= 1.0
    return not (finite and possible and 0.0 < radius < math.inf and 0.0 < gravity < math.inf)


@njit(error_model="numpy", fastmath=CONTRACT)
def _write(
    cell, ending, least, greatest, fall_time, period, drift, gauge, steps, refinements, measures, counts
):
    measures[0, cell] = least
    measures[1, cell] = greatest
    measures[2, cell] = fall_time
    measures[3, cell] = period
    measures[4, cell] = drift
    measures[5, cell] = gauge
    counts[0, cell] = ending
    counts[1, cell] = steps
    counts[2, cell] = refinements


@njit(error_model="numpy", fastmath=CONTRACT)
def _write_at_once(cell, ending, least, greatest, fall_time, measures, counts):
    error = math.nan if ending == INVALID or ending == UNRESOLVED else 0.0
    _write(cell, ending, least, greatest, fall_time, math.nan, error, error, 0, 0, measures, counts)


@njit(error_model="numpy", fastmath=CONTRACT)
def _constants(lane, lanes):
    a, b = lanes[at.I_TILT + lane], lanes[at.I_ROLL + lane]
    return a, b, lanes[at.I_SPIN + lane], lanes[at.I_INVERSE + lane]


@njit(error_model="numpy", fastmath=CONTRACT)
def _start(lane, lanes):
    S, C, w = lanes[at.S_0 + lane], lanes[at.C_0 + lane], lanes[at.W_0 + lane]
    return S, C, w, lanes[at.O_RATE_0 + lane], lanes[at.S_RATE_0 + lane]


@njit(error_model="numpy", fastmath=CONTRACT)
def begin(cell, lane, starts, settings, lanes, measures, counts):
    """Put a cell's start into a lane: BEGUN, or DONE if its ending is known without a step (and written)."""
    tilt, alpha = starts[0, cell], starts[4, cell]
    radius, gravity = starts[5, cell], starts[6, cell]
    if _impossible(tilt, starts[1, cell], starts[2, cell], starts[3, cell], alpha, radius, gravity):
        _write_at_once(cell, INVALID, math.nan, math.nan, math.nan, measures, counts)
        return DONE
    if abs(tilt) >= settings[FALL_TILT]:
        _write_at_once(cell, FELL, tilt, tilt, 0.0, measures, counts)
        return DONE
    unit = math.sqrt(radius / gravity)
    state = scaled_state(tilt, starts[1, cell], starts[2, cell], starts[3, cell], unit)
    constants = inertia(alpha)
    S, C, T, w, o, s = state
    acceleration = tilt_acceleration(state, constants)
    terms = constants[0] * (abs(S) + abs(o) * (constants[1] * abs(s) + constants[2] * abs(o * T)))
    if w == 0.0 and abs(acceleration) <= 8.0 * EPS * terms:
        _write_at_once(cell, STEADY, tilt, tilt, math.nan, measures, counts)
        return DONE
    if settings[STEP] > 0.0 and not settings[DURATION] / settings[STEP] <= _MOST_STEPS:
        _write_at_once(cell, UNRESOLVED, math.nan, math.nan, math.nan, measures, counts)
        return DONE
    scale = settings[STEP] / unit if settings[STEP] > 0.0 else first_step(state, constants, settings[PACE])
    lanes[at.I_TILT + lane], lanes[at.I_ROLL + lane] = constants[0], constants[1]
    lanes[at.I_SPIN + lane], lanes[at.I_INVERSE + lane] = constants[2], constants[3]
    lanes[at.LEAST_C + lane] = settings[COS_FALL]
    lanes[at.S_0 + lane], lanes[at.C_0 + lane], lanes[at.W_0 + lane] = S, C, w
    lanes[at.O_RATE_0 + lane], lanes[at.S_RATE_0 + lane] = o, s
    lanes[at.ENERGY_0 + lane] = energy(S, C, w, o, s, alpha)
    lanes[at.STEP + lane], lanes[at.REFINED + lane], lanes[at.FAILED + lane] = scale, 0.0, math.nan
    lanes[at.BACKWARD + lane], lanes[at.FIRST_TURN + lane], lanes[at.STEPS_KEPT + lane] = 0.0, 0.0, 0.0
    lanes[at.LEAST + lane], lanes[at.GREATEST + lane], lanes[at.UNIT + lane] = tilt, tilt, unit
    lanes[at.ERROR + lane], lanes[at.CHANGE + lane] = 0.0, 0.0
    _set_off(lane, settings, lanes)
    return BEGUN


@njit(error_model="numpy", fastmath=CONTRACT)
def _time_left(lane, settings, lanes):
    """Scaled time that the present leg may take: all, or what is left when the disk passes its start again."""
    return settings[DURATION] / lanes[at.UNIT + lane] - 2.0 * lanes[at.FIRST_TURN + lane]


@njit(error_model="numpy", fastmath=CONTRACT)
def _set_off(lane, settings, lanes):
    """Place the lane at the cell's start, facing the way that it goes now, with the step scale that it holds."""
    S, C, w, o, s = _start(lane, lanes)
    scale = lanes[at.STEP + lane]
    # the motion backward in time is the motion forward with all rates reversed
    sense = 1.0 - 2.0 * lanes[at.BACKWARD + lane]
    state = (S, C, S / C, sense * w, sense * o, sense * s)
    lanes[at.S + lane], lanes[at.C + lane], lanes[at.T + lane] = S, C, state[2]
    lanes[at.W + lane], lanes[at.O_RATE + lane], lanes[at.S_RATE + lane] = state[3], state[4], state[5]
    uniform = settings[STEP] > 0.0
    lanes[at.STEP_UNIFORM + lane] = scale if uniform else 0.0
    lanes[at.STEP_GRADED + lane] = 0.0 if uniform else scale
    lanes[at.TIME + lane] = 0.0
    lanes[at.END + lane] = min(_time_left(lane, settings, lanes), _MOST_STEPS * scale)
    goes = tilt_acceleration(state, _constants(lane, lanes)) if w == 0.0 else state[3]
    lanes[at.HEADING + lane] = math.copysign(1.0, goes)


@njit(error_model="numpy", fastmath=CONTRACT)
def _event(lane, fall_tilt, lanes):
    """Finish on what occurred: (ending so far, state there, scaled time); BOUNDED stands for a turning point."""
    S, C, T, w = lanes[at.S + lane], lanes[at.C + lane], lanes[at.T + lane], lanes[at.W + lane]
    state = (S, C, T, w, lanes[at.O_RATE + lane], lanes[at.S_RATE + lane])
    constants = _constants(lane, lanes)
    t, end = lanes[at.TIME + lane], lanes[at.END + lane]
    longest = 2.0 * (lanes[at.STEP_UNIFORM + lane] + lanes[at.STEP_GRADED + lane] * abs(state[1]))
    there, elapsed, ending = state, 0.0, HORIZON
    if lanes[at.HEADING + lane] * state[3] < 0.0:
        there, elapsed = land_on_turning_point(state, constants, longest)
        ending = BOUNDED
        if not there[1] > lanes[at.LEAST_C + lane]:
            # the disk turned back only beyond fall_tilt: go back to where it passed that
            beyond = abs(abs(math.atan2(there[0], there[1])) - fall_tilt)
            back = -math.sqrt(2.0 * beyond / abs(tilt_acceleration(there, constants)))
            there, elapsed = step(there, constants, back), elapsed + back
            ending = FELL
    elif not state[1] >= lanes[at.LEAST_C + lane]:
        ending = FELL
    if ending == FELL:
        there, more = land_on_tilt(there, constants, math.copysign(fall_tilt, there[0]), longest)
        elapsed += more
    if ending == HORIZON or t + elapsed > end:
        return HORIZON, step(state, constants, end - t), end
    return ending, there, t + elapsed


@njit(error_model="numpy", fastmath=CONTRACT)
def _allowed(lane, settings, lanes):
    """Estimated error [rad] with which a result is accepted.

    The gauges see what a motion loses of its energy, but not how its two other constants change: where a fast disk
    sweeps through large tilts the true error can be a hundred times the estimate. With this care all of a million
    random starts with scaled rates from 0.01 to 1000 came out within the tolerance, or (100 of them) unresolved.
    """
    w, o, s = lanes[at.W_0 + lane], lanes[at.O_RATE_0 + lane], lanes[at.S_RATE_0 + lane]
    care = min(_MOST_CARE, 1.0 + 0.5 * w * w + (o * o + s * s) / 64.0)
    return _SHARE * settings[TOLERANCE] / care


@njit(error_model="numpy", fastmath=CONTRACT)
def _refine(lane, error, allowed, settings, lanes):
    """Set the cell off again with a smaller step, if there is one left to try."""
    # in the reach of the method the next step would leave a quarter of the error at most; rounding stays
    hopeless = lanes[at.FAILED + lane] < _MOST_LOSS and error > 0.5 * lanes[at.FAILED + lane]
    lanes[at.FAILED + lane] = error
    shrink = 0.8 * math.sqrt(math.sqrt(allowed / error))
    if not shrink >= _SMALLEST_SHRINK:
        shrink = _SMALLEST_SHRINK
    if hopeless or lanes[at.REFINED + lane] >= _MOST_REFINEMENTS:
        return False
    lanes[at.STEP + lane] *= min(0.7, shrink)
    lanes[at.REFINED + lane] += 1.0
    _set_off(lane, settings, lanes)
    return True


@njit(error_model="numpy", fastmath=CONTRACT)
def examine(cell, lane, steps, starts, settings, lanes, measures, counts):
    """Find out what occurred in a lane: AFRESH (at its start again) or DONE (its cell is written)."""
    ending, state, t = _event(lane, settings[FALL_TILT], lanes)
    whole = lanes[at.ENERGY_0 + lane]
    lost, rounding, change = loss(state, _start(lane, lanes), whole, starts[4, cell], steps)
    error = math.inf
    if lost <= _MOST_LOSS:
        error = estimated_error(ending, state, lost, rounding, _constants(lane, lanes))
    out_of_steps = ending == HORIZON and lanes[at.END + lane] < _time_left(lane, settings, lanes)
    allowed = _allowed(lane, settings, lanes)
    if out_of_steps or not error <= allowed:
        if not out_of_steps and _refine(lane, error, allowed, settings, lanes):
            return AFRESH
        nan, taken = math.nan, lanes[at.STEPS_KEPT + lane] + steps
        _write(
            cell, UNRESOLVED, nan, nan, nan, nan, nan, nan, taken, lanes[at.REFINED + lane], measures, counts
        )
        return DONE
    tilt = math.copysign(settings[FALL_TILT], state[0]) if ending == FELL else math.atan2(state[0], state[1])
    lanes[at.LEAST + lane] = min(lanes[at.LEAST + lane], tilt)
    lanes[at.GREATEST + lane] = max(lanes[at.GREATEST + lane], tilt)
    lanes[at.ERROR + lane] = max(lanes[at.ERROR + lane], error)
    lanes[at.CHANGE + lane] = max(lanes[at.CHANGE + lane], change)
    lanes[at.STEPS_KEPT + lane] += steps
    at_rest = lanes[at.W_0 + lane] == 0.0
    if ending == BOUNDED and not at_rest and lanes[at.BACKWARD + lane] == 0.0:
        lanes[at.BACKWARD + lane], lanes[at.FIRST_TURN + lane] = 1.0, t
        lanes[at.FAILED + lane] = math.nan
        if _time_left(lane, settings, lanes) > 0.0:
            _set_off(lane, settings, lanes)
            return AFRESH
        ending = HORIZON
    _finish(cell, lane, ending, t, lanes, measures, counts)
    return DONE


@njit(error_model="numpy", fastmath=CONTRACT)
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
