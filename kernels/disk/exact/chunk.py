"""The arrays of a worker that reduces a chunk of cells, and the tables that it reads."""

from typing import Any, NamedTuple

import numpy as np

from kernels.disk.exact import layout as at
from kernels.disk.exact import motion as of
from kernels.disk.exact.counting_sort import BLOCK_ROWS
from kernels.disk.exact.legendre import PANELS
from kernels.disk.exact.period_layout import PERIOD_KEYS, PERIOD_SIZE
from kernels.jit import kernel
from kernels.lanes.layout import aligned

#: Columns of a search for a turning point beyond the expansion about the start: its bracket, a guess of the root, and
#: the rates and the excess at the centre of the panel.
INNER, OUTER, GUESS, S_THERE, P_THERE, EXCESS_THERE = range(6)
SEARCH_COLUMNS = EXCESS_THERE + 1


class Tables(NamedTuple):
    """The values of alpha and their tables (`kernels.disk.exact.legendre`, `kernels.disk.exact.wide_panels`).

    `wide` is empty where no period is asked for.
    """

    alphas: Any
    panels: Any
    nodes: Any
    wide: Any


class Chunk(NamedTuple):
    """Arrays of one worker.

    Attributes
    ----------
    block : float64[SIZE]
        Numbers of a block of lanes (`kernels.disk.exact.layout`).
    motions : float64[size, COLUMNS]
        One motion per row (`kernels.disk.exact.motion`).
    cells : int64[:]
        The cell of each motion.
    searches : float64[2 size, SEARCH_COLUMNS]
        Searches for turning points.
    sought : int64[:]
        What a search is for: twice the number of a motion, and one more for the turning point behind its start. Later
        the number of a motion whose period is sought.
    keys : int64[:]
        Panel, counted through all tables, of a motion, a search or a period; -1 where a search has ended.
    order, ends, blocks : int64 arrays
        As in `kernels.disk.exact.counting_sort`.
    """

    block: Any
    motions: Any
    cells: Any
    searches: Any
    sought: Any
    keys: Any
    order: Any
    ends: Any
    blocks: Any


def memory(size, tables):
    """Arrays for chunks of `size` cells at most: what `chunk_in` makes a `Chunk` of."""
    return (
        aligned(max(at.SIZE, PERIOD_SIZE)),
        np.empty((size, of.COLUMNS)),
        np.empty((2 * size, SEARCH_COLUMNS)),
        np.empty((4, 2 * size), np.int64),
        np.empty(tables * max(PANELS, PERIOD_KEYS), np.int64),
        np.empty((BLOCK_ROWS, 2 * size), np.int64),
    )


#: The types of these arrays, by their names in `kernels.disk.exact.extremes.reduce`.
MEMORY_TYPES = {
    "lanes": "float64[::1]",
    "motions": "float64[:, ::1]",
    "searches": "float64[:, ::1]",
    "numbers": "int64[:, ::1]",
    "ends": "int64[::1]",
    "blocks": "int64[:, ::1]",
}


@kernel
def chunk_in(arrays):
    """The `Chunk` in the arrays of `memory`."""
    lanes, motions, searches, numbers, ends, blocks = arrays
    return Chunk(lanes, motions, numbers[0], searches, numbers[1], numbers[2], numbers[3], ends, blocks)
