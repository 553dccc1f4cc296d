"""Notices of work that takes seconds. The command line shows them; a Python program gets them only if it listens.

EULERDISK_NOTICES=no silences the notices and the progress lines in a log, for scripts that expect nothing on standard
error even on slow machines.
"""

import os
from collections.abc import Callable

_listener: Callable[[str], None] | None = None


def listen(listener: Callable[[str], None] | None) -> None:
    """Set the function that is called with the text of each notice; None removes it."""
    global _listener
    _listener = listener


def notice(text: str) -> None:
    """Send a notice to the listener before work that takes seconds."""
    if _listener is not None and are_wanted():
        _listener(text)


def are_wanted() -> bool:
    """Return whether the environment allows notices."""
    return os.environ.get("EULERDISK_NOTICES") != "no"
