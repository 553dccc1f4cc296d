"""The life of one cell: how it is read, what its events mean, when it has ended, when it is integrated again.

The scalar side of `kernels.lanes.schedule`: everything that differs from cell to cell. `lanes` is the flat array of
`kernels.disk.layout`, `lane` a column of it.

A start that is not at rest lies between its turning points. It is followed forward to the one and then, from the start
again, backward to the other. Forward through both would be as right in exact arithmetic, but a disk kicked off the
top of the potential has to pass that top again on its way, by a margin far below any error of a step. As a
nutation runs back from a turning point the way it came, times follow too.
"""

import math

from kernels.disk import layout as at
from kernels.disk.endings import BOUNDED, FELL, HORIZON, INVALID, STEADY, UNRESOLVED
from kernels.disk.error_estimate import MOST_LOSS, estimated_error, loss
from kernels.disk.rk4 import land_on_tilt, land_on_turning_point, step, tilt_acceleration
from kernels.disk.simd_stages import MOST_STEPS, constants_of, longest, set_off, start_of, state_of, time_left
from kernels.disk.step_size import COS_FALL, DURATION, FALL_TILT, STEP, TOLERANCE, on_hump
from kernels.jit import inlined, internal, simd
from kernels.simd_math import angle_of

#: A result is accepted when its estimated error is within this share of the tolerance; of fast motions see `_allowed`.
_SHARE = 0.125

#: By how much that share may be divided.
_MOST_CARE = 65536.0

_MOST_REFINEMENTS = 6
_SMALLEST_SHRINK = 1.0 / 8.0


@internal
def _impossible(tilt, tilt_rate, precession_rate, roll_rate, alpha, radius, gravity):
    finite = math.isfinite(tilt_rate) and math.isfinite(precession_rate) and math.isfinite(roll_rate)
    possible = abs(tilt) < 0.5 * math.pi and 0.0 < alpha <= 1.0
    return not (finite and possible and 0.0 < radius < math.inf and 0.0 < gravity < math.inf)


@inlined
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


@inlined
def _write_at_once(cell, ending, least, greatest, fall_time, measures, counts):
    error = math.nan if ending == INVALID or ending == UNRESOLVED else 0.0
    _write(cell, ending, least, greatest, fall_time, math.nan, error, error, 0, 0, measures, counts)


@simd
def _put(lane, tilt, tilt_rate, precession_rate, roll_rate, alpha, unit, lanes):
    lanes[at.LEAST + lane], lanes[at.GREATEST + lane] = tilt, tilt
    lanes[at.W_0 + lane], lanes[at.O_RATE_0 + lane] = tilt_rate, precession_rate
    lanes[at.S_RATE_0 + lane], lanes[at.ALPHA + lane], lanes[at.UNIT + lane] = roll_rate, alpha, unit


@simd
def read(cell, lane, starts, settings, lanes, measures, counts):
    """Put a cell's start into a column: whether it moves at all; one that does not is written, its column vacant."""
    tilt, alpha, radius, gravity = starts[0, cell], starts[4, cell], starts[5, cell], starts[6, cell]
    if _impossible(tilt, starts[1, cell], starts[2, cell], starts[3, cell], alpha, radius, gravity):
        _write_at_once(cell, INVALID, math.nan, math.nan, math.nan, measures, counts)
        vacate(lane, lanes)
        return False
    if abs(tilt) >= settings[FALL_TILT]:
        _write_at_once(cell, FELL, tilt, tilt, 0.0, measures, counts)
        vacate(lane, lanes)
        return False
    unit = math.sqrt(radius / gravity)
    _put(lane, tilt, starts[1, cell], starts[2, cell], starts[3, cell], alpha, unit, lanes)
    return True


@internal
def vacate(lane, lanes):
    """Put into a column without a cell what any arithmetic can be done with."""
    _put(lane, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, lanes)


@simd
def moves(cell, lane, settings, lanes, measures, counts):
    """Whether a prepared column is to be integrated, its step settled; if not, the cell is written."""
    if lanes[at.STEADY + lane] == 1.0:
        tilt = lanes[at.LEAST + lane]
        _write_at_once(cell, STEADY, tilt, tilt, math.nan, measures, counts)
        return False
    if settings[STEP] > 0.0:
        if not settings[DURATION] / settings[STEP] <= MOST_STEPS:
            _write_at_once(cell, UNRESOLVED, math.nan, math.nan, math.nan, measures, counts)
            return False
    else:
        lanes[at.STEP + lane] *= on_hump(lanes[at.STIFFNESS + lane])
    return True


@internal
def _event(lane, lowest, fall_tilt, lanes):
    """Finish on what occurred: (ending so far, state there, scaled time); BOUNDED stands for a turning point."""
    state, constants = state_of(lane, lanes), constants_of(lane, lanes)
    t, end, most = lanes[at.TIME + lane], lanes[at.END + lane], longest(lane, lanes)
    there, elapsed, ending = state, 0.0, HORIZON
    if lanes[at.HEADING + lane] * state[3] < 0.0:
        there, elapsed = land_on_turning_point(state, constants, most)
        ending = BOUNDED
        if not there[1] > lowest:
            # the disk turned back only beyond fall_tilt: go back to where it passed that
            beyond = abs(abs(math.atan2(there[0], there[1])) - fall_tilt)
            back = -math.sqrt(2.0 * beyond / abs(tilt_acceleration(there, constants)))
            there, elapsed = step(there, constants, back), elapsed + back
            ending = FELL
    elif not state[1] >= lowest:
        ending = FELL
    if ending == FELL:
        there, more = land_on_tilt(there, constants, math.copysign(fall_tilt, there[0]), most)
        elapsed += more
    if ending == HORIZON or t + elapsed > end:
        return HORIZON, step(state, constants, end - t), end
    return ending, there, t + elapsed


@internal
def _allowed(lane, settings, lanes):
    """Estimated error [rad] with which a result is accepted.

    The gauges see what a motion loses of its energy, but not how its two other constants change: where a fast disk
    sweeps through large tilts the true error can be ten thousand times the estimate. With this care all of six million
    random starts with scaled rates from 0.01 to 1000 came out within the tolerance or, one in two thousand, unresolved.
    """
    w, o, s = lanes[at.W_0 + lane], lanes[at.O_RATE_0 + lane], lanes[at.S_RATE_0 + lane]
    T = lanes[at.S_0 + lane] / lanes[at.C_0 + lane]
    care = (1.0 + w * w + (o * o + s * s) / 24.0) * (1.0 + T * T / 8.0)
    care = min(_MOST_CARE, care)
    return _SHARE * settings[TOLERANCE] / care


@internal
def _end_leg(lane, settings, lanes):
    """Measure the end of a leg that `kernels.disk.simd_stages.land` left open; returns the ending so far."""
    ending, state, t = _event(lane, settings[COS_FALL], settings[FALL_TILT], lanes)
    whole, alpha, steps = lanes[at.ENERGY_0 + lane], lanes[at.ALPHA + lane], lanes[at.STEPS + lane]
    lost, rounding, change = loss(state, start_of(lane, lanes), whole, alpha, steps)
    error = estimated_error(ending, state, lost, rounding, constants_of(lane, lanes))
    lanes[at.TILT_END + lane], lanes[at.TIME_END + lane] = angle_of(state[0], state[1]), t
    lanes[at.ERROR_END + lane], lanes[at.CHANGE_END + lane] = error, change
    return ending


@internal
def _refine(lane, error, allowed, settings, lanes):
    """Set the cell off again with a smaller step, if there is one left to try."""
    # in the reach of the method the next step would leave a quarter of the error at most; rounding stays
    hopeless = lanes[at.FAILED + lane] < MOST_LOSS and error > 0.5 * lanes[at.FAILED + lane]
    lanes[at.FAILED + lane] = error
    shrink = 0.8 * math.sqrt(math.sqrt(allowed / error))
    if not shrink >= _SMALLEST_SHRINK:
        shrink = _SMALLEST_SHRINK
    if hopeless or lanes[at.REFINED + lane] >= _MOST_REFINEMENTS:
        return False
    lanes[at.STEP + lane] *= min(0.7, shrink)
    lanes[at.REFINED + lane] += 1.0
    set_off(lane, settings[STEP], settings[DURATION], lanes)
    return True


@simd
def goes_on(cell, lane, settings, lanes, measures, counts):
    """Decide on a column whose leg has ended: whether it has set off again; if not, the cell is written."""
    ending = BOUNDED if lanes[at.LANDED + lane] == 1.0 else _end_leg(lane, settings, lanes)
    error, t, steps = lanes[at.ERROR_END + lane], lanes[at.TIME_END + lane], lanes[at.STEPS + lane]
    out_of_steps = ending == HORIZON and lanes[at.END + lane] < time_left(lane, settings[DURATION], lanes)
    allowed = _allowed(lane, settings, lanes)
    if out_of_steps or not error <= allowed:
        if not out_of_steps and _refine(lane, error, allowed, settings, lanes):
            return True
        nan, taken = math.nan, lanes[at.STEPS_KEPT + lane] + steps
        _write(
            cell, UNRESOLVED, nan, nan, nan, nan, nan, nan, taken, lanes[at.REFINED + lane], measures, counts
        )
        return False
    tilt = lanes[at.TILT_END + lane]
    if ending == FELL:
        tilt = math.copysign(settings[FALL_TILT], tilt)
    lanes[at.LEAST + lane] = min(lanes[at.LEAST + lane], tilt)
    lanes[at.GREATEST + lane] = max(lanes[at.GREATEST + lane], tilt)
    lanes[at.ERROR + lane] = max(lanes[at.ERROR + lane], error)
    lanes[at.CHANGE + lane] = max(lanes[at.CHANGE + lane], lanes[at.CHANGE_END + lane])
    lanes[at.STEPS_KEPT + lane] += steps
    at_rest = lanes[at.W_0 + lane] == 0.0
    if ending == BOUNDED and not at_rest and lanes[at.BACKWARD + lane] == 0.0:
        lanes[at.BACKWARD + lane], lanes[at.FIRST_TURN + lane] = 1.0, t
        lanes[at.FAILED + lane] = math.nan
        if time_left(lane, settings[DURATION], lanes) > 0.0:
            set_off(lane, settings[STEP], settings[DURATION], lanes)
            return True
        ending = HORIZON
    _finish(cell, lane, ending, t, lanes, measures, counts)
    return False


@internal
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
