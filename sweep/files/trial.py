"""A netCDF file is opened in another process first: of some damaged files the library never comes back.

Of 38,000 files with damaged bytes none ended or stopped netCDF-C 4.10 with HDF5 2.2. But a link to the root group, or
one part of a file copied over another, kept it in a loop, in some files with more memory every turn, and Python cannot
interrupt that. The other process is a fork on Linux, which takes some milliseconds, and a new one elsewhere.
"""

import contextlib
import faulthandler
import math
import os
import resource
import signal
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

#: What opening may take: seconds of processor time, seconds on the clock (a file may lie on a slow network), and bytes
#: of memory beyond those of the process. A file is opened in milliseconds.
_MOST_WORK, _MOST_WAIT, _MOST_BYTES = 2, 120, 2**29

#: Seconds on the clock after which a new process takes the place of a fork.
_MOST_WAIT_FORKED = 20

#: Files up to this size [bytes] are read as a whole: then a chunk cannot keep the library either.
_READ = 2**24

#: Bytes of a message that pass from one process to the other, and what follows it if the other one came to its end.
_MESSAGE, _WHOLE = 2000, b"\0whole"


def check_opens(path: Path) -> None:
    """Open a netCDF file in another process, and read it if it is small.

    Raises
    ------
    OSError
        If it cannot be opened, or not within limits of time and memory; the text says which.
    """
    status, words = (_in_a_fork if sys.platform == "linux" else _in_a_new_process)(path)
    if status < 0:
        words = f"the library took more than {_MOST_WORK} s or {_MOST_BYTES >> 20} MB to open it, or was ended by it"
    if status:
        raise OSError(words or "the library does not open it")


def _in_a_fork(path: Path) -> tuple[int, str]:
    read, write = os.pipe()
    with warnings.catch_warnings():
        # of threads, which the child does not have: see below
        warnings.simplefilter("ignore", DeprecationWarning)
        child = os.fork()
    if child == 0:
        status = 1
        try:
            os.close(read)
            os.write(write, _told(path, _MOST_WAIT_FORKED))
            status = 0
        finally:
            # nothing of the parent's is flushed or closed by this process
            os._exit(status)
    os.close(write)
    with os.fdopen(read, "rb") as pipe:
        told = pipe.read()
    ended = 0
    # the system keeps no status where SIGCHLD is ignored, or where another part of the program waits for all children
    with contextlib.suppress(ChildProcessError):
        ended = os.waitpid(child, 0)[1]
    if not told.endswith(_WHOLE) and (
        not ended or (os.WIFSIGNALED(ended) and os.WTERMSIG(ended) == signal.SIGALRM)
    ):
        # Perhaps a slow disk, or another thread held a lock of the library when this process forked, which no thread
        # of the child gives back.
        return _in_a_new_process(path)
    return _read_from(told)


def _in_a_new_process(path: Path) -> tuple[int, str]:
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    line = [sys.executable, "-m", "sweep.files.trial", str(path.absolute())]
    done = subprocess.run(line, env=environment, capture_output=True, check=False)
    return _read_from(done.stdout)


def _told(path: Path, wait: int = _MOST_WAIT) -> bytes:
    """Return what the other process tells: `_attempt`, and a mark by which the status of the process is not needed."""
    return _attempt(path, wait).encode("utf-8", "replace")[:_MESSAGE] + _WHOLE


def _read_from(told: bytes) -> tuple[int, str]:
    words = told.removesuffix(_WHOLE).decode("utf-8", "replace")
    return (int(bool(words)), words) if told.endswith(_WHOLE) else (-1, "")


def _attempt(path: Path, wait: int = _MOST_WAIT) -> str:
    """Open the file within the limits, and return what is wrong with it; empty if nothing is."""
    _limit(wait)
    import netCDF4

    try:
        with netCDF4.Dataset(path) as file:
            file.set_auto_maskandscale(False)
            _read(file, path.stat().st_size <= _READ)
    except Exception as problem:
        # only the library works here, and of a damaged file it raises all kinds of errors
        return str(problem) or type(problem).__name__
    return ""


def _read(file: Any, values: bool) -> None:
    """Read all attributes, and the values if asked for; what cannot be read is told when it is opened in earnest."""
    for each in (file, *file.variables.values()):
        with contextlib.suppress(Exception):
            for name in each.ncattrs():
                each.getncattr(name)
    for variable in file.variables.values() if values else ():
        with contextlib.suppress(Exception):
            # more values than the file can hold are refused before they are read
            if math.prod(variable.shape) * variable.dtype.itemsize <= _MOST_BYTES // 4:
                variable[...]


def _limit(wait: int) -> None:
    # the end of this process is an answer, and no fault to be printed
    faulthandler.disable()
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.alarm(wait)
    used = resource.getrusage(resource.RUSAGE_SELF)
    _lower(resource.RLIMIT_CPU, int(used.ru_utime + used.ru_stime) + _MOST_WORK)
    _lower(resource.RLIMIT_CORE, 0)
    with contextlib.suppress(OSError, ValueError, IndexError):
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        _lower(resource.RLIMIT_AS, pages * resource.getpagesize() + _MOST_BYTES)


def _lower(kind: int, most: int) -> None:
    hard = resource.getrlimit(kind)[1]
    with contextlib.suppress(OSError, ValueError):
        resource.setrlimit(kind, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))


if __name__ == "__main__":
    sys.stdout.buffer.write(_told(Path(sys.argv[1])))
