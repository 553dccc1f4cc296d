"""Kernels that these tests call directly are cached on disk like the others."""

import pytest

from sweep.model.disk.exact import FALL_TIMES, REDUCE


@pytest.fixture(scope="session", autouse=True)
def _kept_on_disk():
    REDUCE.load()
    FALL_TIMES.load()
