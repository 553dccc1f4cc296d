from pathlib import Path

import mpmath
import numba
import numpy as np
import pytest

from kernels.disk.endings import BOUNDED
from kernels.disk.exact import legendre, turning

# uncompiled, the tables alone take minutes
pytestmark = pytest.mark.compiled

EPS = 2.0**-53
DEGREE = np.pi / 180.0
LEAST, GREATEST, PERIOD, HEIGHT, ERROR = range(5)


def reference():
    """Rows of the table that turning_reference.py wrote: kinds, starts and 40-digit results."""
    lines = Path(__file__).with_name("turning_reference.csv").read_text(encoding="ascii").split()
    rows = [line.split(",") for line in lines]
    given_ = np.array([[float.fromhex(x) for x in row[1:8]] for row in rows]).T
    return (
        np.array([row[0] for row in rows]),
        given_,
        np.array([[float(x) for x in row[8:]] for row in rows]).T,
    )


KINDS, STARTS, EXACT = reference()


@pytest.fixture(scope="module")
def reduced():
    """Measures and counts of the reference's starts."""
    return turning.extremes(STARTS, 89.9 * DEGREE, True)


@pytest.mark.parametrize("alpha", [1e-6, 0.3, 0.5, 1.0])
def test_basis_functions(alpha):
    """Both solutions are Legendre's hypergeometric series, to 1e-14 of each value up to 89.9 degrees."""
    table = legendre.tables([alpha])
    h = mpmath.mpf(1) / 2
    with mpmath.workdps(30):
        mu = mpmath.sqrt(2 / (1 + mpmath.mpf(alpha)) - mpmath.mpf(1) / 4)
        a, b = mpmath.mpc(0.25, -mu / 2), mpmath.mpc(0.25, mu / 2)
        for tilt in (1e-9, -0.01, 0.0625, 0.5, -0.9, 1.3, -89.0 * DEGREE, 89.9 * DEGREE):
            u, c = mpmath.sin(mpmath.mpf(tilt)), mpmath.cos(mpmath.mpf(tilt))
            even, odd = mpmath.hyp2f1(a, b, h, u * u), mpmath.hyp2f1(a + h, b + h, 3 * h, u * u)
            even_u = 2 * u * a * b / h * mpmath.hyp2f1(a + 1, b + 1, 3 * h, u * u)
            odd_u = odd + 2 * u * u * (a + h) * (b + h) / (3 * h) * mpmath.hyp2f1(
                a + 3 * h, b + 3 * h, 5 * h, u * u
            )
            exact = even, -(1 + mpmath.mpf(alpha)) * c * even_u, -u * odd / (1 + mpmath.mpf(alpha)), c * odd_u
            expected = [float(mpmath.re(x)) for x in exact]
            assert legendre.basis(*table, tilt) == pytest.approx(expected, rel=1e-14)


def test_reference_is_large_enough():
    """At least 200 starts, with at least 30 near-flat ones and 50 within 1e-2 of a separatrix."""
    assert KINDS.size >= 200
    assert (KINDS == "flat").sum() >= 30
    assert (np.abs(EXACT[5]) < 0.05)[KINDS == "separatrix"].sum() >= 50


@pytest.mark.parametrize(("measure", "moves"), [(LEAST, 2), (GREATEST, 3)])
def test_turning_points(reduced, measure, moves):
    """The extremes are those of 40 digits, to 2e-14 and 4 roundings of the parameters of the start.

    EXACT[moves] is the condition number: how far the extreme moves if every parameter changes by its own size.
    """
    wrong = np.abs(reduced[0][measure] - EXACT[measure])
    allowed = 2e-14 + 4 * EPS * EXACT[moves]
    assert (reduced[1][0] == BOUNDED).all()
    assert (wrong <= allowed).all(), (wrong / allowed).max()
    well_conditioned = allowed < 1e-12
    assert well_conditioned.sum() >= 200
    assert (wrong[well_conditioned] < 1e-12).all()


def test_estimated_error_covers_the_error(reduced):
    """The estimate is above the error of both extremes, and at most 100 times what condition allows."""
    estimate = reduced[0][ERROR]
    assert (np.abs(reduced[0][:2] - EXACT[:2]).max(axis=0) <= estimate).all()
    assert (estimate < 100 * (2e-16 + EPS * EXACT[2:4].max(axis=0))).all()


def test_wells_and_separatrix(reduced):
    """One or two wells, and the height of the saddle over the energy, to 16 roundings of the energy."""
    two = EXACT[4] == 2
    assert (reduced[1][1] == EXACT[4]).all()
    assert 50 < two.sum() < two.size - 50
    assert np.isnan(reduced[0][HEIGHT][~two]).all()
    np.testing.assert_allclose(reduced[0][HEIGHT][two], EXACT[5][two], rtol=1e-13, atol=16 * EPS)


def test_height_next_to_the_saddle(reduced):
    """Of a disk that is all but at rest on its saddle the height keeps eight digits: no potentials are subtracted."""
    near = np.isin(KINDS, ("circling", "upright")) & (np.abs(EXACT[5]) < 1e-10)
    assert near.sum() >= 10
    np.testing.assert_allclose(reduced[0][HEIGHT][near], EXACT[5][near], rtol=1e-8)


def test_periods(reduced):
    """The period is that of a 40-digit quadrature to 1e-10, or to the rounding of the distance from a separatrix."""
    known = np.isfinite(EXACT[6])
    near = np.where(np.isnan(EXACT[5]), 1.0, np.abs(EXACT[5]))
    wrong = np.abs(reduced[0][PERIOD] / EXACT[6] - 1.0)[known]
    assert known.sum() >= 80
    assert (wrong <= 1e-10 + 8 * EPS / near[known]).all(), wrong.max()


def test_bits_do_not_depend_on_neighbours(reduced):
    """Threads, order and company change no bit; nor does asking for the period."""
    order = np.random.default_rng(0).permutation(KINDS.size)
    threads = numba.get_num_threads()
    try:
        numba.set_num_threads(1)
        measures, counts = turning.extremes(STARTS[:, order], 89.9 * DEGREE, True)
    finally:
        numba.set_num_threads(threads)
    np.testing.assert_array_equal(measures, reduced[0][:, order])
    np.testing.assert_array_equal(counts, reduced[1][:, order])
    without, _ = turning.extremes(STARTS, 89.9 * DEGREE)
    np.testing.assert_array_equal(without[[LEAST, GREATEST, HEIGHT, ERROR]], reduced[0][[0, 1, 3, 4]])
