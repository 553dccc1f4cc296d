"""The exact reduction of a chunk of cells: motions and searches on the same panel are treated together.

Passes over the chunk, each in blocks of lanes ordered by panel: expansions about the starts
(`kernels.disk.exact.near_pass`), search outward from panel to panel, roots on the panels found
(`kernels.disk.exact.far_pass`), and quadratures where periods are asked for (`kernels.disk.exact.chunk_periods`). A
lane never reads its neighbours, and lanes without a motion repeat the last one of their block: a cell's bits depend on
the cell alone.
"""

from kernels.disk.exact.chunk import chunk_in
from kernels.disk.exact.chunk_periods import periods
from kernels.disk.exact.far_pass import find_far
from kernels.disk.exact.motion import write_cell
from kernels.disk.exact.near_pass import find_near
from kernels.disk.exact.scaled_starts import scale_starts
from kernels.jit import kernel
from kernels.native.by_address import NOWHERE, caller_of

_find_periods = caller_of(periods)


@kernel
def reduce_chunk(start, stop, starts, fall_tilt, y_fall, periods_at, which, tables, arrays, measures, counts):
    """Write the cells from `start` to `stop`.

    Arguments as in `kernels.disk.exact.extremes.reduce`; `y_fall` is the stretched `fall_tilt`, `tables` the `Tables`
    and `arrays` those of `kernels.disk.exact.chunk.memory`.
    """
    chunk = chunk_in(arrays)
    n = scale_starts(start, stop, starts, which, fall_tilt, tables, chunk, measures, counts)
    if n > 0:
        find_near(n, tables, chunk)
        find_far(n, tables, chunk, y_fall)
    for i in range(n):
        write_cell(chunk.cells[i], chunk.motions[i], fall_tilt, measures, counts)
    if n > 0 and periods_at != NOWHERE:
        alphas, panels, nodes, wide = tables
        lanes, motions, searches, numbers, ends, blocks = arrays
        _find_periods(
            periods_at, n, alphas, panels, nodes, wide, measures, counts,
            lanes, motions, searches, numbers, ends, blocks,
        )  # fmt: skip
