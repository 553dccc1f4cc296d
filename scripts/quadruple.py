"""Extreme tilts and periods in quadruple precision, some milliseconds each, from `quadruple.c`, compiled on first use.

Needs a C compiler with `__float128` (GCC on x86); without one, `available` returns False.
"""

import ctypes
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path

import numpy as np

from sweep.model.quantity import Array

_SOURCE = Path(__file__).with_suffix(".c")


@cache
def _library() -> ctypes.CDLL | None:
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / "quadruple.so"
        command = ["cc", "-O2", "-shared", "-fPIC", str(_SOURCE), "-o", str(made), "-lquadmath", "-lm"]
        try:
            subprocess.run(command, check=True, capture_output=True)
        except (OSError, subprocess.CalledProcessError):
            return None
        library = ctypes.CDLL(str(made))
    library.prepare()
    return library


def available() -> bool:
    """Return whether this machine can compile the reference."""
    return _library() is not None


def swings(given: Array, fall: float) -> Array:
    """Return the period [s], its relative doubt, and the least and greatest tilt [rad] of all starts, as rows.

    Parameters
    ----------
    given : float64[len(PARAMETERS), n]
    fall : float
        Largest tilt [rad]; a disk that does not turn on both sides before it has NaN for all values.

    Returns
    -------
    float64[4, n]
    """
    library = _library()
    assert library is not None
    starts = np.ascontiguousarray(given.T, dtype=np.float64)
    found = np.full((starts.shape[0], 4), np.nan)

    def address(row: Array) -> ctypes.c_void_p:
        return ctypes.c_void_p(row.ctypes.data)

    def one(cell: int) -> None:
        library.swing(address(starts[cell]), ctypes.c_double(fall), address(found[cell]))

    # the library runs without Python's global lock
    with ThreadPoolExecutor() as threads:
        list(threads.map(one, range(starts.shape[0])))
    return found.T
