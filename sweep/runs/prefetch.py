"""A generator that runs ahead of its consumer in a thread of its own."""

from collections import deque
from collections.abc import Generator, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from typing import Final, TypeVar

T = TypeVar("T")

#: Items that are computed or wait to be taken: one in the making and one that is ready, so that neither side waits for
#: the other where items differ in their cost.
_AHEAD: Final = 2


@contextmanager
def prefetch(items: Generator[T, None, None]) -> Iterator[Iterator[T]]:
    """Give the items of a generator that runs in another thread, always the same one.

    Parameters
    ----------
    items : generator

    Raises
    ------
    BaseException
        Whatever the generator raised, where the consumer takes its next item. When the consumer leaves early, the item
        in the making is finished and dropped, and the generator is closed.
    """
    pool = ThreadPoolExecutor(max_workers=1)
    ended = object()

    def taken() -> Iterator[T]:
        waiting: deque[Future[T | object]] = deque(pool.submit(next, items, ended) for _ in range(_AHEAD))
        while (item := waiting.popleft().result()) is not ended:
            waiting.append(pool.submit(next, items, ended))
            yield item  # type: ignore[misc]  # only `ended` is no T
            # while the next item is waited for, this one need not be in memory
            del item

    try:
        yield taken()
    finally:
        # waits for the item in the making; then no thread uses the generator
        pool.shutdown(cancel_futures=True)
        items.close()
