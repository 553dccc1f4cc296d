"""Who computes the missing blocks of a run, and how the others hear of it; here: this process."""

from collections.abc import Callable, Generator, Iterator, Sequence

from sweep.engine.ahead import ahead
from sweep.engine.runner import Columns, compute, use_threads
from sweep.runs.journal import Journal

#: Called with the cells computed so far and the cells in all.
Progress = Callable[[int, int], None]

#: Called with a sentence for the user.
Say = Callable[[str], None]

#: Asked before every block whether the run should end here.
Stopping = Callable[[], bool]

#: The number of a block that is kept in the journal now, and its columns if they are still in memory.
Kept = tuple[int, Columns | None]

#: Computes blocks of a journal, by number, until `Stopping` says so, and yields each when it is kept there.
Driver = Callable[[Journal, Sequence[int], Stopping], Iterator[Kept]]


def here(threads: int | None) -> Driver:
    """Return the driver that computes in this process: computing, keeping and what the caller does overlap."""

    def drive(book: Journal, numbers: Sequence[int], stopping: Stopping) -> Iterator[Kept]:
        def computing() -> Generator[tuple[int, Columns], None, None]:
            use_threads(threads)
            for number in numbers:
                if stopping():
                    return
                yield number, compute(book.manifest.spec, book.spans[number])

        def keeping() -> Generator[tuple[int, Columns], None, None]:
            with ahead(computing()) as computed:
                for number, columns in computed:
                    book.keep(number, columns)
                    yield number, columns

        with ahead(keeping()) as kept:
            yield from kept

    return drive


def unheard(*_: object) -> None:
    """Nobody listens."""
