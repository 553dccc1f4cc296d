"""Atlases computed in memory. An interrupted call keeps nothing; to be able to resume, write to a file."""

import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sweep.atlas.dataset import assemble, empty_columns
from sweep.engine.compute import Block, check_block_cells, check_device, compute, use_threads
from sweep.engine.grid import BLOCK_CELLS, Span, starts_of
from sweep.errors import StoppedError, are, counted
from sweep.progress.display import following
from sweep.progress.timetable import COMPUTING, SEARCHING, Progress, Show, Stage, Timetable
from sweep.request.spec import SweepSpec
from sweep.runs.executor import Stopping, interruptible
from sweep.runs.forecast import bisected_cells

if TYPE_CHECKING:
    import xarray as xr

#: Cells of the first block, few enough that an interrupt does not wait for minutes if a cell takes 1e-3 s; wanted
#: seconds of a block; largest growth from one block to the next.
_FIRST, _SECONDS, _GROWTH = 2**12, 0.25, 32

_ADVICE = "For a run that can be resumed, write to a file: sweep.run_to_file(spec, path)."


def run(
    spec: SweepSpec | str | Path,
    *,
    threads: int | None = None,
    block_cells: int | None = None,
    progress: Progress = None,
    **changes: Any,
) -> "xr.Dataset":
    """Compute the atlas of a spec in memory: ``run("rolling", radius="12mm")``.

    Ctrl-C, or the interrupt of a notebook, ends the call after its current block, and nothing is kept. To be able to
    resume, write to a file: `sweep.run_to_file`.

    Parameters
    ----------
    spec : SweepSpec, str or Path
        A spec, the name of a preset, or the path of a TOML file.
    threads : int, optional
        Number of threads; by default all that this process may use.
    block_cells : int, optional
        Cells computed at a time; by default some tenths of a second of work. Neither this nor `threads` changes a bit
        of the result.
    progress : bool or callable, optional
        True shows a bar (in a log: a line every few seconds), False nothing. By default there is a bar in notebooks and
        interactive sessions if the work takes more than half a second, and nothing in scripts and tests. A function is
        called with a `sweep.Status` after every block.
    **changes
        Words of the spec with other values, as on the command line; see `SweepSpec.read`.

    Returns
    -------
    xarray.Dataset
        Dimensions: the axes of the spec in order. Variables: those of the model (docs/atlas.md), in SI.
        `sweep.save` writes it.

    Raises
    ------
    RequestError
        If the spec, a change, `threads`, `block_cells` or `progress` is not possible.
    KeyboardInterrupt
        If it was interrupted.
    """
    spec = SweepSpec.read(spec, **changes)
    check_block_cells(block_cells)
    use_threads(threads)
    check_device(spec)
    with following(progress) as show, interruptible(advice=_ADVICE) as stopping:
        return _compute_atlas(spec, block_cells, show, stopping)


def _compute_atlas(spec: SweepSpec, block_cells: int | None, show: Show, stopping: Stopping) -> "xr.Dataset":
    """Compute all cells, and return the atlas; raise StoppedError if `stopping` returns true."""
    timetable = Timetable([Stage(COMPUTING, spec.size), Stage(SEARCHING, bisected_cells(spec))], show)
    columns, done = empty_columns(spec), 0

    def check_stop() -> None:
        if stopping():
            computed = f"{counted(done, 'cell', spec.size)} {are(done, 'was', 'were')} computed"
            raise StoppedError(f"{computed}; nothing is kept")

    timetable.begin(COMPUTING)
    for block in _blocks(spec, block_cells):
        for name, column in block.columns.items():
            columns[name][block.span.start : block.span.stop] = column
        done = block.span.stop
        timetable.report(done)
        check_stop()
    timetable.begin(SEARCHING)

    def report_search(share: float) -> None:
        timetable.report(int(share * bisected_cells(spec)))
        check_stop()

    atlas = assemble(spec, columns, "sweep.run", report_search)
    # an interrupt returns no atlas, so it must not say that all work was done
    check_stop()
    return atlas


def _blocks(spec: SweepSpec, block_cells: int | None) -> Iterator[Block]:
    """Compute all cells, in blocks of a given size, or of a size from the time of the last block."""
    start, cells = 0, block_cells or _FIRST
    while start < spec.size:
        span = Span(start, min(spec.size, start + cells))
        began = time.monotonic()
        yield Block(span, compute(spec, starts_of(spec, span)))
        start = span.stop
        if block_cells is None:
            cells = _next_size(len(span), time.monotonic() - began)


def _next_size(cells: int, seconds: float) -> int:
    """Return the number of cells of the next block, from the cells and seconds of the last one."""
    wanted = cells * min(_SECONDS / seconds, _GROWTH) if seconds > 0 else cells * _GROWTH
    # lanes run empty at the end of each block, so blocks smaller than the first one are not worth it
    return max(_FIRST, min(int(wanted), BLOCK_CELLS))
