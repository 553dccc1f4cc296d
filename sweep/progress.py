"""How far a run is: a bar with the time to go on a terminal, a line now and then in a log."""

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO

from sweep.store import Progress

#: Seconds between two lines in a log.
_EVERY = 10.0


@contextmanager
def reporting(stream: TextIO | None = None, what: str = "cells") -> Iterator[Progress]:
    """Give a callable that shows how many are done, and in all, on `stream`, standard error if not given."""
    stream = stream or sys.stderr
    if stream.isatty():
        with _bar(stream, what) as progress:
            yield progress
    else:
        yield _log(stream, what)


def remaining(elapsed: float, done: int, size: int) -> float:
    """Return the seconds to go if the rest is like what is done (`done` > 0)."""
    return elapsed * (size - done) / done


def _log(stream: TextIO, what: str) -> Progress:
    began = last = time.monotonic()

    def progress(done: int, size: int) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last >= _EVERY:
            last = now
            to_go = remaining(now - began, done, size)
            print(
                f"eulerdisk: {done} of {size} {what} ({100 * done / size:.0f} %), {to_go:.0f} s to go",
                file=stream,
                flush=True,
            )

    return progress


@contextmanager
def _bar(stream: TextIO, what: str) -> Iterator[Progress]:
    from rich.console import Console
    from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    with Bar(*columns, console=Console(file=stream)) as bar:
        task = bar.add_task("preparing", total=None)

        def progress(done: int, size: int) -> None:
            bar.update(task, description=what, completed=done, total=size)

        yield progress
