"""An iterator that works ahead in a thread of its own, a bounded number of items."""

import queue
import threading
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from typing import TypeVar

T = TypeVar("T")


@contextmanager
def ahead(items: Generator[T, None, None], depth: int = 1) -> Iterator[Iterator[T]]:
    """Give the items of a generator that runs in another thread.

    Parameters
    ----------
    items : generator
        Used by the other thread alone, and closed by it.
    depth : int
        Items that may wait to be taken.

    Raises
    ------
    BaseException
        Whatever the generator raised, where its next item would be taken. On leaving early, the item in the making
        is finished and dropped.
    """
    # an item stands in a list of its own; an exception is one; None is the end
    ready: queue.Queue[list[T] | BaseException | None] = queue.Queue(depth)
    left = threading.Event()

    def offer(entry: list[T] | BaseException | None) -> None:
        while not left.is_set():
            try:
                return ready.put(entry, timeout=0.05)
            except queue.Full:
                continue

    def work() -> None:
        try:
            for item in items:
                offer([item])
                if left.is_set():
                    break
            items.close()
            offer(None)
        except BaseException as problem:
            offer(problem)

    def taken() -> Iterator[T]:
        while (entry := ready.get()) is not None:
            if isinstance(entry, BaseException):
                raise entry
            yield entry[0]
            del entry

    worker = threading.Thread(target=work, daemon=True)
    worker.start()
    try:
        yield taken()
    finally:
        left.set()
        worker.join()
