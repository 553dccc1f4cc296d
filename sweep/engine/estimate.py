"""What a run takes: bytes on disk and in memory, seconds, cells of a block, and the measured speed of a machine.

Nothing heavy is imported here before the speed of the kernels is measured.
"""

import math
import shutil
import time
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from sweep.engine.compute import check_device, compute, measured_quantities, usable_threads, use_threads
from sweep.engine.grid import MOST_BLOCK_CELLS, whole
from sweep.errors import RequestError
from sweep.model.kernel import chunk_cells
from sweep.model.quantity import Quantity
from sweep.request.spec import SweepSpec

#: An atlas compresses to about this share of its cells' bytes at most (measured: 0.3 to 0.75).
FILE_SHARE = 0.8

#: A crash costs the blocks in the making: of about this many seconds.
_BLOCK_SECONDS = 1.5

#: Bytes of a process that holds the compiler and the libraries of files, before it has a cell.
_PROCESS_BYTES = 270e6

#: Bytes per cell of a block in all its stages at once: being computed, being written, being compressed.
_STAGES_BYTES = 500

#: Bytes of a row of an edge in a file: four numbers and a code.
_EDGE_BYTES = 33

#: Bytes of memory of a row while its edge is sought; rows whose brackets are bisected at a time, and bytes of
#: each.
_ROW_BYTES, _ROWS_AT_ONCE, _STARTS_BYTES = 40, 2**16, 800

#: Bytes of a value of a start of a table.
_START_BYTES = 8

#: Bytes of memory of a cell and of a point of the curves of a refined boundary while they are joined.
_PLANE_BYTES, _POINT_BYTES = 3, 160

#: Bytes of a point along one axis in a file: its place and its half-width.
_STORED_BYTES = 16


def cell_bytes(spec: SweepSpec) -> int:
    """Return the bytes of one cell's variables in the file."""
    parameters = {name: spec.quantities[name] for name in (*spec.computed, *spec.listed)}
    return _bytes({**spec.model.cell_variables(spec), **parameters})


def journal_bytes(spec: SweepSpec, cells: int) -> float:
    """Return the bytes that finished blocks of so many cells take on disk, at most: of what repeats they have less."""
    return 1.01 * cells * _bytes(measured_quantities(spec)) + table_bytes(spec) + 1e4


def table_bytes(spec: SweepSpec) -> int:
    """Return the bytes of the values of a table of starts, in memory and in the folder of its run."""
    return _START_BYTES * len(spec.listed) * spec.size if spec.starts else 0


def _bytes(quantities: Mapping[str, Quantity]) -> int:
    return sum(np.dtype(each.dtype).itemsize for each in quantities.values())


def file_bytes(spec: SweepSpec) -> float:
    """Return the bytes of the finished file, at most."""
    return FILE_SHARE * spec.size * cell_bytes(spec) + plain_bytes(spec, edges=2) + 1e5


def plain_bytes(spec: SweepSpec, edges: int = 1) -> float:
    """Return the bytes of the axes, of so many edges along every control, and of curves, stored as they are."""
    rows = sum(spec.size // len(getattr(spec, axis)) for axis in spec.model.controls(spec.axes))
    points = _STORED_BYTES * len(spec.axes) * curve_points(spec)
    return 8.0 * sum(spec.shape) + _EDGE_BYTES * edges * rows + points


def memory_bytes(spec: SweepSpec, block_cells: int = MOST_BLOCK_CELLS) -> float:
    """Return the resident bytes of a run at their largest."""
    stages = _STAGES_BYTES * min(block_cells, spec.size)
    return _PROCESS_BYTES + stages + boundary_bytes(spec) + table_bytes(spec)


def boundary_bytes(spec: SweepSpec) -> float:
    """Return the bytes that the search for the boundary holds at most: the verdicts, its rows and its curves."""
    rows = [spec.size // len(getattr(spec, axis)) for axis in spec.model.controls(spec.axes)]
    most = max(rows, default=0)
    held = _ROW_BYTES * most + _STARTS_BYTES * min(most, _ROWS_AT_ONCE)
    points = curve_points(spec)
    return spec.size + held + _PLANE_BYTES * spec.size * bool(points) + _POINT_BYTES * points


def curve_points(spec: SweepSpec) -> int:
    """Return about how many points the curves of a refined boundary have: one on each line of cells, either way."""
    if spec.boundary_width is None or len(spec.axes) < 2:
        return 0
    lines, line = spec.shape[-2:]
    return (lines + line) * (spec.size // (lines * line))


def suitable_block(rate: float, least: int) -> int:
    """Return the cells of a block, a multiple of `least`, at `rate` cells per second."""
    wanted = int(rate * _BLOCK_SECONDS) // least * least
    return min(max(wanted, least), max(MOST_BLOCK_CELLS, least))


def cells_per_second(
    spec: SweepSpec,
    threads: int | None = None,
    *,
    patience: float = 0.2,
    clock: Callable[[], float] = time.perf_counter,
) -> float:
    """Measure how many cells of a spec are computed in a second.

    Parameters
    ----------
    spec : SweepSpec
    threads : int, optional
        As in `compute.use_threads`.
    patience : float
        Seconds of computing that are measurement enough.
    clock : callable
        Returns a time [s].

    Raises
    ------
    RequestError
        If `threads` is out of range, or the spec's device is not there.
    """
    use_threads(threads)
    check_device(spec)
    wanted = usable_threads(threads)
    # loading or compiling the kernels is not what is measured
    _seconds(coarse(spec, 1), clock)
    cells = 256
    while True:
        sample = coarse(spec, cells)
        took = _seconds(sample, clock)
        if took < patience:
            # the shorter of two: on a busy machine a short measurement may have waited more than it worked
            took = min(took, _seconds(sample, clock))
        if took >= patience or cells >= min(spec.size, MOST_BLOCK_CELLS):
            # a small sample does not keep all threads busy
            return sample.size / took * wanted / min(wanted, -(-sample.size // least_cells(1)))
        # grow slowly, so that the next sample does not take much longer than `patience`
        cells *= 4 if 8 * took < patience else 2


def _seconds(spec: SweepSpec, clock: Callable[[], float]) -> float:
    began = clock()
    compute(spec, whole(spec))
    return clock() - began


def block_cells(spec: SweepSpec, threads: int | None = None) -> int:
    """Choose the cells of a block: some seconds of work, but not more than memory and a small loss allow.

    Raises
    ------
    RequestError
        If `threads` is out of range.
    """
    least = least_cells(threads)
    if spec.size <= least:
        return least
    # the processor's time: on a busy machine the clock on the wall would lead to blocks too small to be worth a file
    rate = cells_per_second(spec, 1, patience=0.02, clock=time.process_time) * usable_threads(threads)
    return suitable_block(rate, least)


def least_cells(threads: int | None = None) -> int:
    """Return the cells of a block that gives every thread something to do.

    Raises
    ------
    RequestError
        If `threads` is out of range.
    """
    return chunk_cells() * usable_threads(threads)


def coarse(spec: SweepSpec, cells: int) -> SweepSpec:
    """Return a spec of about so many cells of another, spread evenly over its grid; of random starts the first ones."""
    if spec.samples:
        # as good as others, and drawn together
        return spec.replace(start=spec.start.at(np.arange(min(cells, spec.size))))
    share = (min(cells, spec.size) / spec.size) ** (1.0 / max(len(spec.axes), 1))
    picked: dict[str, list[float]] = {}
    for name in spec.axes:
        # not all values: a range may have more of them than memory holds
        axis = getattr(spec, name)
        count = max(1, round(len(axis) * share))
        picked[name] = axis.at([(2 * i + 1) * len(axis) // (2 * count) for i in range(count)]).tolist()
    return spec.replace(**picked)


def check_room(path: Path, needed: float) -> None:
    """Refuse what does not fit the disk.

    Parameters
    ----------
    path : Path
        A file on that disk, which need not exist; its folder does.
    needed : float
        Bytes to be written.

    Raises
    ------
    RequestError
    """
    free = free_bytes(path)
    if needed > free:
        raise RequestError(
            f"The atlas does not fit on the disk: the file and the journal that it is made from take about "
            f"{size(needed)}, and {size(free)} are free in {path.parent.resolve()}.",
            hint=f"Free {size(needed - free)}, use fewer cells or another disk.",
            where=str(path),
        )


def free_bytes(path: Path) -> float:
    """Return the bytes that are free on the disk of a file, which need not exist; infinite if that is not known."""
    # a file system that has no size does not say what it takes: /proc takes nothing, some network mounts anything
    usage = shutil.disk_usage(path.parent)
    return usage.free if usage.total else math.inf


def size(count: float) -> str:
    """Return a number of bytes for people."""
    for factor, unit in ((1e12, "TB"), (1e9, "GB"), (1e6, "MB")):
        if count >= 10 * factor:
            return f"{count / factor:.0f} {unit}"
    return f"{count / 1e6:.1f} MB"
