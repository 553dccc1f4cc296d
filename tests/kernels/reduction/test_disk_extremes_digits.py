from pathlib import Path

import numpy as np
import pytest
import referee
from disk_reduction import COUNT, ENDING, extremes

from kernels.bodies.arrays import REDUCED_ERROR, REDUCED_MAX, REDUCED_MIN, REDUCED_PERIOD, REDUCED_SEPARATRIX
from kernels.disk.arrays import PARAMETERS
from kernels.disk.endings import BOUNDED
from kernels.native import workers

# uncompiled they take minutes
pytestmark = pytest.mark.compiled

#: Written by tests/turning_reference.py.
TABLE = Path(referee.__file__).with_name("turning_reference.csv")

EPS = 2.0**-53
DEGREE = np.pi / 180.0
EXTREMES = [REDUCED_MIN, REDUCED_MAX]


def reference():
    """Rows of the table that turning_reference.py wrote: kinds, starts and 40-digit results."""
    rows = [line.split(",") for line in TABLE.read_text(encoding="ascii").split()]
    results = 1 + len(PARAMETERS)
    return (
        np.array([row[0] for row in rows]),
        np.array([[float.fromhex(x) for x in row[1:results]] for row in rows]).T,
        np.array([[float(x) for x in row[results:]] for row in rows]).T,
    )


KINDS, STARTS, EXACT = reference()
#: Rows of EXACT; of the two shifts see `turning_reference`.
LEAST, GREATEST, SHIFT_OF_LEAST, SHIFT_OF_GREATEST, WELLS, HEIGHT, PERIOD = range(7)
SHIFTS = [SHIFT_OF_LEAST, SHIFT_OF_GREATEST]


@pytest.fixture(scope="module")
def reduced():
    """Measures and counts of the reference's starts."""
    return extremes(STARTS, 89.9 * DEGREE, True)


def test_reference_is_large_enough():
    """At least 200 starts, with at least 30 near-flat ones and 50 within 1e-2 of a separatrix."""
    assert KINDS.size >= 200
    assert (KINDS == "flat").sum() >= 30
    assert (np.abs(EXACT[HEIGHT]) < 0.05)[KINDS == "separatrix"].sum() >= 50


def test_turning_points(reduced):
    """The extremes are those of 40 digits, to 2e-14 and 8 roundings of the parameters of the start.

    EXACT[shift] is the condition number: how far the extreme moves if every parameter changes by its own size.
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
    """The estimate is above the error of both extremes, and at most 100 times what condition allows."""
    estimate = reduced[0][REDUCED_ERROR]
    assert (np.abs(reduced[0][EXTREMES] - EXACT[[LEAST, GREATEST]]).max(axis=0) <= estimate).all()
    assert (estimate < 100 * (2e-16 + EPS * EXACT[SHIFTS].max(axis=0))).all()


def test_wells(reduced):
    """One or two, also where the potential is all but flat about upright."""
    two = EXACT[WELLS] == 2
    assert (reduced[1][COUNT] == EXACT[WELLS]).all()
    assert 50 < two.sum() < two.size - 50


def test_heights_of_maxima(reduced):
    """Of a maximum that is passed the height is right to 1e-5; of one behind a turning point a parabola tells it."""
    height, exact = reduced[0][REDUCED_SEPARATRIX], EXACT[HEIGHT]
    near = (EXACT[WELLS] == 2) & (np.abs(exact) < 1e-2)
    passed, behind = near & (exact < 0.0), near & (exact > 0.0) & np.isfinite(height)
    assert passed.sum() > 30
    assert behind.sum() > 20
    np.testing.assert_allclose(height[passed], exact[passed], rtol=1e-5)
    np.testing.assert_allclose(height[behind], exact[behind], rtol=0.05)
    # a motion that circles on one side of a far maximum turns before its parabola bends down
    assert (near & ~passed & ~behind).sum() < 6


def test_periods(reduced):
    """The period is that of a 40-digit quadrature to 1e-9; where rounding may change it by more there is none."""
    given = np.isfinite(reduced[0][REDUCED_PERIOD])
    assert given.mean() > 0.9
    known = np.isfinite(EXACT[PERIOD]) & given
    wrong = np.abs(reduced[0][REDUCED_PERIOD] / EXACT[PERIOD] - 1.0)[known]
    assert known.sum() >= 70
    assert (wrong <= 1e-9).all(), wrong.max()
    assert (wrong <= 1e-12).mean() > 0.8


def test_bits_do_not_depend_on_neighbours(reduced):
    """Threads, order and company change no bit; nor does asking for the period."""
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
