"""Messages and progress on standard error, and how a command ends on Ctrl-C and SIGTERM."""

import os
import shlex
import shutil
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import TextIO

import typer

from sweep.errors import StoppedError, printable
from sweep.model.kernel import is_compiling
from sweep.progress.display import showing
from sweep.progress.timetable import COMPUTING, Stage, Timetable


def show(text: str) -> None:
    """Print a result on standard output, its lines escaped by `printable`: words from files are no commands."""
    print("\n".join(map(printable, text.split("\n"))))


def say(text: str) -> None:
    """Print a message on standard error, in one line that prints."""
    print(f"eulerdisk: {printable(text)}", file=sys.stderr)


@contextmanager
def reporting(
    stream: TextIO | None = None, what: str = "cells", quiet: bool = False
) -> Iterator[Callable[[int, int], None]]:
    """Do what `showing` does for work of a single stage: yield a function of (done, all).

    `what` names the things that are counted.
    """
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


#: Seconds that a signal waits for the compiler before it ends the process.
_PATIENCE = 0.5


@contextmanager
def ended_while_compiling() -> Iterator[None]:
    """Let a signal that has a handler end the process while a kernel is compiled: the compiler asks for none.

    Python's own handlers run between two of its instructions, and the compiler may be in one of them for a minute. A
    thread hears of the signal at once.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    heard, told = socket.socketpair()
    told.setblocking(False)
    before = signal.set_wakeup_fd(told.fileno(), warn_on_full_buffer=False)
    listener = threading.Thread(target=_end_if_compiling, args=(heard,), daemon=True)
    listener.start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(before)
        told.close()
        listener.join(2.0 * _PATIENCE)
        heard.close()


def _end_if_compiling(heard: socket.socket) -> None:
    while numbers := heard.recv(16):
        if not is_compiling():
            continue
        time.sleep(_PATIENCE)
        if is_compiling():
            _write_at_once(
                "\neulerdisk: interrupted while a kernel was compiled; finished blocks are kept, and no unfinished "
                "file was written.\n"
            )
            os._exit(128 + numbers[0])


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
