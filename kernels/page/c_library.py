"""Functions of the C library that kernels call, for a module without one; finite arguments, errors within 4 ulp.

Angles are within `kernels.elementary.LARGEST_ANGLE`.
"""

import math

import numpy as np

from kernels.elementary import exponential, hyperbolic_tangent, logarithm, sine_cosine
from kernels.jit import simd
from kernels.simd_math import angle_of


@simd
def sin(x):
    """Return the sine."""
    return sine_cosine(x)[0]


@simd
def cos(x):
    """Return the cosine."""
    return sine_cosine(x)[1]


@simd
def tan(x):
    """Return the tangent."""
    s, c = sine_cosine(x)
    return s / c


@simd
def expm1(x):
    """Return exp(x) - 1."""
    t = hyperbolic_tangent(0.5 * x)
    # exp(x) - 1 = 2 t / (1 - t), t = tanh(x/2), without cancellation for small x
    return 2.0 * t / (1.0 - t) if abs(x) < 1.0 else exponential(x) - 1.0


@simd
def log1p(x):
    """Return log(1 + x)."""
    u = 1.0 + x
    # corrects the rounding of 1 + x to first order
    return logarithm(u) - ((u - 1.0) - x) / u if u < math.inf else u


@simd
def sinh(x):
    """Return the hyperbolic sine."""
    e = expm1(abs(x))
    return math.copysign(0.5 * (e + e / (e + 1.0)) if e < math.inf else e, x)


@simd
def cosh(x):
    """Return the hyperbolic cosine."""
    e = exponential(abs(x))
    return 0.5 * e + 0.5 / e


@simd
def tanh(x):
    """Return the hyperbolic tangent."""
    return hyperbolic_tangent(x)


@simd
def log(x):
    """Return the natural logarithm."""
    return logarithm(x)


@simd
def exp(x):
    """Return the exponential function."""
    return exponential(x)


@simd
def log2(x):
    """Return the binary logarithm."""
    return logarithm(x) * (1.0 / math.log(2.0))


@simd
def pow(x, y):
    """Return a power of a positive number; exact if the number and the result are both powers of two."""
    bits = np.float64(x).view(np.int64)
    exponent = (bits - np.float64(math.sqrt(0.5)).view(np.int64)) >> 52
    whole, rest = y * exponent, y * logarithm(np.int64(bits - (exponent << 52)).view(np.float64))
    power = max(-1022.0, min(1023.0, math.floor(whole)))
    scale = np.int64((np.int64(power) + 1023) << 52).view(np.float64)
    return scale * exponential((whole - power) * math.log(2.0) + rest)


@simd
def asinh(x):
    """Return the inverse hyperbolic sine."""
    size = abs(x)
    root = math.sqrt(1.0 + size * size)
    far = logarithm(size) + math.log(2.0)
    near = log1p(size + size * size / (1.0 + root))
    return math.copysign(far if size > 1e100 else near, x)


@simd
def atan2(y, x):
    """Return the angle of the point (x, y)."""
    size = max(abs(y), abs(x))
    angle = angle_of(abs(y) / size, abs(x) / size) if size > 0.0 else 0.0
    turned = math.pi - angle if math.copysign(1.0, x) < 0.0 else angle
    return math.copysign(turned, y)


@simd
def atan(x):
    """Return the inverse tangent."""
    return atan2(x, 1.0)


@simd
def asin(x):
    """Return the inverse sine."""
    return atan2(x, math.sqrt((1.0 - x) * (1.0 + x)))


@simd
def acos(x):
    """Return the inverse cosine."""
    return atan2(math.sqrt((1.0 - x) * (1.0 + x)), x)


@simd
def hypot(x, y):
    """Return the length of the vector (x, y)."""
    size = max(abs(x), abs(y))
    known = 0.0 < size < math.inf
    a, b = x / size, y / size
    return size * math.sqrt(a * a + b * b) if known else size


#: Name in the C library -> function.
C_LIBRARY = {
    each.__name__: each
    for each in (
        *(sin, cos, tan, asin, acos, atan, atan2),
        *(exp, expm1, log, log1p, log2, pow),
        *(sinh, cosh, tanh, asinh, hypot),
    )
}
