"""What a worker holds while it reduces a chunk of cells, and what it reads besides."""

from typing import Any, NamedTuple

import numpy as np

from kernels.disk.exact import layout as at
from kernels.disk.exact import motion as of
from kernels.disk.exact.legendre import PANELS, TERMS
from kernels.jit import internal
from kernels.lanes.intrinsics import without_refcount

#: Numbers in a cache line.
_LINE = 8

# Columns of a search for a turning point beyond the expansion about the start
INNER, OUTER, GUESS = range(3)
SEARCH_COLUMNS = 3


class Tables(NamedTuple):
    """The values of alpha and their tables (`kernels.disk.exact.legendre.tables`)."""

    alphas: Any
    panels: Any
    nodes: Any


class Chunk(NamedTuple):
    """Arrays of one worker: a block of lanes; motions, their cells and expansions; searches, and what they are of.

    `work` is scratch for the period. `keys` says on which panel, counted through all tables, a motion or a search
    stands (-1: it has ended); `order`, `ends` and `blocks` are those of `kernels.disk.exact.grouped`. `sought` is twice the
    number of a motion, and one more for the turning point behind it.
    """

    block: Any
    motions: Any
    cells: Any
    nears: Any
    work: Any
    searches: Any
    sought: Any
    keys: Any
    order: Any
    ends: Any
    blocks: Any


@internal
def memory(size, tables, with_period):
    """Arrays for a chunk of `size` cells; they have to outlive what `chunk_in` makes of them."""
    return (
        np.empty(at.SIZE + _LINE),
        np.empty((size, of.COLUMNS)),
        np.empty((size if with_period else 0, TERMS)),
        np.empty(TERMS),
        np.empty((2 * size, SEARCH_COLUMNS)),
        np.empty((4, 2 * size), np.int64),
        np.empty(tables * PANELS, np.int64),
        np.empty((3, 2 * size), np.int64),
    )


@internal
def chunk_in(arrays):
    """The `Chunk` that lies in the arrays of `memory`: views that are not counted (`kernels.lanes.intrinsics`)."""
    lanes, motions, nears, work, searches, numbers, ends, blocks = arrays
    # full vectors that cross a cache line cost a quarter of the speed
    aligned = -(lanes.ctypes.data // 8) % _LINE
    return Chunk(
        without_refcount(lanes[aligned : aligned + at.SIZE]), without_refcount(motions), without_refcount(numbers[0]), without_refcount(nears),
        without_refcount(work), without_refcount(searches), without_refcount(numbers[1]), without_refcount(numbers[2]), without_refcount(numbers[3]),
        without_refcount(ends), without_refcount(blocks),
    )  # fmt: skip
