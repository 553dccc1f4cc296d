"""The width of the vectors that kernels are compiled with on this processor: measured once, and remembered.

LLVM prefers half the width on most Intel processors with AVX-512. That is right for those that have one unit for wide
multiply-adds, or that lower their clock much for it, and costs a third of the speed on the others. A name of a
processor does not tell which it is (virtual machines give wrong ones), and a measurement takes some hundredths of a
second; importing Numba and compiling what is measured take the rest of the second that users are told of. The width
changes no bit of a result.
"""

import hashlib
import os
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from sweep.atomic import publish_bytes
from sweep.model.kernel_cache import read_own
from sweep.notices import notice
from sweep.platforms import check_numba, host_features, processor

#: Half and full width [bits] of AVX-512.
HALF, FULL = 256, 512

#: How much faster multiply-adds have to be with one width for it to be chosen: a kernel does other things too, which
#: run at the lower clock that some processors have for wide vectors. Between the two, LLVM knows best.
_GAIN = 1.15

#: Numbers, rounds and repetitions of the measurement: some milliseconds for each width.
_NUMBERS, _ROUNDS, _REPEATS = 512, 8000, 7


def bits(root: Path | None) -> int:
    """Return the width that kernels prefer, 0 where the choice is left to LLVM.

    It is left to LLVM on processors without AVX-512, where both widths are as fast, and where the environment names a
    target (NUMBA_CPU_NAME, NUMBA_CPU_FEATURES).

    Parameters
    ----------
    root : Path or None
        The folder of all caches, in which the choice is remembered; None if it cannot be used.
    """
    return _chosen(root) if _is_in_doubt() else 0


def is_known(root: Path) -> bool:
    """Whether `bits` need not measure."""
    return not _is_in_doubt() or _remembered(_place(root)) is not None


def _is_in_doubt() -> bool:
    named = os.environ.get("NUMBA_CPU_NAME"), os.environ.get("NUMBA_CPU_FEATURES")
    return all(each is None for each in named) and bool(host_features().get("avx512f"))


@lru_cache
def _chosen(root: Path | None) -> int:
    place = None if root is None else _place(root)
    remembered = _remembered(place)
    if remembered is not None:
        return remembered
    notice("measuring how wide the vectors of compiled code should be on this processor takes about 1 s")
    with import_module("kernels.native.machine_code").without_garbage_collection():
        check_numba()
        found = faster(measured())
    if place is not None:
        # where it cannot be kept, the next process measures again
        with suppress(OSError):
            publish_bytes(place, f"{found}\n".encode("ascii"), mode=0o644)
    return found


def measured(clock: Callable[[], float] = time.thread_time) -> dict[int, float]:
    """Return the multiply-adds per second of one thread: width [bits] -> rate."""
    probes = {width: _probe(width) for width in (HALF, FULL)}
    numbers, least = np.zeros(_NUMBERS), dict.fromkeys(probes, np.inf)
    for _ in range(_REPEATS):
        for width, probe in probes.items():
            began = clock()
            probe(numbers, _ROUNDS, 0.5, 0.25)
            least[width] = min(least[width], clock() - began)
    links = int(import_module("kernels.multiply_add").LINKS)
    return {width: _NUMBERS * _ROUNDS * links / seconds for width, seconds in least.items()}


def faster(rates: dict[int, float]) -> int:
    """Return the width that is to be chosen by the rates of `measured`; 0, LLVM's choice, where they are alike."""
    if rates[FULL] > _GAIN * rates[HALF]:
        return FULL
    return HALF if rates[HALF] > _GAIN * rates[FULL] else 0


def _probe(width: int) -> Any:
    pipeline = import_module("kernels.native.pipeline")
    kernel = import_module("kernels.multiply_add").multiply_add
    probe = kernel.copied(kernel.py_func)
    with pipeline.preferring(width):
        probe(np.zeros(_NUMBERS), 1, 0.5, 0.25)
    return probe


def _place(root: Path) -> Path:
    return root / f"vector-width-{_digest(host_features())}.txt"


def _digest(features: Mapping[str, bool]) -> str:
    from importlib.metadata import version

    return hashlib.sha256(
        f"{processor()} {sorted(features.items())} {version('llvmlite')}".encode()
    ).hexdigest()[:16]


def _remembered(place: Path | None) -> int | None:
    text = b"" if place is None else read_own(place)
    return next((width for width in (0, HALF, FULL) if text == b"%d\n" % width), None)
