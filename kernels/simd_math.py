"""Elementary functions of the disk, each for the range that it needs, without calls of the C library.

A call would keep a loop over lanes scalar. `kernels.elementary` has functions for any argument; the functions here
are kept unchanged, so that atlases of the disk keep their bits.
"""

import math

import numpy as np

from kernels.jit import simd

#: pi/2 minus its double.
_REST_OF_QUARTER = 6.123233995736766e-17


@simd
def sine_cosine_of_tilt(tilt):
    """Return sine and cosine of an angle (`tilt`, at most pi/2 in magnitude), with relative errors of at most 3e-16.

    Taylor series in Horner form, of the angle or of pi/2 minus the angle; the first omitted terms are below 3e-18 of
    the sum at pi/4.
    """
    size = abs(tilt)
    steep = size > 0.25 * math.pi
    angle = (0.5 * math.pi - size) + _REST_OF_QUARTER if steep else size
    square = angle * angle
    sine, cosine = 1.0, 1.0
    for n in range(16, 0, -2):
        sine = 1.0 - square * (1.0 / (n * (n + 1.0))) * sine
        cosine = 1.0 - square * (1.0 / (n * (n - 1.0))) * cosine
    sine *= angle
    return math.copysign(cosine if steep else sine, tilt), sine if steep else cosine


@simd
def angle_of(S, C):
    """Return the angle of a sine and a cosine, or of a common multiple of both, with a relative error of at most 1e-15.

    For angles within pi/2 the tangent of an eighth of the angle is at most 1/5; eleven terms of the arc tangent are
    enough.
    """
    tangent = S / (math.sqrt(S * S + C * C) + C)
    for _ in range(2):
        tangent = tangent / (1.0 + math.sqrt(1.0 + tangent * tangent))
    square, total = tangent * tangent, 0.0
    for n in range(21, 0, -2):
        total = 1.0 / n - square * total
    return 8.0 * tangent * total


#: Adding this to a small integer as a float64 puts it into the lowest bits; C library conversions are not vectorised.
_TO_LOW_BITS = 1.5 * 2.0**52
_LN2_HIGH, _LN2_LOW = 0.6931471803691238, 1.9082149292705877e-10


@simd
def exp_minus_one(x):
    """Return exp(x) - 1 for x from -700 to 700, with a relative error of at most 3e-16 (absolute if exp(x) < 1/2).

    Taylor series of the remainder of x after subtracting multiples of ln 2; the first omitted term is below 1e-17.
    """
    shifted = x * (1.0 / math.log(2.0)) + _TO_LOW_BITS
    power = shifted - _TO_LOW_BITS
    rest = (x - power * _LN2_HIGH) - power * _LN2_LOW
    series = 1.0
    for n in range(14, 1, -1):
        series = 1.0 + rest * (1.0 / n) * series
    scale = np.int64((np.float64(shifted).view(np.int64) << 52) + np.float64(1.0).view(np.int64)).view(
        np.float64
    )
    return scale * (rest * series) + (scale - 1.0)


@simd
def logarithm(x):
    """Return the natural logarithm of a normal positive number, with a relative or absolute error of at most 3e-16.

    2 atanh((m-1)/(m+1)) of a mantissa m from 0.7 to 1.4; the first omitted term is below 1e-17.
    """
    bits = np.float64(x).view(np.int64) - np.float64(math.sqrt(0.5)).view(np.int64)
    power = bits >> 52
    m = np.int64(np.float64(x).view(np.int64) - (power << 52)).view(np.float64)
    z = (m - 1.0) / (m + 1.0)
    square, series = z * z, 0.0
    for n in range(21, 0, -2):
        series = 1.0 / n + square * series
    exponent = np.int64(power + np.float64(_TO_LOW_BITS).view(np.int64)).view(np.float64) - _TO_LOW_BITS
    return 2.0 * z * series + exponent * math.log(2.0)
