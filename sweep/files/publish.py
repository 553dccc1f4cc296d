"""Atomic publishing: a file is written under a temporary name in the same folder, synchronised, and then renamed."""

import contextlib
import errno
import os
import secrets
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

from sweep.errors import StorageError

#: Errors of the system that mean "no room": the disk is full, or a quota or a limit on file sizes is reached.
_NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


def publish(unfinished: Path, path: Path) -> None:
    """Rename a finished temporary file to its final name, such that a power cut leaves the old state or the new one."""
    with open(unfinished, "rb+") as file:
        os.fsync(file.fileno())
    os.replace(unfinished, path)
    sync_folder(path.parent)


def publish_bytes(path: Path, content: bytes) -> None:
    """Write a file that is either absent or complete, also after a power cut; if that fails no temporary file stays."""
    # not the tempfile module: only the owner can read its files, and another account of the same group may have to go
    # on with a run
    unfinished = path.with_name(f"{path.name}.{secrets.token_hex(8)}.tmp")
    try:
        with open(unfinished, "xb") as file:
            file.write(content)
        publish(unfinished, path)
    finally:
        unfinished.unlink(missing_ok=True)


@contextlib.contextmanager
def published(path: Path) -> Iterator[Path]:
    """Yield a temporary name beside `path`; the file written there is published when the block ends without an error.

    If the file system refuses, the error is a StorageError.
    """
    unfinished = path.with_name(f".{path.name}.unfinished-{os.getpid()}")
    try:
        with refusals(path):
            yield unfinished
            publish(unfinished, path)
    finally:
        # os.path, because unlink raises where the name is too long
        if os.path.exists(unfinished):
            unfinished.unlink()


def sync_folder(folder: Path) -> None:
    """Write the names in a folder to the disk, on file systems that can do so."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


@contextlib.contextmanager
def refusals(
    path: Path, needed: Callable[[], float] = lambda: 0.0, kept: Callable[[], str] = lambda: ""
) -> Iterator[None]:
    """Turn the errors of the file system and of netCDF into a StorageError that says what to do.

    Parameters
    ----------
    path : Path
        The file that was to be written in the end.
    needed : callable
        Returns how many bytes are still to be written.
    kept : callable
        Returns a clause that says which results are kept, and where; an empty text if the same command cannot go on.
    """
    try:
        yield
    except (OSError, RuntimeError) as problem:
        # netCDF raises RuntimeError("NetCDF: HDF error") for every error of the system; other RuntimeErrors are defects
        if isinstance(problem, RuntimeError) and "NetCDF" not in str(problem):
            raise
        raise _refusal(problem, path, needed(), kept()) from problem


def _refusal(problem: Exception, path: Path, needed: float, kept: str) -> StorageError:
    free = shutil.disk_usage(path.parent).free
    code = problem.errno if isinstance(problem, OSError) else _probe(path.parent, int(needed))
    if code == errno.EFBIG:
        wrong = "A file of this process may not become that large"
        hint = f"Raise the limit (ulimit -f) to {needed / 1e6:.0f} MB"
    elif code in _NO_ROOM:
        missing = max(needed - (free if code == errno.ENOSPC else 0), 1e6)
        wrong, hint = "There is no room left for the file", f"Free about {missing / 1e6:.0f} MB"
    elif code in (errno.EACCES, errno.EPERM, errno.EROFS):
        wrong = "The file could not be written"
        hint = "Get the right to write there, or give another name or folder"
    else:
        wrong = "The file could not be written"
        hint = "Free some space, or give another name or folder"
    return StorageError(
        f"{wrong}: {problem}; {free / 1e6:.0f} MB are free" + (f", {kept}." if kept else "."),
        hint=f"{hint}, and run the same command again." if kept else f"{hint}.",
        where=str(path),
    )


def _probe(folder: Path, size: int) -> int:
    """Return the error that the system gives for a file of this size, 0 for none; netCDF does not pass it on."""
    probe = folder / f".eulerdisk-probe-{os.getpid()}"
    try:
        with open(probe, "wb") as file:
            os.pwrite(file.fileno(), b"\0", max(size, 1))
            if hasattr(os, "posix_fallocate"):
                os.posix_fallocate(file.fileno(), 0, max(size, 1))
    except OSError as problem:
        return problem.errno or 0
    finally:
        with contextlib.suppress(OSError):
            probe.unlink()
    return 0
