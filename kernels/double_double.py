"""Arithmetic with 31 digits: a number is the sum of two doubles, the second one half a last place of the first at most.

Sources: Dekker, Numer. Math. 18 (1971) 224; Knuth, The Art of Computer Programming 2, 4.2.2. The relative error of an
operation is at most 2^-102 (Joldes, Muller, Popescu, ACM Trans. Math. Softw. 44 (2017) 15res). Nothing here may be
contracted: the error of a rounded product or sum is computed from it.
"""

import math

import numpy as np

from kernels.jit import uncontracted

#: The bits of a double without the last 27: such parts of two doubles have an exact product.
_UPPER = np.int64(-1 << 27)
#: pi/2 minus its double, and what that leaves.
_REST_OF_QUARTER = 6.123233995736766e-17
_REST_OF_REST = -1.4973849048591698e-33
#: Terms of the series of sine and cosine up to pi/4: the first one that is left out is below 1e-33.
_TERMS = 28


@uncontracted
def plus(a, b):
    """A + b of two doubles."""
    total = a + b
    of_b = total - a
    return total, (a - (total - of_b)) + (b - of_b)


@uncontracted
def _halves(a):
    upper = np.int64(np.float64(a).view(np.int64) & _UPPER).view(np.float64)
    return upper, a - upper


@uncontracted
def times(a, b):
    """A b of two doubles."""
    product = a * b
    (a_1, a_2), (b_1, b_2) = _halves(a), _halves(b)
    return product, ((a_1 * b_1 - product) + a_1 * b_2 + a_2 * b_1) + a_2 * b_2


@uncontracted
def add(a, b):
    """A + b."""
    high, low = plus(a[0], b[0])
    next_, rest = plus(a[1], b[1])
    high, low = plus(high, low + next_)
    return plus(high, low + rest)


@uncontracted
def negative(a):
    """-a."""
    return -a[0], -a[1]


@uncontracted
def subtract(a, b):
    """A - b."""
    return add(a, negative(b))


@uncontracted
def multiply(a, b):
    """A b."""
    high, low = times(a[0], b[0])
    return plus(high, low + (a[0] * b[1] + a[1] * b[0]))


@uncontracted
def scale(a, factor):
    """A times a double."""
    high, low = times(a[0], factor)
    return plus(high, low + a[1] * factor)


@uncontracted
def shrink(a, divisor):
    """A over a double."""
    first = a[0] / divisor
    high, low = times(first, divisor)
    return plus(first, ((a[0] - high) - low + a[1]) / divisor)


@uncontracted
def divide(a, b):
    """A / b: three steps of long division."""
    first = a[0] / b[0]
    rest = subtract(a, scale(b, first))
    second = rest[0] / b[0]
    rest = subtract(rest, scale(b, second))
    return add(plus(first, second), (rest[0] / b[0], 0.0))


@uncontracted
def square_root(a):
    """Square root of a positive number: that of the double, and one Newton step."""
    root = math.sqrt(a[0])
    return plus(root, subtract(a, times(root, root))[0] / (2.0 * root))


@uncontracted
def sine_cosine(angle):
    """Sine and cosine of a double, at most pi/2 in magnitude."""
    size, whole = abs(angle), (1.0, 0.0)
    steep = size > 0.25 * math.pi
    x = (size, 0.0)
    if steep:
        x = add(plus(0.5 * math.pi, -size), (_REST_OF_QUARTER, _REST_OF_REST))
    square = negative(multiply(x, x))
    sine, cosine = whole, whole
    for n in range(_TERMS, 0, -2):
        sine = add(whole, shrink(multiply(square, sine), n * (n + 1.0)))
        cosine = add(whole, shrink(multiply(square, cosine), n * (n - 1.0)))
    sine = multiply(sine, x)
    if steep:
        sine, cosine = cosine, sine
    return negative(sine) if angle < 0.0 else sine, cosine
