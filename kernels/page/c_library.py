"""The functions of the C library that kernels call, for a module that has none: of any finite argument, within 4 ulp.

Angles are within `kernels.elementary.LARGEST_ANGLE`.
"""

import math

import numpy as np

from kernels.elementary import exponential, hyperbolic_tangent, logarithm, sine_cosine
from kernels.jit import simd
from kernels.simd_math import angle_of


@simd
def sin(x):
    """Sine."""
    return sine_cosine(x)[0]


@simd
def cos(x):
    """Cosine."""
    return sine_cosine(x)[1]


@simd
def tan(x):
    """Tangent."""
    s, c = sine_cosine(x)
    return s / c


@simd
def expm1(x):
    """exp(x) - 1."""
    t = hyperbolic_tangent(0.5 * x)
    # exp(x) - 1 = 2 t / (1 - t), t = tanh(x/2), which loses nothing where x is small
    return 2.0 * t / (1.0 - t) if abs(x) < 1.0 else exponential(x) - 1.0


@simd
def log1p(x):
    """log(1 + x)."""
    u = 1.0 + x
    # what rounding has taken from 1 + x is given back in first order
    return logarithm(u) - ((u - 1.0) - x) / u if u < math.inf else u


@simd
def sinh(x):
    """Hyperbolic sine."""
    e = expm1(abs(x))
    return math.copysign(0.5 * (e + e / (e + 1.0)) if e < math.inf else e, x)


@simd
def cosh(x):
    """Hyperbolic cosine."""
    e = exponential(abs(x))
    return 0.5 * e + 0.5 / e


@simd
def tanh(x):
    """Hyperbolic tangent."""
    return hyperbolic_tangent(x)


@simd
def log(x):
    """Natural logarithm."""
    return logarithm(x)


@simd
def exp(x):
    """Exponential function."""
    return exponential(x)


@simd
def log2(x):
    """Binary logarithm."""
    return logarithm(x) * (1.0 / math.log(2.0))


@simd
def pow(x, y):
    """A positive number to a power; exact where both that number and the result are powers of two."""
    bits = np.float64(x).view(np.int64)
    exponent = (bits - np.float64(math.sqrt(0.5)).view(np.int64)) >> 52
    whole, rest = y * exponent, y * logarithm(np.int64(bits - (exponent << 52)).view(np.float64))
    power = max(-1022.0, min(1023.0, math.floor(whole)))
    scale = np.int64((np.int64(power) + 1023) << 52).view(np.float64)
    return scale * exponential((whole - power) * math.log(2.0) + rest)


@simd
def asinh(x):
    """Inverse of the hyperbolic sine."""
    size = abs(x)
    root = math.sqrt(1.0 + size * size)
    far = logarithm(size) + math.log(2.0)
    near = log1p(size + size * size / (1.0 + root))
    return math.copysign(far if size > 1e100 else near, x)


@simd
def atan2(y, x):
    """Angle of the point (x, y)."""
    size = max(abs(y), abs(x))
    angle = angle_of(abs(y) / size, abs(x) / size) if size > 0.0 else 0.0
    turned = math.pi - angle if math.copysign(1.0, x) < 0.0 else angle
    return math.copysign(turned, y)


@simd
def atan(x):
    """Inverse of the tangent."""
    return atan2(x, 1.0)


@simd
def asin(x):
    """Inverse of the sine."""
    return atan2(x, math.sqrt((1.0 - x) * (1.0 + x)))


@simd
def acos(x):
    """Inverse of the cosine."""
    return atan2(math.sqrt((1.0 - x) * (1.0 + x)), x)


@simd
def hypot(x, y):
    """Length of the vector (x, y)."""
    size = max(abs(x), abs(y))
    known = 0.0 < size < math.inf
    a, b = x / size, y / size
    return size * math.sqrt(a * a + b * b) if known else size


#: Name -> function, as C has them.
C_LIBRARY = {
    each.__name__: each
    for each in (
        *(sin, cos, tan, asin, acos, atan, atan2),
        *(exp, expm1, log, log1p, log2, pow),
        *(sinh, cosh, tanh, asinh, hypot),
    )
}
