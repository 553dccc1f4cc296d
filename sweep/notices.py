"""Notices of work that takes seconds: the command line shows them, a Python program is not told unless it listens.

EULERDISK_NOTICES=no silences them, and the lines of progress in a log: for scripts that expect nothing on standard
error, however slow the machine is.
"""

import os
from collections.abc import Callable

_listener: Callable[[str], None] | None = None


def listen(listener: Callable[[str], None] | None) -> None:
    """Let a function be called with the text of each notice; none with None."""
    global _listener
    _listener = listener


def notice(text: str) -> None:
    """Tell the listener what is going to take seconds, before it begins."""
    if _listener is not None and are_wanted():
        _listener(text)


def are_wanted() -> bool:
    """Return whether the environment lets notices be shown."""
    return os.environ.get("EULERDISK_NOTICES") != "no"
