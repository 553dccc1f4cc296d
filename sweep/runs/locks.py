"""One writer at a time: a lock on a run's folder that the system lets go when its holder dies."""

import contextlib
import errno
import fcntl
import os
import platform
import shlex
import time
from collections.abc import Iterator
from pathlib import Path

from sweep.errors import RequestError

#: The files that stand for the lock, one of them where the file system has locks.
LOCK, OWNER = "lock", "owner"

#: The system's words for "this file system has no locks" (some NFS and Lustre mounts).
_NO_LOCKS = (errno.ENOLCK, errno.ENOTSUP, errno.ENOSYS, errno.EINVAL)


@contextlib.contextmanager
def locked(folder: Path, *, shared: bool = False) -> Iterator[None]:
    """Hold the lock of a folder.

    Parameters
    ----------
    folder : Path
        It exists.
    shared : bool
        Let others hold it too who ask for it shared: the jobs of an array, each writing blocks of its own.

    Raises
    ------
    RequestError
        If somebody else holds it, where the message names process, machine and time; or the folder takes no files.
    """
    path = folder / LOCK
    handle = _acquired(path, fcntl.LOCK_SH if shared else fcntl.LOCK_EX)
    if handle is None:
        with contextlib.nullcontext() if shared else _owned(folder / OWNER):
            yield
        return
    try:
        # who holds it is for people; a full disk is told by whoever has something to write
        with contextlib.suppress(OSError):
            if not shared:
                os.ftruncate(handle, 0)
            os.pwrite(handle, (_signature() + "\n").encode("ascii", "replace"), 0)
        yield
    finally:
        os.close(handle)


def _acquired(path: Path, kind: int) -> int | None:
    while True:
        handle = _opened(path)
        try:
            fcntl.flock(handle, kind | fcntl.LOCK_NB)
        except OSError as problem:
            holder = os.pread(handle, 1000, 0).decode("ascii", "replace").partition("\n")[0]
            os.close(handle)
            if problem.errno in _NO_LOCKS:
                return None
            if not isinstance(problem, BlockingIOError):
                raise
            raise _taken(path.parent, holder) from None
        # whoever finished this run meanwhile has removed the file that we hold: ours must be the one with the name
        with contextlib.suppress(FileNotFoundError):
            if os.path.samestat(os.fstat(handle), os.stat(path)):
                return handle
        os.close(handle)
        if not path.parent.is_dir():
            path.parent.mkdir(exist_ok=True)


def _opened(path: Path) -> int:
    try:
        try:
            return os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        except FileNotFoundError:
            # whoever finished this run meanwhile has removed its folder
            path.parent.mkdir(exist_ok=True)
            return os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    except OSError as problem:
        raise RequestError(
            "the run's folder cannot be written",
            "who goes on with a run may write into its folder, and to its lock",
            f"{path}: {problem.strerror}",
            "let its owner go on with it, or give another output",
            str(path.parent),
        ) from problem


@contextlib.contextmanager
def _owned(path: Path) -> Iterator[None]:
    """Hold a file that only one process can make; it must be cleared away after a crash on another machine."""
    while True:
        try:
            handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
            break
        except FileExistsError:
            holder = path.read_text(encoding="ascii", errors="replace").strip()
            if not _is_gone(holder):
                raise _taken(
                    path.parent, holder, f"; if that process is gone: `rm {shlex.quote(str(path))}`"
                ) from None
            with contextlib.suppress(FileNotFoundError):
                path.unlink()
    os.write(handle, _signature().encode("ascii", "replace"))
    os.close(handle)
    try:
        yield
    finally:
        with contextlib.suppress(FileNotFoundError):
            path.unlink()


def _signature() -> str:
    since = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
    return f"process {os.getpid()} on {platform.node()} since {since} boot {_boot()}"


def _boot() -> str:
    try:
        return Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
    except OSError:
        return "unknown"


def _is_gone(holder: str) -> bool:
    words = holder.split()
    if len(words) != 8 or words[3] != platform.node():
        return False
    if words[7] != _boot():
        return True
    try:
        os.kill(int(words[1]), 0)
    except ProcessLookupError:
        return True
    except (OSError, ValueError):
        return False
    return False


def _taken(folder: Path, holder: str, more: str = "") -> RequestError:
    return RequestError(
        "this output is being written",
        "one run writes it at a time",
        holder.partition(" boot ")[0] or "another process",
        f"wait for it, stop it, or give another output{more}",
        str(folder),
    )
