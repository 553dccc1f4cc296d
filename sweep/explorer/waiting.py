"""Turns and ends of work: one thread at a time calls kernels, and what no client waits for any more ends.

A page that asks anew closes the connection of what it asked before: work ends where its client has gone.
"""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from sweep.model.quantity import Array

#: Kernels use all processors by themselves: the threads that answer requests call them one after another.
KERNELS = threading.RLock()

#: One motion at a time is followed, beside the maps.
MOTIONS = threading.Lock()

#: Seconds between two looks whether the client of a motion is there. Most motions end before the first.
_LOOK = 0.05


class ClientGoneError(Exception):
    """No client waits for the answer any more."""


@contextmanager
def ended_with(check: Callable[[], None]) -> Iterator[Callable[[Array], None]]:
    """Return a context that ends the motion which is followed in it when its client has gone.

    Parameters
    ----------
    check : callable
        Raises ClientGoneError where the client has gone; it is called by another thread.

    Yields
    ------
    callable
        Takes the times of the samples before they are integrated, as `sweep.motion.disk_path.follow` gives them. A
        kernel cannot be interrupted, but it reads the time of each sample when it comes to it: where all are zero
        nothing is left to do.

    Raises
    ------
    ClientGoneError
        If no client waits for the motion.
    """
    done, gone = threading.Event(), threading.Event()
    followed: list[Array] = []

    def watch() -> None:
        while not done.wait(_LOOK):
            try:
                check()
            except (ClientGoneError, OSError):
                # a connection that cannot be looked at has ended too
                gone.set()
            if gone.is_set():
                for times in followed:
                    times[:] = 0.0

    def begun(times: Array) -> None:
        followed.append(times)
        if gone.is_set():
            raise ClientGoneError

    check()
    thread = threading.Thread(target=watch, name="motion watch", daemon=True)
    thread.start()
    try:
        yield begun
    finally:
        done.set()
        thread.join()
        # before the refusal of a motion without times
        if gone.is_set():
            raise ClientGoneError
