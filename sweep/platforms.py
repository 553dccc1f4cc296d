"""The systems and processors that are supported; others are refused or warned, each in a sentence.

Supported are Linux and macOS on x86-64 and arm64 processors with fused multiply-add: there the tests run, and there the
bits of the golden files were made. A system without file locks of the POSIX kind is refused: the journal of a run needs
them. Another processor computes too, more slowly and with other last bits.
"""

import importlib.util
import math
import os
import platform
import re
import sys
import warnings
from collections.abc import Mapping, Sequence
from functools import lru_cache

from sweep.errors import RequestError, SurroundingsWarning, shown

#: Address space [bytes] that a small run and a figure take, and what each thread adds (its stack and its buffers).
_LIBRARIES_BYTES, _THREAD_BYTES = 0.8e9, 1.0e8

#: The same without the compiler, for reading an atlas: measured 0.44e9 with two processors.
_READING_BYTES, _READING_THREAD_BYTES = 0.42e9, 0.4e8

#: Commands that only read an atlas -> the begins of words with which they need more: kernels, figures or writers.
_READERS: Mapping[str, tuple[str, ...]] = {
    "info": ("--partial",),
    "boundary": ("--refine", "--criterion", "-o", "--output"),
    "compare": ("--plot",),
    "export": ("zarr", "--to=zarr"),
}

#: What NUMBA_NUM_THREADS may be.
_THREADS = r"0*[1-9][0-9]{0,3}"

#: Targets that many processors run -> features that they add to what every x86-64 has.
_COMMON_TARGETS: Mapping[str, tuple[str, ...]] = {
    "generic": (),
    "x86-64": (),
    "x86-64-v2": ("sse4.2", "popcnt"),
    "x86-64-v3": ("avx2", "bmi2", "fma"),
    "x86-64-v4": ("avx512f", "avx512bw", "avx512dq", "avx512vl"),
}

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


def check_memory(words: Sequence[str]) -> None:
    """Refuse a limit of memory under which the libraries that a command needs cannot be loaded.

    They do not report that they have too little: they end the process, or wait for threads that could not be started.

    Parameters
    ----------
    words : sequence of str
        The command and its arguments. Those that read an atlas and load no kernel need half as much.

    Raises
    ------
    RequestError
    """
    import resource

    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    if limit == resource.RLIM_INFINITY:
        return
    processors = _processors()
    if _only_reads(words):
        needed = _READING_BYTES + _READING_THREAD_BYTES * processors
    else:
        asked = os.environ.get("NUMBA_NUM_THREADS", "")
        threads = min(processors, int(asked)) if re.fullmatch(_THREADS, asked) else processors
        needed = _LIBRARIES_BYTES + _THREAD_BYTES * threads
    if limit < needed:
        raise RequestError(
            f"The libraries need {needed / 1e6:.0f} MB of address space for this command on this machine; this process "
            f"may use {limit / 1e6:.0f} MB.",
            hint=f"Raise the limit: `ulimit -v {math.ceil(needed / 1024)}`.",
            where="ulimit -v",
        )


def _only_reads(words: Sequence[str]) -> bool:
    command, *others = words or [""]
    if command == "plan":
        return "--no-calibrate" in others
    return command in _READERS and not any(word.startswith(_READERS[command]) for word in others)


@lru_cache
def check_settings() -> None:
    """Refuse settings of Numba with which kernels cannot be compiled, or their code would end the process.

    Raises
    ------
    RequestError
    """
    threads = os.environ.get("NUMBA_NUM_THREADS")
    if threads == "":
        # as from an unset variable of a script; Numba would take it for a number
        del os.environ["NUMBA_NUM_THREADS"]
    elif threads is not None and not re.fullmatch(_THREADS, threads):
        raise _refused_setting("NUMBA_NUM_THREADS", f"must be a number from 1 to 9999; got {threads!r}")
    _check_target_processor()


@lru_cache
def check_numba() -> None:
    """Import Numba; refuse settings with which it cannot be imported.

    Raises
    ------
    RequestError
    """
    check_settings()
    with warnings.catch_warnings():
        # what Numba cannot read it ignores, with a traceback
        warnings.filterwarnings("error", message="(?s)Environment variable 'NUMBA_")
        try:
            import numba  # noqa: F401 - whether it can be imported
        except (ImportError, ValueError, RuntimeError, Warning) as problem:
            named = re.search(r"NUMBA_\w+", str(problem))
            reason = str(problem).strip().partition("\n")[0]
            raise _refused_setting(
                named[0] if named else "NUMBA_*", f"keeps Numba from starting: {reason}"
            ) from problem


def most_threads() -> int:
    """Return how many threads kernels may run in: NUMBA_NUM_THREADS, or as many as there are processors.

    Raises
    ------
    RequestError
        If the variable is no number.
    """
    check_settings()
    return int(os.environ.get("NUMBA_NUM_THREADS") or _processors())


def available_threads() -> int:
    """Return how many threads this process may use: its CPU affinity, and the CPU quota of its control group."""
    affinity = _processors()
    try:
        with open("/sys/fs/cgroup/cpu.max", encoding="ascii") as file:
            quota, period = file.read().split()
        return max(1, min(affinity, -(-int(quota) // int(period))))
    except (OSError, ValueError):
        return affinity


def usual_threads() -> int:
    """Return how many threads kernels run in where nobody chose: those available, NUMBA_NUM_THREADS at most."""
    return min(available_threads(), most_threads())


def _processors() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _check_target_processor() -> None:
    """Refuse a target of NUMBA_CPU_* that this processor does not run: LLVM or the first kernel would end the process.

    Raises
    ------
    RequestError
    """
    given = os.environ.get("NUMBA_CPU_FEATURES")
    if given is None:
        # then Numba switches off what this processor lacks, whatever the name is
        return
    host = host_features()
    for each in given.split(",") if given else ():
        if not re.fullmatch(r"[+-][A-Za-z0-9_.-]+", each):
            raise _refused_setting(
                "NUMBA_CPU_FEATURES", f"must be a list like +avx2,-fma; got {shown(given)!r}"
            )
        if host and each[0] == "+" and not host.get(each[1:]):
            raise _refused_setting(
                "NUMBA_CPU_FEATURES", f"asks for {shown(each)}, which this processor does not have"
            )
    name = os.environ.get("NUMBA_CPU_NAME", "")
    if name and name not in _COMMON_TARGETS and name != processor():
        raise _refused_setting(
            "NUMBA_CPU_FEATURES",
            f"must not stand beside NUMBA_CPU_NAME={shown(name)}, of which it is not known whether this processor runs "
            f"its code; known are this one, {processor()}, and {', '.join(_COMMON_TARGETS)}",
        )
    missing = [each for each in _COMMON_TARGETS.get(name, ()) if host and not host.get(each)]
    if missing:
        raise _refused_setting(
            "NUMBA_CPU_NAME", f"is {name}, which has {', '.join(missing)}; this processor does not"
        )


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


def _refused_setting(name: str, problem: str) -> RequestError:
    return RequestError(
        f"The environment variable {name} {problem.rstrip('.')}.", hint=f"Run `unset {name}`.", where=name
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
