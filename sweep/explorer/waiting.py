"""Who waits for what: one thread at a time calls kernels, the newest question wins, and what is unwanted ends."""

import threading
from collections import OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from sweep.model.quantity import Array

#: Kernels use all processors by themselves: the threads that answer requests call them one after another.
KERNELS = threading.RLock()

#: One motion at a time is followed, beside the maps; and one file with the cells of a window is made.
MOTIONS, FILES = threading.Lock(), threading.Lock()

#: Seconds after which one that waits for its turn looks whether anybody still waits for it.
_WAIT = 0.1

#: Seconds between two looks whether somebody waits for a motion. Most have come to their end before the first.
_LOOK = 0.05

#: Lanes that are remembered: a page has a few, and a page that was left is never heard of again.
_MOST_LANES = 256


class SupersededError(Exception):
    """Nobody waits for the answer any more: a newer request of the same lane came, or the client has gone."""


def still_there(gone: Callable[[], bool]) -> Callable[[], None]:
    """Return a function that raises SupersededError where the client has gone."""

    def check() -> None:
        if gone():
            raise SupersededError

    return check


@contextmanager
def turn(room: threading.Lock, check: Callable[[], None]) -> Iterator[None]:
    """Wait for a lock, and hold it; `check` is called while it waits, and raises if that is in vain."""
    while not room.acquire(timeout=_WAIT):
        check()
    try:
        yield
    finally:
        room.release()


class Lanes:
    """The number of the newest request of every lane; safe to use from several threads.

    A lane is a client with a word for what it asks: its coarse and its fine windows are answered apart.
    """

    def __init__(self) -> None:
        self._newest: OrderedDict[tuple[str, str], int] = OrderedDict()
        self._lock = threading.Lock()

    def enter(self, client: str, lane: str, number: int, gone: Callable[[], bool]) -> Callable[[], None]:
        """Note a request, and return what its computation calls between two pieces of work.

        Parameters
        ----------
        client, lane : str
        number : int
            Grows with the requests of a client.
        gone : callable
            Returns whether the client has closed its connection.

        Returns
        -------
        callable
            Raises SupersededError if the answer is no longer wanted.
        """
        key = client, lane
        with self._lock:
            self._newest[key] = max(number, self._newest.get(key, number))
            self._newest.move_to_end(key)
            if len(self._newest) > _MOST_LANES:
                self._newest.popitem(last=False)

        def check() -> None:
            if self._newest.get(key, number) > number or gone():
                raise SupersededError

        return check


@contextmanager
def ended_with(check: Callable[[], None]) -> Iterator[Callable[[Array], None]]:
    """Return a context that ends the motion which is followed in it when nobody waits for it any more.

    Parameters
    ----------
    check : callable
        Raises SupersededError where nobody waits; it is called by another thread.

    Yields
    ------
    callable
        Takes the times of the samples before they are integrated, as `sweep.motion.disk_path.follow` gives them. A
        kernel cannot be interrupted, but it reads the time of each sample when it comes to it: where all are zero
        nothing is left to do.

    Raises
    ------
    SupersededError
        If nobody waits for the motion.
    """
    done, gone = threading.Event(), threading.Event()
    followed: list[Array] = []

    def watch() -> None:
        while not done.wait(_LOOK):
            try:
                check()
            except (SupersededError, OSError):
                # a connection that cannot be looked at has ended too
                gone.set()
            if gone.is_set():
                for times in followed:
                    times[:] = 0.0

    def begun(times: Array) -> None:
        followed.append(times)
        if gone.is_set():
            raise SupersededError

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
            raise SupersededError
