"""Elementary functions without calls of the C library, which would keep a loop over lanes scalar."""

import math

from kernels.jit import simd

#: pi/2 minus its double.
_REST_OF_QUARTER = 6.123233995736766e-17


@simd
def sine_cosine(tilt):
    """Sine and cosine of an angle (`tilt`, at most pi/2 in magnitude), each with a relative error of at most 3e-16.

    Taylor's series in Horner form, of the angle or of pi/2 minus the angle; the first terms that are left out are below
    3e-18 of the sum at pi/4.
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
    """Angle of a sine and a cosine, or of a common multiple of both, with a relative error of at most 1e-15.

    For angles within pi/2 the tangent of an eighth of the angle is at most 1/5, where eleven terms of the arc tangent
    are enough.
    """
    tangent = S / (math.sqrt(S * S + C * C) + C)
    for _ in range(2):
        tangent = tangent / (1.0 + math.sqrt(1.0 + tangent * tangent))
    square, total = tangent * tangent, 0.0
    for n in range(21, 0, -2):
        total = 1.0 / n - square * total
    return 8.0 * tangent * total
