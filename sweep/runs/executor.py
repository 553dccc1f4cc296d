"""The interface of executors, which compute the missing blocks of a run, and the executor for this process."""

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

#: Number of items ahead: one in computation and one ready, so that no thread waits if the costs of items differ.
_AHEAD: Final = 2


@contextmanager
def prefetch[T](items: Generator[T]) -> Iterator[Iterator[T]]:
    """Yield an iterator over the items of a generator, which runs in one other thread.

    An error in the generator is raised where the consumer takes its next item. If the consumer stops early, the item in
    computation is finished and discarded, and the generator is closed.
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
        # shutdown waits for the item in computation; after that no thread uses the generator
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

    One thread computes blocks, one writes them to the journal, and the caller uses them, all at the same time. Blocks
    come in the requested order.
    """

    def execute(journal: Journal, numbers: Sequence[int], stopping: Stopping) -> Iterator[FinishedBlock]:
        def compute_blocks() -> Generator[tuple[int, Columns]]:
            use_threads(threads)
            for number in numbers:
                if stopping():
                    return
                yield number, measure_block(journal.spec, journal.spans[number])

        def keep_blocks() -> Generator[FinishedBlock]:
            with prefetch(compute_blocks()) as blocks:
                for number, measured in blocks:
                    journal.keep(number, measured)
                    yield number, measured

        with prefetch(keep_blocks()) as finished:
            yield from finished

    return execute


def no_op(*_: object) -> None:
    """Ignore a call of `Show` or `Say`."""


@contextmanager
def interruptible(
    stopping: Stopping | None = None, advice: str = "To continue, make the same call again."
) -> Iterator[Stopping]:
    """Make SIGINT end the ``with`` block after its current block, with a KeyboardInterrupt that says what is kept.

    A second SIGINT raises at once, as it would without this. The handler is not set if the caller has its own handler,
    nor outside the main thread, where Python allows none.

    Parameters
    ----------
    stopping : callable, optional
        The caller's own function for when to stop; SIGINT is not handled then.
    advice : str
        A sentence about what to do after an interrupt.

    Yields
    ------
    callable
        Returns whether to stop.
    """
    if stopping is not None or not _python_handles():
        yield stopping or (lambda: False)
        return
    arrived = False

    # only records the signal: an exception could get lost in a callback of the compiler, or interrupt the journal
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
        raise KeyboardInterrupt("all work was done when the interrupt came.")


def _python_handles() -> bool:
    """Return whether SIGINT raises KeyboardInterrupt in this thread, so that no other handler is replaced."""
    in_main = threading.current_thread() is threading.main_thread()
    return in_main and signal.getsignal(signal.SIGINT) is signal.default_int_handler
