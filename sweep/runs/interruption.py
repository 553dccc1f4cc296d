"""Ctrl-C, and the interrupt of a notebook, while a Python function computes: the block is finished, and kept."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from sweep.errors import StoppedError
from sweep.runs.executor import Stopping


@contextmanager
def interruptible(stopping: Stopping | None = None) -> Iterator[Stopping]:
    """Let SIGINT end the work within after its current block, and raise a KeyboardInterrupt that says what is kept.

    A second SIGINT raises where it arrives, as it would without this. A handler of the caller stays in charge, and so
    does Python outside the main thread, where no handler can be set.

    Parameters
    ----------
    stopping : callable, optional
        Of a caller that says itself when the work is to stop; SIGINT is left alone then.

    Yields
    ------
    callable
        Returns whether to stop.
    """
    if stopping is not None or not _python_handles():
        yield stopping or (lambda: False)
        return
    arrived = False

    # An exception raised here could get lost in a callback of the compiler, or leave a block half kept.
    def stop(number: int, frame: FrameType | None) -> None:
        nonlocal arrived
        if arrived:
            signal.default_int_handler(number, frame)
        arrived = True

    signal.signal(signal.SIGINT, stop)
    try:
        yield lambda: arrived
    except StoppedError as end:
        if not arrived:
            # an executor has ended early
            raise
        raise KeyboardInterrupt(f"{end}. To go on, give the same call again.") from None
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if arrived:
        raise KeyboardInterrupt("all was done when it came.")


def _python_handles() -> bool:
    """Return whether SIGINT raises KeyboardInterrupt in this thread: no one else has a use for it."""
    in_main = threading.current_thread() is threading.main_thread()
    return in_main and signal.getsignal(signal.SIGINT) is signal.default_int_handler
