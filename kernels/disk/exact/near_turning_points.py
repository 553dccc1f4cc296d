"""Expansion of the excess (V - h) of a motion about its start, the turning points near by, and their errors.

Everything is expanded about the start, so that a disk released at rest from 1e-5 rad is as exact as one at 1 rad: the
force is computed once from the start's own numbers, and the start's potential is never subtracted from another of the
same size within 3/4 of a panel. All functions treat a block of motions (`kernels.disk.exact.layout`) that start on one
panel.
"""

import math

from kernels.disk.exact import layout as at
from kernels.disk.exact.layout import LANES
from kernels.disk.exact.legendre import (
    DP1,
    DP2,
    DS1,
    DS2,
    ONE,
    P_P,
    P_S,
    PP,
    S_P,
    S_S,
    SP,
    SS,
    TERMS,
    TILT,
    row_value,
)  # fmt: skip
from kernels.disk.exact.polynomial import value
from kernels.disk.exact.potential import NEAR, rise, rise_at
from kernels.disk.exact.root import ROUNDING, find_roots
from kernels.jit import kernel, simd

#: Relative rounding error of the terms of the excess (measured against 40-digit arithmetic).
TERM_ERROR = 8.0 * ROUNDING
#: Error [rad] of the tables and of the sums over panels, most of it for motions that reach tilts near 90 deg.
_TABLE_ERROR = 128.0 * ROUNDING
#: A first guess is at most this often divided by eight: with a tilt rate of 1e-300 the disk turns within 1e-300.
_MOST_REDUCTIONS = 350


@simd
def rounding_error(block, lane, distance):
    """Rounding error of the excess at a distance in y from the start: of the terms of its expansion, or of h."""
    distance = abs(distance)
    terms = (block[at.PULL + lane] + block[at.CURVATURE + lane] * distance) * distance
    level = block[at.LEVEL + lane]
    return TERM_ERROR * (block[at.KINETIC + lane] + (terms if terms < level else level))


@kernel
def _force_and_sizes(block, alpha):
    """The force on each start, and the sizes of the terms of its excess."""
    for lane in range(LANES):
        w, s0, o0 = block[at.W_0 + lane], block[at.S_0 + lane], block[at.O_0 + lane]
        S, C = block[at.SIN + lane], block[at.COS + lane]
        kinetic = 0.5 * (1.0 + 0.5 * alpha) * w * w
        weight, coupling, twist = S * C, (1.0 + alpha) * s0 * o0 * C, 0.5 * alpha * o0 * o0 * S
        force = weight + coupling - twist
        squares = 0.5 * (1.0 + alpha) * s0 * s0 + 0.25 * alpha * o0 * o0
        goes = force if w == 0.0 else w
        block[at.KINETIC + lane] = kinetic
        block[at.FORCE + lane] = force
        block[at.AHEAD + lane] = 1.0 if goes > 0.0 else -1.0
        block[at.PULL + lane] = abs(weight) + abs(coupling) + abs(twist)
        block[at.CURVATURE + lane] = 1.0 + (1.0 + alpha) * (2.0 * s0 * s0 + o0 * o0)
        block[at.LEVEL + lane] = 1.0 + squares + kinetic


@kernel
def _rates_at_upright(block, panels, panel, nodes, node):
    """The rates at the panel's centre and at upright; both maps have determinant one."""
    ds1, ds2, dp1, dp2 = nodes[node, DS1], nodes[node, DS2], nodes[node, DP1], nodes[node, DP2]
    for lane in range(LANES):
        x, s0 = block[at.X_0 + lane], block[at.S_0 + lane]
        p0 = block[at.O_0 + lane] * block[at.COS + lane]
        s = row_value(panels, panel, P_P, x) * s0 - row_value(panels, panel, S_P, x) * p0
        p = row_value(panels, panel, S_S, x) * p0 - row_value(panels, panel, P_S, x) * s0
        block[at.S_HERE + lane], block[at.P_HERE + lane] = s, p
        block[at.C_1 + lane] = s + (dp2 * s - ds2 * p)
        block[at.C_2 + lane] = p + (ds1 * p - dp1 * s)


@simd
def expand(block, panels, panel, first):
    """V on a panel as polynomials from `first` on, for the rates at its centre in S_HERE and P_HERE."""
    for lane in range(LANES):
        s, p = block[at.S_HERE + lane], block[at.P_HERE + lane]
        ss, sp, pp = s * s, s * p, p * p
        for n in range(TERMS):
            block[first + n * LANES + lane] = (
                ss * panels[panel, SS, n]
                + sp * panels[panel, SP, n]
                + pp * panels[panel, PP, n]
                + panels[panel, ONE, n]
            )


@kernel
def _shift_to_start(block, alpha, nodes, node):
    """Move the expansion in NEAR from the panel's centre to the start: repeated synthetic division."""
    there = rise_at(nodes, node)
    for lane in range(LANES):
        block[at.NEAR + lane] = 0.0
        x = block[at.X_0 + lane]
        for i in range(TERMS - 1):
            for n in range(TERMS - 2, i - 1, -1):
                block[at.NEAR + n * LANES + lane] += x * block[at.NEAR + (n + 1) * LANES + lane]
    for lane in range(LANES):
        kinetic = block[at.KINETIC + lane]
        base = block[at.NEAR + lane] + kinetic
        block[at.CENTRE + lane] = -base
        block[at.BASE + lane] = rise(alpha, there, block[at.C_1 + lane], block[at.C_2 + lane]) + base
        block[at.NEAR + lane] = -kinetic
        block[at.NEAR + LANES + lane] = -block[at.FORCE + lane]


@kernel
def expand_about_starts(block, alpha, panels, panel, nodes, node):
    """Expand the excess of each motion about its start, into NEAR: from the start's rows to those of the motion."""
    _force_and_sizes(block, alpha)
    _rates_at_upright(block, panels, panel, nodes, node)
    expand(block, panels, panel, at.NEAR)
    _shift_to_start(block, alpha, nodes, node)


@kernel
def _excess_to_one_side(block, sense):
    """Write the expansions in NEAR as functions of the outward distance into WORK; whether a root lies within them.

    At rest the start is a zero itself; WORK is then the quotient of the excess by the distance.
    """
    for lane in range(LANES):
        side = sense * block[at.AHEAD + lane]
        rest = block[at.KINETIC + lane] == 0.0
        here = side if rest else 1.0
        for n in range(TERMS - 1):
            coefficient, following = (
                block[at.NEAR + n * LANES + lane],
                block[at.NEAR + (n + 1) * LANES + lane],
            )
            block[at.WORK + n * LANES + lane] = here * (following if rest else coefficient)
            here *= side
        last = block[at.NEAR + (TERMS - 1) * LANES + lane]
        block[at.WORK + (TERMS - 1) * LANES + lane] = 0.0 if rest else here * last
        block[at.SIDE + lane] = side
    more = 0
    for lane in range(LANES):
        side, rest = block[at.SIDE + lane], block[at.KINETIC + lane] == 0.0
        # a motion below its saddle turns before it
        away = side * (block[at.TOP + lane] - block[at.Y_0 + lane])
        reach = NEAR - side * block[at.X_0 + lane]
        within = (block[at.HEIGHT + lane] > 0.0) & (away > 0.0) & (away <= reach)
        reach = away if within else reach
        excess = value(block, at.WORK + lane, LANES, reach)
        excess = excess * reach if rest else excess
        seeks = (block[at.WANTED + lane] > 0.0) & (within | (excess > 0.0))
        block[at.EXCESS + lane] = excess
        block[at.OUTER + lane] = reach
        block[at.INNER + lane] = 0.0
        block[at.ACTIVE + lane] = 1.0 if seeks else 0.0
        more |= int(seeks)
    return more != 0


@kernel
def _first_guess(block):
    """First guesses of the roots of polynomials that are negative at 0 and positive at OUTER.

    The roots of the first three terms; if these never become positive, a point within a factor of eight of the root:
    it can be as near as 1e-9.
    """
    more = 0
    for lane in range(LANES):
        a, b, c = block[at.WORK + lane], block[at.WORK + LANES + lane], block[at.WORK + 2 * LANES + lane]
        outer = block[at.OUTER + lane]
        square = b * b - 4.0 * a * c
        real = (square > 0.0) & ((b > 0.0) | (c > 0.0))
        root = math.sqrt(square if real else 0.0)
        guess = (-2.0 * a if b > 0.0 else root - b) / (b + root if b > 0.0 else 2.0 * c)
        good = real & (guess > 0.0) & (guess < outer)
        block[at.ROOT + lane] = guess if good else outer
        lost = (block[at.ACTIVE + lane] > 0.0) & (not good)
        block[at.HERE + lane] = 1.0 if lost else 0.0
        more |= int(lost)
    for _ in range(_MOST_REDUCTIONS):
        if more == 0:
            return
        more = 0
        for lane in range(LANES):
            less = 0.125 * block[at.ROOT + lane]
            lost = (block[at.HERE + lane] > 0.0) & (value(block, at.WORK + lane, LANES, less) > 0.0)
            block[at.ROOT + lane] = less if lost else block[at.ROOT + lane]
            block[at.HERE + lane] = 1.0 if lost else 0.0
            more |= int(lost)


@kernel
def tilts_and_errors(block, panels, panel):
    """The tilts, and their errors, of turning points on one panel, X from its centre."""
    for lane in range(LANES):
        x = block[at.X + lane]
        cos = row_value(panels, panel, ONE, x)
        block[at.TILT + lane] = row_value(panels, panel, TILT, x)
        error = rounding_error(block, lane, block[at.DISTANCE + lane]) * cos / abs(block[at.SLOPE + lane])
        block[at.ERROR + lane] = error + _TABLE_ERROR


@kernel
def near_turning_points(block, sense, panels, panel):
    """Find the turning points that lie within the expansions about the starts, in the lanes that are WANTED.

    `sense` is +1 on the side to which the disk sets off, -1 on the other. Lanes that found one are left in WANTED as
    -1, with DISTANCE, TILT, ERROR and SLOPE; the excess at the end of the expansion is left in EXCESS.
    """
    if not _excess_to_one_side(block, sense):
        return
    for lane in range(LANES):
        block[at.WANTED + lane] = -1.0 if block[at.ACTIVE + lane] > 0.0 else block[at.WANTED + lane]
    _first_guess(block)
    find_roots(block, 0.0)
    for lane in range(LANES):
        distance, slope = block[at.ROOT + lane], block[at.SLOPE + lane]
        along = block[at.SIDE + lane] * distance
        block[at.SLOPE + lane] = distance * slope if block[at.KINETIC + lane] == 0.0 else slope
        block[at.DISTANCE + lane] = along
        block[at.X + lane] = block[at.X_0 + lane] + along
    tilts_and_errors(block, panels, panel)
