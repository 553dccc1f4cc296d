"""The interface of executors, which compute the missing blocks of a run, and the one that computes in this process."""

import signal
import threading
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from types import FrameType
from typing import Final

from sweep.engine.compute import measure_block, use_threads
from sweep.errors import StoppedError
from sweep.runs.journal import Columns, Journal

#: Items that are being computed or wait to be used: one of each kind, so that neither thread waits for the other where
#: items differ in their cost.
_AHEAD: Final = 2


@contextmanager
def prefetch[T](items: Generator[T]) -> Iterator[Iterator[T]]:
    """Give the items of a generator that runs in another thread, always the same one.

    What the generator raises is raised where the consumer takes its next item. When the consumer stops early, the item
    that is being computed is finished and discarded, and the generator is closed.
    """
    pool = ThreadPoolExecutor(max_workers=1)
    ended = object()

    def taken() -> Iterator[T]:
        waiting: deque[Future[T | object]] = deque(pool.submit(next, items, ended) for _ in range(_AHEAD))
        while (item := waiting.popleft().result()) is not ended:
            waiting.append(pool.submit(next, items, ended))
            yield item  # type: ignore[misc]  # only `ended` is no T
            # free the memory of this item before waiting for the next one
            del item

    try:
        yield taken()
    finally:
        # shutdown waits for the item that is being computed; after it no thread uses the generator
        pool.shutdown(cancel_futures=True)
        items.close()


#: Called with a sentence for the user.
Say = Callable[[str], None]

#: Returns whether the run should end before its next block.
Stopping = Callable[[], bool]

#: A block that is kept in the journal: its number, and its measured columns if they are still in memory.
FinishedBlock = tuple[int, Columns | None]

#: Computes the numbered blocks of a journal until `Stopping` returns true, and yields each one when it is kept there.
Executor = Callable[[Journal, Sequence[int], Stopping], Iterator[FinishedBlock]]


def local(threads: int | None) -> Executor:
    """Return the executor that computes in this process.

    One thread computes, one keeps finished blocks, and the caller uses them; the three overlap. Blocks come in the
    order in which they were asked for.
    """

    def execute(journal: Journal, numbers: Sequence[int], stopping: Stopping) -> Iterator[FinishedBlock]:
        def computed() -> Generator[tuple[int, Columns]]:
            use_threads(threads)
            for number in numbers:
                if stopping():
                    return
                yield number, measure_block(journal.spec, journal.spans[number])

        def kept() -> Generator[FinishedBlock]:
            with prefetch(computed()) as blocks:
                for number, measured in blocks:
                    journal.keep(number, measured)
                    yield number, measured

        with prefetch(kept()) as finished:
            yield from finished

    return execute


def no_op(*_: object) -> None:
    """Ignore a call of `Show` or `Say`."""


@contextmanager
def interruptible(
    stopping: Stopping | None = None, advice: str = "To go on, give the same call again."
) -> Iterator[Stopping]:
    """Let SIGINT end the work within after its current block, and raise a KeyboardInterrupt that says what is kept.

    A second SIGINT raises where it arrives, as it would without this. A handler of the caller stays in charge, and so
    does Python outside the main thread, where no handler can be set.

    Parameters
    ----------
    stopping : callable, optional
        Of a caller that says itself when the work is to stop; SIGINT is left alone then.
    advice : str
        The sentence that says what to do after an interrupt.

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
        raise KeyboardInterrupt(f"{end}. {advice}") from None
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if arrived:
        raise KeyboardInterrupt("all was done when it came.")


def _python_handles() -> bool:
    """Return whether SIGINT raises KeyboardInterrupt in this thread: no one else has a use for it."""
    in_main = threading.current_thread() is threading.main_thread()
    return in_main and signal.getsignal(signal.SIGINT) is signal.default_int_handler
