"""From the blocks of a run to the file at its final name; the run's folder goes when the file is there."""

import json
import os
from collections.abc import Iterator
from pathlib import Path

from sweep.atlas import declarations
from sweep.engine.runner import Block
from sweep.errors import StorageError
from sweep.files import store
from sweep.files.publish import publish, publish_text
from sweep.runs import journal
from sweep.runs.failures import Failures
from sweep.runs.journal import DamagedBlockError, Journal


def publish_atlas(book: Journal, path: Path, blocks: Iterator[Block]) -> Failures:
    """Assemble, check and publish the atlas of a run, and remove the run's folder.

    Parameters
    ----------
    book : Journal
    path : Path
    blocks : iterator of Block
        All of them, in order.

    Returns
    -------
    Failures

    Raises
    ------
    StorageError
        If a block is damaged.
    OSError, RuntimeError
        If the file system or netCDF refuses.
    """
    failures = Failures()
    manifest, unfinished = book.manifest, book.folder / journal.ASSEMBLED
    attributes = declarations.global_attributes(manifest.spec, manifest.command, manifest.created)
    attributes["versions"] = json.dumps(manifest.versions, sort_keys=True)
    try:
        store.write(manifest.spec, unfinished, failures.counting(blocks), attributes)
        # whoever finds the folder after a crash must know whether the file at the final name came out of it
        record = {"file": _identity(unfinished), "failures": [list(failures.counts.items()), failures.first]}
        publish_text(book.folder / journal.PUBLISHED, json.dumps(record))
        publish(unfinished, path)
    except DamagedBlockError as problem:
        raise StorageError(
            "a block was damaged after it had been verified",
            "blocks stay as they were written",
            str(problem),
            "run the same command again; if it comes back, test the disk and the memory",
            str(book.folder),
        ) from problem
    finally:
        unfinished.unlink(missing_ok=True)
    journal.remove(book.folder)
    return failures


def published(folder: Path, path: Path) -> Failures | None:
    """Return what the run in a folder found if it has published its file and was killed before it could tidy up."""
    try:
        record = json.loads((folder / journal.PUBLISHED).read_text(encoding="ascii"))
        if record["file"] != _identity(path):
            return None
        counts, first = record["failures"]
        return Failures(dict(counts), [(cell, code) for cell, code in first])
    except (OSError, ValueError):
        return None


def _identity(path: Path) -> list[int]:
    # a rename changes none of these
    status = os.stat(path)
    return [status.st_ino, status.st_size, status.st_mtime_ns]
