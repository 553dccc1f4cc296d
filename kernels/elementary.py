"""Elementary functions of any argument, without calls of the C library, which would prevent vectorisation over lanes.

Horner's scheme is written out, because a loop inside a lane function would keep the loop over lanes scalar. The
coefficients are those of Taylor's series; the first omitted term is below 1e-17 of the sum.
"""

import math

import numpy as np

from kernels.jit import simd

#: Largest angle of `sine_cosine`; up to it the number of quarter turns times `_QUARTER_1` is exact.
LARGEST_ANGLE = 1.6e6

#: Adding this to a small integer as a float64 puts it into the lowest bits; C library conversions are not vectorised.
_TO_LOW_BITS = 1.5 * 2.0**52

# pi/2 in three parts; the first two have 33 bits each
_QUARTER_1 = 1.57079632673412561417
_QUARTER_2 = 6.07710050630396597660e-11
_QUARTER_3 = 2.02226624879595063154e-21

# pi/4 in two parts
_EIGHTH_1, _EIGHTH_2 = 0.78539816339744830962, 3.06161699786838301793e-17

# ln 2 in two parts; the first has 32 bits
_LN2_1, _LN2_2 = 6.93147180369123816490e-01, 1.90821492927058770002e-10


@simd
def _sine_terms(z):
    """Return (sin(x) - x)/x^3 for z = x^2, x within pi/4."""
    return -1 / 6 + z * (
        1 / 120
        + z * (-1 / 5040 + z * (1 / 362880 + z * (-1 / 39916800 + z * (1 / 6227020800 - z / 1307674368000))))
    )


@simd
def _cosine_terms(z):
    """Return (cos(x) - 1 + x^2/2)/x^4 for z = x^2, x within pi/4."""
    return 1 / 24 + z * (
        -1 / 720
        + z
        * (1 / 40320 + z * (-1 / 3628800 + z * (1 / 479001600 + z * (-1 / 87178291200 + z / 20922789888000))))
    )


@simd
def sine_cosine(x):
    """Return sine and cosine, each with an error of at most 1 ulp; NaN beyond `LARGEST_ANGLE`."""
    shifted = x * (2.0 / math.pi) + _TO_LOW_BITS
    quarters, k = np.float64(shifted).view(np.int64), shifted - _TO_LOW_BITS
    # the rest of the angle in two parts, y and w, after Cody and Waite
    a = x - k * _QUARTER_1
    r = a - k * _QUARTER_2
    t = ((a - r) - k * _QUARTER_2) - k * _QUARTER_3
    y = r + t
    w = (r - y) + t
    z = y * y
    sine = y + (z * y * _sine_terms(z) + w * (1.0 - 0.5 * z))
    half = 0.5 * z
    near = 1.0 - half
    cosine = near + (((1.0 - near) - half) + (z * z * _cosine_terms(z) - y * w))
    swapped = (quarters & 1) != 0
    s, c = cosine if swapped else sine, sine if swapped else cosine
    s = -s if (quarters & 2) != 0 else s
    c = -c if ((quarters + 1) & 2) != 0 else c
    known = abs(x) <= LARGEST_ANGLE
    return s if known else math.nan, c if known else math.nan


@simd
def _exponential_terms(r):
    """Return (exp(r) - 1 - r)/r^2 for r within ln(2)/2."""
    return 1 / 2 + r * (
        1 / 6
        + r
        * (
            1 / 24
            + r
            * (
                1 / 120
                + r
                * (
                    1 / 720
                    + r
                    * (
                        1 / 5040
                        + r
                        * (
                            1 / 40320
                            + r
                            * (
                                1 / 362880
                                + r
                                * (1 / 3628800 + r * (1 / 39916800 + r * (1 / 479001600 + r / 6227020800)))
                            )
                        )
                    )
                )
            )
        )
    )


@simd
def exponential(x):
    """Return exp(x) with an error of at most 1 ulp; 0 below -745, infinite above 709.78."""
    bounded = -745.2 if x < -745.2 else (709.9 if x > 709.9 else x)
    shifted = bounded * (1.0 / math.log(2.0)) + _TO_LOW_BITS
    k = shifted - _TO_LOW_BITS
    high = bounded - k * _LN2_1
    r = high - k * _LN2_2
    low = (high - r) - k * _LN2_2
    mantissa = 1.0 + (r + (r * r * _exponential_terms(r) + low))
    # as two factors, because 2^k may be outside the range of normal numbers
    power = np.float64(shifted).view(np.int64) - np.float64(_TO_LOW_BITS).view(np.int64)
    first = power >> 1
    one = np.float64(1.0).view(np.int64)
    scaled = mantissa * np.int64((first << 52) + one).view(np.float64)
    found = scaled * np.int64(((power - first) << 52) + one).view(np.float64)
    return x if x != x else found


@simd
def logarithm(x):
    """Return the natural logarithm of a normal positive number, with an error of at most 1 ulp.

    The result is -inf for 0, inf for inf, and NaN for all other numbers. Uses 2 atanh(s), s = (m-1)/(m+1), of a
    mantissa m from sqrt(1/2) to sqrt(2).
    """
    bits = np.float64(x).view(np.int64)
    power = (bits - np.float64(math.sqrt(0.5)).view(np.int64)) >> 52
    m = np.int64(bits - (power << 52)).view(np.float64)
    k = np.int64(power + np.float64(_TO_LOW_BITS).view(np.int64)).view(np.float64) - _TO_LOW_BITS
    f = m - 1.0
    s = f / (2.0 + f)
    z = s * s
    # (2 atanh(s) - 2 s)/s
    rest = z * (
        2 / 3
        + z
        * (
            2 / 5
            + z
            * (
                2 / 7
                + z
                * (
                    2 / 9
                    + z * (2 / 11 + z * (2 / 13 + z * (2 / 15 + z * (2 / 17 + z * (2 / 19 + z * (2 / 21))))))
                )
            )
        )
    )
    # log(1 + f) = f - (f^2/2 - s (f^2/2 + rest)), without cancellation near 1
    half = 0.5 * f * f
    found = k * _LN2_1 - ((half - (s * (half + rest) + k * _LN2_2)) - f)
    found = found if x >= 2.2250738585072014e-308 else (-math.inf if x == 0.0 else math.nan)
    return x if x == math.inf else found


@simd
def hyperbolic_tangent(x):
    """Return tanh(x) with an error of at most 4 ulp."""
    size = abs(x)
    size = 22.0 if size > 22.0 else size
    # expm1(2 size), accurate for small arguments
    doubled = 2.0 * size
    shifted = doubled * (1.0 / math.log(2.0)) + _TO_LOW_BITS
    k = shifted - _TO_LOW_BITS
    high = doubled - k * _LN2_1
    r = high - k * _LN2_2
    low = (high - r) - k * _LN2_2
    scale = np.int64((np.float64(shifted).view(np.int64) << 52) + np.float64(1.0).view(np.int64)).view(
        np.float64
    )
    grown = scale * (r + (r * r * _exponential_terms(r) + low)) + (scale - 1.0)
    return math.copysign(grown / (grown + 2.0), x)


# fmt: off
@simd
def _arc_tangent_terms(z):
    """Return (atan(t) - t)/t^3 for z = t^2, t within tan(pi/8)."""
    return -1 / 3 + z * (1 / 5 + z * (-1 / 7 + z * (1 / 9 + z * (-1 / 11 + z * (1 / 13 + z * (-1 / 15 + z * (
        1 / 17 + z * (-1 / 19 + z * (1 / 21 + z * (-1 / 23 + z * (1 / 25 + z * (-1 / 27 + z * (1 / 29 + z * (
        -1 / 31 + z * (1 / 33 + z * (-1 / 35 + z * (1 / 37 + z * (-1 / 39 + z * (1 / 41 + z * (
        -1 / 43))))))))))))))))))))
# fmt: on


@simd
def arc_tangent(y, x):
    """Return the angle of the point (x, y) from the x axis, from -pi to pi, with an error of at most 4 ulp.

    As for math.atan2, the angle of (0, 0) is 0 or pi with the signs of its coordinates; NaN where both are infinite.
    """
    a, b = abs(x), abs(y)
    least, most = (a, b) if a < b else (b, a)
    # NaN stays, also for two infinities
    ratio = least / most if most != 0.0 else 0.0 * most
    # tan(pi/8)
    turned = ratio > 0.41421356237309503
    t = (ratio - 1.0) / (ratio + 1.0) if turned else ratio
    z = t * t
    angle = t + t * z * _arc_tangent_terms(z)
    angle = _EIGHTH_1 + (angle + _EIGHTH_2) if turned else angle
    angle = 2.0 * _EIGHTH_1 - (angle - 2.0 * _EIGHTH_2) if b > a else angle
    angle = 4.0 * _EIGHTH_1 - (angle - 4.0 * _EIGHTH_2) if math.copysign(1.0, x) < 0.0 else angle
    return math.copysign(angle, y) if x == x and y == y else math.nan


@simd
def rough_log2(x):
    """Return the binary logarithm of a positive normal number with an error of at most 0.09, by reading its bits."""
    # 39 bits after the point, because the exponent needs 13 of the 52 bits of a mantissa
    bits = (np.float64(x).view(np.int64) >> 13) + np.float64(_TO_LOW_BITS).view(np.int64)
    return (np.int64(bits).view(np.float64) - _TO_LOW_BITS) * 2.0**-39 - 1023.0


@simd
def rough_exp2(x):
    """Return 2^x for x within 1000, with a relative error of at most 0.07; the inverse of `rough_log2`."""
    bounded = -1000.0 if x < -1000.0 else (1000.0 if x > 1000.0 else x)
    shifted = (bounded + 1023.0) * 2.0**39 + _TO_LOW_BITS
    bits = np.float64(shifted).view(np.int64) - np.float64(_TO_LOW_BITS).view(np.int64)
    return np.int64(bits << 13).view(np.float64)
