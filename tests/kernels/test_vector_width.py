"""Vectors of the full width, for these kernels alone."""

import numpy as np
import pytest
from numba import njit

from kernels.multiply_add import LINKS, multiply_add
from kernels.native import pipeline

pytestmark = pytest.mark.compiled


@pytest.fixture
def compiled():
    """Return a function that compiles `multiply_add` with a preferred width [bits]."""

    def with_width(bits):
        pipeline.prefer(bits)
        found = multiply_add.copied(multiply_add.py_func).compiled
        found(np.zeros(8), 1, 0.5, 0.25)
        return found

    before = pipeline._preferred
    yield with_width
    pipeline.prefer(before)


def llvm(function):
    """Return what Numba hands to LLVM for the only compiled form."""
    return next(iter(function.inspect_llvm().values()))


@pytest.mark.parametrize("bits", [256, 512])
def test_a_kernel_prefers_the_width_that_was_asked_for(compiled, bits):
    """LLVM is told the width with the function."""
    assert f'"prefer-vector-width"="{bits}"' in llvm(compiled(bits))


def test_without_a_width_the_choice_is_left_to_llvm(compiled):
    """Nothing is said of a width then."""
    assert "prefer-vector-width" not in llvm(compiled(0))


def test_code_of_other_packages_is_compiled_as_ever(compiled):
    """Numba's own settings stay as they are for whatever else a program compiles."""
    compiled(512)

    @njit
    def others(numbers):
        total = 0.0
        for number in numbers:
            total += number
        return total

    others(np.zeros(8))
    assert "prefer-vector-width" not in llvm(others)


def test_the_width_of_the_machine_code_is_the_preferred_one(compiled):
    """The registers of the machine code are those of the width."""
    from sweep.platforms import host_features

    if not host_features().get("avx512f"):
        pytest.skip("a processor without AVX-512")
    wide, narrow = (next(iter(compiled(bits).inspect_asm().values())) for bits in (512, 256))
    assert "zmm" in wide
    assert "zmm" not in narrow
    assert "ymm" in narrow


def test_the_width_changes_no_bit(compiled):
    """Lanes never exchange a number; the referee is the closed form of the sum."""
    numbers = np.random.default_rng().random(1000)
    results = []
    for bits in (0, 256, 512):
        results.append(numbers.copy())
        compiled(bits)(results[-1], 3, 0.7, 0.3)
    assert results[0].tobytes() == results[1].tobytes() == results[2].tobytes()
    # a geometric sum: x -> a x + b, 3 LINKS times
    n = 3 * LINKS
    expected = 0.7**n * numbers + 0.3 * (1.0 - 0.7**n) / (1.0 - 0.7)
    np.testing.assert_allclose(results[0], expected, rtol=1e-14)
