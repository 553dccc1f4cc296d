"""Messages and progress on standard error, and how a command ends on Ctrl-C and SIGTERM."""

import os
import shlex
import shutil
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import Event, Thread
from types import FrameType
from typing import TYPE_CHECKING, TextIO

import typer

from sweep.errors import StoppedError, printable

if TYPE_CHECKING:
    from sweep.runs.progress import Show, Status

#: Seconds between two lines in a log.
_LOG_INTERVAL = 5.0


def show(text: str) -> None:
    """Print a result on standard output, its lines escaped by `printable`: words from files are no commands."""
    print("\n".join(map(printable, text.split("\n"))))


def say(text: str) -> None:
    """Print a message on standard error, in one line that prints."""
    print(f"eulerdisk: {printable(text)}", file=sys.stderr)


@contextmanager
def showing(stream: TextIO | None = None, quiet: bool = False) -> Iterator["Show"]:
    """Yield a function that shows the status of a run: a bar on a terminal, a line every few seconds in a log.

    The progress is shown on standard error if no stream is given, and not at all if `quiet`.
    """
    stream = stream or sys.stderr
    if quiet:
        yield lambda _: None
        return
    with _bar(stream) if stream.isatty() else _log(stream) as show:
        yield show


@contextmanager
def reporting(
    stream: TextIO | None = None, what: str = "cells", quiet: bool = False
) -> Iterator[Callable[[int, int], None]]:
    """Do what `showing` does for work of a single stage: yield a function of (done, all).

    `what` names the things that are counted.
    """
    # not at the top: it loads numpy, which `eulerdisk --help` does not need
    from sweep.runs.progress import COMPUTING, Stage, Timetable

    with showing(stream, quiet) as show:
        timetable: Timetable | None = None

        def progress(done: int, size: int) -> None:
            nonlocal timetable
            if timetable is None:
                timetable = Timetable([Stage(COMPUTING, size)], show, time.monotonic, what)
                timetable.begin(COMPUTING, done)
            else:
                timetable.report(done)

        yield progress


class _Latest:
    """The latest status, and the words for what is left of it as time goes by."""

    def __init__(self) -> None:
        self.status: Status | None = None
        self._at = 0.0

    def take(self, status: "Status") -> None:
        """Take the place of the status before."""
        self._at, self.status = time.monotonic(), status

    def to_go(self) -> str:
        """Return how long all will take from now on; empty if that is not known, or if all is done."""
        # not at the top: it loads numpy, which `eulerdisk --help` does not need
        from sweep.engine.estimate import duration

        if self.status is None or not self.status.seconds:
            return ""
        # as long as there is something to do it takes some time, however long it was expected to take
        return f"{duration(max(1.0, self.status.seconds - (time.monotonic() - self._at)))} to go"

    def line(self) -> str:
        """Return the line of a log."""
        if self.status is None:
            return f"{_utc()} preparing"
        done, size = self.status.done, self.status.size
        share = f" {done} of {size} {self.status.things} ({100 * done / size:.0f} %)" if size else ""
        return ", ".join(filter(None, (f"{_utc()} {self.status.stage}{share}", self.to_go())))


def _utc() -> str:
    return time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(time.time()))


@contextmanager
def _log(stream: TextIO) -> Iterator["Show"]:
    latest, ended = _Latest(), Event()

    def write() -> None:
        while not ended.wait(_LOG_INTERVAL):
            print(f"eulerdisk: {latest.line()}", file=stream, flush=True)

    # a thread, because a block or the search for a boundary may take minutes without a word
    writer = Thread(target=write, daemon=True)
    writer.start()
    try:
        yield latest.take
    finally:
        ended.set()
        writer.join()


@contextmanager
def _bar(stream: TextIO) -> Iterator["Show"]:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, ProgressColumn, Task, TaskProgressColumn, TextColumn
    from rich.text import Text

    latest = _Latest()

    class ToGo(ProgressColumn):
        def render(self, task: Task) -> Text:
            return Text(latest.to_go())

    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), ToGo())
    with Progress(*columns, console=Console(file=stream)) as bar:
        task = bar.add_task("preparing", total=None)

        def show(status: "Status") -> None:
            latest.take(status)
            bar.update(task, description=status.stage, completed=status.done, total=status.size or None)

        yield show


class _Abandoned(BaseException):
    """A signal ended work whose unfinished result is of no use."""


@contextmanager
def abandonable(output: Path) -> Iterator[Callable[[], None]]:
    """On a signal, give up the work, whose unfinished result is of no use; a second signal does not wait.

    Yields a function to be called regularly: it ends the work if a signal has arrived.
    """
    arrived: list[int] = []

    def check() -> None:
        if arrived:
            raise _Abandoned

    def stop(number: int, _frame: FrameType | None) -> None:
        check()
        arrived.append(number)

    with _handling(stop):
        try:
            yield check
        except _Abandoned:
            say(f"interrupted; {output} was not written, nothing is left behind.")
            raise typer.Exit(128 + arrived[0]) from None


@contextmanager
def stoppable(program: str | None = None) -> Iterator[Callable[[], bool]]:
    """On a signal, end the run after the current block, say which command continues it, and exit.

    Yields a function that returns whether to stop. The signal handler only records the signal: an exception raised in
    it can get lost in a callback of the compiler. A second signal does not wait for the end of the block, which may
    take long. `program` is the word that starts this program in a shell, by default that of this process.
    """
    arrived: list[int] = []
    words = [program] if program else _program()
    again = f"To go on, run the same command again:\n    {shlex.join([*words, *sys.argv[1:]])}\n"

    def stop(number: int, _frame: FrameType | None) -> None:
        if arrived:
            # not print, which is not reentrant: the signal may have interrupted a print
            _write_at_once(f"\neulerdisk: stopped at once; finished blocks are kept. {again}")
            os._exit(128 + number)
        arrived.append(number)
        _write_at_once("\neulerdisk: stopping when this block is done; a second signal stops at once\n")

    with _handling(stop):
        try:
            yield lambda: bool(arrived)
        except StoppedError as end:
            print(f"eulerdisk: interrupted; {end}. {again}", end="", file=sys.stderr)
            raise typer.Exit(128 + arrived[0]) from None


def _write_at_once(text: str) -> None:
    # a terminal that has gone does not keep a run from stopping
    with suppress(OSError):
        os.write(2, text.encode(errors="backslashreplace"))


@contextmanager
def _handling(stop: Callable[[int, FrameType | None], None]) -> Iterator[None]:
    before = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _program() -> list[str]:
    """Return the words that start this program from the shell that has started it."""
    started = sys.argv[0]
    if os.path.basename(started) == "__main__.py":
        return [sys.executable, "-m", "sweep"]
    found = shutil.which("eulerdisk")
    # The bare name if the shell finds this program under it; else the path of the call (environment not activated).
    return ["eulerdisk"] if found and os.path.realpath(found) == os.path.realpath(started) else [started]
