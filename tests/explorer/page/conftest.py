"""Node in place of a browser, for what the page computes.

`node` runs the page of the presets for all tests of a module; `opened(url=None)` runs
that of any explorer until the test ends.
"""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing

import pytest

from .node_page import NodePage


@pytest.fixture(scope="module")
def node(url: str) -> Iterator[NodePage]:
    """Run the page of the presets for all tests of a module."""
    with closing(NodePage(url)) as page:
        yield page


@pytest.fixture
def opened(url: str) -> Iterator[Callable[..., NodePage]]:
    """Return a function that runs the page of an explorer, that of the presets if none is given."""
    with ExitStack() as stack:
        yield lambda url=url: stack.enter_context(closing(NodePage(url)))
