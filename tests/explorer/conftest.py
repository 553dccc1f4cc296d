"""One explorer of the presets for all tests of this room."""

from collections.abc import Iterator

import pytest

from sweep.explorer.explorer import explore


@pytest.fixture(scope="package")
def url() -> Iterator[str]:
    """Return the address of an explorer of the presets."""
    with explore() as explorer:
        yield explorer.url
