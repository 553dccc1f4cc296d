"""The exact reduction: extreme tilts for all time, wells, separatrix and period of many cells, without time stepping.

A motion is confined to the interval around its start on which its potential (`kernels.wells`) does not exceed its
energy h; the ends of the interval are the turning points (`kernels.swing`).
"""

import math

import numpy as np
from numba import njit, prange

from kernels.borrow import borrowed
from kernels.disk import CONTRACT
from kernels.endings import BOUNDED, FELL, INVALID, STEADY, UNRESOLVED
from kernels.legendre import TERMS, Y_END, stretched, tables
from kernels.period import period
from kernels.shares import scattered
from kernels.swing import BEYOND, OFF_TABLE, TURNS, begin, height_of, noise, tilt_error, turn
from kernels.wells import ROUNDING, saddle

#: Cells that one task of the parallel loop owns.
CHUNK = 512
#: Tables held at once when alpha is an axis: 147 kB each.
TABLES = 128
#: A force at rest below this share of its terms is rounding (as in `kernels.cell`).
_STEADY = 16.0 * ROUNDING


@njit(error_model="numpy", fastmath=CONTRACT)
def _write(cell, ending, wells, least, greatest, period, height, error, measures, counts):
    measures[0, cell] = least
    measures[1, cell] = greatest
    measures[2, cell] = period
    measures[3, cell] = height
    measures[4, cell] = error
    counts[0, cell] = ending
    counts[1, cell] = wells


@njit(error_model="numpy", fastmath=CONTRACT)
def _write_nothing(cell, ending, wells, height, measures, counts):
    _write(cell, ending, wells, math.nan, math.nan, math.nan, height, math.nan, measures, counts)


@njit(error_model="numpy", fastmath=CONTRACT)
def _swing(
    cell, tilt, w, unit, motion, force, sizes, wells, top, height,
    fall_tilt, y_fall, with_period, panels, nodes, near, work, measures, counts,
):  # fmt: skip
    """Find both turning points of a motion that is neither steady nor on a separatrix, and write the cell.

    A disk that falls has shown only what came before: the side to which it sets off is looked at first.
    """
    barrier = top if height > 0.0 else math.nan
    ahead = 1 if w > 0.0 or (w == 0.0 and force > 0.0) else -1
    end, dy1, tilt1, slope1 = turn(ahead, motion, panels, nodes, barrier, y_fall, near, work)
    back, dy2, tilt2, slope2 = TURNS, 0.0, tilt, -force
    falls = end == BEYOND or (end == TURNS and ahead * tilt1 >= fall_tilt)
    if w != 0.0 and not falls:
        back, dy2, tilt2, slope2 = turn(-ahead, motion, panels, nodes, barrier, y_fall, near, work)
    if end == OFF_TABLE or back == OFF_TABLE:
        _write_nothing(cell, UNRESOLVED, wells, height, measures, counts)
        return
    error = 0.0
    if falls:
        tilt1 = ahead * fall_tilt
    else:
        error = tilt_error(sizes, dy1, tilt1, slope1)
    if back == BEYOND or -ahead * tilt2 >= fall_tilt:
        falls, tilt2 = True, -ahead * fall_tilt
    elif w != 0.0 and not falls:
        error = max(error, tilt_error(sizes, dy2, tilt2, slope2))
    # rounding of the last place must not put the start outside its own interval
    least, greatest = min(tilt, tilt1, tilt2), max(tilt, tilt1, tilt2)
    duration = math.nan
    if with_period and not falls:
        duration = unit * period(motion, panels, nodes, near, work, dy1, slope1, dy2, slope2, top, height)
    _write(
        cell, FELL if falls else BOUNDED, wells, least, greatest, duration, height, error, measures, counts
    )


@njit(error_model="numpy", fastmath=CONTRACT)
def _reduce_cell(
    cell, starts, alpha, table, fall_tilt, y_fall, with_period, panels, nodes, near, work, measures, counts
):
    """Write one cell."""
    tilt, rate, precession, roll = starts[0, cell], starts[1, cell], starts[2, cell], starts[3, cell]
    radius, gravity = starts[5, cell], starts[6, cell]
    possible = abs(tilt) < 0.5 * math.pi and 0.0 < radius < math.inf and 0.0 < gravity < math.inf
    finite = math.isfinite(rate) and math.isfinite(precession) and math.isfinite(roll)
    if table < 0 or not (possible and finite):
        _write_nothing(cell, INVALID, 0, math.nan, measures, counts)
        return
    unit = math.sqrt(radius / gravity)
    w, spin, roll = rate * unit, precession * unit, roll * unit
    if w * w == 0.0:
        w = 0.0  # a kick without energy is none
    if abs(tilt) >= fall_tilt:
        _write(cell, FELL, 0, tilt, tilt, math.nan, math.nan, 0.0, measures, counts)
        return
    S, C = math.sin(tilt), math.cos(tilt)
    y0 = stretched(S, C)
    if abs(y0) >= Y_END:
        _write_nothing(cell, UNRESOLVED, 0, math.nan, measures, counts)
        return
    motion, force, sizes = begin(y0, w, roll + spin * S, spin * C, S, C, alpha, table, panels, nodes, near)
    if not math.isfinite(motion[7]):
        _write_nothing(cell, UNRESOLVED, 0, math.nan, measures, counts)
        return
    top = saddle(alpha, table, panels, nodes, motion[5], motion[6], work)
    wells, height = 1, math.nan
    if not math.isnan(top):
        wells, height = 2, height_of(motion, panels, nodes, top, near, work)
    if w == 0.0 and abs(force) <= _STEADY * sizes[1]:
        _write(cell, STEADY, wells, tilt, tilt, math.nan, height, 0.0, measures, counts)
    elif wells == 2 and abs(height) <= noise(sizes, top - motion[2]):
        _write_nothing(cell, UNRESOLVED, wells, height, measures, counts)
    else:
        _swing(
            cell, tilt, w, unit, motion, force, sizes, wells, top, height,
            fall_tilt, y_fall, with_period, panels, nodes, near, work, measures, counts,
        )  # fmt: skip


@njit(error_model="numpy", fastmath=CONTRACT, parallel=True, nogil=True)
def reduce(starts, fall_tilt, with_period, alphas, which, panels, nodes, measures, counts):
    """Find the extremes of every cell for all time.

    Parameters
    ----------
    starts : float64[7, n]
        Rows: tilt [rad], tilt rate, precession rate, roll rate [rad/s], alpha [1] (not read), radius [m],
        gravity [m/s^2].
    fall_tilt : float
        Magnitude of the tilt [rad] that counts as a fall.
    with_period : bool
        Whether to compute the period: a quadrature, several times the cost of the rest.
    alphas : float64[m]
        The values of alpha that occur, in (0, 1].
    which : int64[n]
        Index of each cell's alpha, negative where it is not in (0, 1].
    panels, nodes : arrays
        `kernels.legendre.tables` of `alphas`.
    measures : float64[5, n], written
        Rows: least and greatest tilt [rad], nutation period [s], separatrix [1], estimated error of the extremes [rad].
        NaN where a measure does not exist. Separatrix is the saddle of the potential minus the energy, over m g
        radius: positive for a motion trapped in one of two wells, negative for one that passes over the saddle, NaN
        for one well.
    counts : int32[2, n], written
        Rows: ending (`kernels.endings`), wells of the potential (1, 2; 0 where it is not known).

    Notes
    -----
    Never raises. Bounded: both extremes hold for all time. Fell: the first fall_tilt reached and what came before.
    Steady: at rest on an equilibrium, to rounding. Unresolved: on a separatrix to rounding (the period is infinite
    and it is not known whether the disk passes), or beyond the table's end at 89.9 degrees.
    """
    n = which.size
    chunks = (n + CHUNK - 1) // CHUNK
    y_fall = stretched(math.sin(fall_tilt), math.cos(fall_tilt))
    scratch = np.empty((chunks, 2, TERMS))
    step = scattered(chunks)
    for place in prange(chunks):
        chunk = place * step % chunks
        own_starts, own_panels, own_nodes = borrowed(starts), borrowed(panels), borrowed(nodes)
        own_measures, own_counts = borrowed(measures), borrowed(counts)
        near, work = borrowed(scratch[chunk, 0]), borrowed(scratch[chunk, 1])
        for cell in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            table = which[cell]
            _reduce_cell(
                cell, own_starts, alphas[max(table, 0)], table, fall_tilt, y_fall, with_period,
                own_panels, own_nodes, near, work, own_measures, own_counts,
            )  # fmt: skip


def extremes(starts, fall_tilt, with_period=False):
    """Measures and counts of `reduce`, as new arrays: builds the tables of every alpha that occurs.

    Parameters
    ----------
    starts : float64[7, n]
    fall_tilt : float
    with_period : bool

    Returns
    -------
    measures : float64[5, n]
    counts : int32[2, n]
    """
    starts = np.ascontiguousarray(starts, dtype=np.float64)
    alpha, n = starts[4], starts.shape[1]
    measures, counts = np.empty((5, n)), np.empty((2, n), np.int32)
    # sorting a million equal numbers would take as long as reducing a million cells
    found, which = (alpha[:1], np.zeros(n, np.int64)) if n and (alpha == alpha[0]).all() else _distinct(alpha)
    possible = (found > 0.0) & (found <= 1.0)
    which = np.where(possible[which], (np.cumsum(possible) - 1)[which], -1) if not possible.all() else which
    found = found[possible]
    if found.size <= TABLES:
        known = found if found.size else np.ones(1)
        reduce(starts, fall_tilt, with_period, known, which, *tables(known), measures, counts)
        return measures, counts
    for first in range(0, found.size, TABLES):
        known = found[first : first + TABLES]
        cells = np.flatnonzero((which >= first) & (which < first + TABLES) | ((which < 0) & (first == 0)))
        some, numbers = np.empty((5, cells.size)), np.empty((2, cells.size), np.int32)
        local = np.where(which[cells] < 0, -1, which[cells] - first)
        reduce(
            np.take(starts, cells, axis=1),
            fall_tilt,
            with_period,
            known,
            local,
            *tables(known),
            some,
            numbers,
        )
        measures[:, cells], counts[:, cells] = some, numbers
    return measures, counts


def _distinct(alpha):
    found, which = np.unique(alpha, return_inverse=True)
    return found, which.astype(np.int64)
