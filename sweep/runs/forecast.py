"""What a run will take, measured on samples of its cells: seconds, and bytes on disk."""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Self

from sweep.atlas.cf_metadata import cell_declarations
from sweep.engine import estimate
from sweep.engine.compute import derive_block, measure_block
from sweep.engine.grid import MOST_BLOCK_CELLS, Span
from sweep.errors import RequestError, counted
from sweep.files.raw_chunks import packed
from sweep.progress.timetable import COMPUTING, SEARCHING, Show, Stage, Timetable, duration
from sweep.request.spec import SweepSpec
from sweep.runs.journal import encode

#: Seconds per cell to read and check a block of the journal; and of one thread to derive, filter and write a cell.
#: Measured with 1e7 cells of 52 bytes on a busy machine.
_READING, _WRITING = 8e-8, 5e-7


#: Names of stages, beside those that every sweep has.
READING: Final = "reading what is there"
WRITING: Final = "writing"


def of_run(spec: SweepSpec, missing: int, threads: int | None, show: Show) -> Timetable:
    """Return the timetable of a run that has to compute `missing` of its cells.

    `threads` write all cells when the last one is computed; None if they are written while they are computed.
    """
    computing = [Stage(COMPUTING, spec.size)] if missing else []
    writing = [Stage(WRITING, spec.size, _WRITING / threads)] if threads else []
    return Timetable([*computing, *writing, Stage(SEARCHING, bisected_cells(spec))], show)


def of_part(cells: int, show: Show) -> Timetable:
    """Return the timetable of a job that computes so many cells and leaves the file to another one."""
    return Timetable([Stage(READING, cells, _READING), Stage(COMPUTING, cells)], show)


def of_journal(spec: SweepSpec, threads: int, show: Show) -> Timetable:
    """Return the timetable of making the file of a run whose cells are all computed."""
    stages = [Stage(READING, spec.size, _READING), Stage(WRITING, spec.size, _WRITING / threads)]
    return Timetable([*stages, Stage(SEARCHING, bisected_cells(spec))], show)


def bisected_cells(spec: SweepSpec) -> int:
    """Return about how many cells the bisection of the boundary integrates: a bracket in every row."""
    width = spec.boundary_width
    if width is None:
        return 0
    cells = 0
    for axis in spec.model.controls(spec.axes):
        low, high = getattr(spec, axis).ends()
        count = len(getattr(spec, axis))
        halvings = math.log2(max(1.0, (high - low) / max(count - 1, 1) / width))
        cells += spec.size // count * math.ceil(halvings)
    # the edges, and in a plane the curves again
    return cells * (1 if len(spec.axes) < 2 else 2)


#: Stretches of the grid that are kept and filtered as a run does it, and cells of each.
_STRETCHES, _CELLS = 3, 8192

#: Seconds that computing a stretch, or some rows, may take; cells per second where they were not measured.
_PATIENCE, _RATE_UNKNOWN = 0.1, 1e4

#: Seconds in which a run loads its kernels, chooses its blocks and makes its folder, once the kernels are compiled.
_LOADING = 0.3

#: What the bytes of other stretches may have more than those of the samples.
_MARGIN = 1.1

#: Rows in which the boundary is searched and cells of each, at most; how many fewer the first search has; cells that
#: the bisection of a row computes.
_ROWS, _ALONG, _FEWER, _HALVINGS = 2048, 128, 8, 40

#: Cells from which on the bytes on disk are worth a sample; below that the bounds of `estimate` are small.
_FEW = 10_000


@dataclass(frozen=True)
class Forecast:
    """What a run takes.

    Attributes
    ----------
    rate : float
        Cells per second that its threads compute.
    keeping : float
        Seconds of one processor for all else that is done with a cell: to keep it, to derive, filter and write it.
    journal, file : float
        Bytes per cell on disk.
    start, search : float
        Seconds before the first cell, and for the boundary after the last one.
    """

    rate: float
    keeping: float
    journal: float
    file: float
    start: float
    search: float

    @classmethod
    def measured(cls, spec: SweepSpec, threads: int | None) -> Self:
        """Measure on samples of the cells of a spec; what this process has done before counts as the start.

        Raises
        ------
        RequestError
            If `threads` is out of range, or the spec's device is not there.
        """
        start = time.process_time() + _LOADING
        rate = estimate.cells_per_second(spec, threads)
        keeping, journal, file = _keeping(spec, rate)
        return cls(rate, keeping, journal, file, start, bisected_cells(spec) / rate)

    def seconds(self, spec: SweepSpec, threads: int, processors: int) -> float:
        """Return how long the run takes [s].

        Parameters
        ----------
        spec : SweepSpec
        threads, processors : int
            As many threads compute, and as many keep what is computed, on the processors that there are.
        """
        computing, keeping = spec.size / self.rate, spec.size * self.keeping
        used = min(threads, processors)
        beside = max(computing, keeping / used, (used * computing + keeping) / processors)
        return self.start + beside + self.search

    def journal_bytes(self, spec: SweepSpec) -> float:
        """Return the bytes of the journal."""
        return min(self.journal * spec.size + 1e4, estimate.journal_bytes(spec, spec.size))

    def file_bytes(self, spec: SweepSpec) -> float:
        """Return the bytes of the file."""
        return min(self.file * spec.size + estimate.plain_bytes(spec) + 1e5, estimate.file_bytes(spec))


def describe(
    spec: SweepSpec,
    path: Path,
    found: Forecast | None,
    cells: int | None,
    threads: int = 1,
    processors: int = 1,
) -> list[str]:
    """Return what a run takes, one line each: cells, blocks, time, memory, disk.

    Parameters
    ----------
    spec : SweepSpec
    path : Path
        The file of the end.
    found : Forecast or None
        If it was measured.
    cells : int or None
        Cells of a block, if they are decided.
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
    blocks = f"{math.ceil(spec.size / most)} of {counted(min(most, spec.size), 'cell')}"
    expected, about = "not measured", "at most"
    journal, file = estimate.journal_bytes(spec, spec.size), estimate.file_bytes(spec)
    if found is not None:
        taken = duration(found.seconds(spec, threads, processors))
        expected, about = f"about {taken} ({found.rate:.3g} cells per second)", "about"
        journal, file = found.journal_bytes(spec), found.file_bytes(spec)
    free = estimate.free_bytes(path)
    room = f"{estimate.size(free)} free" if math.isfinite(free) else "free space unknown"
    return [
        f"cells    {spec.size} ({shape})",
        f"blocks   {blocks}" if cells else f"blocks   at least {blocks} at most",
        f"time     {expected}",
        f"memory   about {estimate.size(estimate.memory_bytes(spec, most))}",
        f"disk     {about} {estimate.size(journal)} for the journal, which goes at the end, and {about} "
        f"{estimate.size(file)} for the file; {room} in {path.parent.resolve()}",
    ]


def check_room(path: Path, spec: SweepSpec, cells: int) -> None:
    """Refuse a run that does not fit the disk.

    The bounds of `estimate` are wide: only where they do not fit are some cells computed, to know better.

    Parameters
    ----------
    path : Path
        The file; its folder exists.
    spec : SweepSpec
    cells : int
        Cells that are still to be computed.

    Raises
    ------
    RequestError
    """
    most = estimate.journal_bytes(spec, cells) + estimate.file_bytes(spec)
    try:
        estimate.check_room(path, most)
    except RequestError:
        if spec.size < _FEW:
            raise
        _, journal, file = _keeping(spec, _RATE_UNKNOWN)
        known = journal * cells + file * spec.size + estimate.plain_bytes(spec, edges=2) + 1e5
        estimate.check_room(path, min(most, known))


def _keeping(
    spec: SweepSpec, rate: float, clock: Callable[[], float] = time.process_time
) -> tuple[float, float, float]:
    """Return what cells take beside their computation: seconds of one processor, bytes in the journal and in the file.

    Measured on stretches of the grid, and per cell.
    """
    count = max(1, min(_CELLS, spec.size // _STRETCHES, int(_PATIENCE * rate)))
    taken, journal, file = 0.0, 0, 0
    for k in range(_STRETCHES):
        first = (2 * k + 1) * (spec.size - count) // (2 * _STRETCHES)
        span = Span(first, first + count)
        measured = measure_block(spec, span)
        began = clock()
        content = encode(measured, spec.shape[-1] if spec.axes else 1)
        columns = derive_block(spec, span, measured)
        file += sum(len(packed(columns[each.name], count)) for each in cell_declarations(spec))
        taken += clock() - began
        # the line that names the columns stands once in a block
        journal += len(content) - content.index(b"\n")
    cells = _STRETCHES * count
    return taken / cells, _MARGIN * journal / cells, _MARGIN * file / cells
