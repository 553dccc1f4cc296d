"""Where the numbers of cells lie in memory: LANES cells side by side, quantity after quantity, in one flat array.

A *lane* is the place of one cell among the LANES cells of such an array. A model names its quantities ("rows") for
`place_rows`; quantity `row` of lane `lane` is then `lanes[row + lane]`. Constant offsets into a single array let the
compiler prove that no lane accesses another one's numbers; with two dimensions or several arrays it cannot, and the
lane loop stays scalar (30 times slower).
"""

import numpy as np

#: Four AVX-512 or eight AVX2 vectors: enough independent chains to hide latency. With 16 a run takes 6 % longer, with
#: 48 it takes 3 % less where there are cells enough, but more lanes idle while the last long cell of a chunk ends.
LANES = 32

#: Numbers (float64) in a cache line.
CACHE_LINE = 8


def offsets(first, stop, lanes=LANES):
    """Offsets of the rows from `first` to `stop` in the flat array of `lanes` cells.

    Parameters
    ----------
    first, stop : int
        Numbers of the first row and of the one after the last.
    lanes : int
        Cells that lie side by side.

    Returns
    -------
    tuple of int
    """
    return tuple(row * lanes for row in range(first, stop))


def place_rows(stepping, kept, returned):
    """Number the rows of a model from lists of their names.

    Parameters
    ----------
    stepping : sequence of str
        Groups of names with blanks between them: what lanes need while they step.
    kept : sequence of str
        The same, for what is kept of a cell between its events.
    returned : str
        The first of the rows of `stepping` that a block does not need back after an event.

    Returns
    -------
    dict of str to int
        Name -> offset of its row; STEPPING, SIZE: numbers of all lanes while they step, and in all; RETURNED.

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
    """Uninitialised memory for `size` numbers (float64) that begins with a cache line.

    Full vectors that cross a cache line cost a quarter of the speed.
    """
    memory = np.empty(size + CACHE_LINE)
    first = -(memory.ctypes.data // 8) % CACHE_LINE
    return memory[first : first + size]
