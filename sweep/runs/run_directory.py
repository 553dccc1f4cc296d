"""The folder of a run, beside the output: claimed by one process, begun or resumed, and removed at the end."""

import contextlib
import json
import os
import re
from collections.abc import Iterator
from pathlib import Path

from sweep.atlas.cf_metadata import created
from sweep.atlas.report_units import with_substitutes
from sweep.atomic import TEMPORARY, create, publish, publish_bytes, sync_folder
from sweep.engine.compute import check_block_cells
from sweep.errors import RequestError
from sweep.files.paths import check_name, check_target
from sweep.files.publish import refusals
from sweep.request.spec import SweepSpec
from sweep.runs.folder import LOCK, MANIFEST, STARTS, SUFFIX, directory_of, locked
from sweep.runs.forecast import block_cells as suitable_block_cells
from sweep.runs.forecast import check_run_fits
from sweep.runs.journal import BLOCK, BLOCK_NAME, BLOCKS, Journal
from sweep.runs.manifest import SAME_BITS, Manifest, discard

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
    if found := _foreign(folder):
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
        check_run_fits(path, spec, spec.size - journal.cells(journal.held()))
        return journal
    made = created()
    check_run_fits(path, spec, spec.size)
    cells = block_cells or suitable_block_cells(spec, threads)
    with refusals(path):
        journal = Journal.create(folder, Manifest.new(spec, cells, made, with_substitutes(command, spec)))
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
            f"{SAME_BITS}.",
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
        return (folder / PUBLISHED).read_bytes() == record
    except OSError:
        return False


def _record(path: Path, spec: SweepSpec) -> bytes:
    # a rename changes none of these
    status = os.stat(path)
    identity = [status.st_ino, status.st_size, status.st_mtime_ns]
    return json.dumps({"file": identity, "spec": spec.canonical()}).encode("ascii")


def remove(folder: Path) -> None:
    """Remove the folder of a run; files of others stay, and then the folder too.

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


def _foreign(folder: Path) -> list[str]:
    """Return the names in a folder without a manifest that no run gives."""
    # os.path, because a pathlib.Path raises where the name is too long
    if not os.path.isdir(folder) or (folder / MANIFEST).exists():
        return []
    return sorted(
        name for name in os.listdir(folder) if name not in (*_NAMES, BLOCKS) and not TEMPORARY.fullmatch(name)
    )
