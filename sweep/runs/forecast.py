"""The cost of a run: seconds, measured on samples of its cells, and bytes on disk and in memory.

This module imports nothing heavy before it measures the speed of the kernels.
"""

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Self

import numpy as np

from sweep import platforms
from sweep.atlas.cf_metadata import cell_declarations
from sweep.engine.compute import (
    check_device,
    compute,
    derive_block,
    measure_block,
    measured_quantities,
    stored_quantities,
    usable_threads,
    use_threads,
)
from sweep.engine.grid import MOST_BLOCK_CELLS, Span, whole
from sweep.errors import RequestError, counted
from sweep.files.publish import FILE_SHARE, check_room, size
from sweep.files.raw_chunks import packed
from sweep.model.kernel import chunk_cells
from sweep.model.quantity import Quantity
from sweep.progress.timetable import COMPUTING, SEARCHING, Show, Stage, Timetable, duration
from sweep.request.spec import SweepSpec
from sweep.runs.journal import encode

#: Seconds of work in a block: a crash costs the blocks in progress.
_BLOCK_SECONDS = 1.5

#: Bytes of a process with the compiler and the file libraries, before it has any cells.
_PROCESS_BYTES = 270e6

#: Bytes per cell of a block in all its stages together: computing, writing and compressing.
_STAGES_BYTES = 500

#: Bytes of a row of an edge in a file: four numbers and a code.
_EDGE_BYTES = 33

#: Bytes of memory of a row during the search for its edge; number of rows whose brackets are bisected together, and
#: bytes of each.
_ROW_BYTES, _ROWS_AT_ONCE, _STARTS_BYTES = 40, 2**16, 800

#: Bytes of a value in a table of starts.
_START_BYTES = 8

#: Bytes of memory of a cell, and of a point, while the points of a refined boundary are joined to curves.
_PLANE_BYTES, _POINT_BYTES = 3, 160

#: Bytes of a point along one axis in a file: its position and its half-width.
_STORED_BYTES = 16

#: Seconds per cell to read and check a block of the journal; seconds per cell of one thread to derive, filter and write
#: cells. Measured with 1e7 cells of 52 bytes on a busy machine.
_READING, _WRITING = 8e-8, 5e-7


#: Names of the stages that not every sweep has.
READING: Final = "reading finished blocks"
WRITING: Final = "writing"

#: Number of parts of the grid that are encoded and filtered as in a run, and most cells of each.
_STRETCHES, _CELLS = 3, 8192

#: Seconds for computing a part; cells per second if they were not measured.
_PATIENCE, _RATE_UNKNOWN = 0.1, 1e4

#: Seconds in which a run loads its compiled kernels, chooses its blocks and makes its folder.
_LOADING = 0.3

#: Allowance for parts that take more bytes than the samples.
_MARGIN = 1.1

#: Least number of cells for which measuring the bytes on disk is worth it: for fewer cells the bounds are small.
_FEW = 10_000


# -- bytes


def cell_bytes(spec: SweepSpec) -> int:
    """Return the bytes of the variables of one cell in the file."""
    return _bytes(stored_quantities(spec))


def journal_bytes(spec: SweepSpec, cells: int) -> float:
    """Return an upper bound of the bytes of finished blocks with this many cells; repeated values take less."""
    return 1.01 * cells * _bytes(measured_quantities(spec)) + table_bytes(spec) + 1e4


def table_bytes(spec: SweepSpec) -> int:
    """Return the bytes of a table of starts, in memory and in the folder of its run."""
    return _START_BYTES * len(spec.listed) * spec.size if spec.starts else 0


def _bytes(quantities: Mapping[str, Quantity]) -> int:
    return sum(np.dtype(quantity.dtype).itemsize for quantity in quantities.values())


def file_bytes(spec: SweepSpec) -> float:
    """Return an upper bound of the bytes of the finished file."""
    return FILE_SHARE * spec.size * cell_bytes(spec) + plain_bytes(spec, edges=2) + 1e5


def plain_bytes(spec: SweepSpec, edges: int = 1) -> float:
    """Return the uncompressed bytes of the axes, of `edges` edges along every control, and of curves."""
    rows = sum(spec.size // len(getattr(spec, axis)) for axis in spec.model.controls(spec.axes))
    points = _STORED_BYTES * len(spec.axes) * curve_points(spec)
    return 8.0 * sum(spec.shape) + _EDGE_BYTES * edges * rows + points


def memory_bytes(spec: SweepSpec, block_cells: int = MOST_BLOCK_CELLS) -> float:
    """Return the largest resident bytes of a run."""
    stages = _STAGES_BYTES * min(block_cells, spec.size)
    return _PROCESS_BYTES + stages + boundary_bytes(spec) + table_bytes(spec)


def boundary_bytes(spec: SweepSpec) -> float:
    """Return the largest bytes of the search for the boundary: its verdicts, rows and curves."""
    rows = [spec.size // len(getattr(spec, axis)) for axis in spec.model.controls(spec.axes)]
    most = max(rows, default=0)
    of_rows = _ROW_BYTES * most + _STARTS_BYTES * min(most, _ROWS_AT_ONCE)
    points = curve_points(spec)
    return spec.size + of_rows + _PLANE_BYTES * spec.size * bool(points) + _POINT_BYTES * points


def curve_points(spec: SweepSpec) -> int:
    """Return an estimate of the points on the curves of a refined boundary: one on each row and column of cells."""
    if spec.boundary_width is None or len(spec.axes) < 2:
        return 0
    lines, line = spec.shape[-2:]
    return (lines + line) * (spec.size // (lines * line))


# -- cells of a block, and the speed of a machine


def suitable_block(rate: float, least: int) -> int:
    """Return the number of cells of a block, a multiple of `least`, at `rate` cells per second."""
    wanted = int(rate * _BLOCK_SECONDS) // least * least
    return min(max(wanted, least), max(MOST_BLOCK_CELLS, least))


def cells_per_second(
    spec: SweepSpec,
    threads: int | None = None,
    *,
    patience: float = 0.2,
    clock: Callable[[], float] = time.perf_counter,
) -> float:
    """Measure the speed of the kernels for a spec, in cells per second.

    Parameters
    ----------
    spec : SweepSpec
    threads : int, optional
        As in `compute.use_threads`.
    patience : float
        Seconds of computing that are enough for a measurement.
    clock : callable
        Returns a time [s].

    Raises
    ------
    RequestError
        If `threads` is out of range, or the spec's device is missing.
    """
    use_threads(threads)
    check_device(spec)
    wanted = usable_threads(threads)
    # load or compile the kernels before the measurement
    _seconds(coarse(spec, 1), clock)
    cells = 256
    while True:
        sample = coarse(spec, cells)
        took = _seconds(sample, clock)
        if took < patience:
            # the shorter of two: on a busy machine most of a short measurement may be waiting
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
    """Return the number of cells of a block for about a second of work, limited by memory and the loss in a crash.

    Raises
    ------
    RequestError
        If `threads` is out of range.
    """
    least = least_cells(threads)
    if spec.size <= least:
        return least
    # processor time: on a busy machine, wall clock time would give blocks too small to be worth a file
    rate = cells_per_second(spec, 1, patience=0.02, clock=time.process_time) * usable_threads(threads)
    return suitable_block(rate, least)


def least_cells(threads: int | None = None) -> int:
    """Return the least number of cells of a block that keeps all threads busy.

    Raises
    ------
    RequestError
        If `threads` is out of range.
    """
    return chunk_cells() * usable_threads(threads)


def coarse(spec: SweepSpec, cells: int) -> SweepSpec:
    """Return a spec of about this many cells, spread evenly over the grid; the first ones of random starts."""
    if spec.samples:
        # as good as any others
        return spec.replace(start=spec.start.at(np.arange(min(cells, spec.size))))
    share = (min(cells, spec.size) / spec.size) ** (1.0 / max(len(spec.axes), 1))
    values: dict[str, list[float]] = {}
    for name in spec.axes:
        # never all values: a range may have more than fit into memory
        axis = getattr(spec, name)
        count = max(1, round(len(axis) * share))
        values[name] = axis.at([(2 * i + 1) * len(axis) // (2 * count) for i in range(count)]).tolist()
    return spec.replace(**values)


# -- stages


def of_run(spec: SweepSpec, missing: int, threads: int | None, show: Show) -> Timetable:
    """Return the timetable of a run that has to compute `missing` of its cells.

    `threads` is the number of threads that write the cells after the computation; None if both overlap.
    """
    computing = [Stage(COMPUTING, spec.size)] if missing else []
    writing = [Stage(WRITING, spec.size, _WRITING / threads)] if threads else []
    return Timetable([*computing, *writing, Stage(SEARCHING, bisected_cells(spec))], show)


def of_part(cells: int, show: Show) -> Timetable:
    """Return the timetable of a job that computes this many cells and writes no file."""
    return Timetable([Stage(READING, cells, _READING), Stage(COMPUTING, cells)], show)


def of_journal(spec: SweepSpec, threads: int, show: Show) -> Timetable:
    """Return the timetable of writing the file of a run whose cells are all computed."""
    stages = [Stage(READING, spec.size, _READING), Stage(WRITING, spec.size, _WRITING / threads)]
    return Timetable([*stages, Stage(SEARCHING, bisected_cells(spec))], show)


def bisected_cells(spec: SweepSpec) -> int:
    """Return an estimate of the cells that the bisection of the boundary integrates: a bracket in every row."""
    width = spec.boundary_width
    if width is None:
        return 0
    cells = 0
    for axis in spec.model.controls(spec.axes):
        low, high = getattr(spec, axis).ends()
        count = len(getattr(spec, axis))
        halvings = math.log2(max(1.0, (high - low) / max(count - 1, 1) / width))
        cells += spec.size // count * math.ceil(halvings)
    # for the edges and, in a plane, again for the curves
    return cells * (1 if len(spec.axes) < 2 else 2)


# -- a forecast


@dataclass(frozen=True)
class Forecast:
    """The cost of a run.

    Attributes
    ----------
    rate : float
        Cells per second of all its threads.
    keeping : float
        Processor seconds per cell for everything else: to keep it in the journal, derive, filter and write it.
    journal, file : float
        Bytes per cell on disk.
    start, search : float
        Seconds before the first cell, and for the boundary after the last cell.
    """

    rate: float
    keeping: float
    journal: float
    file: float
    start: float
    search: float

    @classmethod
    def measured(cls, spec: SweepSpec, threads: int | None) -> Self:
        """Measure samples of the cells of a spec; the processor time of this process so far counts as the start.

        Raises
        ------
        RequestError
            If `threads` is out of range, or the spec's device is missing.
        """
        start = time.process_time() + _LOADING
        rate = cells_per_second(spec, threads)
        keeping, journal, file = _keeping(spec, rate)
        return cls(rate, keeping, journal, file, start, bisected_cells(spec) / rate)

    def seconds(self, spec: SweepSpec, threads: int, processors: int) -> float:
        """Return the time of the run [s].

        Parameters
        ----------
        spec : SweepSpec
        threads, processors : int
            The number of threads that compute, which is also the number that keep and write; available processors.
        """
        computing, keeping = spec.size / self.rate, spec.size * self.keeping
        used = min(threads, processors)
        both = max(computing, keeping / used, (used * computing + keeping) / processors)
        return self.start + both + self.search

    def journal_bytes(self, spec: SweepSpec) -> float:
        """Return the bytes of the journal."""
        return min(self.journal * spec.size + 1e4, journal_bytes(spec, spec.size))

    def file_bytes(self, spec: SweepSpec) -> float:
        """Return the bytes of the file."""
        return min(self.file * spec.size + plain_bytes(spec) + 1e5, file_bytes(spec))


def describe(
    spec: SweepSpec,
    path: Path,
    found: Forecast | None,
    cells: int | None,
    threads: int = 1,
    processors: int = 1,
) -> list[str]:
    """Return the cost of a run as lines: cells, blocks, time, memory, disk.

    Parameters
    ----------
    spec : SweepSpec
    path : Path
        The file.
    found : Forecast or None
        None if it was not measured.
    cells : int or None
        Cells of a block; None if they are not decided yet.
    threads, processors : int
        As in `Forecast.seconds`.
    """
    most = cells or MOST_BLOCK_CELLS
    shape = (
        "random starts"
        if spec.samples
        else "starts of a table"
        if spec.starts
        else " x ".join(map(str, spec.shape)) or "one"
    )
    blocks, cells_each = math.ceil(spec.size / most), counted(min(most, spec.size), "cell")
    expected, about = "not measured", "at most"
    journal, file = journal_bytes(spec, spec.size), file_bytes(spec)
    if found is not None:
        taken = duration(found.seconds(spec, threads, processors))
        expected, about = f"about {taken} ({found.rate:.3g} cells per second)", "about"
        journal, file = found.journal_bytes(spec), found.file_bytes(spec)
    free = platforms.free_bytes(path.parent)
    room = f"{size(free)} free" if math.isfinite(free) else "free space unknown"
    return [
        f"cells    {spec.size} ({shape})",
        f"blocks   {blocks} of {cells_each}"
        if cells
        else f"blocks   at least {blocks} of at most {cells_each}",
        f"time     {expected}",
        f"memory   about {size(memory_bytes(spec, most))}",
        f"disk     {about} {size(journal)} for the journal, which is removed at the end, and {about} "
        f"{size(file)} for the file; {room} in {path.parent.resolve()}",
    ]


def check_run_fits(path: Path, spec: SweepSpec, cells: int) -> None:
    """Refuse a run that does not fit on the disk.

    The upper bounds are loose. If they do not fit, some cells are computed to get a better estimate.

    Parameters
    ----------
    path : Path
        The file; its folder exists.
    spec : SweepSpec
    cells : int
        Number of cells still to be computed.

    Raises
    ------
    RequestError
    """
    most = journal_bytes(spec, cells) + file_bytes(spec)
    try:
        check_room(path, most)
    except RequestError:
        if spec.size < _FEW:
            raise
        _, journal, file = _keeping(spec, _RATE_UNKNOWN)
        known = journal * cells + file * spec.size + plain_bytes(spec, edges=2) + 1e5
        check_room(path, min(most, known))


def _keeping(
    spec: SweepSpec, rate: float, clock: Callable[[], float] = time.process_time
) -> tuple[float, float, float]:
    """Measure the costs per cell besides its computation: processor seconds, bytes in the journal and in the file.

    Measured on parts of the grid.
    """
    count = max(1, min(_CELLS, spec.size // _STRETCHES, int(_PATIENCE * rate)))
    seconds, journal, file = 0.0, 0, 0
    for k in range(_STRETCHES):
        first = (2 * k + 1) * (spec.size - count) // (2 * _STRETCHES)
        span = Span(first, first + count)
        measured = measure_block(spec, span)
        began = clock()
        content = encode(measured, spec.shape[-1] if spec.axes else 1)
        columns = derive_block(spec, span, measured)
        file += sum(len(packed(columns[variable.name], count)) for variable in cell_declarations(spec))
        seconds += clock() - began
        # without the line with the names of the columns, of which a block has only one
        journal += len(content) - content.index(b"\n")
    cells = _STRETCHES * count
    return seconds / cells, _MARGIN * journal / cells, _MARGIN * file / cells
