"""Ctrl-C and SIGTERM while something is computed."""

import os
import shlex
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

import typer

from sweep.errors import StoppedError


@contextmanager
def stoppable() -> Iterator[Callable[[], bool]]:
    """Turn Ctrl-C and SIGTERM into the end of the block, a message and an exit status.

    Gives what says whether to stop. The handler only takes note: an exception out of it could get lost in a callback
    of the compiler. A second signal does not wait for the block, which may be inside a kernel for long.
    """
    arrived: list[int] = []
    again = f"To go on, run the same command again:\n    {shlex.join(['eulerdisk', *sys.argv[1:]])}\n"

    def stop(number: int, _frame: FrameType | None) -> None:
        if arrived:
            # not print: the signal may have come in the middle of one
            os.write(2, f"\neulerdisk: stopped at once; finished blocks are kept. {again}".encode())
            os._exit(128 + number)
        arrived.append(number)

    before = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
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
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
