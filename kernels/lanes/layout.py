"""The memory layout of cells: LANES cells side by side, quantity after quantity, in one flat array.

A *lane* is the place of one cell among the LANES cells of such an array. A model names its quantities ("rows") for
`place_rows`; quantity `row` of lane `lane` is then `lanes[row + lane]`. Constant offsets into a single array let the
compiler prove that no lane accesses the numbers of another one. With two dimensions or several arrays it cannot, and
the loop over lanes stays scalar (30 times slower).
"""

import numpy as np

#: Four AVX-512 or eight AVX2 vectors: enough independent chains to hide latency. With 16 a run takes 6 % longer. With
#: 48 it takes 3 % less if there are enough cells, but more lanes idle while the last long cell of a chunk ends.
LANES = 32

#: Numbers (float64) in a cache line.
CACHE_LINE = 8


def offsets(first, stop, lanes=LANES):
    """Return the offsets of the rows from `first` to `stop` in the flat array of `lanes` cells.

    Parameters
    ----------
    first, stop : int
        Numbers of the first row and of the row after the last.
    lanes : int
        Number of cells side by side.

    Returns
    -------
    tuple of int
    """
    return tuple(row * lanes for row in range(first, stop))


def place_rows(stepping, kept, returned):
    """Return the offsets of the rows of a model, from lists of their names.

    Parameters
    ----------
    stepping : sequence of str
        Groups of names separated by blanks: quantities that lanes need while they step.
    kept : sequence of str
        The same, for quantities kept for a cell between its events.
    returned : str
        The first row of `stepping` that a block does not need back after an event.

    Returns
    -------
    dict of str to int
        Name -> offset of its row; STEPPING and SIZE: numbers of all lanes while they step, and in total; RETURNED.

    Raises
    ------
    ValueError
        If a name occurs twice.
    """
    moving, names = " ".join(stepping).split(), " ".join((*stepping, *kept)).split()
    if len(set(names)) < len(names):
        raise ValueError(f"a name occurs twice among the rows: {' '.join(names)}")
    rows = {name: number * LANES for number, name in enumerate(names)}
    return {**rows, "STEPPING": len(moving) * LANES, "SIZE": len(names) * LANES, "RETURNED": rows[returned]}


def aligned(size):
    """Return uninitialised memory for `size` numbers (float64), aligned to a cache line.

    Full vectors that cross a cache line cost a quarter of the speed.
    """
    memory = np.empty(size + CACHE_LINE)
    first = -(memory.ctypes.data // 8) % CACHE_LINE
    return memory[first : first + size]
