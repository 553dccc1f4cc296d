"""What differs where the meridian is an arc of an ellipse: functions in the place of those of equal names for a circle.

With n = 1/sqrt(C^2 + q^2 S^2), where q^2 is the square of `kernels.bodies.shapes.Body`, a circle of the radius `edge`
becomes the ellipse of the support function edge/n: a = core + edge n C, b = -shift - edge q^2 n S, r = edge q^2 n^3.
"""

import math

from kernels.bodies.equations import per_inertia
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
from kernels.jit import kernel, simd

#: Rows of a series: C^2 + q^2 S^2; n and its products with the sine, the cosine and itself; a - r C.
_ROUND, _NORMAL, _NORMAL_SIN, _NORMAL_COS, _NORMAL_SQUARE, _INNER = range(OF_ELLIPSE, OF_ELLIPSE + 6)


@simd
def _root(S, body):
    """1/n of the docstring of the module."""
    return math.sqrt(1.0 - (1.0 - body.square) * S * S)


@simd
def levers(S, C, body):
    """See `kernels.bodies.equations.levers`."""
    n, rest = 1.0 / _root(S, body), 1.0 - body.square
    long, wide = body.core + body.edge * n * C, -(body.shift + body.edge * (body.square * n) * S)
    return long, wide, body.core * S - body.shift * C + body.edge * n * rest * S * C


@simd
def curvature_radius(S, C, body):
    """See `kernels.bodies.equations.curvature_radius`."""
    n = 1.0 / _root(S, body)
    return body.edge * body.square * n * n * n


@simd
def evolute(S, C, body):
    """See `kernels.bodies.equations.evolute`."""
    n = 1.0 / _root(S, body)
    return body.core + body.edge * n * C * (1.0 - body.square * n * n)


@simd
def height(S, C, body):
    """See `kernels.bodies.equations.height`."""
    return body.core * C + body.shift * S + body.edge * _root(S, body)


@simd
def excess(S, C, body):
    """See `kernels.bodies.equations.excess`."""
    return height(S, C, body) - curvature_radius(S, C, body)


@simd
def energy_gained(state, start, body, axial):
    """See `kernels.bodies.equations.energy_gained`."""
    S, C, _, w, o, s = state
    S0, C0, w0, o0, s0 = start
    a, b, _ = levers(S, C, body)
    a0, b0, _ = levers(S0, C0, body)
    rise, fall = S - S0, -(S - S0) * (S + S0) / (C + C0)
    root, root0 = _root(S, body), _root(S0, body)
    rooted = -(1.0 - body.square) * rise * (S + S0) / (root + root0)
    # the gain of n
    more = -rooted / (root * root0)
    longer = body.edge * (fall / root + C0 * more)
    wider = -body.edge * body.square * (rise / root + S0 * more)
    v, v0 = a * s + b * o, a0 * s0 + b0 * o0
    faster = a * (s - s0) + s0 * longer + b * (o - o0) + o0 * wider
    return (
        0.5 * (w - w0) * (w + w0) / per_inertia(S, C, body)
        + 0.5 * (longer * (a + a0) + wider * (b + b0)) * w0 * w0
        + 0.5 * body.transverse * (o - o0) * (o + o0)
        + 0.5 * body.axial * (s - s0) * (s + s0)
        + 0.5 * faster * (v + v0)
        + body.core * fall
        + body.shift * rise
        + body.edge * rooted
    )


@simd
def pull_and_terms(state, body):
    """See `kernels.bodies.equations.pull_and_terms`."""
    S, C, T, _, o, s = state
    a, b, lever = levers(S, C, body)
    A, I = body.transverse, body.axial
    oT, arm = o * T, a - b * T
    pull = abs(lever + o * (I * s - A * oT + arm * (a * s + b * o)))
    heavy = body.core * abs(S) + abs(body.shift) * C
    heavy += body.edge * abs(1.0 - body.square) * abs(S) * C / _root(S, body)
    return pull, heavy + abs(o) * (I * abs(s) + A * abs(oT) + abs(arm) * (abs(a * s) + abs(b * o)))


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


#: Names of functions for a circle -> those for an ellipse.
FUNCTIONS = {
    each.__name__: each
    for each in (
        levers, curvature_radius, evolute, excess, height, energy_gained, pull_and_terms, describe, evolute_along,
        radius_of,
    )
}  # fmt: skip
