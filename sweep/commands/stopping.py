"""Ctrl-C and SIGTERM while something is computed."""

import os
import shlex
import shutil
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

import typer

from sweep.errors import StoppedError


class _Stopped(BaseException):
    """A signal asked for the end of something that is worth nothing unfinished."""


@contextmanager
def abandonable(output: Path) -> Iterator[Callable[[], None]]:
    """As `stoppable`, for a file that is worth nothing unfinished.

    Gives what is to be called now and then: it ends the work if a signal has come. A second signal ends it at once.
    """
    arrived: list[int] = []

    def check() -> None:
        if arrived:
            raise _Stopped

    def stop(number: int, _frame: FrameType | None) -> None:
        check()
        arrived.append(number)

    with _handling(stop):
        try:
            yield check
        except _Stopped:
            print(
                f"eulerdisk: interrupted; {output} was not written, nothing is left behind.", file=sys.stderr
            )
            raise typer.Exit(128 + arrived[0]) from None


@contextmanager
def _handling(stop: Callable[[int, FrameType | None], None]) -> Iterator[None]:
    before = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def stoppable(program: str | None = None) -> Iterator[Callable[[], bool]]:
    """Turn Ctrl-C and SIGTERM into the end of the block, a message with the command that goes on, and an exit status.

    Gives what says whether to stop. The handler only takes note: an exception out of it could get lost in a callback
    of the compiler. A second signal does not wait for the block, which may be inside a kernel for long.
    """
    arrived: list[int] = []
    words = [program] if program else _program()
    again = f"To go on, run the same command again:\n    {shlex.join([*words, *sys.argv[1:]])}\n"

    def stop(number: int, _frame: FrameType | None) -> None:
        if arrived:
            # not print: the signal may have come in the middle of one
            os.write(2, f"\neulerdisk: stopped at once; finished blocks are kept. {again}".encode())
            os._exit(128 + number)
        arrived.append(number)
        os.write(2, b"\neulerdisk: stopping when this block is done; a second signal stops at once\n")

    with _handling(stop):
        try:
            yield lambda: bool(arrived)
        except StoppedError as end:
            kept = (
                f"{end.done} of {end.blocks} blocks are kept in {end.folder}"
                if end.done
                else "no block was finished"
            )
            print(f"eulerdisk: interrupted; {kept}. {again}", end="", file=sys.stderr)
            raise typer.Exit(128 + arrived[0]) from None


def _program() -> list[str]:
    """Return the words that start this program from the shell that has started it."""
    started = sys.argv[0]
    if os.path.basename(started) == "__main__.py":
        return [sys.executable, "-m", "sweep"]
    found = shutil.which("eulerdisk")
    # by its name, where that leads here; otherwise as it was called, for instance out of an environment not activated
    return ["eulerdisk"] if found and os.path.realpath(found) == os.path.realpath(started) else [started]
