"""The folder of a run, beside the output: claimed by one process, begun or resumed, and removed at the end."""

import contextlib
import json
import os
from collections.abc import Iterator
from pathlib import Path

from sweep.atlas.cf_metadata import created
from sweep.engine import estimate
from sweep.errors import RequestError
from sweep.files.paths import check_target
from sweep.files.publish import publish, publish_bytes, refusals, sync_folder
from sweep.request.regular_files import read_regular
from sweep.request.spec import SweepSpec
from sweep.runs.journal import BLOCK, BLOCKS, DAMAGED, Journal
from sweep.runs.locks import LOCK, OWNER, locked
from sweep.runs.manifest import MANIFEST, Manifest, discard

#: Suffix of the name of the folder, after the name of the output.
SUFFIX = ".run"

#: The file while it is written, and the record of the file that was published.
UNFINISHED, PUBLISHED = "assembled.nc", "published.json"

#: All files that a run makes in its folder, and in that of its blocks.
_NAMES = (MANIFEST, UNFINISHED, PUBLISHED, LOCK, OWNER)
_KINDS = (f"*{BLOCK}", f"*{BLOCK}{DAMAGED}", "*.tmp")


def resolved(path: str | Path) -> Path:
    """Return where a file will be: a symbolic link is followed, so that two names of one output share one lock."""
    return Path(os.path.realpath(path)) if os.path.islink(path) else Path(path)


def directory_of(path: Path) -> Path:
    """Return the folder of the run that makes a file."""
    return path.parent / (path.name + SUFFIX)


@contextlib.contextmanager
def claimed(path: Path, overwrite: bool) -> Iterator[Path]:
    """Make and lock the folder of the run that makes a file.

    A RequestError says that the folder cannot be made or holds other things, or that another process has locked it. A
    folder that is new is removed again when the ``with`` block fails before a block was kept.
    """
    folder = directory_of(path)
    found = unrecognised(folder)
    if found and not (folder / MANIFEST).exists():
        raise RequestError(
            f"A run keeps its blocks in a folder named like the file with {SUFFIX} at its end, and that name is taken: "
            f"{folder.name} holds {', '.join(found[:5])}, which no run has made.",
            hint="Give another name, or move that folder.",
            where=str(path),
        )
    try:
        folder.mkdir(exist_ok=True)
    except OSError as problem:
        # a cause that prevents the folder prevents the file too, and check_target gives the clearer message for it
        check_target(path, overwrite)
        raise RequestError(
            f"A run keeps its blocks in a folder beside the file, and {folder.name} could not be made: "
            f"{problem.strerror}.",
            hint="Give another name or folder.",
            where=str(path),
        ) from problem
    with locked(folder):
        is_new = not (folder / MANIFEST).exists()
        try:
            yield folder
        except BaseException:
            if is_new and not any((folder / BLOCKS).glob(f"*{BLOCK}*")):
                remove(folder)
            raise


def begin_or_resume(
    spec: SweepSpec, path: Path, folder: Path, block_cells: int | None, threads: int | None, command: str
) -> Journal:
    """Return the journal of the run in a claimed folder, which must be a run of `spec`, or that of a new run."""
    if block_cells is not None and block_cells < 1:
        raise RequestError(
            f"A block has at least one cell; got {block_cells}.", hint="Leave it out.", where="block_cells"
        )
    if (folder / MANIFEST).exists():
        journal = Journal.at(folder)
        check_same_run(journal, spec)
        return journal
    made = created()
    estimate.check_room(path, estimate.run_bytes(spec))
    cells = block_cells or estimate.block_cells(spec, threads)
    with refusals(path):
        journal = Journal.create(folder, Manifest.new(spec, cells, made, command))
        sync_folder(folder.parent)
    return journal


def check_same_run(journal: Journal, spec: SweepSpec) -> None:
    """Refuse to go on with a journal of another spec, or begun by a program that computes other bits."""
    differences = journal.manifest.differences(spec)
    if differences:
        raise RequestError(
            "The folder holds blocks of another run. A run goes on with the spec and the program that it was begun "
            f"with; these differ: {'; '.join(differences)}.",
            hint=f"Give the same spec or another output, or discard the blocks with {discard(journal.folder)}.",
            where=str(journal.folder),
        )


def remove_unfinished(folder: Path) -> None:
    """Remove what a killed process left half written. Only for the process that holds the exclusive lock."""
    for path in [*(folder / BLOCKS).glob("*.tmp"), *folder.glob("*.tmp"), folder / UNFINISHED]:
        path.unlink(missing_ok=True)


def publish_file(folder: Path, path: Path, spec: SweepSpec) -> None:
    """Give the finished file of a run its final name.

    Write the record first, because after a crash the folder may remain.
    """
    publish_bytes(folder / PUBLISHED, _record(folder / UNFINISHED, spec))
    publish(folder / UNFINISHED, path)


def has_published(folder: Path, path: Path, spec: SweepSpec) -> bool:
    """Return whether a run of `spec` has published its file, and was killed before it removed its folder."""
    try:
        record = _record(path, spec)
        return read_regular(folder / PUBLISHED, len(record)) == record
    except OSError:
        return False


def _record(path: Path, spec: SweepSpec) -> bytes:
    # a rename changes none of these
    status = os.stat(path)
    identity = [status.st_ino, status.st_size, status.st_mtime_ns]
    return json.dumps({"file": identity, "spec": spec.canonical()}).encode("ascii")


def remove(folder: Path) -> None:
    """Remove the folder of a run; unrecognised files stay, and then the folder too.

    The record of what was published is removed last: until then, the next process after a crash sees that the file is
    there.
    """
    blocks = folder / BLOCKS
    names = [folder / name for name in _NAMES if name != PUBLISHED]
    for path in (*(path for kind in _KINDS for path in blocks.glob(kind)), *names, *folder.glob("*.tmp")):
        with contextlib.suppress(OSError):
            path.unlink()
    with contextlib.suppress(OSError):
        blocks.rmdir()
    (folder / PUBLISHED).unlink(missing_ok=True)
    with contextlib.suppress(OSError):
        folder.rmdir()


def unrecognised(folder: Path) -> list[str]:
    """Return the names of the files in a folder that no run makes."""
    # os.path, because a pathlib.Path raises where the name is too long
    if not os.path.isdir(folder):
        return []
    return sorted(
        name
        for name in os.listdir(folder)
        if name not in (*_NAMES, BLOCKS) and not name.endswith(".tmp") and not name.startswith(".")
    )
