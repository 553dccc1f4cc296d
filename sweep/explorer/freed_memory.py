"""Memory that is free again is given back to the system, where the C library has functions for it (glibc)."""

import ctypes
from contextlib import suppress
from functools import lru_cache
from typing import Any

#: Of glibc's mallopt: the option, and the size [bytes] from which a block of memory is apart from the heaps.
_MMAP_THRESHOLD, _APART = -3, 2**20


def keep_large_blocks_apart() -> None:
    """Let every large block of memory be given back as soon as it is free, for as long as the process lives.

    By itself the C library keeps blocks in the heaps of its threads up to the size of the largest one that was ever
    given back, which may be 32 MB: after one large window each thread that answers keeps some 20 MB.
    """
    with suppress(OSError, TypeError, AttributeError):
        ctypes.CDLL(None).mallopt(_MMAP_THRESHOLD, _APART)


def give_back() -> None:
    """Give back what is free in the heaps of all threads.

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
