"""The folder of a run, next to the output: claimed by one process, begun or resumed, and removed at the end."""

import contextlib
import json
import os
import re
from collections.abc import Iterator
from pathlib import Path

from sweep.atlas.cf_metadata import created
from sweep.atomic import TEMPORARY, create, publish, publish_bytes, sync_folder
from sweep.engine.compute import check_block_cells
from sweep.errors import RequestError
from sweep.files.paths import check_name, check_target
from sweep.files.publish import refusals
from sweep.request.spec import SweepSpec
from sweep.runs.folder import LOCK, MANIFEST, STARTS, directory_of, locked
from sweep.runs.forecast import block_cells as suitable_block_cells
from sweep.runs.forecast import check_run_fits
from sweep.runs.journal import BLOCK, BLOCK_NAME, BLOCKS, Journal
from sweep.runs.manifest import SAME_BITS, Manifest, discard

#: Names of the unfinished file, and of the record of the published file.
UNFINISHED, PUBLISHED = "assembled.nc", "published.json"

#: Names of the files in the folder of a run, except the blocks in their own folder, and temporary files in both.
_NAMES = (MANIFEST, STARTS, UNFINISHED, PUBLISHED, LOCK)


@contextlib.contextmanager
def claimed(path: Path, overwrite: bool) -> Iterator[Path]:
    """Make and lock the folder of the run that writes a file.

    Raises a RequestError if the folder cannot be made, contains foreign files, or is locked by another process. A new
    folder is removed again if the ``with`` block fails before a block was kept.
    """
    check_name(path)
    folder = directory_of(path)
    if foreign := _foreign_names(folder):
        raise RequestError(
            f"The folder {folder.name}, in which this run would keep its blocks, contains other files: "
            f"{', '.join(foreign[:5])}.",
            hint="Give another name, or move that folder.",
            where=str(path),
        )
    try:
        folder.mkdir(exist_ok=True)
    except OSError as problem:
        # what prevents the folder usually prevents the file too, and check_target gives a clearer message
        check_target(path, overwrite)
        raise RequestError(
            f"The folder {folder.name}, in which this run would keep its blocks, could not be made: "
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


def create_unfinished(folder: Path) -> Path:
    """Create the file of a run under its temporary name; replace one that a killed process left."""
    path = folder / UNFINISHED
    path.unlink(missing_ok=True)
    os.close(create(path))
    return path


def begin_or_resume(
    spec: SweepSpec,
    path: Path,
    folder: Path,
    block_cells: int | None,
    threads: int | None,
    command: str,
) -> Journal:
    """Return the journal of the run in a claimed folder, which must have the same `spec`, or of a new run."""
    check_block_cells(block_cells)
    if os.path.lexists(folder / MANIFEST):
        journal = Journal.at(folder)
        check_same_run(journal, spec)
        check_run_fits(path, spec, spec.size - journal.cells(journal.held()))
        return journal
    made = created()
    check_run_fits(path, spec, spec.size)
    cells = block_cells or suitable_block_cells(spec, threads)
    with refusals(path):
        journal = Journal.create(folder, Manifest.new(spec, cells, made, command))
        sync_folder(folder.parent)
    return journal


def check_same_run(journal: Journal, spec: SweepSpec) -> None:
    """Refuse to resume the journal of another spec, or of a program or machine that computes other bits."""
    manifest = journal.manifest
    differences = manifest.differences(spec)
    if differences:
        raise RequestError(
            "The folder has blocks of another run. A run can only be resumed with the same spec and program; these "
            f"differ: {'; '.join(differences)}.",
            hint=f"Give the same spec or another output, or remove the blocks with {discard(journal.folder)}.",
            where=str(journal.folder),
        )
    differences = manifest.machine_differences()
    if differences:
        raise RequestError(
            "This machine may compute other bits than the one that began the run; these differ: "
            f"{'; '.join(differences)}.",
            hint="Resume it on the same kind of machine, or start it again with this environment on all machines: "
            f"{SAME_BITS}.",
            where=str(journal.folder),
        )


def remove_unfinished(folder: Path) -> None:
    """Remove files that a killed process left half written. Only for the process with the exclusive lock."""
    for path in [*_matching(folder / BLOCKS, TEMPORARY), *_matching(folder, TEMPORARY), folder / UNFINISHED]:
        path.unlink(missing_ok=True)


def _matching(folder: Path, *names: re.Pattern[str]) -> list[Path]:
    """Return the files of a folder whose whole names match a pattern."""
    try:
        files = os.listdir(folder)
    except OSError:
        return []
    return [folder / file for file in files if any(name.fullmatch(file) for name in names)]


def publish_file(folder: Path, path: Path, spec: SweepSpec) -> None:
    """Give the finished file of a run its final name.

    The record is written first, because the folder may remain after a crash.
    """
    publish_bytes(folder / PUBLISHED, _record(folder / UNFINISHED, spec))
    publish(folder / UNFINISHED, path)


def has_published(folder: Path, path: Path, spec: SweepSpec) -> bool:
    """Return whether a run of `spec` has published its file but was killed before it removed its folder."""
    try:
        record = _record(path, spec)
        return (folder / PUBLISHED).read_bytes() == record
    except OSError:
        return False


def _record(path: Path, spec: SweepSpec) -> bytes:
    # a rename does not change these
    status = os.stat(path)
    identity = [status.st_ino, status.st_size, status.st_mtime_ns]
    return json.dumps({"file": identity, "spec": spec.canonical()}).encode("ascii")


def remove(folder: Path) -> None:
    """Remove the folder of a run; if it contains foreign files, they and the folder remain.

    The record of the published file is removed last, so that after a crash the next process knows that it exists.
    """
    blocks = folder / BLOCKS
    names = [folder / name for name in _NAMES if name != PUBLISHED]
    for path in (*_matching(blocks, BLOCK_NAME, TEMPORARY), *names, *_matching(folder, TEMPORARY)):
        with contextlib.suppress(OSError):
            path.unlink()
    with contextlib.suppress(OSError):
        blocks.rmdir()
    (folder / PUBLISHED).unlink(missing_ok=True)
    with contextlib.suppress(OSError):
        folder.rmdir()


def _foreign_names(folder: Path) -> list[str]:
    """Return the names of files in a folder without a manifest that do not come from a run."""
    # os.path, because pathlib.Path raises an error if the name is too long
    if not os.path.isdir(folder) or (folder / MANIFEST).exists():
        return []
    return sorted(
        name for name in os.listdir(folder) if name not in (*_NAMES, BLOCKS) and not TEMPORARY.fullmatch(name)
    )
