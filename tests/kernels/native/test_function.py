"""Functions that are compiled when they are first needed."""

import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from numba import types

from kernels.jit import kernel
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


def square(number):
    """Multiply a number by itself."""
    return number * number


def test_python_and_kernels_call_one_function():
    """What only kernels have called so far is compiled without what Python needs, and again when Python calls it."""
    both = kernel(square)
    assert entry(number="float64")(lambda number: both(number) + 1.0)(3.0) == 10.0
    assert not both.compiled.overloads
    assert both(4.0) == 16.0
    assert entry(number="float64")(lambda number: both(number) + 2.0)(3.0) == 11.0


@entry(whole="int64", number="float64")
def operators(whole, number):
    """Operate on a number with literals, with numbers of its type and of another, and in place."""
    shifted = (whole << 3) - whole % 5
    shifted += whole
    number /= whole
    return shifted, number**2 - 0.5 * number, int(number < whole) + 2 * int(whole != 7)


@pytest.mark.parametrize(("whole", "number"), [(7, 2.5), (-13, 1e150), (4, -0.75)])
def test_operators_do_what_python_does(whole, number):
    """The referee is Python, to the last bit."""
    assert operators(whole, number) == operators.py_func(whole, number)


def test_compiling_a_kernel_keeps_no_times():
    """Numba would keep an event for each call of LLVM, several times over."""
    from numba import njit

    ours, others = kernel(square).compiled, njit(square)
    for each in (ours, others):
        each.compile((types.float64,))
    assert "timers" in others.get_metadata((types.float64,))
    assert "timers" not in ours.get_metadata((types.float64,))
