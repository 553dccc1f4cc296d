"""One explorer of the presets for all tests in this folder, and separate ones for single tests."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack

import pytest
from explorer_browser import Served, served

from sweep.explorer.explorer import explore


@pytest.fixture(scope="package")
def url() -> Iterator[str]:
    """Return the address of an explorer of the presets."""
    with explore() as explorer:
        yield explorer.url


@pytest.fixture
def served_with() -> Iterator[Callable[..., Served]]:
    """Return a function that runs an explorer with other arguments until the test ends."""
    with ExitStack() as stack:
        yield lambda *words: stack.enter_context(served(*map(str, words)))
