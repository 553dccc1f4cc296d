"""Sines, cosines and tilts in vector code, which a call of the C library would keep from being one."""

import math

from numba import njit

from kernels.disk import CONTRACT


@njit(error_model="numpy", fastmath=CONTRACT, inline="always")
def sine_cosine(tilt):
    """Sine and cosine of a tilt of at most pi/2, to 3e-16 (the sine of a small one to as much of itself).

    Taylor's series, nested; the first terms that are left out, tilt^23/23! and tilt^22/22!, are 2e-17 at pi/2.
    """
    square = tilt * tilt
    sine, cosine = 1.0, 1.0
    for n in range(20, 0, -2):
        sine = 1.0 - square * (1.0 / (n * (n + 1.0))) * sine
        cosine = 1.0 - square * (1.0 / (n * (n - 1.0))) * cosine
    return tilt * sine, cosine


@njit(error_model="numpy", fastmath=CONTRACT, inline="always")
def tilt_of(S, C):
    """Tilt of a sine and a cosine, or of a common multiple of both, to 1e-15 of itself.

    The tangent of an eighth of it is 1/5 at most within pi/2, where eleven terms of the arc tangent are enough.
    """
    tangent = S / (math.sqrt(S * S + C * C) + C)
    for _ in range(2):
        tangent = tangent / (1.0 + math.sqrt(1.0 + tangent * tangent))
    square, total = tangent * tangent, 0.0
    for n in range(21, 0, -2):
        total = 1.0 / n - square * total
    return 8.0 * tangent * total
