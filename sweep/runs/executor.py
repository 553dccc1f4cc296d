"""The interface of executors, which compute the missing blocks of a run; and the one that computes in this process."""

from collections.abc import Callable, Generator, Iterator, Sequence
from typing import NamedTuple

from sweep.engine.compute import measure_block, use_threads
from sweep.runs.journal import Columns, Journal
from sweep.runs.prefetch import prefetch

#: Called with the number of cells that are computed and the number of all cells.
Progress = Callable[[int, int], None]

#: Called with a sentence for the user.
Say = Callable[[str], None]

#: Returns whether the run should end before its next block.
Stopping = Callable[[], bool]


class FinishedBlock(NamedTuple):
    """A block that is kept in the journal: its number, and its measured columns if they are still in memory."""

    number: int
    measured: Columns | None


#: Computes the numbered blocks of a journal until `Stopping` returns true, and yields each one when it is kept there.
Executor = Callable[[Journal, Sequence[int], Stopping], Iterator[FinishedBlock]]


def local(threads: int | None) -> Executor:
    """Return the executor that computes in this process.

    One thread computes, one keeps finished blocks, and the caller uses them; the three overlap. Blocks come in the
    order in which they were asked for.
    """

    def execute(journal: Journal, numbers: Sequence[int], stopping: Stopping) -> Iterator[FinishedBlock]:
        def computed() -> Generator[tuple[int, Columns], None, None]:
            use_threads(threads)
            for number in numbers:
                if stopping():
                    return
                yield number, measure_block(journal.spec, journal.spans[number])

        def kept() -> Generator[FinishedBlock, None, None]:
            with prefetch(computed()) as blocks:
                for number, measured in blocks:
                    journal.keep(number, measured)
                    yield FinishedBlock(number, measured)

        with prefetch(kept()) as finished:
            yield from finished

    return execute


def no_op(*_: object) -> None:
    """Ignore a call of `Progress` or `Say`."""
