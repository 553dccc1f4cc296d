"""A chunk of cells through the exact reduction: motions and searches that stand on one panel are treated together.

Three passes over the chunk, each in blocks of lanes ordered by panel: about the starts (`kernels.disk.exact.near_pass`), out
from panel to panel, and to the roots on the panels found (`kernels.disk.exact.far_pass`). A lane never looks at its
neighbours, and lanes without a motion repeat the last one of their block: a cell's bits depend on the cell alone.
"""

from kernels.disk.exact import motion as of
from kernels.disk.exact.chunk import chunk_in
from kernels.disk.exact.far_pass import find_far
from kernels.disk.exact.motion import write_cell
from kernels.disk.exact.near_pass import find_near
from kernels.disk.exact.scaled_starts import scale_starts
from kernels.jit import internal


@internal
def reduce_chunk(
    start, stop, starts, fall_tilt, y_fall, with_period, which, tables, arrays, measures, counts
):
    """Write the cells from `start` to `stop`.

    Arguments as in `kernels.disk.exact.extremes.reduce`, but for the stretched `fall_tilt`, the `Tables`, and the arrays of
    `kernels.disk.exact.chunk.memory`.
    """
    chunk = chunk_in(arrays)
    n = scale_starts(start, stop, starts, which, fall_tilt, tables, chunk, measures, counts)
    if n > 0:
        find_near(n, tables, chunk)
        find_far(n, tables, chunk, y_fall)
    for i in range(n):
        motion = chunk.motions[i]
        near = chunk.nears[i] if with_period else chunk.work
        write_cell(
            chunk.cells[i], motion, fall_tilt, with_period, tables, int(motion[of.TABLE]), near, chunk.work,
            measures, counts,
        )  # fmt: skip
