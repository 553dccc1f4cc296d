"""A chunk of cells through the exact reduction: motions and searches that stand on one panel are treated together.

Three passes over the chunk, each in blocks of lanes ordered by panel: about the starts (`kernels.disk.exact.starts`), out
from panel to panel, and to the roots on the panels found (`kernels.disk.exact.searches`). A lane never looks at its
neighbours, and lanes without a motion repeat the last one of their block: a cell's bits depend on the cell alone.
"""

from kernels.disk.exact import motion as of
from kernels.disk.exact.chunk import chunk_in
from kernels.disk.exact.entry import enter
from kernels.disk.exact.motion import leave
from kernels.disk.exact.searches import search
from kernels.disk.exact.starts import about_starts
from kernels.jit import internal


@internal
def reduce_chunk(
    start, stop, starts, fall_tilt, y_fall, with_period, which, tables, arrays, measures, counts
):
    """Write the cells from `start` to `stop`.

    Arguments as in `kernels.disk.exact.turning.reduce`, but for the stretched `fall_tilt`, the `Tables`, and the arrays of
    `kernels.disk.exact.chunk.memory`.
    """
    chunk = chunk_in(arrays)
    n = enter(start, stop, starts, which, fall_tilt, tables, chunk, measures, counts)
    if n > 0:
        about_starts(n, tables, chunk)
        search(n, tables, chunk, y_fall)
    for i in range(n):
        motion = chunk.motions[i]
        near = chunk.nears[i] if with_period else chunk.work
        leave(
            chunk.cells[i], motion, fall_tilt, with_period, tables, int(motion[of.TABLE]), near, chunk.work,
            measures, counts,
        )  # fmt: skip
