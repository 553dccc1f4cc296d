"""A second process that compiles entry points while this one compiles others.

Numba's own Python code takes two thirds of the time of a compilation, so that threads would not help. The second
process leaves what it made in the cache; whatever goes wrong with it costs the time of compiling in this process.
"""

import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from typing import TYPE_CHECKING

from sweep.platforms import usual_threads

if TYPE_CHECKING:
    import subprocess

#: Seconds after which a second process that has not ended is given up; it takes about 6.
_PATIENCE = 60.0

#: The same where this process is not to compile: beside ten others that compute it took two minutes.
_MORE_PATIENCE = 600.0


class SecondProcess:
    """Compiles entry points one after the other, once it is started.

    Parameters
    ----------
    entries : sequence of str
        Each as ``module:function``.
    """

    def __init__(self, entries: Sequence[str]) -> None:
        self._entries, self._over = entries, False
        self._process: subprocess.Popen[bytes] | None = None

    def start(self) -> bool:
        """Begin to compile, if there is a processor for it and nobody waits yet; returns whether it has begun."""
        return usual_threads() > 1 and self._start()

    def _start(self) -> bool:
        import subprocess

        # the program that a frozen application is made of is no Python interpreter
        is_python = bool(sys.executable) and not getattr(sys, "frozen", False)
        if self._over or self._process is not None or not self._entries or not is_python:
            return False
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        line = [sys.executable, "-m", "sweep.model.compile_entry", *self._entries]
        nothing = subprocess.DEVNULL
        with suppress(OSError):
            self._process = subprocess.Popen(
                line, env=environment, stdin=nothing, stdout=nothing, stderr=nothing
            )
        return self._process is not None

    def wait(self, patience: float | None = None) -> None:
        """Return when it has ended, at once if it was not started; from now on it is not.

        Parameters
        ----------
        patience : float, optional
            Seconds after which it is given up.
        """
        process, self._process, self._over = self._process, None, True
        if process is None:
            return
        import subprocess

        try:
            with suppress(subprocess.TimeoutExpired):
                process.wait(_PATIENCE if patience is None else patience)
        finally:
            # also where this process is told to end meanwhile
            if process.poll() is None:
                process.kill()
                process.wait()


def compiled_by_another(entries: Sequence[str]) -> None:
    """Let another process compile entry points, those that are not kept, and wait for it: also with one processor."""
    other = SecondProcess(entries)
    other._start()
    other.wait(_MORE_PATIENCE)
