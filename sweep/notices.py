"""Notices of work that takes seconds: the command line shows them, a Python program is not told unless it listens.

Nobody is told where EULERDISK_NOTICES is ``no``, as in scripts that expect nothing on standard error.
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
    if _listener is not None and os.environ.get("EULERDISK_NOTICES") != "no":
        _listener(text)
