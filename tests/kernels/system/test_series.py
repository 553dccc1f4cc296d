"""Taylor coefficients of every operation, compared with mpmath's numerical derivatives at 60 digits."""

import math

import mpmath
import pytest

from kernels import elementary
from kernels.system.polynomials import ORDER
from kernels.system.series import SeriesSource

#: y(t) of a state whose rate is a polynomial in time.
PATH = (0.7, 0.3, -0.2, 0.05)

FUNCTIONS = {
    "sin": mpmath.sin, "cos": mpmath.cos, "tan": mpmath.tan, "exp": mpmath.exp, "log": mpmath.log,
    "sqrt": mpmath.sqrt, "tanh": mpmath.tanh,
}  # fmt: skip
POWERS = (2.0, 3.0, 4.0, 5.0, -1.0, -1.5, 0.5, 2.5, 1.3, -3.0)


def coefficients(more, wanted):
    """Return the coefficients of an instruction after those of the path (0: y, 1: the time)."""
    program = [
        ("state", 0),
        ("time",),
        ("number", PATH[1]),
        ("number", 2.0 * PATH[2]),
        ("number", 3.0 * PATH[3]),
    ]
    # the rate a + b t + c t^2
    program += [("*", 3, 1), ("*", 1, 1), ("*", 4, 6), ("+", 2, 5), ("+", 8, 7), *more]
    source = SeriesSource(tuple(program), (9,), (len(program) - 1 if wanted is None else wanted,), ORDER)
    space = {
        name: getattr(elementary, name)
        for name in ("sine_cosine", "exponential", "logarithm", "hyperbolic_tangent", "arc_tangent")
    }
    space |= {"math": math, "y0": PATH[0], "t": 0.0, "p0": 1.7}
    constants = {name: text for text, name in source.constants.names.items()}
    lines = [
        *source.constants.lines(),
        *(f"{name} = {text}" for name, text in constants.items()),
        *source.lines,
    ]
    exec("\n".join(lines), space)
    return [float(eval(text or "0.0", space)) for text in source.wanted[0]]


def path(t):
    """Return y at a time."""
    return sum(mpmath.mpf(each) * t**k for k, each in enumerate(PATH))


def assert_right(found, function):
    """Assert that coefficients equal mpmath's."""
    with mpmath.workdps(60):
        truth = mpmath.taylor(function, 0, ORDER)
    for k, (ours, theirs) in enumerate(zip(found, truth, strict=True)):
        assert ours == pytest.approx(float(theirs), rel=1e-11, abs=1e-14), k


@pytest.mark.parametrize("name", FUNCTIONS)
def test_functions(name):
    """Each function of a known path has the coefficients of the composition."""
    assert_right(coefficients([(name, 0)], None), lambda t: FUNCTIONS[name](path(t)))


@pytest.mark.parametrize("exponent", POWERS)
def test_powers(exponent):
    """Each power, by products, roots or the recurrence, has the right coefficients."""
    assert_right(coefficients([("**", 0, exponent)], None), lambda t: path(t) ** mpmath.mpf(exponent))


def test_small_powers_at_zero():
    """Squares, cubes and fourth powers are defined at a zero base: t^2, t^3, t^4."""
    for exponent in (2, 3, 4):
        assert coefficients([("**", 1, float(exponent))], None) == [
            float(k == exponent) for k in range(ORDER + 1)
        ]


def test_products_quotients_and_constants():
    """Products and quotients of two series, and of a series and a constant of the cell, are right."""
    for more, function in (
        ([("*", 0, 0)], lambda t: path(t) ** 2),
        ([("sin", 0), ("*", 10, 0)], lambda t: mpmath.sin(path(t)) * path(t)),
        ([("cos", 0), ("/", 0, 10)], lambda t: path(t) / mpmath.cos(path(t))),
        ([("parameter", 0), ("sqrt", 10), ("/", 0, 11)], lambda t: path(t) / mpmath.sqrt(mpmath.mpf(1.7))),
        ([("parameter", 0), ("/", 10, 0)], lambda t: mpmath.mpf(1.7) / path(t)),
        ([("parameter", 0), ("*", 10, 1), ("cos", 11)], lambda t: mpmath.cos(mpmath.mpf(1.7) * t)),
        ([("neg", 0), ("-", 10, 1)], lambda t: -path(t) - t),
        ([("sin", 0), ("cos", 0), ("**", 10, 2.0), ("**", 11, 2.0), ("+", 12, 13)], lambda t: mpmath.mpf(1) + 0 * t),
    ):  # fmt: skip
        assert_right(coefficients(more, None), function)


def test_the_angle_of_a_point():
    """Two series, a series and a constant of the cell in both places, and a turn through a right angle are right."""

    def squares(y, x):
        return [("*", y, y), ("*", x, x)]

    number = mpmath.mpf(1.7)
    for more, function in (
        ([*squares(0, 1), ("+", 10, 11), ("atan2", 0, 1, 12)], lambda t: mpmath.pi / 2 - mpmath.atan(t / path(t))),
        ([("cos", 0), *squares(0, 10), ("+", 11, 12), ("atan2", 0, 10, 13)],
         lambda t: mpmath.atan(path(t) / mpmath.cos(path(t)))),
        ([("parameter", 0), *squares(0, 10), ("+", 11, 12), ("atan2", 0, 10, 13)],
         lambda t: mpmath.atan(path(t) / number)),
        ([("parameter", 0), *squares(10, 0), ("+", 11, 12), ("atan2", 10, 0, 13)],
         lambda t: mpmath.atan(number / path(t))),
    ):  # fmt: skip
        assert_right(coefficients(more, None), function)
