"""The folder of a run: the names of its files, and its lock, so that only one process at a time writes it.

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

#: System errors that mean "this file system has no locks" (some NFS and Lustre mounts).
_NO_LOCKS = (errno.ENOLCK, errno.ENOTSUP, errno.ENOSYS, errno.EINVAL)


def resolved(path: str | Path) -> Path:
    """Return the path of a file with a symbolic link followed, so that two names of one output share one lock."""
    path = as_path(path)
    return Path(os.path.realpath(path)) if os.path.islink(path) else path


def directory_of(path: Path) -> Path:
    """Return the folder of the run that writes a file."""
    return path.parent / (path.name + SUFFIX)


def unfinished(path: Path) -> Path | None:
    """Return the folder of the unfinished run for a path, its file or its folder; None if there is none."""
    for folder in (path, directory_of(path)):
        if os.path.isfile(folder / MANIFEST):
            return folder
    return None


@contextlib.contextmanager
def locked(folder: Path, *, shared: bool = False) -> Iterator[None]:
    """Hold the lock of an existing folder; a RequestError names the process, machine and time of another holder.

    Several processes can hold a shared lock: the jobs of an array write different blocks.
    """
    handle = _acquire(folder / LOCK, fcntl.LOCK_SH if shared else fcntl.LOCK_EX)
    try:
        # the holder's name is only for messages, so ignore a full disk: writing a block will report it
        with contextlib.suppress(OSError):
            if not shared:
                os.ftruncate(handle, 0)
            os.pwrite(handle, f"{_signature()}\n".encode("ascii", "replace"), 0)
        yield
    finally:
        os.close(handle)


def _acquire(path: Path, kind: int) -> int:
    """Lock the file, and return its handle."""
    while True:
        handle = _open(path)
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
        # A run that ended in the meantime has removed the file, and another process may have made a new one. Only a
        # lock on the file that now has the name excludes other processes.
        with contextlib.suppress(FileNotFoundError):
            if os.path.samestat(os.fstat(handle), os.lstat(path)):
                return handle
        os.close(handle)


def _holder(handle: int) -> str:
    """Return the signature in a locked file; empty if there was no space to write it."""
    return os.pread(handle, 1000, 0).decode("ascii", "replace").partition("\n")[0]


def _open(path: Path) -> int:
    try:
        # the run that held the lock may have ended and removed its folder
        path.parent.mkdir(exist_ok=True)
        return open_or_create(path)
    except OSError as problem:
        raise RequestError(
            f"Cannot resume the run: its folder or its file {path.name} is not writable: {problem.strerror}.",
            hint="Let the owner of the folder resume the run, or give another output.",
            where=str(path.parent),
        ) from problem


def _signature() -> str:
    since = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
    return f"process {os.getpid()} on {platform.node()} since {since}"


def _no_locks(folder: Path, problem: OSError) -> RequestError:
    return RequestError(
        f"The file system of this folder has no locks ({problem.strerror}), which a run needs to be its only writer.",
        hint="Give an output on another file system, or mount this one with locks.",
        where=str(folder),
    )


def _taken(folder: Path, holder: str) -> RequestError:
    return RequestError(
        f"This output is being written by {holder or 'another process'}; only one run at a time can write it.",
        hint="Wait for that process, stop it, or give another output.",
        where=str(folder),
    )
