"""The time from the start of a body to fall_tilt, as a quadrature over the tilt."""

import math

from kernels.bodies import arrays as row
from kernels.disk.endings import FELL
from kernels.jit import kernel
from kernels.native.entry import parallel
from kernels.reduction.cells import CHUNK, MOTION_TYPES, motion_memory, reduce_cell
from kernels.reduction.nutation import (
    CUT_TYPES,
    angle_of_start,
    cut_memory,
    cut_nutation,
    describe_nutation,
    is_vague,
)
from kernels.reduction.panels import TABLE_TYPES, Table, clear_table, table_memory
from kernels.reduction.pieces import HIGH, SIGN
from kernels.reduction.turning import COUNT, stretch


@kernel
def _fall_time(table, pieces, ways, near, waiting, cuts):
    """Return the scaled time from the start of a motion to its fall; NaN on a separatrix to rounding."""
    if is_vague(near):
        return math.nan
    nutation = describe_nutation(table, pieces, ways, near)
    _, time = cut_nutation(nutation, 0.0, math.pi, False, waiting, cuts)
    if ways[1, COUNT] > 0.0:
        # it turns first, and passes its start again
        grows = (pieces[0, 0, HIGH] > 0.0) == (pieces[0, 0, SIGN] > 0.0)
        angle = angle_of_start(nutation)
        low, high = (angle, math.pi) if grows else (0.0, angle)
        _, there = cut_nutation(nutation, low, high, False, waiting, cuts)
        time += there
    return time


@parallel(
    CHUNK,
    lambda *_: (*table_memory(), *motion_memory(), *cut_memory()),
    starts="float64[:, ::1]",
    kind="float64",
    fall_tilt="float64",
    times="float64[::1], written",
    **TABLE_TYPES,
    **MOTION_TYPES,
    **CUT_TYPES,
)
def fall_times(
    start,
    stop,
    starts,
    kind,
    fall_tilt,
    times,
    bodies,
    edges,
    made,
    panels,
    work,
    pieces,
    ways,
    near,
    waiting,
    cuts,
):
    """Compute the time at which bodies fall.

    Python calls it without `start`, `stop` and the arguments after `times`.

    Parameters
    ----------
    start, stop : int
        The cells of one chunk.
    starts, kind, fall_tilt
        As for `kernels.reduction.cells.reduce`.
    times : float64[n], written
        Time [s] at which the tilt reaches `fall_tilt`; 0 if a start is beyond it, NaN if a body does not fall.
    bodies ... cuts : arrays
        Memory of a thread.

    Notes
    -----
    Never raises.
    """
    table = Table(bodies, edges, made, panels, work)
    clear_table(table)
    y_fall = stretch(fall_tilt)
    for cell in range(start, stop):
        ending, _, _, _ = reduce_cell(starts, cell, kind, fall_tilt, y_fall, table, pieces, ways, near)
        times[cell] = math.nan
        if ending == FELL and ways[0, COUNT] == 0.0:
            times[cell] = 0.0
        elif ending == FELL:
            unit = math.sqrt(starts[row.RADIUS, cell] / starts[row.GRAVITY, cell])
            times[cell] = unit * _fall_time(table, pieces, ways, near, waiting, cuts)
