"""A file at its final name is whole: it is written under another name, made safe, and then renamed."""

import contextlib
import errno
import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

from sweep.errors import StorageError

#: The system's words for "there is no more room": the disk, a quota, a limit on the size of a file.
_NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


def publish(unfinished: Path, path: Path) -> None:
    """Give a file that was written to its end its final name, in a way that a power cut cannot undo.

    Raises
    ------
    OSError
    """
    with open(unfinished, "rb+") as file:
        os.fsync(file.fileno())
    os.replace(unfinished, path)
    sync_folder(path.parent)


def publish_text(path: Path, text: str) -> None:
    """Write a small text file that is either absent or whole.

    Raises
    ------
    OSError
    """
    unfinished = path.with_name(f"{path.name}.{os.getpid()}.tmp")
    unfinished.write_text(text, encoding="ascii")
    publish(unfinished, path)


def sync_folder(folder: Path) -> None:
    """Make the names in a folder survive a power cut, where its file system can."""
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
    """Say what a file system refuses in the words of a StorageError.

    Parameters
    ----------
    path : Path
        What was to be written in the end.
    needed : callable
        Returns the bytes that are still to be written.
    kept : callable
        Returns what the reader may rely on, and where it is; nothing, if the same command does not go on.

    Raises
    ------
    StorageError
    """
    try:
        yield
    except (OSError, RuntimeError) as problem:
        # netCDF says "HDF error" whatever the system told it; other RuntimeErrors are defects of ours
        if isinstance(problem, RuntimeError) and "NetCDF" not in str(problem):
            raise
        raise _refusal(problem, path, needed(), kept()) from problem


def _refusal(problem: Exception, path: Path, needed: float, kept: str) -> StorageError:
    free = shutil.disk_usage(path.parent).free
    told = problem.errno if isinstance(problem, OSError) else _ask(path.parent, int(needed))
    given = f"{problem}; {free / 1e6:.0f} MB are free" + (f"; {kept}" if kept else "")
    if told == errno.EFBIG:
        what, do = "a file may not become that large", f"raise the limit (ulimit -f) to {needed / 1e6:.0f} MB"
    elif told in _NO_ROOM:
        missing = max(needed - (free if told == errno.ENOSPC else 0), 1e6)
        what, do = "there is no room left", f"free about {missing / 1e6:.0f} MB"
    elif told in (errno.EACCES, errno.EPERM, errno.EROFS):
        what, do = (
            "the file could not be written",
            "give yourself the right to write there, or another name or folder",
        )
    else:
        what, do = "the file could not be written", "free some space, or give another name or folder"
    return StorageError(
        what,
        "the folder takes new files, and has room for them to the end",
        given,
        f"{do}, and run the same command again" if kept else do,
        str(path),
    )


def _ask(folder: Path, size: int) -> int:
    # what would the system say to a file of that size? Nothing is written but its last byte
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
