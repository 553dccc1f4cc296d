"""How far a run is: a bar with the time to go on a terminal, a line now and then in a log."""

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO

from sweep.engine import estimate
from sweep.runs.executor import Progress

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


def say(text: str) -> None:
    """Tell the user a sentence."""
    print(f"eulerdisk: {text}", file=sys.stderr)


def remaining(elapsed: float, done: int, size: int) -> float:
    """Return the seconds to go if the rest is like what is done (`done` > 0)."""
    return elapsed * (size - done) / done


class _Pace:
    """Seconds to go, at the pace since the first report: the blocks of an earlier run took no time in this one."""

    def __init__(self) -> None:
        self._began = time.monotonic()
        self._first: tuple[float, int] | None = None

    def to_go(self, done: int, size: int) -> float:
        now = time.monotonic()
        self._first = self._first or (now, done)
        since, before = self._first if done > self._first[1] else (self._began, 0)
        return remaining(now - since, done - before, size - before)


def _log(stream: TextIO, what: str) -> Progress:
    last, pace = time.monotonic(), _Pace()

    def progress(done: int, size: int) -> None:
        nonlocal last
        to_go = estimate.duration(pace.to_go(done, size))
        if time.monotonic() - last >= _EVERY:
            last = time.monotonic()
            print(
                f"eulerdisk: {done} of {size} {what} ({100 * done / size:.0f} %), {to_go} to go",
                file=stream,
                flush=True,
            )

    return progress


@contextmanager
def _bar(stream: TextIO, what: str) -> Iterator[Progress]:
    from rich.console import Console
    from rich.progress import BarColumn, TaskProgressColumn, TextColumn
    from rich.progress import Progress as Bar

    pace = _Pace()
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TextColumn("{task.fields[to_go]}"),
    )
    with Bar(*columns, console=Console(file=stream)) as bar:
        task = bar.add_task("preparing", total=None, to_go="")

        def progress(done: int, size: int) -> None:
            to_go = f"{estimate.duration(pace.to_go(done, size))} to go"
            bar.update(task, description=what, completed=done, total=size, to_go=to_go)

        yield progress
