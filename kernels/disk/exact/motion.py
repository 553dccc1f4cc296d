"""One motion of the exact reduction: its row of numbers, and the results of its cell that follow from them.

The scalar side of the reduction, once per cell. `motions` holds a row per motion of a chunk, with the columns below.
"""

import math

from kernels.disk.endings import BOUNDED, FELL, STEADY, UNRESOLVED
from kernels.disk.exact import arrays as exact_row
from kernels.disk.exact.far_turning_points import BEYOND, OFF_TABLE
from kernels.jit import inlined, kernel

# The start: tilt [rad] and its rate, sqrt(R/g) [s], stretched tilt, distance from its panel's centre, rates s and o,
# sin and cos of the tilt, the panel, the table
TILT, W, UNIT, Y_0, X_0, S_0, O_0, SIN, COS, PANEL_0, TABLE = range(11)
# The motion, as in `kernels.disk.exact.layout`; its kind
AHEAD, TOP, HEIGHT, C_1, C_2, BASE, KIND = range(11, 18)
KINETIC, PULL, CURVATURE, LEVEL, FORCE, BEND, S_HERE, P_HERE, CENTRE = range(18, 27)
# Of the turning point ahead, and in the following columns of the one behind: how the search ended, tilt, its estimated
# error, distance in y from the start, slope of V there, and the excess where the expansion about the start ends
END, TURN, ERROR, DISTANCE, SLOPE, EXCESS = range(27, 33)
#: Columns from a turning point to the other one's.
BEHIND = EXCESS + 1 - END
# The quadrature of the period (`kernels.disk.exact.period_pass`): trapezoidal sum over the number of its intervals,
# how far that is from the sum before, and the same sum of the errors by rounding
SUM, CHANGE, ROUNDING = range(END + 2 * BEHIND, END + 2 * BEHIND + 3)
COLUMNS = ROUNDING + 1

#: Kinds of motions.
OSCILLATES, RESTS, ON_SEPARATRIX, NOT_FINITE = 0.0, 1.0, 2.0, 3.0


@inlined
def _write(cell, ending, wells, least, greatest, height, error, measures, counts):
    measures[exact_row.EXACT_TILT_MIN, cell] = least
    measures[exact_row.EXACT_TILT_MAX, cell] = greatest
    measures[exact_row.EXACT_NUTATION_PERIOD, cell] = math.nan
    measures[exact_row.EXACT_SEPARATRIX, cell] = height
    measures[exact_row.EXACT_TILT_ERROR, cell] = error
    counts[exact_row.EXACT_ENDING, cell] = ending
    counts[exact_row.EXACT_WELLS, cell] = wells


@inlined
def _write_nothing(cell, ending, wells, height, measures, counts):
    _write(cell, ending, wells, math.nan, math.nan, height, math.nan, measures, counts)


@kernel
def _ending_and_extremes(motion, fall_tilt):
    """(ending, least, greatest tilt, error); where the disk falls, only extremes before the fall count."""
    tilt, ahead = motion[TILT], motion[AHEAD]
    kicked = motion[W] != 0.0
    falls = motion[END] == BEYOND or ahead * motion[TURN] >= fall_tilt
    looks_back = kicked and not falls
    if motion[END] == OFF_TABLE or (looks_back and motion[END + BEHIND] == OFF_TABLE):
        return UNRESOLVED, math.nan, math.nan, math.nan
    first, error = (ahead * fall_tilt, 0.0) if falls else (motion[TURN], motion[ERROR])
    second = tilt
    if looks_back:
        second = motion[TURN + BEHIND]
        falls = motion[END + BEHIND] == BEYOND or -ahead * second >= fall_tilt
        if falls:
            second = -ahead * fall_tilt
        else:
            error = max(error, motion[ERROR + BEHIND])
    # rounding must not put the start outside its own interval
    return FELL if falls else BOUNDED, min(tilt, first, second), max(tilt, first, second), error


@kernel
def write_cell(cell, motion, fall_tilt, measures, counts):
    """Write the cell of a motion whose turning points are known, but for its period."""
    kind, height = motion[KIND], motion[HEIGHT]
    wells = 1 if math.isnan(motion[TOP]) else 2
    if kind == NOT_FINITE:
        _write_nothing(cell, UNRESOLVED, 0, math.nan, measures, counts)
        return
    if kind == RESTS:
        tilt = motion[TILT]
        _write(cell, STEADY, wells, tilt, tilt, height, 0.0, measures, counts)
        return
    if kind == ON_SEPARATRIX:
        _write_nothing(cell, UNRESOLVED, wells, height, measures, counts)
        return
    ending, least, greatest, error = _ending_and_extremes(motion, fall_tilt)
    _write(cell, ending, wells, least, greatest, height, error, measures, counts)
