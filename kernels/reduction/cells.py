"""Cells of the reduction: extreme tilts for all time and the period of any body of revolution."""

import math

import numpy as np

from kernels.bodies import arrays as row
from kernels.bodies.shapes import FIRST_WITH_POLES, RIM, Body
from kernels.bodies.starts import body_of, is_possible, side_of
from kernels.disk.arrays import ENDING
from kernels.disk.endings import BOUNDED, EDGE_CHANGE, FELL, INVALID, UNRESOLVED
from kernels.disk.equations import scaled_state
from kernels.jit import kernel
from kernels.native.entry import parallel
from kernels.reduction.nutation import CUT_TYPES, cut_memory, find_period
from kernels.reduction.panels import TABLE_TYPES, Table, clear_table, table_memory, take_body
from kernels.reduction.pieces import PIECE
from kernels.reduction.turning import MOST_PIECES, NEAR, TOP, WAY, find_extremes, stretch

#: Number of cells that a thread takes at a time; cells with the same body share its panels.
CHUNK = 512

#: Types of the arrays with a motion: `find_extremes` writes them.
MOTION_TYPES = {"pieces": "float64[:, :, ::1]", "ways": "float64[:, ::1]", "near": "float64[::1]"}


def motion_memory():
    """Return the arrays of a motion, uninitialised."""
    return np.empty((2, MOST_PIECES, PIECE)), np.empty((2, WAY)), np.empty(NEAR)


@kernel
def own_body(starts, cell, kind):
    """Return the `Body` whose table serves a cell; for a rim, the body at positive tilts."""
    body, sign = body_of(starts, cell, kind), side_of(kind, starts[row.TILT, cell])
    shift = -body.shift if sign < 0.0 else body.shift
    return Body(body.core, shift, body.edge, body.square, body.axial, body.transverse, body.ratio)


@kernel
def scaled_start(starts, cell):
    """Return (unit of time [s], tilt [rad], w, o, s) of a cell, with scaled rates."""
    unit, tilt = math.sqrt(starts[row.RADIUS, cell] / starts[row.GRAVITY, cell]), starts[row.TILT, cell]
    rates = starts[row.TILT_RATE, cell], starts[row.PRECESSION_RATE, cell], starts[row.ROLL_RATE, cell]
    _, _, _, w, o, s = scaled_state(tilt, rates[0], rates[1], rates[2], unit)
    return unit, tilt, w, o, s


@kernel
def reduce_cell(starts, cell, kind, fall_tilt, y_fall, table, pieces, ways, near):
    """Return (ending, least, greatest tilt [rad], error [rad]) of a cell; write its motion, if it has one.

    `y_fall` is the stretched `fall_tilt`.
    """
    nan, tilt = math.nan, starts[row.TILT, cell]
    ways[:] = 0.0
    near[TOP] = math.inf
    if not is_possible(starts, cell, kind, body_of(starts, cell, kind)):
        return INVALID, nan, nan, nan
    if abs(tilt) >= fall_tilt and kind < FIRST_WITH_POLES:
        return FELL, tilt, tilt, 0.0
    if kind == RIM and tilt == 0.0:
        return EDGE_CHANGE, tilt, tilt, 0.0
    take_body(table, own_body(starts, cell, kind))
    _, tilt, w, o, s = scaled_start(starts, cell)
    ending, least, greatest, error = find_extremes(table, kind, tilt, w, o, s, y_fall, pieces, ways, near)
    if ending == UNRESOLVED:
        return UNRESOLVED, nan, nan, nan
    return ending, least, greatest, error


@parallel(
    CHUNK,
    lambda *_: (*table_memory(), *motion_memory(), *cut_memory()),
    starts="float64[:, ::1]",
    kind="float64",
    fall_tilt="float64",
    timed="int64",
    measures="float64[:, ::1], written",
    counts="int32[:, ::1], written",
    **TABLE_TYPES,
    **MOTION_TYPES,
    **CUT_TYPES,
)
def reduce(
    start, stop, starts, kind, fall_tilt, timed, measures, counts, bodies, edges, made, panels, work, pieces, ways,
    near, waiting, cuts,
):  # fmt: skip
    """Find the extremes of every cell for all time, and its period.

    Python calls it without `start`, `stop` and the arguments after `counts`.

    Parameters
    ----------
    start, stop : int
        The cells of one chunk.
    starts : float64[len(PARAMETERS), n]
    kind : float
        Number of the body (`kernels.bodies.shapes`).
    fall_tilt : float
        Magnitude of the tilt [rad] that counts as a fall; it is not read for bodies with poles.
    timed : int
        0 to omit the period.
    measures : float64[len(REDUCED), n], written
    counts : int32[1, n], written
        Codes of `kernels.disk.endings`.
    bodies ... cuts : arrays
        Memory of a thread.

    Notes
    -----
    Never raises. Bounded: both extremes hold for all time. Fell and edge_change: the first such tilt reached and the
    extreme before it. Unresolved: on a separatrix to rounding.
    """
    table = Table(bodies, edges, made, panels, work)
    clear_table(table)
    y_fall = stretch(fall_tilt)
    for cell in range(start, stop):
        ending, least, greatest, error = reduce_cell(
            starts, cell, kind, fall_tilt, y_fall, table, pieces, ways, near
        )
        period = math.nan
        if timed != 0 and ending == BOUNDED:
            period = scaled_start(starts, cell)[0] * find_period(table, pieces, ways, near, waiting, cuts)
        counts[ENDING, cell] = ending
        measures[row.REDUCED_MIN, cell], measures[row.REDUCED_MAX, cell] = least, greatest
        measures[row.REDUCED_PERIOD, cell], measures[row.REDUCED_ERROR, cell] = period, error
        measures[row.REDUCED_SEPARATRIX, cell] = (
            near[TOP] if ending != UNRESOLVED and abs(near[TOP]) < math.inf else math.nan
        )
