"""A motion that nobody waits for any more is not followed to its end."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from sweep.explorer.turns import SupersededError
from sweep.model.quantity import Array

#: Seconds between two looks at whether somebody still waits. Most motions have come to their end before the first.
_LOOK = 0.05


@contextmanager
def abandoned_with(check: Callable[[], None]) -> Iterator[Callable[[Array], None]]:
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
    watch = _Watch(check)
    thread = threading.Thread(target=watch.run, name="motion watch", daemon=True)
    check()
    thread.start()
    try:
        yield watch.begun
    finally:
        watch.done.set()
        thread.join()
        # before whatever a motion without times is refused for
        watch.raise_if_gone()


class _Watch:
    """Looks whether somebody waits, and takes the times away if nobody does."""

    def __init__(self, check: Callable[[], None]) -> None:
        self._check = check
        self._times: Array | None = None
        self._gone = False
        self.done = threading.Event()

    def begun(self, times: Array) -> None:
        self._times = times
        self.raise_if_gone()

    def raise_if_gone(self) -> None:
        if self._gone:
            raise SupersededError

    def run(self) -> None:
        while not self.done.wait(_LOOK):
            try:
                self._check()
            except (SupersededError, OSError):
                # a connection that cannot be looked at has ended too
                self._gone = True
            if self._gone and self._times is not None:
                self._times[:] = 0.0
