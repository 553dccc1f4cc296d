"""Runs to a file: claim the folder, compute missing blocks, derive, write cells, find the boundary, publish."""

import contextlib
import itertools
import json
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.atlas.cf_metadata import global_attributes
from sweep.engine.compute import Block, check_device, derive_block, usable_threads, use_threads
from sweep.engine.grid import chunks
from sweep.errors import StoppedError, StorageError, are, counted
from sweep.files.atlas_writer import AtlasWriter
from sweep.files.one_thread import netcdf_to_itself
from sweep.files.paths import check_target
from sweep.files.publish import refusals
from sweep.model.quantity import FAILED, UNDECIDED
from sweep.progress.display import following
from sweep.progress.timetable import COMPUTING, SEARCHING, Progress, Show, Timetable
from sweep.request.spec import SweepSpec
from sweep.runs import run_directory
from sweep.runs.executor import Executor, FinishedBlock, Say, Stopping, interruptible, local, no_op, prefetch
from sweep.runs.folder import resolved
from sweep.runs.forecast import (
    READING,
    WRITING,
    bisected_cells,
    file_bytes,
    journal_bytes,
    of_part,
    of_run,
)
from sweep.runs.journal import Columns, DamagedBlockError, Journal
from sweep.runs.manifest import Manifest

#: Most failed cells that are listed.
_LISTED = 10

#: The variable of a system with the change of its conserved quantities. A larger change than the first number, and than
#: the second number times the tolerance, causes a warning.
_CONSERVED_CHANGE, _CHANGE, _CHANGE_OF_TOLERANCE = "conserved_change", 1e-6, 1e4

#: Share of undecided cells above which there is a warning.
_MUCH = 0.5


class Failures:
    """The cells of an atlas that could not be computed, their number and the first ones, and the warnings about others.

    Parameters
    ----------
    spec : SweepSpec
    """

    def __init__(self, spec: SweepSpec) -> None:
        self.spec = spec
        # code of an ending -> number of cells; flat index and code of the listed cells
        self._counts = dict.fromkeys(spec.model.endings.codes(FAILED), 0)
        self._first: list[tuple[int, int]] = []
        # the largest change of a conserved quantity, and the flat index of its cell
        self._change, self._changed, self._undecided = 0.0, 0, 0

    @classmethod
    def in_file(cls, path: Path, spec: SweepSpec) -> "Failures":
        """Return the failures of an atlas in a file."""
        # imported here, so that refusing a request does not take this time
        import netCDF4

        failures = cls(spec)
        with netcdf_to_itself(), netCDF4.Dataset(path.absolute()) as file:
            file.set_auto_mask(False)
            names = [name for name in ("ending", "stability", _CONSERVED_CHANGE) if name in file.variables]
            for span, slices in chunks(spec.shape):
                failures.count(
                    span.start, {name: np.asarray(file[name][slices]).reshape(-1) for name in names}
                )
        return failures

    def count(self, start: int, columns: Mapping[str, npt.NDArray[Any]]) -> None:
        """Add some cells; cells are added in C order.

        Parameters
        ----------
        start : int
            Flat index of the first cell.
        columns : mapping of str to array, shape (n,)
            The codes of the endings and the verdicts, and the change of conserved quantities if the system has any.
        """
        endings = columns["ending"]
        self._undecided += int(np.count_nonzero(columns["stability"] == UNDECIDED))
        if _CONSERVED_CHANGE in columns:
            changes = np.nan_to_num(np.asarray(columns[_CONSERVED_CHANGE], np.float64), posinf=np.inf)
            place = int(np.argmax(changes))
            if changes[place] > self._change:
                self._change, self._changed = float(changes[place]), start + place
        for code in self._counts:
            self._counts[code] += int(np.count_nonzero(endings == code))
        failed = np.flatnonzero(self.spec.model.endings.have(FAILED, endings))
        self._first += [(start + int(i), int(endings[i])) for i in failed[: _LISTED - len(self._first)]]

    @property
    def total(self) -> int:
        """The number of failed cells."""
        return sum(self._counts.values())

    def describe(self) -> list[str]:
        """Return a line with the number of failed cells, and lines with coordinates and endings of the first ones."""
        names = self.spec.model.endings.flags
        kinds = " and ".join(f"{count} {names[code]}" for code, count in self._counts.items() if count)
        return [
            f"{counted(self.total, 'cell', self.spec.size)} could not be computed "
            f"({100.0 * self.total / self.spec.size:.3g} %): {kinds}",
            *(f"    {self._coordinates(cell)}: {names[code]}" for cell, code in self._first),
            *(["    ..."] if self.total > _LISTED else []),
            *(
                f"    {ending.name}: {ending.reason}. {ending.help}."
                for ending in self.spec.model.endings
                if self._counts.get(ending.code) and ending.help
            ),
        ]

    def warnings(self) -> list[str]:
        """Return lines of warning if most cells are undecided, or if a conserved quantity changes."""
        lines, undecided = [], self._undecided - self.total
        if undecided > _MUCH * self.spec.size:
            lines.append(
                f"{counted(undecided, 'cell', self.spec.size)} {are(undecided)} undecided; eulerdisk explain shows why "
                "for each cell"
            )
            if reason := self.spec.model.reason_without_verdicts(self.spec):
                lines.append(reason)
        if self._change > max(_CHANGE, _CHANGE_OF_TOLERANCE * self.spec.tolerance):
            lines.append(
                f"a conserved quantity changes by {self._change:.2g} of its terms at "
                f"{self._coordinates(self._changed)}: the right-hand side does not conserve it"
            )
        return lines

    def __repr__(self) -> str:
        """Return the lines of `describe`, for an interpreter that shows the result of a call."""
        return "\n".join(self.describe()) if self.total else _all_computed(self.spec.size)

    def _coordinates(self, cell: int) -> str:
        words = []
        for name, place in zip(self.spec.axes, np.unravel_index(cell, self.spec.shape), strict=True):
            quantity = self.spec.quantities[name]
            units = "deg" if quantity.units == "rad" else ""
            words.append(f"{name}={getattr(self.spec, name).at(place) * quantity.plot_scale:.9g}{units}")
        return " ".join(words) or "the only cell"


def _all_computed(cells: int) -> str:
    return "the one cell was computed" if cells == 1 else f"all {cells} cells were computed"


def run_to_file(
    spec: SweepSpec | str | Path,
    path: str | Path,
    *,
    overwrite: bool = False,
    threads: int | None = None,
    block_cells: int | None = None,
    command: str = "sweep.run_to_file",
    progress: Progress = None,
    say: Say = no_op,
    stopping: Stopping | None = None,
    executor: Executor | None = None,
    **changes: Any,
) -> Failures:
    """Compute the atlas of a spec and write it to one netCDF file; resume an earlier run if there is one.

    Parameters
    ----------
    spec : SweepSpec, str or Path
        A spec, the name of a preset, or the path of a TOML file.
    path : str or Path
        The file; it appears only when it is complete. Until then finished blocks are kept in a folder next to it, named
        like the file with the suffix ``.run``.
    overwrite : bool
        Replace an existing file, at the very end.
    threads : int, optional
        Number of threads; by default all that this process may use.
    block_cells : int, optional
        Cells of a block; by default about a second of work. A resumed run keeps the size of its blocks.
    command : str
        The user's command, for the history.
    progress : bool or callable, optional
        As in `sweep.run`.
    say : callable, optional
        Called with a sentence when blocks of an earlier run are kept or set aside.
    stopping : callable, optional
        Called before every block; the run ends when it returns true. By default Ctrl-C, or the interrupt of a notebook,
        ends the run after its current block.
    executor : callable, optional
        Computes the blocks; by default in this process.
    **changes
        Words of the spec with other values, as on the command line; see `SweepSpec.read`.

    Returns
    -------
    Failures
        The cells that could not be computed.

    Raises
    ------
    RequestError
        If the spec or a change is not possible, the file exists, its folder is missing or not writable, another run
        writes it or has left blocks of another spec, or the disk has not enough space; nothing was changed.
    StorageError
        If the file system fails during the run; finished blocks are kept.
    StoppedError
        If `stopping` returned true; finished blocks are kept.
    KeyboardInterrupt
        If it was interrupted; finished blocks are kept, and the message says where.
    """
    spec, path = SweepSpec.read(spec, **changes), resolved(path)
    with (
        following(progress) as show,
        interruptible(stopping) as stopping,
        run_directory.claimed(path, overwrite) as folder,
    ):
        if run_directory.has_published(folder, path, spec):
            # an earlier run was killed between publishing its file and removing its folder
            run_directory.remove(folder)
            return Failures.in_file(path, spec)
        check_target(path, overwrite)
        used = usable_threads(threads)
        check_device(spec)
        journal = run_directory.begin_or_resume(spec, path, folder, block_cells, threads, command)
        missing = _missing_blocks(journal, say, show)

        def bytes_to_write() -> float:
            left = spec.size - journal.cells(journal.held())
            return journal_bytes(spec, left) + file_bytes(spec)

        # a new run in this process gets its blocks in order: it writes them while it computes the next ones
        at_once = executor is None and len(missing) == len(journal.spans)
        timetable = of_run(spec, journal.cells(missing), None if at_once else used, show)
        computed = (executor or local(threads))(journal, missing, stopping)
        finished = reported(journal, computed, missing, timetable, spec.size)
        with refusals(path, bytes_to_write, journal.kept), contextlib.closing(finished):
            if at_once:
                measured = ((number, columns) for number, columns in finished if columns is not None)
                return _write_and_publish(journal, path, measured, timetable, threads, stopping)
            # other runs compute all blocks before they write the file, so that a run that is killed repeatedly still
            # makes progress
            for _ in finished:
                pass
            return publish_from_journal(journal, path, timetable, threads, stopping)


def _missing_blocks(journal: Journal, say: Say, show: Show) -> list[int]:
    """Return the numbers of the blocks to compute, and report the blocks that an earlier run has left."""
    run_directory.remove_unfinished(journal.folder)
    blocks = range(len(journal.spans))
    if not journal.held():
        return list(blocks)
    missing = verified(journal, blocks, of_part(journal.spec.size, show), say)
    finished = len(blocks) - len(missing)
    say(
        f"resuming: {counted(finished, 'block', len(blocks))} {are(finished)} finished, {len(missing)} to compute"
    )
    return missing


def verified(journal: Journal, numbers: Sequence[int], timetable: Timetable, say: Say) -> list[int]:
    """Return the numbers of the blocks that must be computed, missing or damaged ones, and report the damaged ones."""
    timetable.begin(READING)
    missing, damaged = journal.verify(numbers, timetable.report)
    for problem in damaged:
        say(f"damaged, set aside and computed again: {problem}")
    return missing


def reported(
    journal: Journal,
    computed: Iterator[FinishedBlock],
    missing: Sequence[int],
    timetable: Timetable,
    cells: int,
) -> Generator[FinishedBlock]:
    """Yield the computed blocks and report progress; raise StoppedError if they end before all missing ones are done.

    `cells` is the number of cells in the missing and the finished blocks together.
    """
    left, done = set(missing), cells - journal.cells(missing)
    if left:
        timetable.begin(COMPUTING, done)
    for number, measured in computed:
        left.discard(number)
        done += len(journal.spans[number])
        timetable.report(done)
        yield number, measured
    if left:
        raise StoppedError(journal.kept())


def publish_from_journal(
    journal: Journal,
    path: Path,
    timetable: Timetable,
    threads: int | None = None,
    stopping: Stopping = lambda: False,
) -> Failures:
    """Write the file of a run whose blocks are all in the journal, publish it, and remove the folder of the run."""

    def report_blocks(blocks: Iterator[tuple[int, Columns]]) -> Iterator[tuple[int, Columns]]:
        timetable.begin(WRITING)
        for number, columns in itertools.takewhile(lambda _: not stopping(), blocks):
            timetable.report(journal.spans[number].stop)
            yield number, columns

    with prefetch(journal.blocks()) as blocks:
        return _write_and_publish(journal, path, report_blocks(blocks), timetable, threads, stopping)


def _write_and_publish(
    journal: Journal,
    path: Path,
    measured: Iterable[tuple[int, Columns]],
    timetable: Timetable,
    threads: int | None,
    stopping: Stopping,
) -> Failures:
    """Write the file of a run from its measured blocks in C order, publish it, and remove the folder of the run."""
    unfinished, spec = run_directory.create_unfinished(journal.folder), journal.spec
    # the bisection of the boundary computes cells in this thread
    use_threads(threads)
    try:
        blocks = _spanned_or_raise_stopped(journal, measured, stopping)
        writer = AtlasWriter(unfinished, spec, attributes_of(journal.manifest), usable_threads(threads))
        cells = writer.write_cells(blocks, partial(derive_block, spec))
        failures = write_atlas(writer, cells, timetable, lambda: _raise_if_stopped(journal, stopping))
        run_directory.publish_file(journal.folder, path, spec)
    except DamagedBlockError as problem:
        raise StorageError(
            f"A block was damaged after it had been verified: {problem}.",
            hint="Run the same command again. If this happens again, test the disk and the memory.",
            where=str(journal.folder),
        ) from problem
    finally:
        unfinished.unlink(missing_ok=True)
    run_directory.remove(journal.folder)
    return failures


def _spanned_or_raise_stopped(
    journal: Journal, measured: Iterable[tuple[int, Columns]], stopping: Stopping
) -> Generator[Block]:
    """Yield measured blocks with their cells, and raise StoppedError at their end if the run must stop."""
    for number, columns in measured:
        # if the run must stop, blocks in progress are still consumed, so that the journal keeps them, but not written
        if not stopping():
            yield Block(journal.spans[number], columns)
    _raise_if_stopped(journal, stopping)


def _raise_if_stopped(journal: Journal, stopping: Stopping) -> None:
    if stopping():
        raise StoppedError(journal.kept())


def write_atlas(
    writer: AtlasWriter,
    cells: Iterable[Block],
    timetable: Timetable,
    go_on: Callable[[], None] = lambda: None,
) -> Failures:
    """Consume the cells of an atlas from `AtlasWriter.write_cells`, then find and write its boundary.

    Returns the cells that could not be computed. `go_on` is called repeatedly after the last cell; it may raise an
    error to end the work. Other errors come from `AtlasWriter`.
    """

    def seen(done: float) -> None:
        go_on()
        timetable.report(int(done))

    spec = writer.spec
    failures = Failures(spec)
    for block in cells:
        failures.count(block.span.start, block.columns)
    timetable.begin(SEARCHING)
    bisected = bisected_cells(spec)
    writer.write_boundary(lambda share: seen(share * bisected))
    seen(bisected)
    return failures


def attributes_of(manifest: Manifest) -> dict[str, Any]:
    """Return the global attributes of the file of a run, with the time and the command of its start."""
    attributes = global_attributes(manifest.spec, manifest.command, manifest.created)
    return attributes | {"versions": json.dumps(manifest.versions, sort_keys=True)}
