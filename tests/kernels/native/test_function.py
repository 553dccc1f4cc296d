"""Functions that are compiled when they are first needed."""

import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from kernels.native.entry import entry
from kernels.native.function import LazyFunction


def test_two_threads_make_one_function():
    """Two dispatchers of one function would compile it twice."""
    made = []

    def make(function):
        time.sleep(0.05)
        made.append(function)
        return object()

    lazy = LazyFunction(len, make)
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda _: lazy.compiled, range(4)))
    assert len(made) == 1
    assert len(set(map(id, found))) == 1


@entry(whole="int64", number="float64")
def mixed(whole, number):
    """Use one operator with several types."""
    return whole // 2 + whole // 2, whole / 2 + number / 2, whole // 2 + number // 2


def test_what_an_operator_returns_follows_its_types():
    """What is remembered of an operator holds for the types that it was asked for."""
    assert mixed(3, 3.5) == (2, 3.25, 2.0)
    assert [type(each) for each in mixed(3, 3.5)] == [int, float, float]


def test_the_typing_of_other_functions_is_as_before():
    """What a kernel's compilation remembers of operators is forgotten with it."""
    from numba.core.registry import cpu_target

    entry(number="float64")(lambda number: 2.0 * number)(np.float64(1.0))
    assert "resolve_function_type" not in vars(cpu_target.typing_context)
