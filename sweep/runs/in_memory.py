"""An atlas in memory. If the call is interrupted, the cells that are done stay, and the same call goes on with them."""

import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sweep.atlas.dataset import assemble, empty_columns
from sweep.atlas.report_units import with_substitutes
from sweep.engine.compute import Block, check_block_cells, check_device, compute, use_threads
from sweep.engine.grid import BLOCK_CELLS, Span, starts_of
from sweep.errors import StoppedError, are, counted
from sweep.files.publish import size
from sweep.progress.display import following
from sweep.progress.timetable import COMPUTING, SEARCHING, Progress, Show, Stage, Timetable
from sweep.request.spec import SweepSpec
from sweep.runs.executor import Stopping, interruptible
from sweep.runs.forecast import bisected_cells, cell_bytes

if TYPE_CHECKING:
    import xarray as xr

#: Cells of the first block, few enough that an interrupt does not wait for minutes where a cell takes 1e-3 s; seconds
#: that a block should take; and how much larger the next one may be.
_FIRST, _SECONDS, _GROWTH = 2**12, 0.25, 32


class _Cells:
    """The cells of an atlas that are computed so far: the first ones in C order."""

    def __init__(self, spec: SweepSpec) -> None:
        self.spec, self.done, self.columns = spec, 0, empty_columns(spec)

    def take(self, block: Block) -> None:
        """Add the next cells."""
        for name, column in block.columns.items():
            self.columns[name][block.span.start : block.span.stop] = column
        self.done = block.span.stop

    def kept(self) -> str:
        """Return in words what is kept."""
        taken = size(self.done * cell_bytes(self.spec))
        return f"{counted(self.done, 'cell', self.spec.size)} {are(self.done)} computed and kept in memory ({taken})"


#: The cells of the last call that did not come to its end, if no call has gone on with them.
_interrupted: _Cells | None = None


def run(
    spec: SweepSpec | str | Path,
    *,
    threads: int | None = None,
    block_cells: int | None = None,
    progress: Progress = None,
    **changes: Any,
) -> "xr.Dataset":
    """Compute the atlas of a spec in memory: ``run("rolling", radius="12mm")``.

    Ctrl-C, or the interrupt of a notebook, ends the call after its current block. The cells that are done stay in
    memory, and the same call goes on with them, until another call is interrupted or `sweep.forget` is called. What has
    to survive the end of the process is computed with `sweep.run_to_file`.

    Parameters
    ----------
    spec : SweepSpec, str or Path
        A spec, the name of a preset, or the path of a TOML file.
    threads : int, optional
        Threads to use; all that this process may use if not given.
    block_cells : int, optional
        Cells computed at a time; some tenths of a second of work if not given. Neither this nor `threads` changes a bit
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
        Dimensions: the spec's axes in order. The variables are those of the model (docs/atlas.md), in SI.
        `sweep.save` writes it.

    Raises
    ------
    RequestError
        If the spec or a change is not possible, or `threads`, `block_cells` or `progress` is.
    KeyboardInterrupt
        If it was interrupted, with how much is kept.
    """
    global _interrupted
    spec = SweepSpec.read(spec, **changes)
    check_block_cells(block_cells)
    use_threads(threads)
    check_device(spec)
    cells = _taken_up(spec)
    try:
        with following(progress) as show, interruptible() as stopping:
            return _computed(cells, block_cells, show, stopping)
    except BaseException:
        # an error of the caller's progress function loses nothing either
        if cells.done:
            _interrupted = cells
        raise


def forget() -> None:
    """Free the cells that an interrupted `sweep.run` has kept in memory; the same call then begins anew."""
    global _interrupted
    _interrupted = None


def _taken_up(spec: SweepSpec) -> _Cells:
    """Return the cells that a call of the same spec has left, which no other call gets; else none of them computed."""
    global _interrupted
    if _interrupted is None or _interrupted.spec != spec:
        return _Cells(spec)
    cells, _interrupted = _interrupted, None
    return cells


def _computed(cells: _Cells, block_cells: int | None, show: Show, stopping: Stopping) -> "xr.Dataset":
    """Compute the cells that are missing, and return the atlas; raise StoppedError when the call is to stop."""
    spec = cells.spec
    timetable = Timetable([Stage(COMPUTING, spec.size), Stage(SEARCHING, bisected_cells(spec))], show)

    def go_on() -> None:
        if stopping():
            raise StoppedError(cells.kept())

    timetable.begin(COMPUTING, cells.done)
    for block in _blocks(spec, cells.done, block_cells):
        cells.take(block)
        timetable.report(cells.done)
        go_on()
    timetable.begin(SEARCHING)

    def searched(share: float) -> None:
        timetable.report(int(share * bisected_cells(spec)))
        go_on()

    atlas = assemble(spec, cells.columns, with_substitutes("sweep.run", spec), searched)
    # not later: a call that raises returns no atlas, and the cells would be lost
    go_on()
    return atlas


def _blocks(spec: SweepSpec, start: int, given: int | None) -> Iterator[Block]:
    """Compute the cells from `start` on, in blocks of a given size, or of one that the time of the last suggests."""
    cells = given or _FIRST
    while start < spec.size:
        span = Span(start, min(spec.size, start + cells))
        began = time.monotonic()
        yield Block(span, compute(spec, starts_of(spec, span)))
        start = span.stop
        if given is None:
            cells = _next_size(len(span), time.monotonic() - began)


def _next_size(cells: int, seconds: float) -> int:
    """Return the cells of the block after one of so many cells that took so long."""
    wanted = cells * min(_SECONDS / seconds, _GROWTH) if seconds > 0 else cells * _GROWTH
    # the lanes of the threads run empty at the end of each block: smaller ones than the first are not worth it
    return max(_FIRST, min(int(wanted), BLOCK_CELLS))
