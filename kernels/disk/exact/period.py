"""The nutation period of bounded motions: a quadrature between the two turning points (scaled), side by side.

The period is 2 int dtilt/v with v^2 = -4 excess/(2 + alpha). With distance = MIDDLE + HALF cos(angle), from one turning
point to the other, the integrand becomes smooth, even and periodic: the error of the trapezoidal sum is about squared
with each doubling of its places.

Near a separatrix the motion is slow at the saddle, where the integrand has a pair of poles or a second root near the
interval. There the distance is ANCHOR + WIDTH sinh(u) about the saddle (PASSES) or ANCHOR + WIDTH (cosh(u) - 1) from
the turning point before it, with u = MIDDLE + HALF times a cosine with crowded ends: the cost grows more slowly than
the logarithm of the distance from the separatrix. Between ANCHOR and WIDTH lie the two roots of the excess next to the
saddle, complex ones if the motion passes. With those of the parabola that touches V at the saddle the sums of circling
disks would need 48 and 64 intervals where most are given 40.

The rows of a block are those of `kernels.disk.exact.period_layout`; w and q are explained in
`kernels.disk.exact.wide_panels`.
"""

import math

import numpy as np

from kernels.disk.exact import period_layout as at
from kernels.disk.exact.legendre import DP1, DP2, DS1, DS2, NODES, REACH
from kernels.disk.exact.period_layout import LANES
from kernels.disk.exact.potential import rise, rise_at
from kernels.disk.exact.wide_panels import CENTRES, SIDE, SPACING, STRIDE, W_ONE, W_PP, W_SP, W_SS
from kernels.jit import kernel, simd
from kernels.simd_math import exp_minus_one, logarithm

#: Wide panels from one that is used to the next, their distance in y; up to which distance the first one is used
#: alone.
PIECE_STRIDE = 3
PIECE = PIECE_STRIDE * SPACING
ALONE = 0.8
_ALONE = math.tanh(0.5 * ALONE)
#: Groups of coefficients of Q that are enough for w up to 0.1 and 0.2: what is left out is below 2e-16.
SHORT, LONG = 2, 3
SHORT_REACH, LONG_REACH = 2.0 * math.atanh(0.1), 2.0 * math.atanh(0.2)
#: Share of an interval by which a place may be said to lie elsewhere.
_SLACK = 0.01
#: Coefficients of V that tell its expansion about a saddle; the expansion tells the roots if the square of their
#: distance times V'''/(6 V'') is less than this.
_SADDLE_TERMS, _FOLD = 24, 0.05
#: How far the places of the sums crowd at the ends, see `_crowded`: chosen among 0, 0.03, 0.045 and 0.06 by the errors
#: over several kinds of starts, for some of which 0.06 was better. The slope of `_crowded` by the sine at the ends, and
#: by the angle in the middle between these.
_CROWD = 0.045
_AT_END, _AT_MIDDLE = (1.0 - 9.0 * _CROWD) / (1.0 - _CROWD), (1.0 + 3.0 * _CROWD) / (1.0 - _CROWD)
#: Steps of Newton's method that are enough to find an angle to far less than _SLACK.
_NEWTON_STEPS = 4
#: Cosines and sines of half the angles of the places, for numbers of intervals that divide this one: the first and the
#: second sums of nearly all motions. Computing them took 6 % of the time of the periods of circling disks.
_MOST_KEPT = 960
_HALF_ANGLES = [0.5 * i * (math.pi / _MOST_KEPT) for i in range(_MOST_KEPT)]
_HALF_COSINES = np.array([math.cos(each) for each in _HALF_ANGLES])
_HALF_SINES = np.array([math.sin(each) for each in _HALF_ANGLES])


@simd
def _half_tangent(y):
    """tanh(y/2), with all digits however small y is."""
    grown = exp_minus_one(abs(y))
    return math.copysign(grown / (grown + 2.0), y)


@simd
def _limit(w, cosh, sinh, slope, stretch):
    """Half of the integrand at a turning point, where it is 0/0; `stretch` is the second derivative of the place."""
    q = cosh * (1.0 + w * w) + 2.0 * sinh * w
    return 0.5 / q * math.sqrt((1.0 - w * w) * stretch / abs(slope))


@kernel
def _prepare(block, centre):
    """Turn the places and distances of a block from y into w: those in W_0, FIRST and SECOND.

    Returns whether all motions of the block stay on one wide panel.
    """
    others = 0
    for lane in range(LANES):
        w_0 = _half_tangent(block[at.W_0 + lane] - centre)
        rest = 1.0 - w_0 * w_0
        first, second = _half_tangent(block[at.FIRST + lane]), _half_tangent(block[at.SECOND + lane])
        first, second = rest * first / (1.0 + w_0 * first), rest * second / (1.0 + w_0 * second)
        farthest = max(abs(w_0 + first), abs(w_0 + second))
        block[at.W_0 + lane] = w_0
        block[at.FIRST + lane], block[at.SECOND + lane] = first, second
        block[at.EDGE + lane] = 1.0 if farthest <= _ALONE else math.tanh(0.25 * PIECE)
        block[at.SUM_4 + lane] = block[at.SUM_2 + lane] = block[at.SUM_1 + lane] = 0.0
        others |= int(farthest > _ALONE)
    return others == 0


@kernel
def _substitute(block, cosh, sinh):
    """Choose the substitution of motions far from a separatrix, and the ends of their sums."""
    for lane in range(LANES):
        w_0, first, second = block[at.W_0 + lane], block[at.FIRST + lane], block[at.SECOND + lane]
        half = 0.5 * abs(first - second)
        block[at.MIDDLE + lane], block[at.HALF + lane] = 0.5 * (first + second), half
        ends = _limit(w_0 + first, cosh, sinh, block[at.FIRST_SLOPE + lane], half)
        ends += _limit(w_0 + second, cosh, sinh, block[at.SECOND_SLOPE + lane], half)
        block[at.ENDS + lane] = ends


@kernel
def _expand_about_saddles(block, wide, upright):
    """Expand V about each saddle, into V_0 to V_5; PLACE_OF_SADDLE becomes a place on the panel `upright`.

    No saddle is beyond w = 0.19 there, where a few terms tell these coefficients well enough.
    """
    for lane in range(LANES):
        block[at.PLACE_OF_SADDLE + lane] = _half_tangent(block[at.PLACE_OF_SADDLE + lane])
        for k in range(at.V_TERMS):
            block[at.V_0 + k * LANES + lane] = 0.0
    for n in range(_SADDLE_TERMS - 1, -1, -1):
        ss, sp, pp, one = (
            wide[upright, W_SS, n],
            wide[upright, W_SP, n],
            wide[upright, W_PP, n],
            wide[upright, W_ONE, n],
        )
        for lane in range(LANES):
            s, p, place = block[at.C_1 + lane], block[at.C_2 + lane], block[at.PLACE_OF_SADDLE + lane]
            for k in range(at.V_TERMS - 1, 0, -1):
                below = block[at.V_0 + (k - 1) * LANES + lane]
                block[at.V_0 + k * LANES + lane] = below + place * block[at.V_0 + k * LANES + lane]
            coefficient = s * (s * ss + p * sp) + (p * p * pp + one)
            block[at.V_0 + lane] = coefficient + place * block[at.V_0 + lane]


@kernel
def _find_roots_at_saddles(block, wide, upright, centre):
    """Write AWAY and WIDTH: the middle of the two roots of the excess next to each saddle, and half their distance.

    About the saddle the excess is that of a parabola times 1 + V_3/V_2 x + ..., and its roots are a series in those of
    the parabola, +-t: t - b1 t^2 + (2 b1^2 - b2) t^3 + ..., with 1 + b1 x + ... the square root of that factor. The
    even powers make the middle. Near a fold the series says nothing, and is left out.
    """
    _expand_about_saddles(block, wide, upright)
    shift = math.tanh(0.5 * centre)
    rest = 1.0 - shift * shift
    for lane in range(LANES):
        place, w_0 = block[at.PLACE_OF_SADDLE + lane], block[at.W_0 + lane]
        scale = 0.5 * (1.0 - place * place)
        square = block[at.SQUARE + lane] * scale * scale
        b1 = 0.5 * block[at.V_3 + lane] / block[at.V_2 + lane]
        b2 = 0.5 * (block[at.V_4 + lane] / block[at.V_2 + lane] - b1 * b1)
        b3 = 0.5 * block[at.V_5 + lane] / block[at.V_2 + lane] - b1 * b2
        near = abs(square) * max(b1 * b1, abs(b2)) < _FOLD
        middle = square * (square * (5.0 * b1 * (b2 - b1 * b1) - b3) - b1)
        size = 1.0 + square * (2.0 * b1 * b1 - b2)
        middle, size = middle if near else 0.0, math.sqrt(abs(square)) * (size if near else 1.0)
        # the saddle itself is known to few digits more than its height needs
        middle -= 0.5 * block[at.V_1 + lane] / block[at.V_2 + lane]
        # from the panel at upright to that of the motion, by differences: a saddle can lie next to the start
        square = math.copysign(size * size, square) if near else 0.0
        at_saddle = 1.0 - shift * place
        below = at_saddle - shift * middle
        stretch = rest / (below * below - shift * shift * square)
        away = _half_tangent(block[at.AWAY + lane])
        away = (1.0 - w_0 * w_0) * away / (1.0 + w_0 * away)
        away += stretch * (middle * below + shift * square) / at_saddle
        passes = block[at.PASSES + lane] > 0.0
        block[at.AWAY + lane] = away
        block[at.WIDTH + lane] = stretch * size if passes else block[at.SECOND + lane] - away


@kernel
def _substitute_saddle(block, cosh, sinh):
    """Choose the substitution of motions near a separatrix, and the ends of their sums.

    SECOND is the turning point next to the saddle of a motion that turns before it.
    """
    for lane in range(LANES):
        w_0, first, second = block[at.W_0 + lane], block[at.FIRST + lane], block[at.SECOND + lane]
        away, width, passes = block[at.AWAY + lane], block[at.WIDTH + lane], block[at.PASSES + lane] > 0.0
        far = (first - away) / width
        near = (second - away) / width if passes else 1.0
        sign = 1.0 if passes else -1.0
        # of a motion that turns before its saddle both are positive
        sinh_1, sinh_2 = math.sqrt(far * far + sign), math.sqrt(near * near + sign)
        u_1, u_2 = logarithm(abs(far) + sinh_1), logarithm(abs(near) + sinh_2)
        u_1, u_2 = math.copysign(u_1, far), math.copysign(u_2, near) if passes else 0.0
        middle, half = 0.5 * (u_1 + u_2) if passes else 0.0, 0.5 * (u_1 - u_2) if passes else u_1
        size = abs(width)
        block[at.ANCHOR + lane] = away if passes else second
        block[at.MIDDLE + lane], block[at.HALF + lane] = middle, half
        # cosh(u) of the one substitution, sinh(u) of the other; next to the saddle of the latter the limit of u^2/2
        ends = _limit(w_0 + first, cosh, sinh, block[at.FIRST_SLOPE + lane], _AT_END * half * size * sinh_1)
        last = _AT_END * half * size * sinh_2 if passes else (_AT_MIDDLE * half) ** 2 * size
        block[at.ENDS + lane] = ends + _limit(w_0 + second, cosh, sinh, block[at.SECOND_SLOPE + lane], last)


@kernel
def _expand(block, alpha, table, nodes, wide, centre, w_shift, groups):
    """Expand the excess on the wide panel of this number: Q, A_0 and A_1.

    `w_shift` is the place of its centre, LOW and HIGH are where it counts.
    """
    panel, node = table * CENTRES + SIDE + centre, table * NODES + 2 * (REACH + STRIDE * centre)
    ds1, ds2, dp1, dp2 = nodes[node, DS1], nodes[node, DS2], nodes[node, DP1], nodes[node, DP2]
    for lane in range(LANES):
        w_0, c1, c2 = block[at.W_0 + lane], block[at.C_1 + lane], block[at.C_2 + lane]
        about = (w_0 > block[at.LOW + lane]) & (w_0 <= block[at.HIGH + lane])
        block[at.ABOUT + lane] = 1.0 if about else 0.0
        block[at.ROOT + lane] = (w_0 - w_shift) / (1.0 - w_0 * w_shift) if about else 0.0
        block[at.S_HERE + lane] = c1 + (ds1 * c1 + ds2 * c2)
        block[at.P_HERE + lane] = c2 + (dp1 * c1 + dp2 * c2)
    _divide(block, wide, panel, groups)
    there = rise_at(nodes, node)
    for lane in range(LANES):
        about, root = block[at.ABOUT + lane] > 0.0, block[at.ROOT + lane]
        level = rise(alpha, there, block[at.C_1 + lane], block[at.C_2 + lane]) - block[at.BASE + lane]
        s, p = block[at.S_HERE + lane], block[at.P_HERE + lane]
        slope = s * s * wide[panel, W_SS, 1] + s * p * wide[panel, W_SP, 1]
        slope += p * p * wide[panel, W_PP, 1] + wide[panel, W_ONE, 1]
        block[at.A_0 + lane] = -block[at.KINETIC + lane] if about else level
        block[at.A_1 + lane] = -2.0 * block[at.FORCE + lane] / (1.0 - root * root) if about else slope


@kernel
def _divide(block, wide, panel, groups):
    """Divide V on a wide panel twice by the distance from ROOT, by synthetic division, into so many groups of Q."""
    for lane in range(LANES):
        block[at.ONCE + lane] = block[at.TWICE + lane] = 0.0
    for n in range(groups * at.GROUP + 1, 1, -1):
        ss, sp, pp, one = (
            wide[panel, W_SS, n],
            wide[panel, W_SP, n],
            wide[panel, W_PP, n],
            wide[panel, W_ONE, n],
        )
        for lane in range(LANES):
            s, p, root = block[at.S_HERE + lane], block[at.P_HERE + lane], block[at.ROOT + lane]
            once = (s * (s * ss + p * sp) + (p * p * pp + one)) + root * block[at.ONCE + lane]
            block[at.ONCE + lane] = once
            block[at.TWICE + lane] = once + root * block[at.TWICE + lane]
        first = at.Q + (n - 2) * LANES
        for lane in range(LANES):
            block[first + lane] = block[at.TWICE + lane]


@kernel
def _place(block, cos, sin):
    """DISTANCE and STRETCH at an angle."""
    for lane in range(LANES):
        half = block[at.HALF + lane]
        block[at.DISTANCE + lane] = block[at.MIDDLE + lane] + half * cos
        block[at.STRETCH + lane] = half * sin


@kernel
def _crowded(cos, sin):
    """(cos(a) - _CROWD cos(3 a))/(1 - _CROWD) of an angle, given its cosine and sine, and minus the derivative by a.

    Next to the ends it moves more slowly than the cosine, and more quickly in the middle, where a substitution near a
    separatrix makes the integrand nearly constant.
    """
    crowded = cos * ((1.0 + 3.0 * _CROWD) - 4.0 * _CROWD * cos * cos)
    slope = sin * ((1.0 - 9.0 * _CROWD) + 12.0 * _CROWD * sin * sin)
    return crowded / (1.0 - _CROWD), slope / (1.0 - _CROWD)


@kernel
def _uncrowded(crowded):
    """The cosine of the angle whose `_crowded` cosine is given."""
    cos = crowded
    for _ in range(_NEWTON_STEPS):
        excess = cos * ((1.0 + 3.0 * _CROWD) - 4.0 * _CROWD * cos * cos) - (1.0 - _CROWD) * crowded
        cos -= excess / ((1.0 + 3.0 * _CROWD) - 12.0 * _CROWD * cos * cos)
    return max(-1.0, min(1.0, cos))


@kernel
def _place_saddle(block, cos, sin, half_cos, half_sin):
    """DISTANCE and STRETCH at an angle, of the substitutions near a separatrix; of the second one at half the angle."""
    for lane in range(LANES):
        half, width, passes = block[at.HALF + lane], block[at.WIDTH + lane], block[at.PASSES + lane] > 0.0
        u = block[at.MIDDLE + lane] + half * (cos if passes else half_cos)
        power = 1.0 + exp_minus_one(abs(u))
        inverse = 1.0 / power
        cosh, sinh = 0.5 * (power + inverse), math.copysign(0.5 * (power - inverse), u)
        block[at.DISTANCE + lane] = block[at.ANCHOR + lane] + width * (sinh if passes else cosh - 1.0)
        stretch = cosh * sin if passes else sinh * half_sin
        block[at.STRETCH + lane] = abs(width) * half * stretch


@kernel
def _locate(block, shift):
    """PLACE on the present wide panel, and AWAY_THERE: the distance from the start or from the panel's centre."""
    if shift == 0.0:
        for lane in range(LANES):
            block[at.PLACE + lane] = block[at.W_0 + lane] + block[at.DISTANCE + lane]
            block[at.AWAY_THERE + lane] = (
                block[at.DISTANCE + lane] if block[at.ABOUT + lane] > 0.0 else block[at.PLACE + lane]
            )
        return
    rest = 1.0 - shift * shift
    for lane in range(LANES):
        w_0, distance = block[at.W_0 + lane], block[at.DISTANCE + lane]
        below = 1.0 / (1.0 - (w_0 + distance) * shift)
        place = (w_0 + distance - shift) * below
        from_start = distance * rest * below / (1.0 - w_0 * shift)
        block[at.PLACE + lane] = place
        block[at.AWAY_THERE + lane] = from_start if block[at.ABOUT + lane] > 0.0 else place


@simd
def _continue(block, group, lane, value):
    """Continue Horner's rule for Q at PLACE with the coefficients of a group."""
    for n in range((group + 1) * at.GROUP - 1, group * at.GROUP - 1, -1):
        value = value * block[at.PLACE + lane] + block[at.Q + n * LANES + lane]
    return value


@kernel
def _add(block, place, cosh, sinh, groups):
    """Add the integrand at places of this number that lie on the present wide panel to the sums that they belong to."""
    # a factor each, as the compiler makes scalar code of a row that it does not know
    odd, second = (1.0 if place % 2 == 1 else 0.0), (1.0 if place % 4 == 2 else 0.0)
    fourth = 1.0 - odd - second
    for lane in range(LANES):
        block[at.PART + lane] = 0.0
    if groups > LONG:
        for lane in range(LANES):
            block[at.PART + lane] = _continue(block, 3, lane, _continue(block, 4, lane, 0.0))
    if groups > SHORT:
        for lane in range(LANES):
            block[at.PART + lane] = _continue(block, 2, lane, block[at.PART + lane])
    for lane in range(LANES):
        distance, away = block[at.DISTANCE + lane], block[at.AWAY_THERE + lane]
        w = block[at.W_0 + lane] + distance
        value = _continue(block, 0, lane, _continue(block, 1, lane, block[at.PART + lane]))
        kinetic = -(block[at.A_0 + lane] + away * (block[at.A_1 + lane] + away * value))
        square = cosh * (1.0 + w * w) + 2.0 * sinh * w
        square *= square
        inverse = 1.0 / (square * kinetic)
        part = block[at.STRETCH + lane] * math.sqrt(inverse)
        size = 2.0 * abs(distance)
        terms = (block[at.PULL + lane] + block[at.CURVATURE + lane] * size) * size
        level = block[at.LEVEL + lane]
        error = block[at.KINETIC + lane] + (terms if terms < level else level)
        here = (w > block[at.LOW + lane]) & (w <= block[at.HIGH + lane])
        part = part if here else 0.0
        block[at.ERROR + lane] += part * (square * inverse) * error if here else 0.0
        block[at.SUM_1 + lane] += odd * part
        block[at.SUM_2 + lane] += second * part
        block[at.SUM_4 + lane] += fourth * part


@kernel
def _enter(block, piece):
    """Write from where to where a piece counts in LOW and HIGH; whether any motion gets there."""
    far, some = math.tanh(0.5 * PIECE * (abs(piece) + 0.5)), 0
    near = math.tanh(0.5 * PIECE * (abs(piece) - 0.5))
    for lane in range(LANES):
        edge, w_0 = block[at.EDGE + lane], block[at.W_0 + lane]
        begin = edge if abs(piece) == 1 else near
        end = edge if piece == 0 else far
        begin = -edge if piece == 0 else begin
        low, high = (begin, end) if piece >= 0 else (-end, -begin)
        block[at.LOW + lane], block[at.HIGH + lane] = low, high
        first, second = w_0 + block[at.FIRST + lane], w_0 + block[at.SECOND + lane]
        some |= int(((first > low) | (second > low)) & ((first <= high) | (second <= high)))
    return some != 0


@simd
def _cosine(block, lane, w, saddle):
    """Cosine of the angle (of half of it, in the second substitution near a separatrix) at which w is passed."""
    away = block[at.W_0 + lane] + block[at.ANCHOR + lane] if saddle else block[at.W_0 + lane]
    u = w - away
    if saddle:
        u /= block[at.WIDTH + lane]
        passes = block[at.PASSES + lane] > 0.0
        u = u if passes or u > 0.0 else 0.0
        size = abs(u)
        root = math.sqrt(size * size + 1.0 if passes else size * (size + 2.0))
        u = math.copysign(logarithm(root + (size if passes else size + 1.0)), u)
    return (u - block[at.MIDDLE + lane]) / block[at.HALF + lane]


@kernel
def _first_and_last(block, saddle, intervals):
    """Numbers of the first and the last place that may lie on the present wide panel, in any motion."""
    for lane in range(LANES):
        block[at.COS_LOW + lane] = _cosine(block, lane, block[at.LOW + lane], saddle)
        block[at.COS_HIGH + lane] = _cosine(block, lane, block[at.HIGH + lane], saddle)
    first, last = math.pi, 0.0
    most_1, least_1, most_2, least_2 = -1.0, 1.0, 0.0, 1.0
    for lane in range(LANES):
        low, high = block[at.COS_LOW + lane], block[at.COS_HIGH + lane]
        low, high = (low, high) if low < high else (high, low)
        if saddle and block[at.PASSES + lane] == 0.0:
            if low <= 1.0 and high >= 0.0:
                most_2, least_2 = max(most_2, min(1.0, high)), min(least_2, max(0.0, low))
        elif low <= 1.0 and high >= -1.0:
            most_1, least_1 = max(most_1, min(1.0, high)), min(least_1, max(-1.0, low))
    if saddle:
        most_1, least_1 = _uncrowded(most_1), _uncrowded(least_1)
        most_2, least_2 = _uncrowded(most_2), _uncrowded(least_2)
    if most_1 >= least_1:
        first, last = math.acos(most_1), math.acos(least_1)
    if most_2 >= least_2:
        first, last = min(first, 2.0 * math.acos(most_2)), max(last, 2.0 * math.acos(least_2))
    # next to an end of the interval the cosine keeps half of the digits of the angle
    step = math.pi / intervals
    return max(1, math.ceil(first / step - _SLACK)), min(intervals - 1, math.floor(last / step + _SLACK))


@kernel
def _add_places(block, saddle, every, first, last, intervals, cosh, sinh, shift, groups):
    """Add places on the present wide panel, from the first one to the last, all or `every` second one."""
    step, stride = math.pi / intervals, _MOST_KEPT // intervals
    kept = stride * intervals == _MOST_KEPT
    for i in range(first, last + 1, every):
        if kept:
            half_cos, half_sin = _HALF_COSINES[stride * i], _HALF_SINES[stride * i]
        else:
            half_cos, half_sin = math.cos(0.5 * i * step), math.sin(0.5 * i * step)
        cos, sin = 1.0 - 2.0 * half_sin * half_sin, 2.0 * half_sin * half_cos
        if saddle:
            _place_saddle(block, *_crowded(cos, sin), *_crowded(half_cos, half_sin))
        else:
            _place(block, cos, sin)
        _locate(block, shift)
        _add(block, i, cosh, sinh, groups)


@kernel
def integrate(block, alpha, table, nodes, wide, number, groups, saddle, fresh, intervals):
    """Sum the integrand of a block over all wide panels; `number` is that of the one in which the places are given.

    `groups` of coefficients are enough. `fresh` sums begin with all places of so many intervals, others with every
    second one.
    """
    centre = number * SPACING
    cosh, sinh = math.cosh(centre), math.sinh(centre)
    alone = _prepare(block, centre)
    if saddle:
        _find_roots_at_saddles(block, wide, table * CENTRES + SIDE, centre)
        _substitute_saddle(block, cosh, sinh)
    else:
        _substitute(block, cosh, sinh)
    for side in (1, -1):
        piece = 0 if side > 0 else -1
        while abs(number + PIECE_STRIDE * piece) <= SIDE and _enter(block, piece):
            shift = math.tanh(0.5 * PIECE * piece)
            _expand(block, alpha, table, nodes, wide, number + PIECE_STRIDE * piece, shift, groups)
            first, last = (1, intervals - 1) if alone else _first_and_last(block, saddle, intervals)
            # every second place is one of odd number
            first, every = (first, 1) if fresh else (first | 1, 2)
            _add_places(block, saddle, every, first, last, intervals, cosh, sinh, shift, groups)
            if alone:
                return
            piece += side
