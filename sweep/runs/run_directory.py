"""The folder of a run, beside the output: claimed by one process, begun or resumed, and removed at the end."""

import contextlib
import errno
import json
import os
import re
import shlex
import stat
from collections.abc import Iterator
from pathlib import Path

from sweep.atlas.cf_metadata import created
from sweep.atomic import TEMPORARY, create, publish, publish_bytes, sync_folder, try_publishing
from sweep.engine import estimate, machine
from sweep.engine.compute import check_block_cells
from sweep.errors import RequestError
from sweep.files.paths import check_name, check_target
from sweep.files.publish import refusals
from sweep.request.regular_files import read_regular
from sweep.request.spec import SweepSpec
from sweep.runs.forecast import check_room
from sweep.runs.journal import BLOCK, BLOCK_NAME, BLOCKS, Journal
from sweep.runs.locks import LOCK, SIGNATURE, locked
from sweep.runs.manifest import Manifest, discard
from sweep.runs.names import MANIFEST, STARTS, STARTS_HEAD, SUFFIX, directory_of

#: The file while it is written, and the record of the file that was published.
UNFINISHED, PUBLISHED = "assembled.nc", "published.json"

#: All files that a run makes in its folder; in that of its blocks it makes blocks. In both it makes temporary files.
_NAMES = (MANIFEST, STARTS, UNFINISHED, PUBLISHED, LOCK)


@contextlib.contextmanager
def claimed(path: Path, overwrite: bool) -> Iterator[Path]:
    """Make and lock the folder of the run that makes a file.

    A RequestError says that the folder cannot be made or holds other things, or that another process has locked it. A
    folder that is new is removed again when the ``with`` block fails before a block was kept.
    """
    check_name(path)
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
    check_kinds(folder)
    with locked(folder):
        is_new = not (folder / MANIFEST).exists()
        try:
            _check_rename(folder, path)
            yield folder
        except BaseException:
            if is_new and not any((folder / BLOCKS).glob(f"*{BLOCK}*")):
                remove(folder)
            raise


def check_kinds(folder: Path) -> None:
    """Refuse a folder in which a name that a run gives to a file is that of another thing.

    Raises
    ------
    RequestError
    """
    for name in (*_NAMES, BLOCKS):
        path = folder / name
        if not os.path.lexists(path) or (path.is_dir() if name == BLOCKS else _is_regular(path)):
            continue
        kind = (
            "a symbolic link" if path.is_symlink() else "a folder" if path.is_dir() else "not a regular file"
        )
        if name == BLOCKS:
            kind = "not a folder"
        raise RequestError(
            f"In the folder of the run {name} is {kind}, and no run has made that.",
            hint=f"Move it away (`mv {shlex.quote(str(path))} ELSEWHERE`), or give another output.",
            where=str(folder),
        )


def _is_regular(path: Path) -> bool:
    return stat.S_ISREG(os.lstat(path).st_mode)


def _check_rename(folder: Path, path: Path) -> None:
    """Refuse a folder from which the finished file cannot be renamed to its final name."""
    try:
        try_publishing(path, source=folder)
    except OSError as problem:
        if problem.errno in (errno.ENOSPC, errno.EDQUOT):
            # no room is told later, with the bytes that are needed
            return
        if problem.errno != errno.EXDEV:
            check_target(path, True)
        raise RequestError(
            f"The finished file is renamed from the folder of the run, {folder.name}, to its final name, and that "
            f"cannot be done here: {problem.strerror}. Both must be on one file system, and writable.",
            hint="Give an output on the file system of that folder, or remove the link to it.",
            where=str(path),
        ) from problem


def create_unfinished(folder: Path) -> Path:
    """Create the file of a run under its temporary name, in place of one that a killed process left."""
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
    """Return the journal of the run in a claimed folder, which must be a run of `spec`, or that of a new run."""
    check_block_cells(block_cells)
    if os.path.lexists(folder / MANIFEST):
        journal = Journal.at(folder)
        check_same_run(journal, spec)
        return journal
    made = created()
    check_room(path, spec, spec.size)
    cells = block_cells or estimate.block_cells(spec, threads)
    with refusals(path):
        journal = Journal.create(folder, Manifest.new(spec, cells, made, command))
        sync_folder(folder.parent)
    return journal


def check_same_run(journal: Journal, spec: SweepSpec) -> None:
    """Refuse to go on with a journal of another spec, or of a program or machine that computes other bits."""
    manifest = journal.manifest
    differences = manifest.differences(spec)
    if differences:
        raise RequestError(
            "The folder holds blocks of another run. A run goes on with the spec and the program that it was begun "
            f"with; these differ: {'; '.join(differences)}.",
            hint=f"Give the same spec or another output, or discard the blocks with {discard(journal.folder)}.",
            where=str(journal.folder),
        )
    differences = manifest.machine_differences()
    if differences:
        raise RequestError(
            "This machine may compute other bits than the one that began the run; these differ: "
            f"{'; '.join(differences)}.",
            hint="Go on with it on machines of that kind, or begin it anew with the same environment on all of them: "
            f"{machine.SAME_BITS}.",
            where=str(journal.folder),
        )


def remove_unfinished(folder: Path) -> None:
    """Remove what a killed process left half written. Only for the process that holds the exclusive lock."""
    for path in [*_matching(folder / BLOCKS, TEMPORARY), *_matching(folder, TEMPORARY), folder / UNFINISHED]:
        path.unlink(missing_ok=True)


def _matching(folder: Path, *names: re.Pattern[str]) -> list[Path]:
    """Return the files of a folder whose whole names match a pattern."""
    try:
        found = os.listdir(folder)
    except OSError:
        return []
    return [folder / each for each in found if any(name.fullmatch(each) for name in names)]


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
    for path in (*_matching(blocks, BLOCK_NAME, TEMPORARY), *names, *_matching(folder, TEMPORARY)):
        with contextlib.suppress(OSError):
            path.unlink()
    with contextlib.suppress(OSError):
        blocks.rmdir()
    (folder / PUBLISHED).unlink(missing_ok=True)
    with contextlib.suppress(OSError):
        folder.rmdir()


def unrecognised(folder: Path) -> list[str]:
    """Return the names in a folder without a manifest that no run makes, or that hold what no run has written."""
    # os.path, because a pathlib.Path raises where the name is too long
    if not os.path.isdir(folder):
        return []
    found = [name for name in os.listdir(folder) if name != BLOCKS and not _left_by_run(folder / name)]
    if os.path.isdir(folder / BLOCKS):
        found += [
            f"{BLOCKS}/{name}"
            for name in os.listdir(folder / BLOCKS)
            if not (BLOCK_NAME.fullmatch(name) or name.startswith("."))
        ]
    return sorted(found)


def _left_by_run(path: Path) -> bool:
    """Return whether a file is hidden, or one that a run leaves if it is killed before or after it has a manifest."""
    if path.name.startswith("."):
        return True
    begins = {
        LOCK: SIGNATURE.encode(),
        PUBLISHED: b'{"file": ',
        STARTS: STARTS_HEAD,
    }
    if path.name not in begins or not _is_regular(path):
        return False
    with open(path, "rb") as file:
        content = file.read(100)
    return not content or content.startswith(begins[path.name])
