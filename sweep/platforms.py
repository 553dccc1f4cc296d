"""The machine: all that the program asks of it, and the systems and processors that are supported.

Processors, memory, free disk and the user's folder are asked for here and nowhere else, so that tests can put their own
answers in place of these functions; whoever calls one calls it by its module, ``platforms.free_bytes(...)``.

Supported are Linux and macOS on x86-64 and arm64 processors with fused multiply-add: there the tests run, and there the
bits of the golden files were made. A system without file locks of the POSIX kind is refused: the journal of a run needs
them. Another processor computes too, more slowly and with other last bits.
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

#: Address space [bytes] that a small run and a figure take, and what each thread adds (its stack and its buffers).
_LIBRARIES_BYTES, _THREAD_BYTES = 0.8e9, 1.0e8

#: Possible values of NUMBA_NUM_THREADS.
_THREADS = r"0*[1-9][0-9]{0,3}"

_SYSTEMS = ("linux", "darwin")
_X86, _ARM = ("x86_64", "amd64"), ("arm64", "aarch64")


class UnsupportedSystemError(RequestError, ImportError):
    """The program cannot run on this system."""


def check_system() -> None:
    """Refuse a system without the file locks of runs.

    Raises
    ------
    UnsupportedSystemError
    """
    if importlib.util.find_spec("fcntl") is None:
        raise UnsupportedSystemError(
            f"Linux and macOS are supported; this system is {platform.system() or sys.platform}, which lacks the file "
            "locks (Python's module fcntl) that keep two runs from writing one output.",
            hint="On Windows use eulerdisk in the Windows Subsystem for Linux (WSL).",
        )


def check_memory() -> None:
    """Refuse a limit of memory under which the libraries cannot be loaded.

    They do not report that they have too little: they end the process, or wait for threads that could not be started.

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
    """Return how many threads kernels may run in: NUMBA_NUM_THREADS, or as many as there are processors.

    Raises
    ------
    RequestError
        If the variable is no number.
    """
    asked = os.environ.get("NUMBA_NUM_THREADS")
    if asked == "":
        # as from an unset variable of a script; Numba would take it for a number
        del os.environ["NUMBA_NUM_THREADS"]
    if asked and not re.fullmatch(_THREADS, asked):
        raise RequestError(
            f"The environment variable NUMBA_NUM_THREADS must be a number from 1 to 9999; got {asked!r}.",
            hint="Run `unset NUMBA_NUM_THREADS`.",
            where="NUMBA_NUM_THREADS",
        )
    return int(asked or processors())


def available_threads() -> int:
    """Return how many threads this process may use: its processors, within the CPU quota of its control group."""
    return max(1, min(processors(), math.ceil(min(processor_quota(), 1e9))))


def usual_threads() -> int:
    """Return how many threads kernels run in by default: those available, NUMBA_NUM_THREADS at most."""
    return min(available_threads(), most_threads())


def processors() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def processor_quota() -> float:
    """Return how many processors' time the control group of this process may take; infinite without a quota."""
    try:
        with open("/sys/fs/cgroup/cpu.max", encoding="ascii") as file:
            quota, period = file.read().split()
        return int(quota) / int(period)
    except (OSError, ValueError, ZeroDivisionError):
        return math.inf


def address_space() -> float:
    """Return how many bytes of addresses this process may use; infinite without a limit."""
    import resource

    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    return math.inf if limit == resource.RLIM_INFINITY else limit


def free_bytes(folder: Path) -> float:
    """Return the bytes that are free on the disk of a folder; infinite if the file system does not say."""
    # a file system that has no size does not say what it takes: /proc takes nothing, some network mounts anything
    usage = shutil.disk_usage(folder)
    return usage.free if usage.total else math.inf


def cache_home() -> Path:
    """Return the folder in which this user keeps what can be made again.

    A user without a home, as in a container that runs under a bare number, has a folder among the temporary files.
    """
    import platformdirs

    try:
        folder = Path(platformdirs.user_cache_dir("eulerdisk", appauthor=False))
    except RuntimeError:
        folder = Path("~")
    # older versions of platformdirs leave "~" as it is, which would name a folder here
    return folder if folder.is_absolute() else Path(tempfile.gettempdir(), f"eulerdisk-{os.getuid()}")


def processor() -> str:
    """Return LLVM's name of this processor."""
    from llvmlite import binding

    return str(binding.get_host_cpu_name())


def host_features() -> Mapping[str, bool]:
    """Return the features of this processor, by LLVM's names; none if LLVM does not know it."""
    from llvmlite import binding

    try:
        return dict(binding.get_host_cpu_features())
    except RuntimeError:
        return {}


@lru_cache
def warn_of_processor() -> None:
    """Warn once, when the first kernel is loaded, if the system or the processor is none of those supported."""
    problem = _problem()
    if problem:
        warnings.warn(
            f"{problem}. Supported are Linux and macOS on x86-64 and arm64 processors with fused multiply-add. The "
            "kernels work here too, but may be slower, and the last bits of an atlas may differ from those of other "
            "machines.",
            SurroundingsWarning,
            stacklevel=2,
        )


def _problem() -> str:
    """Return what is not supported here, without a full stop; empty if everything is."""
    machine = platform.machine().lower()
    if sys.platform not in _SYSTEMS:
        return f"eulerdisk was not tested on this system, {sys.platform}"
    if machine in _ARM:
        return ""
    if machine not in _X86:
        return f"eulerdisk was not tested on this processor, {machine or 'of unknown architecture'}"
    return "" if _has_fma() else f"This processor ({machine}) has no fused multiply-add"


def _has_fma() -> bool:
    """Return whether an x86-64 processor multiplies and adds in one instruction, as far as LLVM can tell."""
    # LLVM compiles without the instruction for a processor that it does not know
    return bool(host_features().get("fma"))
