"""Whose turn it is: one thread at a time calls kernels, and of the requests of one lane only the latest is answered."""

import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from sweep.errors import RequestError

#: Kernels use all processors by themselves: the threads that answer requests call them one after another.
KERNELS = threading.RLock()

#: One motion at a time is followed, beside the maps: one that takes minutes, of an odd disk or with a tiny loss, holds
#: up motions alone.
_MOTIONS = threading.Lock()

#: Seconds that a motion waits for the one before it.
PATIENCE = 10.0

#: Files with the cells of a window, and windows of more than `LARGE` pixels, that are made at a time: each takes some
#: 100 MB, and a server would take as much memory as it is asked for at once.
FILES, LARGE_WINDOWS, LARGE = threading.Semaphore(1), threading.Semaphore(2), 1_000_000

#: Seconds after which one that waits for its turn looks whether anybody still waits for it.
_WAIT = 0.1

#: Lanes that are remembered: a page has a few, and a page that was left is never heard of again.
_MOST_LANES = 256


class BusyError(RequestError):
    """Another motion is still being followed: what was asked for is possible, and may be asked for again."""


class SupersededError(Exception):
    """Nobody waits for the answer any more: a newer request of the same lane came, or the client has gone."""


def still_there(gone: Callable[[], bool]) -> Callable[[], None]:
    """Return a function that raises SupersededError where the client has gone."""

    def check() -> None:
        if gone():
            raise SupersededError

    return check


@contextmanager
def motion_turn(check: Callable[[], None]) -> Iterator[None]:
    """Wait until no other motion is followed; `check` is called while it waits, and raises if that is in vain.

    Raises
    ------
    BusyError
        If that takes too long.
    """
    end = time.monotonic() + PATIENCE
    while not _MOTIONS.acquire(timeout=min(_WAIT, PATIENCE)):
        check()
        if time.monotonic() > end:
            raise BusyError(
                f"The motion that was asked for before is still being followed after {PATIENCE:g} s.",
                hint="Wait for it, or start the explorer again.",
                where="motion",
            )
    try:
        yield
    finally:
        _MOTIONS.release()


@contextmanager
def turn(room: threading.Semaphore, check: Callable[[], None]) -> Iterator[None]:
    """Wait until there is room, and take it; `check` is called while it waits, and raises if that is in vain."""
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
