"""The periods of a chunk of cells, as an entry point of its own.

It is compiled apart from the extremes (`kernels.disk.exact.extremes.reduce`), which call it by its address: it need not
be compiled where no periods are asked for, and elsewhere two processes compile both at once.
"""

from kernels.disk.exact.chunk import MEMORY_TYPES, Tables, chunk_in
from kernels.disk.exact.period_pass import find_periods
from kernels.native.entry import entry


@entry(
    n="int64",
    alphas="float64[::1]",
    panels="float64[:, :, ::1]",
    nodes="float64[:, ::1]",
    wide="float64[:, :, ::1]",
    measures="float64[:, ::1], written",
    counts="int32[:, ::1], written",
    **MEMORY_TYPES,
)
def periods(
    n, alphas, panels, nodes, wide, measures, counts, lanes, motions, searches, numbers, ends, blocks,
):  # fmt: skip
    """Write the periods of the bounded ones of n motions.

    Parameters
    ----------
    n : int
    alphas ... wide : arrays
        As in `kernels.disk.exact.chunk.Tables`.
    measures, counts : arrays, written
        As in `kernels.disk.exact.extremes.reduce`, with all but the periods.
    lanes ... blocks : arrays
        `kernels.disk.exact.chunk.memory` with the motions of a chunk, as `reduce` leaves them.
    """
    tables, arrays = Tables(alphas, panels, nodes, wide), (lanes, motions, searches, numbers, ends, blocks)
    find_periods(n, tables, chunk_in(arrays), measures, counts)
