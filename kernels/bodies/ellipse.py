"""Replacements of functions of `kernels.bodies.pair` for a meridian that is an arc of an ellipse.

They replace the functions of the same names for a circle.

With n = 1/sqrt(C^2 + q^2 S^2), where q^2 is the square of `kernels.bodies.shapes.Body`, a circle of radius `edge`
becomes the ellipse with the support function edge/n: a = core + edge n C, b = -shift - edge q^2 n S,
r = edge q^2 n^3.
"""

import math

from kernels.bodies.pair import (
    ALONG,
    COS,
    HEIGHT,
    LEVER,
    LONG,
    MIX,
    OF_ELLIPSE,
    SIN,
    WIDE,
    product,
)
from kernels.jit import kernel

#: Rows of a series: C^2 + q^2 S^2; n and its products with the sine, the cosine and itself; a - r C.
_ROUND, _NORMAL, _NORMAL_SIN, _NORMAL_COS, _NORMAL_SQUARE, _INNER = range(OF_ELLIPSE, OF_ELLIPSE + 6)


@kernel
def describe(series, body, k, first):
    """See `kernels.bodies.pair.describe`.

    The series of n = m^(-1/2), with m = C^2 + q^2 S^2, follows from m n' = -n m'/2.
    """
    S, C, rest, flat = series[SIN, k], series[COS, k], 1.0 - body.square, body.edge * body.square
    series[_ROUND, k] = first - rest * product(series, SIN, SIN, k)
    if k == 0:
        series[_NORMAL, 0] = 1.0 / math.sqrt(series[_ROUND, 0])
    else:
        total = 0.0
        for i in range(1, k + 1):
            total += (0.5 * i - k) * series[_ROUND, i] * series[_NORMAL, k - i]
        series[_NORMAL, k] = total / (k * series[_ROUND, 0])
    series[_NORMAL_SIN, k] = product(series, _NORMAL, SIN, k)
    series[_NORMAL_COS, k] = product(series, _NORMAL, COS, k)
    series[_NORMAL_SQUARE, k] = product(series, _NORMAL, _NORMAL, k)
    series[LONG, k] = body.core * first + body.edge * series[_NORMAL_COS, k]
    series[WIDE, k] = -body.shift * first - flat * series[_NORMAL_SIN, k]
    leaning = body.edge * rest * product(series, _NORMAL_SIN, COS, k)
    series[LEVER, k] = body.core * S - body.shift * C + leaning
    series[HEIGHT, k] = body.core * C + body.shift * S + body.edge * product(series, _ROUND, _NORMAL, k)
    series[_INNER, k] = series[LONG, k] - flat * product(series, _NORMAL_SQUARE, _NORMAL_COS, k)
    bent = flat * product(series, _NORMAL_SQUARE, _NORMAL_SIN, k)
    series[MIX, k] = bent + body.ratio * series[WIDE, k]


@kernel
def evolute_along(series, body, k):
    """See `kernels.bodies.pair.evolute_along`."""
    return product(series, _INNER, ALONG, k)


@kernel
def radius_of(series, body, k, first):
    """See `kernels.bodies.pair.radius_of`."""
    return body.edge * body.square * product(series, _NORMAL_SQUARE, _NORMAL, k)


#: Names of functions for a circle -> functions for an ellipse.
FUNCTIONS = {function.__name__: function for function in (describe, evolute_along, radius_of)}
