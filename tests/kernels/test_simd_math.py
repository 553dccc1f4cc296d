import math

import mpmath
from hypothesis import given
from hypothesis import strategies as st

from kernels.simd_math import angle_of, exp_minus_one, logarithm, sine_cosine_of_tilt

FLAT = math.nextafter(math.pi / 2, 0.0)
TILTS = st.floats(-FLAT, FLAT, allow_subnormal=False)


@given(TILTS)
def test_sine_and_cosine(tilt):
    """Both have a relative error of at most 3e-16, even near upright and flat."""
    sine, cosine = sine_cosine_of_tilt(tilt)
    with mpmath.workdps(30):
        assert abs(sine - mpmath.sin(tilt)) <= 3e-16 * abs(mpmath.sin(tilt))
        assert abs(cosine - mpmath.cos(tilt)) <= 3e-16 * abs(mpmath.cos(tilt))


@given(TILTS, st.floats(0.9, 1.1))
def test_the_tilt_of_a_sine_and_a_cosine(tilt, common):
    """The tilt has a relative error of at most 1e-15, for any common factor of sine and cosine."""
    S, C = common * math.sin(tilt), common * math.cos(tilt)
    assert abs(angle_of(S, C) - mpmath.atan2(S, C)) <= 1e-15 * abs(tilt)


@given(TILTS)
def test_opposite_tilts(tilt):
    """Sine and tilt are odd and the cosine is even, to the last bit."""
    sine, cosine = sine_cosine_of_tilt(tilt)
    assert sine_cosine_of_tilt(-tilt) == (-sine, cosine)
    assert angle_of(-sine, cosine) == -angle_of(sine, cosine)


def test_beyond_flat_the_side_is_kept():
    """A disk that a long step takes beyond flat stays on its side."""
    for side in [-1.0, 1.0]:
        assert math.copysign(1.0, angle_of(side * math.sin(1.7), math.cos(1.7))) == side, side


@given(st.one_of(st.floats(-700.0, 700.0), st.floats(-1.0, 1.0), st.floats(-1e-9, 1e-9)))
def test_exponential(x):
    """exp(x) - 1 is right to a relative 4e-16 even for small x, or to 4e-16 where exp(x) is small."""
    with mpmath.workdps(30):
        truth = mpmath.expm1(x)
        assert abs(exp_minus_one(x) - truth) <= 4e-16 * (1 if x < -0.7 else abs(truth))


@given(st.one_of(st.floats(1e-300, 1e300), st.floats(0.5, 2.0)))
def test_logarithm(x):
    """The logarithm is right to a relative 4e-16, or to 4e-16 near one."""
    with mpmath.workdps(30):
        truth = mpmath.log(x)
        assert abs(logarithm(x) - truth) <= 4e-16 * max(1, abs(truth))
