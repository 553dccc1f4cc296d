"""Publishing for libraries that write to a path: the file or folder appears complete or not at all."""

import contextlib
import errno
import math
import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

from sweep import platforms
from sweep.atomic import create_temporary, create_temporary_folder, publish, publish_folder
from sweep.errors import RequestError, StorageError

#: Errors of the system that mean "no room": the disk is full, or a quota or a limit on file sizes is reached.
_NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)

#: Largest ratio of the size of an atlas file to the bytes of its cells (measured: 0.3 to 0.75).
FILE_SHARE = 0.8


@contextlib.contextmanager
def published(path: Path, needed: float = 0.0) -> Iterator[Path]:
    """Yield an empty temporary file next to `path` to write to; publish it when the ``with`` block ends.

    If the block fails, the file is removed. If the file system fails, or has no room for `needed` bytes, a StorageError
    is raised.
    """
    # absolute, because programs misread the start of a relative name as an option or a protocol, or drop a blank
    path = path.absolute()
    with refusals(path, lambda: needed):
        unfinished = create_temporary(path.parent)
        try:
            if needed:
                _reserve(unfinished, int(needed))
            yield unfinished
            publish(unfinished, path)
        finally:
            unfinished.unlink(missing_ok=True)


def _reserve(unfinished: Path, size: int) -> None:
    """Check that a file can have `size` bytes by allocating and freeing them; raise OSError if not."""
    with open(unfinished, "rb+") as file:
        os.pwrite(file.fileno(), b"\0", max(size - 1, 0))
        if hasattr(os, "posix_fallocate"):
            os.posix_fallocate(file.fileno(), 0, max(size, 1))
        file.truncate(0)


@contextlib.contextmanager
def published_folder(path: Path) -> Iterator[Path]:
    """Do the same as `published` for a folder; an existing folder is removed when the new one is complete."""
    path = path.absolute()
    with refusals(path):
        unfinished = create_temporary_folder(path.parent)
        try:
            yield unfinished
            publish_folder(unfinished, path)
        finally:
            shutil.rmtree(unfinished, ignore_errors=True)


@contextlib.contextmanager
def refusals(
    path: Path, needed: Callable[[], float] = lambda: 0.0, kept: Callable[[], str] = lambda: ""
) -> Iterator[None]:
    """Turn errors of the file system and of netCDF into a StorageError with a hint.

    Parameters
    ----------
    path : Path
        The final path of the output.
    needed : callable
        Returns the number of bytes still to be written.
    kept : callable
        Returns a clause that says which results are kept and where; empty if the same command cannot resume.
    """
    try:
        yield
    except (OSError, RuntimeError) as problem:
        # netCDF raises RuntimeError("NetCDF: HDF error") for all system errors; other RuntimeErrors are defects
        if isinstance(problem, RuntimeError) and "NetCDF" not in str(problem):
            raise
        raise _refusal(problem, path, needed(), kept()) from problem


def _refusal(problem: Exception, path: Path, needed: float, kept: str) -> StorageError:
    free = platforms.free_bytes(path.parent)
    # netCDF and HDF5 do not always report the number of the system error
    code = getattr(problem, "errno", None) or _probe(path.parent, int(needed))
    if code == errno.EFBIG:
        wrong = "This process may not write a file that large"
        # the size of a figure is not known in advance; ulimit counts units of 1024 bytes
        hint = (
            f"Raise the limit: `ulimit -f {math.ceil(needed / 1024)}`"
            if needed
            else "Raise the limit (ulimit -f)"
        )
    elif code in _NO_ROOM:
        missing = max(needed - (free if code == errno.ENOSPC else 0), 1e6)
        wrong, hint = "The disk has no room left for the file", f"Free about {missing / 1e6:.0f} MB"
    elif code in (errno.EACCES, errno.EPERM, errno.EROFS):
        wrong = "The file could not be written"
        hint = "Get permission to write there, or give another name or folder"
    else:
        wrong = "The file could not be written"
        hint = "Free some space, or give another name or folder"
    room = f"; {free / 1e6:.0f} MB are free" if math.isfinite(free) else ""
    return StorageError(
        f"{wrong}: {problem}" + room + (f", {kept}." if kept else "."),
        hint=f"{hint}, and run the same command again." if kept else f"{hint}.",
        where=str(path),
    )


def _probe(folder: Path, size: int) -> int:
    """Return the system error for a file of this size, or 0; netCDF does not report it."""
    try:
        unfinished = create_temporary(folder)
    except OSError as problem:
        return problem.errno or 0
    try:
        _reserve(unfinished, size)
    except OSError as problem:
        return problem.errno or 0
    finally:
        with contextlib.suppress(OSError):
            unfinished.unlink()
    return 0


def check_room(path: Path, needed: float) -> None:
    """Refuse a file that does not fit on the disk.

    Parameters
    ----------
    path : Path
        A file on that disk. It need not exist, but its folder must.
    needed : float
        Bytes to be written.

    Raises
    ------
    RequestError
    """
    free = platforms.free_bytes(path.parent)
    if needed > free:
        raise RequestError(
            f"The atlas does not fit on the disk: the file and its journal need about {size(needed)}, but only "
            f"{size(free)} are free in {path.parent.resolve()}, {size(needed - free)} too little.",
            hint=f"Free {size(needed - free)}, use fewer cells or another disk.",
            where=str(path),
        )


def size(count: float) -> str:
    """Return a number of bytes in readable units."""
    for factor, unit in ((1e12, "TB"), (1e9, "GB"), (1e6, "MB")):
        if count >= 10 * factor:
            return f"{count / factor:.0f} {unit}"
    return f"{count / 1e6:.1f} MB" if count >= 1e6 else f"{count / 1e3:.0f} kB"
