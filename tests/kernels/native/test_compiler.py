"""What Numba compiles: vectors of the requested width, and only the code that calls need."""

import re

import numpy as np
import pytest
from numba import types

from kernels.jit import kernel
from kernels.native import compiler
from kernels.native.entry import entry, parallel

pytestmark = pytest.mark.compiled


@entry(numbers="float64[::1]")
def straight(numbers):
    """Change numbers that fit several to a vector."""
    for i in range(numbers.size):
        numbers[i] = 0.5 * numbers[i] + 0.25


@parallel(64, lambda *_: (np.empty(64),), rows="float64[:, ::1]", memory="float64[::1]")
def in_chunks(start, stop, rows, memory):
    """Change numbers through the memory of a thread."""
    for i in range(start, stop):
        memory[i - start] = rows[0, i]
    for i in range(memory.size):
        memory[i] = 0.5 * memory[i] + 0.25
    for i in range(start, stop):
        rows[0, i] = memory[i - start]


def test_every_function_of_an_entry_point_prefers_the_width(monkeypatch):
    """After inlining, every function prefers the width, and the machine code has such vectors if any."""
    texts, object_code = [], compiler._PartLibrary.object_code

    def seen(self):
        module, code = object_code(self)
        texts.append((str(module), self._codegen._tm.emit_assembly(module)))
        return module, code

    monkeypatch.setattr(compiler._PartLibrary, "object_code", seen)
    for point in (straight, in_chunks):
        for given, expected in (("", "512"), ("256", "256")):
            monkeypatch.setenv("EULERDISK_VECTOR_BITS", given)
            point.compiled()
            module, assembly = texts.pop()
            groups = dict(re.findall(r"^attributes #(\d+) = \{(.*)\}$", module, re.MULTILINE))
            functions = re.findall(r"^define [^\n]* #(\d+) ", module, re.MULTILINE)
            assert functions
            for each in functions:
                found = re.findall(r'"prefer-vector-width"="(\d+)"', groups[each])
                assert found == [expected], (point, given)
            if "zmm" in assembly or "ymm" in assembly:
                assert ("zmm" in assembly) <= (expected == "512"), (point, given)


def square(number):
    """Square a number."""
    return number * number


def test_python_and_kernels_call_one_function():
    """A function first called by kernels is compiled without Python's wrapper, and again when Python calls it."""
    both = kernel(square)
    assert entry(number="float64")(lambda number: both(number) + 1.0)(3.0) == 10.0
    assert both.compiled.overloads[(types.float64,)].library._finalized
    assert both(4.0) == 16.0
    assert entry(number="float64")(lambda number: both(number) + 2.0)(3.0) == 11.0


@entry(whole="int64", number="float64")
def operators(whole, number):
    """Combine a number with literals and with numbers of its own and another type, also in place."""
    shifted = (whole << 3) - whole % 5
    shifted += whole
    number /= whole
    return shifted, number**2 - 0.5 * number, int(number < whole) + 2 * int(whole != 7)


def test_operators_do_what_python_does():
    """Operators give Python's results to the last bit."""
    for given in ((7, 2.5), (-13, 1e150), (4, -0.75)):
        assert operators(*given) == operators.py_func(*given), given
