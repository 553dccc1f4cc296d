"""The height of a saddle over the energy of a motion, with 31 digits (`kernels.double_double`).

In doubles the height is a difference of numbers of the order of one, and the period of a motion near a separatrix goes
like its logarithm. Here the rates are carried from the start to the saddle: with u = sin(tilt) they obey Legendre's
equation, ((1-u^2) s')' = -2 s/(1+alpha) with (1-u^2) s' = -p/(1+alpha), whose Taylor coefficients have a recurrence of
three terms. Source of the equations: as in `kernels.disk.exact.legendre`.
"""

import math

from kernels.disk.arrays import GRAVITY, PRECESSION_RATE, RADIUS, ROLL_RATE, TILT, TILT_RATE
from kernels.double_double import (
    add,
    divide,
    multiply,
    plus,
    scale,
    shrink,
    sine_cosine,
    square_root,
    subtract,
    times,
)
from kernels.jit import internal

#: Of the distance from a place to upright or flat, the nearer pole, so much is crossed by one Taylor series.
_REACH = 0.5
#: Terms at most, and the share of the sum below which terms are left out.
_MOST_TERMS, _LEAST = 140, 1e-31
#: Series at most: each brings a start near flat half as far again from its pole.
_MOST_SERIES = 40


@internal
def _square(a):
    return multiply(a, a)


@internal
def _carry(alpha, s, p, u, square, t):
    """(s, p) at u + t, from their values at u; `square` is 1 - u^2, `t` the distance."""
    stretch = plus(1.0, alpha)
    share, first = divide((2.0, 0.0), stretch), divide(multiply(p, t), multiply(stretch, square))
    a, d = divide(scale(multiply(u, t), 2.0), square), divide(multiply(t, t), square)
    before, term = s, (-first[0], -first[1])
    total, slope = add(s, term), term
    for n in range(_MOST_TERMS):
        ahead = multiply(a, scale(term, (n + 1.0) * (n + 1.0)))
        behind = multiply(d, multiply(add((n * (n + 1.0), 0.0), share), before))
        following = shrink(add(ahead, behind), (n + 1.0) * (n + 2.0))
        before, term = term, following
        total, slope = add(total, term), add(slope, scale(term, n + 2.0))
        if (n + 2.0) * (abs(term[0]) + abs(before[0])) <= _LEAST * (abs(total[0]) + abs(slope[0])):
            break
    there = add(u, t)
    rest = multiply(subtract((1.0, 0.0), there), add((1.0, 0.0), there))
    return total, divide(multiply(multiply(stretch, rest), slope), (-t[0], -t[1])), there, rest


@internal
def height_at(u, alpha, starts, cell):
    """(V - h, dV/dy) at sin(tilt) = `u`, both scaled, of the motion that starts in a cell; NaN if it is too far."""
    sin, cos = sine_cosine(starts[TILT, cell])
    precession = starts[PRECESSION_RATE, cell]
    s_0, o_0 = add((starts[ROLL_RATE, cell], 0.0), scale(sin, precession)), scale(cos, precession)
    s, p, place, rest = s_0, multiply(o_0, cos), sin, _square(cos)
    for _ in range(_MOST_SERIES):
        left = subtract((u, 0.0), place)
        if abs(left[0]) <= _LEAST:
            break
        reach = _REACH * rest[0] / (1.0 + abs(place[0]))
        step = left if abs(left[0]) <= reach else (math.copysign(reach, left[0]), 0.0)
        s, p, place, rest = _carry(alpha, s, p, place, rest, step)
    if abs(subtract((u, 0.0), place)[0]) > _LEAST:
        return math.nan, math.nan
    squares = scale(subtract(_square(s), _square(s_0)), 0.5)
    stretch = plus(1.0, alpha)
    turning = scale(subtract(divide(_square(p), rest), _square(o_0)), 0.25 * alpha)
    rate = starts[TILT_RATE, cell]
    kinetic = multiply(scale(plus(1.0, 0.5 * alpha), 0.5), times(rate, rate))
    unit = divide((starts[RADIUS, cell], 0.0), (starts[GRAVITY, cell], 0.0))
    rise = multiply(unit, subtract(add(multiply(stretch, squares), turning), kinetic))
    root = square_root(rest)
    height = add(rise, subtract(root, cos))
    o = p[0] / root[0]
    pull = (1.0 + alpha) * s[0] * p[0] - 0.5 * alpha * o * o * u
    return height[0], -(u * root[0] + unit[0] * pull)
