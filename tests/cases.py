"""Cases of one test in a loop: a failure names its case."""

from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def case(*what: object) -> Iterator[None]:
    """Run one case; an error in it names the case."""
    try:
        yield
    except Exception as error:
        error.add_note(f"in the case {what!r}")
        raise
