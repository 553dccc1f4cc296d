"""The exact reduction of many cells, with the tables of every alpha that occurs among them."""

import numpy as np

from kernels.legendre import tables
from kernels.turning import reduce

#: Tables held at once when alpha is an axis: 147 kB each.
TABLES = 128


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
        reduce(starts[:, cells], fall_tilt, with_period, known, local, *tables(known), some, numbers)
        measures[:, cells], counts[:, cells] = some, numbers
    return measures, counts


def _distinct(alpha):
    found, which = np.unique(alpha, return_inverse=True)
    return found, which.astype(np.int64)
