"""Messages and progress on standard error, and the end of a command on Ctrl-C or SIGTERM."""

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
    """Print a result on standard output. `printable` escapes it: text from files must not control the terminal."""
    print("\n".join(map(printable, text.split("\n"))))


def say(text: str) -> None:
    """Print a message on standard error, as one line, escaped by `printable`."""
    print(f"eulerdisk: {printable(text)}", file=sys.stderr)


@contextmanager
def reporting(
    stream: TextIO | None = None, what: str = "cells", quiet: bool = False
) -> Iterator[Callable[[int, int], None]]:
    """Show progress as `showing` does, for work of a single stage: yield a function of (done, all).

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
    """A signal ended work whose unfinished result is useless."""


@contextmanager
def abandonable(output: Path) -> Iterator[Callable[[], None]]:
    """On a signal, abandon work whose unfinished result is useless; a second signal ends it at once.

    Yields a function for the work to call regularly: it ends the work if a signal has arrived.
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
            say(f"interrupted; {output} was not written, and no unfinished file remains.")
            raise typer.Exit(128 + arrived[0]) from None


@contextmanager
def stoppable(program: str | None = None) -> Iterator[Callable[[], bool]]:
    """On a signal, end the run after the current block, report the command that continues it, and exit.

    Yields a function that returns whether to stop. The signal handler only records the signal: an exception raised in
    it can get lost in a callback of the compiler. A second signal does not wait for the end of the block, which may
    take long. `program` is the word that starts this program in a shell, by default the one that started this process.
    """
    arrived: list[int] = []
    words = [program] if program else _program()
    again = f"To continue, run the same command again:\n    {shlex.join([*words, *sys.argv[1:]])}\n"

    def stop(number: int, _frame: FrameType | None) -> None:
        if arrived:
            # print is not reentrant, and the signal may have interrupted one
            _write_at_once(f"\neulerdisk: stopped at once; finished blocks are kept. {again}")
            os._exit(128 + number)
        arrived.append(number)
        _write_at_once("\neulerdisk: stopping after this block; a second signal stops at once\n")

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
    """Let a signal that has a handler end the process while a kernel is compiled.

    Python runs its handlers between two of its instructions, and the compiler may spend a minute in one instruction. A
    thread receives the signal at once.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    receiver, sender = socket.socketpair()
    sender.setblocking(False)
    before = signal.set_wakeup_fd(sender.fileno(), warn_on_full_buffer=False)
    listener = threading.Thread(target=_end_if_compiling, args=(receiver,), daemon=True)
    listener.start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(before)
        sender.close()
        listener.join(2.0 * _PATIENCE)
        receiver.close()


def _end_if_compiling(receiver: socket.socket) -> None:
    while numbers := receiver.recv(16):
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
    # a closed terminal must not keep a run from stopping
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
    """Return the words that start this program in the user's shell."""
    started = sys.argv[0]
    if os.path.basename(started) == "__main__.py":
        return [sys.executable, "-m", "sweep"]
    found = shutil.which("eulerdisk")
    # The bare name if the shell would find this program by it; otherwise its path (the environment is not activated).
    return ["eulerdisk"] if found and os.path.realpath(found) == os.path.realpath(started) else [started]
