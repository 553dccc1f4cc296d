"""Functions that are compiled when they are first needed."""

import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from kernels.native.function import LazyFunction


@pytest.mark.compiled
def test_two_threads_make_one_function():
    """Two threads get the same function; two Numba functions would be compiled twice."""
    made = []

    def make(function, options):
        time.sleep(0.05)
        made.append(function)
        return object()

    lazy = LazyFunction(len, make)
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda _: lazy.compiled, range(4)))
    assert len(made) == 1
    assert len(set(map(id, found))) == 1
