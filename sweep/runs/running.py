"""A run from its claim to the finished file: the blocks that are missing are computed, then all are assembled."""

import contextlib
from collections.abc import Generator, Iterator, Sequence
from pathlib import Path

from sweep.engine import estimate
from sweep.engine.ahead import ahead
from sweep.engine.device import check_device
from sweep.engine.runner import Block, usable_threads
from sweep.errors import StoppedError
from sweep.files.publish import refusals
from sweep.files.store import check_target
from sweep.request.spec import SweepSpec
from sweep.runs import journal
from sweep.runs.assembly import publish_atlas, published
from sweep.runs.claims import begun, check_claimable, claimed, final
from sweep.runs.driving import Driver, Kept, Progress, Say, Stopping, here, unheard
from sweep.runs.failures import Failures
from sweep.runs.journal import Journal


def run_to_file(
    spec: SweepSpec,
    path: str | Path,
    *,
    overwrite: bool = False,
    threads: int | None = None,
    block_cells: int | None = None,
    command: str = "sweep.run_to_file",
    progress: Progress = unheard,
    say: Say = unheard,
    stopping: Stopping = lambda: False,
    driver: Driver | None = None,
) -> Failures:
    """Compute the atlas of a spec and write it to one netCDF file, going on where an earlier run has ended.

    Parameters
    ----------
    spec : SweepSpec
    path : str or Path
        The file; it appears only when it is complete. Until then finished blocks are kept in a folder beside it, named
        like the file with ``.run`` at its end.
    overwrite : bool
        Replace an existing file, at the very end.
    threads : int, optional
        Threads to use; all that this process may use if not given.
    block_cells : int, optional
        Cells of a block, of about a second of work if not given. A run that goes on keeps the blocks it was begun with.
    command : str
        What the user ran, for the history.
    progress : callable, optional
        Called with (cells done, cells in all) after every block.
    say : callable, optional
        Called with a sentence when blocks of an earlier run are kept or set aside.
    stopping : callable, optional
        Asked before every block whether to end the run.
    driver : callable, optional
        Computes blocks elsewhere.

    Returns
    -------
    Failures
        The cells that could not be computed.

    Raises
    ------
    RequestError
        If the file exists, its folder does not or cannot be written, another run writes it or has left blocks of
        another spec, or the disk has not enough room; nothing has been touched then.
    StorageError
        If the file system refuses on the way; finished blocks are kept.
    StoppedError
        If `stopping` said so; finished blocks are kept.
    """
    path = final(path)
    check_claimable(path, overwrite)
    usable_threads(threads)
    check_device(spec)
    with claimed(path, overwrite) as folder:
        earlier = published(folder, path)
        if earlier is not None:
            journal.remove(folder)
            return earlier
        check_target(path, overwrite)
        book = begun(spec, path, folder, block_cells, threads, command)
        return _fill(book, path, driver, threads, progress, say, stopping)


def _fill(
    book: Journal,
    path: Path,
    driver: Driver | None,
    threads: int | None,
    progress: Progress,
    say: Say,
    stopping: Stopping,
) -> Failures:
    spec = book.manifest.spec
    book.sweep_out()
    sound, damaged = book.verify()
    missing = book.missing(sound)
    cells = sum(len(book.spans[number]) for number in missing)
    for each in damaged:
        say(f"damaged, set aside and computed again: {each}")
    if sound or damaged:
        say(f"going on: {len(sound)} of {len(book.spans)} blocks are there, {len(missing)} to compute")
    if sound:
        progress(spec.size - cells, spec.size)
    estimate.check_room(path, estimate.journal_bytes(spec, cells) + estimate.file_bytes(spec))
    computed = _watched(book, (driver or here(threads))(book, missing, stopping), missing, progress)

    def needed() -> float:
        to_come = sum(len(book.spans[number]) for number in book.missing(book.held()))
        return estimate.journal_bytes(spec, to_come) + estimate.file_bytes(spec)

    with refusals(path, needed, book.kept), contextlib.closing(computed):
        if sound or driver:
            # what is missing comes first: however often a run is killed, it gets further
            for _ in computed:
                pass
            with ahead(_unless(stopping, book)) as blocks:
                return publish_atlas(book, path, blocks)
        return publish_atlas(book, path, _in_passing(book, computed, stopping))


def _watched(
    book: Journal, driven: Iterator[Kept], missing: Sequence[int], progress: Progress
) -> Generator[Kept, None, None]:
    size = book.manifest.spec.size
    left = {number: len(book.spans[number]) for number in missing}
    for number, columns in driven:
        left.pop(number, None)
        progress(size - sum(left.values()), size)
        yield number, columns
    if left:
        raise StoppedError(str(book.folder), len(book.spans) - len(left), len(book.spans))


def _in_passing(book: Journal, computed: Iterator[Kept], stopping: Stopping) -> Iterator[Block]:
    # once the run is to stop, blocks in the making are kept, but not compressed any more
    for number, columns in computed:
        if columns is not None and not stopping():
            yield Block(book.spans[number], columns)
    if stopping():
        raise StoppedError(str(book.folder), len(book.spans), len(book.spans))


def _unless(stopping: Stopping, book: Journal) -> Generator[Block, None, None]:
    for block in book.blocks():
        if stopping():
            raise StoppedError(str(book.folder), len(book.spans), len(book.spans))
        yield block
