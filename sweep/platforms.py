"""Queries of the machine, and the supported systems and processors.

Only this module asks for processors, memory, free disk space and the user's folder, so that tests can replace these
functions. Call them through the module, as in ``platforms.free_bytes(...)``.

The supported systems are Linux and macOS on x86-64 and arm64 processors with fused multiply-add: the tests run there,
and the golden files were made there. A system without POSIX file locks is refused, because the journal of a run needs
them. Other processors also work, but more slowly and with different last bits.
"""

import importlib.util
import math
import os
import platform
import re
import shutil
import sys
import tempfile
import warnings
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path

from sweep.errors import RequestError, SurroundingsWarning

#: Address space [bytes] of a small run and a figure, and of each additional thread (its stack and its buffers).
_LIBRARIES_BYTES, _THREAD_BYTES = 0.8e9, 1.0e8

#: Possible values of NUMBA_NUM_THREADS.
_THREADS = r"0*[1-9][0-9]{0,3}"

_SYSTEMS = ("linux", "darwin")
_X86, _ARM = ("x86_64", "amd64"), ("arm64", "aarch64")


class UnsupportedSystemError(RequestError, ImportError):
    """The program cannot run on this system."""


def check_system() -> None:
    """Refuse a system without the file locks that runs need.

    Raises
    ------
    UnsupportedSystemError
    """
    if importlib.util.find_spec("fcntl") is None:
        raise UnsupportedSystemError(
            f"eulerdisk supports Linux and macOS; this system is {platform.system() or sys.platform}, which lacks the "
            "file locks (Python's module fcntl) that prevent two runs from writing the same output.",
            hint="On Windows use eulerdisk in the Windows Subsystem for Linux (WSL).",
        )


def check_memory() -> None:
    """Refuse a memory limit that is too small for loading the libraries.

    The libraries do not report this: they end the process, or wait for threads that could not be started.

    Raises
    ------
    RequestError
    """
    limit = address_space()
    needed = _LIBRARIES_BYTES + _THREAD_BYTES * min(processors(), most_threads())
    if limit < needed:
        raise RequestError(
            f"The libraries need {needed / 1e6:.0f} MB of address space on this machine; this process may use "
            f"{limit / 1e6:.0f} MB.",
            hint=f"Raise the limit: `ulimit -v {math.ceil(needed / 1024)}`.",
            where="ulimit -v",
        )


def most_threads() -> int:
    """Return the largest number of threads for kernels: NUMBA_NUM_THREADS, or the number of processors.

    Raises
    ------
    RequestError
        If the variable is not a number from 1 to 9999.
    """
    asked = os.environ.get("NUMBA_NUM_THREADS")
    if asked == "":
        # e.g. from an unset variable in a script; Numba would try to read it as a number
        del os.environ["NUMBA_NUM_THREADS"]
    if asked and not re.fullmatch(_THREADS, asked):
        raise RequestError(
            f"The environment variable NUMBA_NUM_THREADS must be a number from 1 to 9999; got {asked!r}.",
            hint="Run `unset NUMBA_NUM_THREADS`.",
            where="NUMBA_NUM_THREADS",
        )
    return int(asked or processors())


def available_threads() -> int:
    """Return the number of threads for this process: its processors, limited by the CPU quota of its cgroup."""
    return max(1, min(processors(), math.ceil(min(processor_quota(), 1e9))))


def usual_threads() -> int:
    """Return the default number of threads for kernels: the available ones, at most NUMBA_NUM_THREADS."""
    return min(available_threads(), most_threads())


def processors() -> int:
    """Return the number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def processor_quota() -> float:
    """Return the CPU quota of this process's control group, in processors; infinite without a quota."""
    try:
        with open("/sys/fs/cgroup/cpu.max", encoding="ascii") as file:
            quota, period = file.read().split()
        return int(quota) / int(period)
    except (OSError, ValueError, ZeroDivisionError):
        return math.inf


def address_space() -> float:
    """Return the limit of this process's address space [bytes]; infinite without a limit."""
    import resource

    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    return math.inf if limit == resource.RLIM_INFINITY else limit


def file_size() -> float:
    """Return the limit on the size of the files of this process [bytes]; infinite without a limit."""
    import resource

    limit, _ = resource.getrlimit(resource.RLIMIT_FSIZE)
    return math.inf if limit == resource.RLIM_INFINITY else limit


def free_bytes(folder: Path) -> float:
    """Return the free space on the disk of a folder [bytes]; infinite if the file system does not report it."""
    # file systems that report a size of 0 do not report their room: /proc has none, some network mounts any amount
    usage = shutil.disk_usage(folder)
    return usage.free if usage.total else math.inf


def cache_home() -> Path:
    """Return the cache folder of this user.

    For a user without a home, as in a container with a bare user number, it lies among the temporary files.
    """
    import platformdirs

    try:
        folder = Path(platformdirs.user_cache_dir("eulerdisk", appauthor=False))
    except RuntimeError:
        folder = Path("~")
    # older versions of platformdirs do not expand "~", which would name a folder in the working directory
    return folder if folder.is_absolute() else Path(tempfile.gettempdir(), f"eulerdisk-{os.getuid()}")


def processor() -> str:
    """Return LLVM's name for this processor."""
    from llvmlite import binding

    return str(binding.get_host_cpu_name())


def host_features() -> Mapping[str, bool]:
    """Return the features of this processor by LLVM name; empty if LLVM does not know the processor."""
    from llvmlite import binding

    try:
        return dict(binding.get_host_cpu_features())
    except RuntimeError:
        return {}


@lru_cache
def warn_of_processor() -> None:
    """Warn once, when the first kernel is loaded, if the system or the processor is not supported."""
    problem = _problem()
    if problem:
        warnings.warn(
            f"{problem}. eulerdisk supports Linux and macOS on x86-64 and arm64 processors with fused multiply-add. "
            "The kernels also work here, but may be slower, and the last bits of an atlas may differ from atlases of "
            "other machines.",
            SurroundingsWarning,
            stacklevel=2,
        )


def _problem() -> str:
    """Return what is not supported here, without a period; empty if everything is supported."""
    machine = platform.machine().lower()
    if sys.platform not in _SYSTEMS:
        return f"eulerdisk was not tested on this system, {sys.platform}"
    if machine in _ARM:
        return ""
    if machine not in _X86:
        return f"eulerdisk was not tested on this processor, {machine or 'of unknown architecture'}"
    return "" if _has_fma() else f"This processor ({machine}) has no fused multiply-add"


def _has_fma() -> bool:
    """Return whether LLVM reports a fused multiply-add instruction for an x86-64 processor."""
    # LLVM compiles without this instruction for unknown processors
    return bool(host_features().get("fma"))
