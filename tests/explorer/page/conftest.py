"""Node instead of a browser, for the page's computations.

`node` runs the page of the presets for all tests of a module; `opened(url=None)` runs
any explorer's page until the test ends.
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
    """Return a function that runs an explorer's page, by default that of the presets."""
    with ExitStack() as stack:
        yield lambda url=url: stack.enter_context(closing(NodePage(url)))
