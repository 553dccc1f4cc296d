"""Ctrl-C and SIGTERM while something is computed."""

import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

import typer


class _Stopped(BaseException):
    """A signal asked the run to end."""


@contextmanager
def stoppable(output: Path) -> Iterator[Callable[[], None]]:
    """Turn Ctrl-C and SIGTERM into a message and an exit status.

    Gives what is to be called after each block: it ends the run if a signal has come. An exception out of a signal
    handler can get lost in a callback of the compiler, so that only a second signal raises one.
    """
    arrived: list[int] = []

    def check() -> None:
        if arrived:
            raise _Stopped

    def stop(number: int, _frame: FrameType | None) -> None:
        check()
        arrived.append(number)

    before = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield check
    except _Stopped:
        print(f"eulerdisk: interrupted; {output} was not written, nothing is left behind.", file=sys.stderr)
        raise typer.Exit(128 + arrived[0]) from None
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
