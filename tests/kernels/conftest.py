"""Kernels that these tests call without the rooms of `sweep` are kept on disk, as the others are."""

import pytest

from sweep.model.disk.exact import FALL_TIMES, REDUCE


@pytest.fixture(scope="session", autouse=True)
def _kept_on_disk():
    REDUCE.load()
    FALL_TIMES.load()
