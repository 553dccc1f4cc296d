"""The process of a command: its standard streams, its warnings and its exit status.

A message that cannot be shown does not end a run: errors of standard error are ignored. A result that cannot be shown
ends the command with status 3, like a file that cannot be written.
"""

import errno
import io
import os
import signal
import sys
import traceback
import warnings
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from sweep.commands.terminal import say
from sweep.errors import LeftOutWarning, RequestError, StorageError, SurroundingsWarning, printable
from sweep.version import __version__

#: Exit status for a defect of the program: EX_SOFTWARE of sysexits.h.
DEFECT = 70

#: System errors that this program cannot cause: disk space, permissions, devices, and limits of a process.
_SURROUNDINGS = (
    errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EROFS, errno.EACCES, errno.EPERM, errno.EMFILE,
    errno.ENFILE, errno.ENOMEM, errno.EAGAIN, errno.ESTALE, errno.ENODEV, errno.ETIMEDOUT, errno.EBUSY,
)  # fmt: skip

#: Warnings about what a user can fix: the content of a file, and the program's environment.
_FOR_USERS = LeftOutWarning, SurroundingsWarning


class _Messages(io.RawIOBase):
    """Standard error without exceptions: a closed terminal or a full disk does not end a run."""

    def writable(self) -> bool:
        return True

    def fileno(self) -> int:
        return 2

    def isatty(self) -> bool:
        return os.isatty(2)

    def write(self, text: Any) -> int:
        with suppress(OSError):
            os.write(2, text)
        return len(text)


def open_streams() -> None:
    """Give the process three standard streams, even if it was started without them.

    The next file to be opened takes the number of a closed stream, so a library's messages could go into an atlas.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
    # tests that capture the output have their own streams
    if isinstance(sys.stdout, io.TextIOWrapper) and sys.stdout is sys.__stdout__:
        sys.stdout.reconfigure(errors="backslashreplace")
    if sys.stderr is sys.__stderr__:
        encoding = sys.stderr.encoding if sys.stderr else "utf-8"
        sys.stderr = io.TextIOWrapper(
            _Messages(), encoding, "backslashreplace", line_buffering=True, write_through=True
        )


def tell_warnings() -> None:
    """Print warnings for users in one line, like other messages; show other warnings as before."""
    before, shown_once = warnings.showwarning, set[str]()

    def show(message: Warning | str, category: type[Warning], *place: Any) -> None:
        if issubclass(category, _FOR_USERS):
            # Python forgets which warnings it has shown when a library changes the filters
            if str(message) not in shown_once:
                shown_once.add(str(message))
                say(f"warning: {message}")
        else:
            before(message, category, *place)

    warnings.showwarning = show  # type: ignore[assignment]  # the names of the other arguments do not matter
    # overrides -W error: a warning ends no command
    for category in _FOR_USERS:
        warnings.filterwarnings("default", category=category)


def exit_status(command: Callable[[], None]) -> int:
    """Run a command, report its failure if it fails, and return the exit status of the process."""
    status = _status(command)
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
        return status
    except BrokenPipeError:
        status = status or 1
    except OSError as problem:
        status = status or _refused(
            f"The results cannot be written: {problem}.", "Send the output elsewhere."
        )
    # the interpreter flushes when it exits, and would change the status
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    return status


def _status(command: Callable[[], None]) -> int:
    try:
        command()
    except SystemExit as end:
        # the parser takes an EOFError for Ctrl-D at a prompt, but this program has no prompts
        asked = getattr(end.__context__, "__cause__", None)
        if isinstance(asked, KeyboardInterrupt):
            return _interrupted()
        return _defect(asked) if isinstance(asked, EOFError) else _code(end)
    except KeyboardInterrupt:
        return _interrupted()
    except RequestError as error:
        say(str(error))
        return error.status
    except MemoryError:
        return _refused(
            "This process has run out of memory.",
            "Use a smaller --block-cells, or allow more memory.",
        )
    except OSError as problem:
        if problem.errno not in _SURROUNDINGS:
            return _defect(problem)
        return _refused(f"The system refused: {problem}.", "Remove the cause and run the same command again.")
    # any other error that arrives here is a defect
    except Exception as problem:
        return _defect(problem)
    return 0


def _code(end: SystemExit) -> int:
    return end.code if isinstance(end.code, int) else 0 if end.code is None else 1


def _interrupted() -> int:
    # If the interrupt came inside exec(), which dataclasses use, the interpreter remembers that and ignores the exit
    # status. Another exec() makes it forget.
    exec("")
    say("interrupted; no unfinished file was written.")
    return 128 + signal.SIGINT


def _refused(problem: str, hint: str) -> int:
    error = StorageError(problem, hint)
    say(str(error))
    return error.status


def _defect(problem: BaseException) -> int:
    # it may contain text from files and from the user, whose control characters are escaped
    lines = "".join(traceback.format_exception(problem)).rstrip("\n").split("\n")
    sys.stderr.write("\n".join(map(printable, lines)) + "\n")
    say(
        f"This is a defect of eulerdisk {__version__}, not of your request: {type(problem).__name__}. Please report it "
        "to the authors, with the command and the lines above. Finished blocks of a run are kept."
    )
    return DEFECT
