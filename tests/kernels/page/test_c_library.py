"""The page's replacements of C library functions, compared with mpmath at 50 digits."""

import math

import mpmath
import numpy as np
import pytest

from kernels.page.c_library import C_LIBRARY

#: For each function, the exponents of two of its smallest and largest argument, and if both signs occur.
ARGUMENTS = {
    "sin": (-40, 20, True), "cos": (-40, 20, True), "tan": (-40, 20, True), "exp": (-40, 9, True),
    "expm1": (-60, 9, True), "log": (-900, 900, False), "log1p": (-60, 900, False), "log2": (-900, 900, False),
    "sinh": (-60, 9, True), "cosh": (-60, 9, True), "tanh": (-60, 9, True), "asinh": (-60, 900, True),
    "asin": (-60, 0, True), "acos": (-60, 0, True), "atan": (-900, 900, True),
}  # fmt: skip

#: Tolerance in units in the last place.
WITHIN = 6.0


def drawn(rng, low, high, both):
    """Return random arguments, uniform in the logarithm."""
    found = 2.0 ** rng.uniform(low, high, 300)
    return found * rng.choice([-1.0, 1.0], found.size) if both else found


@pytest.mark.slow_lane
def test_functions_of_one_number(rng):
    """Functions are within a few units in the last place for all arguments of the kernels."""
    for name, arguments in ARGUMENTS.items():
        referee = getattr(mpmath, {"log2": "log"}.get(name, name))
        for x in drawn(rng, *arguments):
            with mpmath.workdps(50):
                true = referee(mpmath.mpf(float(x)), *([2] if name == "log2" else []))
                apart = float(abs(mpmath.mpf(float(C_LIBRARY[name](float(x)))) - true))
            assert apart <= WITHIN * np.spacing(abs(float(true))), (name, x)


@pytest.mark.compiled
def test_functions_of_two_numbers(rng):
    """Angles in all quadrants, and lengths of very small and large points, are right."""
    rng = np.random.default_rng(rng)
    x, y = (drawn(rng, -400, 400, True) for _ in range(2))
    for a, b in [
        *zip(x, y, strict=True),
        (0.0, 1.0),
        (0.0, -1.0),
        (1.0, 0.0),
        (-1.0, 0.0),
        (0.0, 0.0),
        (-0.0, -1.0),
    ]:
        assert C_LIBRARY["atan2"](float(a), float(b)) == pytest.approx(
            math.atan2(a, b), rel=2e-15, abs=1e-300
        )
        assert C_LIBRARY["hypot"](float(a), float(b)) == pytest.approx(math.hypot(a, b), rel=1e-15)


def test_powers_of_two_are_exact(rng):
    """Powers of two, by which kernels scale, are exact; others are right to rounding."""
    power = C_LIBRARY["pow"]
    for exponent in range(-1000, 1000, 37):
        assert power(2.0, float(exponent)) == 2.0**exponent
    for x, y in rng.uniform([0.1, -20.0], [10.0, 20.0], (200, 2)):
        assert power(float(x), float(y)) == pytest.approx(float(x) ** float(y), rel=1e-14)
