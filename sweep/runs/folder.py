"""The folder of a run: its names, and the lock by which one process at a time writes it.

The system releases the lock when its holder dies.
"""

import contextlib
import errno
import fcntl
import os
import platform
import time
from collections.abc import Iterator
from pathlib import Path

from sweep.atomic import open_or_create
from sweep.errors import RequestError, as_path

#: Suffix of the name of the folder, after the name of the output.
SUFFIX = ".run"

#: Name of the manifest in the folder of a run.
MANIFEST = "manifest.json"

#: Name of the file in that folder with the values of a table of starts, little-endian doubles.
STARTS = "starts.bin"

#: The file that is locked.
LOCK = "lock"

#: Errors of the system that mean "this file system has no locks" (some NFS and Lustre mounts).
_NO_LOCKS = (errno.ENOLCK, errno.ENOTSUP, errno.ENOSYS, errno.EINVAL)


def resolved(path: str | Path) -> Path:
    """Return where a file will be: a symbolic link is followed, so that two names of one output share one lock."""
    path = as_path(path)
    return Path(os.path.realpath(path)) if os.path.islink(path) else path


def directory_of(path: Path) -> Path:
    """Return the folder of the run that makes a file."""
    return path.parent / (path.name + SUFFIX)


def unfinished(path: Path) -> Path | None:
    """Return the folder of the unfinished run that makes a file, or that is given itself; None if there is none."""
    for folder in (path, directory_of(path)):
        if os.path.isfile(folder / MANIFEST):
            return folder
    return None


@contextlib.contextmanager
def locked(folder: Path, *, shared: bool = False) -> Iterator[None]:
    """Hold the lock of a folder that exists; a RequestError names the process, machine and time of another holder.

    A shared lock is held together with other processes that ask for it shared: the jobs of an array write different
    blocks.
    """
    handle = _acquired(folder / LOCK, fcntl.LOCK_SH if shared else fcntl.LOCK_EX)
    try:
        # The holder's name serves only messages, so a full disk is no error here; writing a block will report it.
        with contextlib.suppress(OSError):
            if not shared:
                os.ftruncate(handle, 0)
            os.pwrite(handle, f"{_signature()}\n".encode("ascii", "replace"), 0)
        yield
    finally:
        os.close(handle)


def _acquired(path: Path, kind: int) -> int:
    """Return the handle of the locked file."""
    while True:
        handle = _opened(path)
        try:
            fcntl.flock(handle, kind | fcntl.LOCK_NB)
        except OSError as problem:
            holder = _holder(handle)
            os.close(handle)
            if problem.errno in _NO_LOCKS:
                raise _no_locks(path.parent, problem) from None
            if not isinstance(problem, BlockingIOError):
                raise
            raise _taken(path.parent, holder) from None
        # A run that has ended meanwhile has removed the file, and perhaps another process has made a new one. Only a
        # lock on the file that has the name now excludes other processes.
        with contextlib.suppress(FileNotFoundError):
            if os.path.samestat(os.fstat(handle), os.lstat(path)):
                return handle
        os.close(handle)


def _holder(handle: int) -> str:
    """Return the signature in a locked file; an empty text where there was no room for it."""
    return os.pread(handle, 1000, 0).decode("ascii", "replace").partition("\n")[0]


def _opened(path: Path) -> int:
    try:
        # the run that held the lock may have ended and removed its folder
        path.parent.mkdir(exist_ok=True)
        return open_or_create(path)
    except OSError as problem:
        raise RequestError(
            f"The folder of the run or its file {path.name} cannot be written, which going on with a run needs: "
            f"{problem.strerror}.",
            hint="Let the owner of the folder go on with the run, or give another output.",
            where=str(path.parent),
        ) from problem


def _signature() -> str:
    since = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
    return f"process {os.getpid()} on {platform.node()} since {since}"


def _no_locks(folder: Path, problem: OSError) -> RequestError:
    return RequestError(
        f"The file system of this folder has no locks ({problem.strerror}), by which one run at a time writes it.",
        hint="Give an output on another file system, or have this one mounted with locks.",
        where=str(folder),
    )


def _taken(folder: Path, holder: str) -> RequestError:
    return RequestError(
        f"This output is being written by {holder or 'another process'}; one run writes it at a time.",
        hint="Wait for that process, stop it, or give another output.",
        where=str(folder),
    )
