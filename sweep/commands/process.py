"""The process of a command: its three streams, what it needs of its surroundings, and its exit status.

A message that cannot be shown is no reason to end a run: errors of standard error are ignored. A result that cannot be
shown is: then the status is 3, as for a file that cannot be written.
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

#: Exit status of a defect of the program: EX_SOFTWARE of sysexits.h.
DEFECT = 70

#: Errors of the system that no code of this program can cause: room, rights, devices, and the limits of a process.
_SURROUNDINGS = (
    errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EROFS, errno.EACCES, errno.EPERM, errno.EMFILE,
    errno.ENFILE, errno.ENOMEM, errno.EAGAIN, errno.ESTALE, errno.ENODEV, errno.ETIMEDOUT, errno.EBUSY,
)  # fmt: skip

#: Warnings of what a user can put right: what a file holds, and what surrounds the program.
_FOR_USERS = LeftOutWarning, SurroundingsWarning


class _Messages(io.RawIOBase):
    """Standard error, without errors: a closed terminal or a full disk of a log does not end a run."""

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
    """Give the process three streams, also where it was started without them.

    The next file that is opened takes the number of a closed stream: messages of a library would go into an atlas.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
    # a test that reads what is printed has its own streams
    if isinstance(sys.stdout, io.TextIOWrapper) and sys.stdout is sys.__stdout__:
        sys.stdout.reconfigure(errors="backslashreplace")
    if sys.stderr is sys.__stderr__:
        encoding = sys.stderr.encoding if sys.stderr else "utf-8"
        sys.stderr = io.TextIOWrapper(
            _Messages(), encoding, "backslashreplace", line_buffering=True, write_through=True
        )


def tell_warnings() -> None:
    """Let warnings for users be said in one line, as all messages are; others are shown as before."""
    before, shown_once = warnings.showwarning, set[str]()

    def show(message: Warning | str, category: type[Warning], *place: Any) -> None:
        if issubclass(category, _FOR_USERS):
            # Python itself forgets what it has shown when a library changes the filters
            if str(message) not in shown_once:
                shown_once.add(str(message))
                say(f"warning: {message}")
        else:
            before(message, category, *place)

    warnings.showwarning = show  # type: ignore[assignment]  # the names of the rest do not matter here
    # also under -W error: it ends no command
    for each in _FOR_USERS:
        warnings.filterwarnings("default", category=each)


def exit_status(command: Callable[[], None]) -> int:
    """Run a command, tell how it failed if it did, and return the exit status of the process."""
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
    # the interpreter flushes at its end, and would end with a status of its own
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    return status


def _status(command: Callable[[], None]) -> int:
    try:
        command()
    except SystemExit as end:
        # the parser takes an EOFError for Ctrl-D at a question, and this program asks none
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
            "The memory that this process may use is not enough.",
            "Use a smaller --block-cells, or more memory.",
        )
    except OSError as problem:
        if problem.errno not in _SURROUNDINGS:
            return _defect(problem)
        return _refused(f"The system refuses: {problem}.", "Remove the cause and run the same command again.")
    # any other error that arrives here is a defect
    except Exception as problem:
        return _defect(problem)
    return 0


def _code(end: SystemExit) -> int:
    return end.code if isinstance(end.code, int) else 0 if end.code is None else 1


def _interrupted() -> int:
    # An interrupt that came while a text was executed, as `dataclasses` do, would decide how the interpreter ends,
    # with any status: it remembers the last text.
    exec("")
    say("interrupted; no unfinished file was written.")
    return 128 + signal.SIGINT


def _refused(problem: str, hint: str) -> int:
    error = StorageError(problem, hint)
    say(str(error))
    return error.status


def _defect(problem: BaseException) -> int:
    # names from files and words of the user stand in it: what a terminal obeys is escaped
    lines = "".join(traceback.format_exception(problem)).rstrip("\n").split("\n")
    sys.stderr.write("\n".join(map(printable, lines)) + "\n")
    say(
        f"This is a defect of eulerdisk {__version__}, not of the request: {type(problem).__name__}. Please report it "
        "to the authors, with the command and the lines above. Finished blocks of a run are kept."
    )
    return DEFECT
