"""First roots and largest values of random and difficult polynomials, compared with NumPy's roots."""

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from kernels.system.polynomials import ORDER
from kernels.system.roots import first_above, greatest_to


def memory_of(polynomial):
    """Return the memory of a polynomial: its coefficients and a workspace."""
    memory = np.zeros(2 * (ORDER + 1))
    memory[: polynomial.coef.size] = polynomial.coef
    return memory


def first_above_of(polynomial, h=1.0):
    """Return the result of `first_above`."""
    return first_above(0, h, ORDER + 1, memory_of(polynomial))


def greatest_of(polynomial, h=1.0):
    """Return the result of `greatest_to`."""
    return greatest_to(0, h, ORDER + 1, memory_of(polynomial))


def test_the_first_of_many_roots(rng, count):
    """Of up to twelve roots in a step, some close together, the first is found; NumPy is the referee."""
    compared = 0
    for _ in range(count(150, 3000)):
        roots = np.sort(rng.uniform(-0.3, 1.3, rng.integers(1, ORDER + 1)))
        if np.min(np.diff(roots), initial=1.0) < 1e-3:
            continue
        polynomial = rng.choice([-1.0, 1.0]) * Polynomial.fromroots(roots)
        time, proved = first_above_of(polynomial)
        inside = roots[(roots > 0.0) & (roots < 1.0)]
        ends = np.concatenate([[0.0], inside, [1.0]])
        positive = polynomial(0.5 * (ends[1:] + ends[:-1])) > 0.0
        truth = ends[:-1][positive][0] if positive.any() else np.inf
        # a root is uncertain by the rounding of the values over the slope
        slack = 1e-14 * np.sum(np.abs(polynomial.coef)) / max(abs(polynomial.deriv()(min(truth, 1.0))), 1e-30)
        assert proved
        assert time == pytest.approx(truth, abs=1e-13 + slack), roots
        compared += 1
    assert compared > 80


def test_an_excursion_between_two_close_roots():
    """A positive value for a millionth of a step is found, and so is its absence."""
    for width in (1e-2, 1e-4, 1e-6):
        bump = Polynomial([-((0.37) ** 2) + width**2, 2 * 0.37, -1.0])
        time, proved = first_above_of(bump)
        assert (time, proved) == (pytest.approx(0.37 - width, abs=1e-9), True)
        assert first_above_of(bump - 2.0 * width**2) == (np.inf, True)


def test_what_touches_is_not_proved():
    """A double root, up to rounding, is no crossing and is reported as not proved."""
    time, proved = first_above_of(-(Polynomial([-0.3, 1.0]) ** 2))
    assert proved is False or proved == 0
    assert time == np.inf or abs(time - 0.3) < 1e-6


def test_what_begins_above_and_what_begins_at_zero():
    """A positive value, or a rise from zero, counts as above at once; a fall from zero does not."""
    assert first_above_of(Polynomial([1e-300])) == (0.0, True)
    assert first_above_of(Polynomial([0.0, 1.0])) == (0.0, True)
    assert first_above_of(Polynomial([0.0, -1.0])) == (np.inf, True)
    assert first_above_of(Polynomial([0.0, -1.0, 2.0]))[0] == pytest.approx(0.5, abs=1e-15)
    assert first_above_of(Polynomial([0.0])) == (np.inf, True)


def test_greatest_values(rng, count):
    """The highest of up to eleven extremes of a polynomial is found, to the rounding of its terms."""
    for _ in range(count(150, 3000)):
        polynomial = Polynomial.fromroots(rng.uniform(-0.3, 1.3, rng.integers(2, ORDER + 1))) * rng.normal()
        real = polynomial.deriv().roots()
        places = np.concatenate([[0.0, 1.0], real[np.abs(real.imag) < 1e-6].real])
        truth = polynomial(places[(places >= 0.0) & (places <= 1.0)]).max()
        assert greatest_of(polynomial) == pytest.approx(truth, abs=1e-13 * np.sum(np.abs(polynomial.coef)))


def test_the_narrowest_summit():
    """Chebyshev's polynomial has seven maxima of 1 from -1 to 1; if one is raised slightly, it is found."""
    wave = Polynomial(np.polynomial.chebyshev.cheb2poly([0.0] * 12 + [1.0]))
    for tilt in (1e-3, -1e-3):
        tilted = (wave + Polynomial([0.0, tilt]))(Polynomial([-1.0, 2.0]))
        assert greatest_of(tilted) == pytest.approx(1.0 + 1e-3, abs=1e-9)
