"""The exact reduction: extreme tilts for all time, wells, separatrix and period of many cells, without time stepping.

A motion is confined to the interval around its start on which its potential (`kernels.disk.exact.potential`) does not
exceed its energy h; the ends of the interval are the turning points (`kernels.disk.exact.near_turning_points`).
"""

import math

import numpy as np

from kernels.disk.arrays import ALPHA
from kernels.disk.exact.arrays import EXACT_COUNTS, EXACT_MEASURES
from kernels.disk.exact.chunk import MEMORY_TYPES, Tables, memory
from kernels.disk.exact.chunk_periods import periods
from kernels.disk.exact.legendre import stretched, tables
from kernels.disk.exact.reduction import reduce_chunk
from kernels.disk.exact.wide_panels import no_wide_panels, wide_panels
from kernels.native.by_address import NOWHERE, address_of
from kernels.native.entry import parallel

#: Cells of a chunk, which a thread takes at a time.
CHUNK = 2048
#: Tables held at once when alpha is an axis: 162 kB each.
TABLES = 128


def _memory_of_thread(starts, fall_tilt, periods_at, alphas, *_):
    return memory(min(CHUNK, starts.shape[1]), alphas.size)


@parallel(
    CHUNK,
    _memory_of_thread,
    starts="float64[:, ::1]",
    fall_tilt="float64",
    periods_at="int64",
    alphas="float64[::1]",
    which="int64[::1]",
    panels="float64[:, :, ::1]",
    nodes="float64[:, ::1]",
    wide="float64[:, :, ::1]",
    measures="float64[:, ::1], written",
    counts="int32[:, ::1], written",
    **MEMORY_TYPES,
)
def reduce(
    start, stop, starts, fall_tilt, periods_at, alphas, which, panels, nodes, wide, measures, counts,
    lanes, motions, searches, numbers, ends, blocks,
):  # fmt: skip
    """Find the extremes of every cell for all time.

    Python calls it without `start`, `stop` and what follows `counts`.

    Parameters
    ----------
    start, stop : int
        The cells of one chunk.
    starts : float64[len(PARAMETERS), n]
        Rows as in `kernels.disk.arrays`; alpha is not read.
    fall_tilt : float
        Magnitude of the tilt [rad] that counts as a fall.
    periods_at : int
        Address of `kernels.disk.exact.chunk_periods.periods`, NOWHERE to leave out the period: a quadrature, half as
        much again as the rest or as much again.
    alphas : float64[m]
        The values of alpha that occur, in (0, 1].
    which : int64[n]
        Index of each cell's alpha, negative where it is not in (0, 1].
    panels, nodes : arrays
        `kernels.disk.exact.legendre.tables` of `alphas`.
    wide : array
        `kernels.disk.exact.wide_panels.wide_panels` of `alphas`; not read without `periods_at`.
    measures : float64[len(EXACT_MEASURES), n], written
        Separatrix is the saddle of the potential minus the energy: positive for a motion trapped in one of two wells,
        negative for one that passes over the saddle, NaN for one well.
    counts : int32[len(EXACT_COUNTS), n], written
    lanes ... blocks : arrays
        `kernels.disk.exact.chunk.memory`.

    Notes
    -----
    Never raises. Bounded: both extremes hold for all time. Fell: the first fall_tilt reached and the extreme before it.
    Steady: at rest on an equilibrium, to rounding. Unresolved: on a separatrix to rounding (the period is infinite and
    it is not known whether the disk passes), or beyond the table's end at 89.9 degrees.
    """
    y_fall = stretched(math.sin(fall_tilt), math.cos(fall_tilt))
    own, arrays = Tables(alphas, panels, nodes, wide), (lanes, motions, searches, numbers, ends, blocks)
    reduce_chunk(start, stop, starts, fall_tilt, y_fall, periods_at, which, own, arrays, measures, counts)


def extremes(starts, fall_tilt, with_period=False):
    """Measures and counts of `reduce`, as new arrays: builds the tables of every alpha that occurs.

    Parameters
    ----------
    starts : float64[len(PARAMETERS), n]
    fall_tilt : float
    with_period : bool

    Returns
    -------
    measures : float64[len(EXACT_MEASURES), n]
    counts : int32[len(EXACT_COUNTS), n]
    """
    starts = np.ascontiguousarray(starts, dtype=np.float64)
    measures, counts = _results(starts.shape[1])
    periods_at = address_of(periods) if with_period else NOWHERE
    known, which = _tables_of(starts[ALPHA])
    if known.size <= TABLES and (which[:-1] <= which[1:]).all():
        reduce(
            starts, fall_tilt, periods_at, known, which, *_all_tables(known, with_period), measures, counts
        )
        return measures, counts
    # the cells of one table are treated together, so that blocks are full and few tables are in memory at once
    order = np.argsort(which, kind="stable")
    which = which[order]
    for first in range(0, known.size, TABLES):
        begin, end = np.searchsorted(which, [first if first > 0 else -1, first + TABLES])
        cells, some = order[begin:end], known[first : first + TABLES]
        found, numbers = _results(cells.size)
        own = np.take(starts, cells, axis=1)
        local = np.maximum(which[begin:end] - first, -1)
        reduce(own, fall_tilt, periods_at, some, local, *_all_tables(some, with_period), found, numbers)
        measures[:, cells], counts[:, cells] = found, numbers
    return measures, counts


def _all_tables(alphas, with_period):
    return *tables(alphas), wide_panels(alphas) if with_period else no_wide_panels()


def _results(n):
    return np.empty((len(EXACT_MEASURES), n)), np.empty((len(EXACT_COUNTS), n), np.int32)


def _tables_of(alpha):
    """The values of alpha for which tables are to be built, and which one each cell uses; -1 for impossible values."""
    # sorting a million equal numbers would take as long as reducing a million cells
    if alpha.size and (alpha == alpha[0]).all():
        found, which = alpha[:1], np.zeros(alpha.size, np.int64)
    else:
        found, which = np.unique(alpha, return_inverse=True)
        which = which.astype(np.int64)
    possible = (found > 0.0) & (found <= 1.0)
    if possible.any():
        places = np.where(possible, np.cumsum(possible) - 1, -1)
        return found[possible], places[which]
    return np.ones(1), np.full(alpha.size, -1)
