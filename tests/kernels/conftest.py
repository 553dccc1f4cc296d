"""Kernels that these tests call without the rooms of `sweep` are kept on disk, as the others are."""

import pytest

from sweep.model.disk.exact import EXTREMES, FALL_TIMES


@pytest.fixture(scope="session", autouse=True)
def _kept_on_disk():
    EXTREMES.load()
    FALL_TIMES.load()
