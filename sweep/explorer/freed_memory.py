"""Memory that is free again is given back to the system."""

import ctypes
from functools import lru_cache
from typing import Any


def give_back() -> None:
    """Give back what is free in the heaps of all threads, where the C library has a function for it (glibc).

    It keeps a heap for each of several threads, and in each what the largest request of a thread has ever taken: the
    file of a large window leaves 50 to 120 MB, and the threads that answer are others each time. This takes
    milliseconds.
    """
    trim = _trim()
    if trim is not None:
        trim(0)


@lru_cache
def _trim() -> Any:
    try:
        return getattr(ctypes.CDLL(None), "malloc_trim", None)
    except (OSError, TypeError):
        return None
