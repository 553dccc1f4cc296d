"""The folder of a run belongs to one run, one spec and one program: taken, begun, or gone on with."""

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from sweep.atlas.clock import created
from sweep.engine import calibrate, estimate
from sweep.errors import RequestError
from sweep.files.publish import refusals, sync_folder
from sweep.files.store import check_target
from sweep.request.spec import SweepSpec
from sweep.runs import journal
from sweep.runs.journal import Journal
from sweep.runs.locks import locked
from sweep.runs.manifest import Manifest, discard


def final(path: str | Path) -> Path:
    """Return where a file will be: a symbolic link is followed, so that two names of one output meet at one lock."""
    return Path(os.path.realpath(path)) if os.path.islink(path) else Path(path)


def check_claimable(path: Path, overwrite: bool) -> None:
    """Refuse an output that could not be written in the end, or that exists and no run of it is unfinished.

    Raises
    ------
    RequestError
    """
    check_target(path, overwrite or os.path.isdir(_folder(path)))


def _folder(path: Path) -> Path:
    return path.parent / (path.name + journal.SUFFIX)


@contextlib.contextmanager
def claimed(path: Path, overwrite: bool) -> Iterator[Path]:
    """Hold the folder of a run alone; if no block was kept in a new one, nothing is left of it.

    Raises
    ------
    RequestError
        If the file could not be written in the end, or another run writes it.
    """
    folder = _folder(path)
    # inside the lock it is asked again: the run that held it may have made the file
    check_claimable(path, overwrite)
    found = journal.strange(folder)
    if found and not (folder / journal.MANIFEST).exists():
        raise RequestError(
            "the name of the run's folder is taken",
            f"blocks are kept in a folder named like the file with {journal.SUFFIX} at its end",
            f"{folder} holds {', '.join(found[:5])}, which no run has made",
            "give another name, or move that folder",
            str(path),
        )
    try:
        folder.mkdir(exist_ok=True)
    except OSError as problem:
        raise RequestError(
            "the file could not be written",
            "the folder takes a new folder beside the file",
            f"{folder}: {problem.strerror}",
            "give another name or folder",
            str(path),
        ) from problem
    with locked(folder):
        fresh = not (folder / journal.MANIFEST).exists()
        try:
            yield folder
        except BaseException:
            if fresh and not any((folder / "blocks").glob("*.npz*")):
                journal.remove(folder)
            raise


def begun(
    spec: SweepSpec, path: Path, folder: Path, block_cells: int | None, threads: int | None, command: str
) -> Journal:
    """Return the journal of the run in a folder, or of a new one.

    Raises
    ------
    RequestError
        If the folder holds another run, or the disk has not enough room.
    """
    if block_cells is not None and block_cells < 1:
        raise RequestError("no block", "block_cells >= 1", str(block_cells), "leave it out", "block_cells")
    if (folder / journal.MANIFEST).exists():
        book = Journal(folder, Manifest.read(folder / journal.MANIFEST))
        check_same(book, spec)
        return book
    made = created()
    estimate.check_room(path, estimate.run_bytes(spec))
    cells = block_cells or calibrate.block_cells(spec, threads)
    manifest = Manifest.new(spec, cells, made, command)
    with refusals(path):
        manifest.write(folder / journal.MANIFEST)
        sync_folder(folder.parent)
    return Journal(folder, manifest)


def check_same(book: Journal, spec: SweepSpec) -> None:
    """Refuse to go on with a journal of another spec, or begun by a program that computes other bits.

    Raises
    ------
    RequestError
        It names the fields that differ.
    """
    differences = book.manifest.differences(spec)
    if differences:
        raise RequestError(
            "blocks of another run are there",
            "a run goes on with the spec and the program that it was begun with",
            "; ".join(differences),
            f"give the same spec, another output, or discard the blocks: {discard(book.folder)}",
            str(book.folder),
        )
