"""Elementary functions of any argument, compared with mpmath."""

import math

import mpmath
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from kernels import elementary


def ulps(found, truth):
    """Return the error of a number in units in the last place of the true one."""
    with mpmath.workdps(40):
        return float(abs(mpmath.mpf(found) - truth)) / float(np.spacing(abs(float(truth))))


ANGLES = st.one_of(
    st.floats(-1.6e6, 1.6e6),
    st.floats(-1.0, 1.0),
    st.integers(-1_000_000, 1_000_000).map(lambda n: n * math.pi / 2),
)


@given(ANGLES)
def test_sine_and_cosine(x):
    """Both are right to one unit in the last place, even near multiples of a right angle."""
    sine, cosine = elementary.sine_cosine(x)
    with mpmath.workdps(40):
        assert ulps(sine, mpmath.sin(x)) <= 1.0
        assert ulps(cosine, mpmath.cos(x)) <= 1.0


def test_angles_beyond_the_largest_have_no_value():
    """Larger angles give NaN instead of a wrong number."""
    for x in (1.6001e6, -1e300, math.inf, math.nan):
        assert all(map(math.isnan, elementary.sine_cosine(x))), x


@given(st.one_of(st.floats(-708.0, 709.0), st.floats(-1e-3, 1e-3)))
def test_exponential(x):
    """The exponential is right to one unit in the last place."""
    with mpmath.workdps(40):
        assert ulps(elementary.exponential(x), mpmath.exp(x)) <= 1.0


def test_exponential_beyond_all_numbers():
    """Beyond the range of numbers, exp is zero or infinite, and NaN for NaN."""
    assert [elementary.exponential(x) for x in (-800.0, -math.inf, 800.0, math.inf)] == [
        0,
        0,
        math.inf,
        math.inf,
    ]
    assert math.isnan(elementary.exponential(math.nan))


@given(st.one_of(st.floats(2.3e-308, 1e308), st.floats(0.99, 1.01)))
def test_logarithm(x):
    """The logarithm is right to one unit in the last place, even near 1."""
    with mpmath.workdps(40):
        assert x == 1.0 or ulps(elementary.logarithm(x), mpmath.log(x)) <= 1.0


def test_logarithm_of_what_has_none():
    """The logarithm of zero is minus infinity; negative and subnormal numbers give NaN."""
    assert elementary.logarithm(1.0) == 0.0
    assert (elementary.logarithm(0.0), elementary.logarithm(math.inf)) == (-math.inf, math.inf)
    assert all(math.isnan(elementary.logarithm(x)) for x in (-1.0, 1e-310, math.nan))


@given(st.one_of(st.floats(-40.0, 40.0), st.floats(-1e-3, 1e-3)))
def test_hyperbolic_tangent(x):
    """The hyperbolic tangent is right to two units in the last place."""
    with mpmath.workdps(40):
        assert x == 0.0 or abs(x) < 1e-300 or ulps(elementary.hyperbolic_tangent(x), mpmath.tanh(x)) <= 2.0


@given(st.floats(1e-300, 1e300), st.floats(-900.0, 900.0))
def test_rough_logarithms(x, power):
    """They are accurate enough for step lengths, and one is the inverse of the other."""
    assert abs(elementary.rough_log2(x) - math.log2(x)) <= 0.09
    assert abs(elementary.rough_exp2(power) / 2.0**power - 1.0) <= 0.07
    assert abs(elementary.rough_log2(elementary.rough_exp2(power)) - power) <= 1e-9


SIDES = st.one_of(st.floats(-1e150, 1e150), st.floats(-2.0, 2.0), st.sampled_from([0.0, -0.0, 1.0, -1.0]))


@given(SIDES, SIDES)
def test_arc_tangent(y, x):
    """The angle of a point is right to four units in the last place in all quadrants."""
    found = elementary.arc_tangent(y, x)
    with mpmath.workdps(40):
        true = mpmath.atan2(mpmath.mpf(y), mpmath.mpf(x))
        if y == 0.0 or abs(true) < 1e-300:
            assert found == math.atan2(y, x) or abs(true) < 1e-300
        else:
            assert ulps(found, true) <= 4.0


def test_arc_tangent_without_a_value():
    """NaN stays NaN, and one infinite coordinate gives a right angle or none."""
    assert math.isnan(elementary.arc_tangent(math.nan, 1.0))
    assert math.isnan(elementary.arc_tangent(1.0, math.nan))
    assert elementary.arc_tangent(math.inf, 1.0) == math.pi / 2
    assert elementary.arc_tangent(1.0, math.inf) == 0.0
