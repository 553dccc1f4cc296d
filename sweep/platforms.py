"""The systems and processors that are supported; others are refused or warned, each in a sentence.

Supported are Linux and macOS on x86-64 and arm64 processors with fused multiply-add: there the tests run, and there the
bits of the golden files were made. A system without file locks of the POSIX kind is refused: the journal of a run needs
them. Another processor computes too, more slowly and with other last bits.
"""

import importlib.util
import platform
import sys
import warnings
from functools import lru_cache

from sweep.errors import RequestError

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


@lru_cache
def warn_of_processor() -> None:
    """Warn once, when the first kernel is loaded, if the system or the processor is none of those supported."""
    problem = _problem()
    if problem:
        warnings.warn(
            f"{problem}. Supported are Linux and macOS on x86-64 and arm64 processors with fused multiply-add. The "
            "kernels work here too, but may be slower, and the last bits of an atlas may differ from those of other "
            "machines.",
            RuntimeWarning,
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
    from llvmlite import binding

    try:
        return bool(binding.get_host_cpu_features().get("fma"))
    except RuntimeError:
        # LLVM does not know the processor, and compiles without the instruction
        return False
