from pathlib import Path

import numpy as np
import pytest
import referee
from disk_reduction import COUNT, ENDING, extremes

from kernels.bodies.arrays import REDUCED_ERROR, REDUCED_MAX, REDUCED_MIN, REDUCED_PERIOD, REDUCED_SEPARATRIX
from kernels.disk.arrays import PARAMETERS
from kernels.disk.endings import BOUNDED
from kernels.native import workers

# takes minutes without compilation
pytestmark = pytest.mark.compiled

#: Written by tests/turning_reference.py.
TABLE = Path(referee.__file__).with_name("turning_reference.csv")

EPS = 2.0**-53
DEGREE = np.pi / 180.0
EXTREMES = [REDUCED_MIN, REDUCED_MAX]


def reference():
    """Return the table of turning_reference.py: kinds, starts and 40-digit results."""
    rows = [line.split(",") for line in TABLE.read_text(encoding="ascii").split()]
    results = 1 + len(PARAMETERS)
    return (
        np.array([row[0] for row in rows]),
        np.array([[float.fromhex(x) for x in row[1:results]] for row in rows]).T,
        np.array([[float(x) for x in row[results:]] for row in rows]).T,
    )


KINDS, STARTS, EXACT = reference()
#: Rows of EXACT; `turning_reference` explains the two shifts.
LEAST, GREATEST, SHIFT_OF_LEAST, SHIFT_OF_GREATEST, WELLS, HEIGHT, PERIOD = range(7)
SHIFTS = [SHIFT_OF_LEAST, SHIFT_OF_GREATEST]


@pytest.fixture(scope="module")
def reduced():
    """Return the measures and counts of the reference's starts."""
    return extremes(STARTS, 89.9 * DEGREE, True)


def test_reference_is_large_enough():
    """The table has at least 200 starts, 30 of them near flat and 50 within 1e-2 of a separatrix."""
    assert KINDS.size >= 200
    assert (KINDS == "flat").sum() >= 30
    assert (np.abs(EXACT[HEIGHT]) < 0.05)[KINDS == "separatrix"].sum() >= 50


def test_turning_points(reduced):
    """Extremes agree with 40 digits to 2e-14 plus 8 roundings of the start's parameters.

    EXACT[shift] is the condition number: how far the extreme moves if every parameter changes by its own
    size.
    """
    for case in [(REDUCED_MIN, LEAST, SHIFT_OF_LEAST), (REDUCED_MAX, GREATEST, SHIFT_OF_GREATEST)]:
        measure, exact, shift = case
        wrong = np.abs(reduced[0][measure] - EXACT[exact])
        allowed = 2e-14 + 8 * EPS * EXACT[shift]
        assert (reduced[1][ENDING] == BOUNDED).all(), case
        assert (wrong <= allowed).all(), (wrong / allowed).max()
        well_conditioned = allowed < 1e-12
        assert well_conditioned.sum() >= 200, case
        assert (wrong[well_conditioned] < 1e-12).all(), case


def test_estimated_error_covers_the_error(reduced):
    """The estimate exceeds the error of both extremes and is at most 100 times the bound from the condition number."""
    estimate = reduced[0][REDUCED_ERROR]
    assert (np.abs(reduced[0][EXTREMES] - EXACT[[LEAST, GREATEST]]).max(axis=0) <= estimate).all()
    assert (estimate < 100 * (2e-16 + EPS * EXACT[SHIFTS].max(axis=0))).all()


def test_wells(reduced):
    """The number of wells is right, also for a potential that is almost flat around upright."""
    two = EXACT[WELLS] == 2
    assert (reduced[1][COUNT] == EXACT[WELLS]).all()
    assert 50 < two.sum() < two.size - 50


def test_heights_of_maxima(reduced):
    """The height of a passed maximum is right to 1e-5; behind a turning point, a parabola gives it."""
    height, exact = reduced[0][REDUCED_SEPARATRIX], EXACT[HEIGHT]
    near = (EXACT[WELLS] == 2) & (np.abs(exact) < 1e-2)
    passed, behind = near & (exact < 0.0), near & (exact > 0.0) & np.isfinite(height)
    assert passed.sum() > 30
    assert behind.sum() > 20
    np.testing.assert_allclose(height[passed], exact[passed], rtol=1e-5)
    np.testing.assert_allclose(height[behind], exact[behind], rtol=0.05)
    # for circling on one side of a far maximum, the motion turns before its parabola bends down
    assert (near & ~passed & ~behind).sum() < 6


def test_periods(reduced):
    """Periods agree with a 40-digit quadrature to 1e-9; where rounding matters more, there is none."""
    given = np.isfinite(reduced[0][REDUCED_PERIOD])
    assert given.mean() > 0.9
    known = np.isfinite(EXACT[PERIOD]) & given
    wrong = np.abs(reduced[0][REDUCED_PERIOD] / EXACT[PERIOD] - 1.0)[known]
    assert known.sum() >= 70
    assert (wrong <= 1e-9).all(), wrong.max()
    assert (wrong <= 1e-12).mean() > 0.8


def test_bits_do_not_depend_on_neighbours(reduced):
    """Threads, order, other cells and asking for the period do not change a bit."""
    order = np.random.default_rng(0).permutation(KINDS.size)
    workers.use(1)
    try:
        measures, counts = extremes(STARTS[:, order], 89.9 * DEGREE, True)
    finally:
        workers.use(None)
    np.testing.assert_array_equal(measures, reduced[0][:, order])
    np.testing.assert_array_equal(counts, reduced[1][:, order])
    without, _ = extremes(STARTS, 89.9 * DEGREE)
    rest = [REDUCED_MIN, REDUCED_MAX, REDUCED_SEPARATRIX, REDUCED_ERROR]
    np.testing.assert_array_equal(without[rest], reduced[0][rest])
