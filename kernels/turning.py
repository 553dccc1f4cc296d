"""The turning points of one motion: the ends of the interval of tilt on which its potential does not exceed its energy.

Everything is expanded about the start, so that a disk released at rest from 1e-5 rad is as exact as one at 1 rad: the
force is computed once from the start's own numbers, and the start's potential is never subtracted from another of
the same size within 3/4 of a panel.
"""

import math

from numba import njit

from kernels.disk import CONTRACT
from kernels.legendre import (
    DP1,
    DP2,
    DS1,
    DS2,
    NODES,
    P_P,
    P_S,
    PANEL,
    PANELS,
    REACH,
    S_P,
    S_S,
    TERMS,
    TILT,
    Y_END,
    row_value,
)
from kernels.period import NEAR
from kernels.wells import NODE, expand_excess, rise, value, zero

#: How a search for a turning point ends.
TURNS, BEYOND, OFF_TABLE = 0, 1, 2


@njit(error_model="numpy", fastmath=CONTRACT)
def origin(table, panels, nodes, k0, x0, s0, p0):
    """(s, p) at the start panel's centre and (c1, c2) at upright; both maps have determinant one."""
    panel, node = table * PANELS + REACH + k0, table * NODES + 2 * (REACH + k0)
    s = row_value(panels, panel, P_P, x0) * s0 - row_value(panels, panel, S_P, x0) * p0
    p = row_value(panels, panel, S_S, x0) * p0 - row_value(panels, panel, P_S, x0) * s0
    c1 = s + (nodes[node, DP2] * s - nodes[node, DS2] * p)
    c2 = p + (nodes[node, DS1] * p - nodes[node, DP1] * s)
    return s, p, c1, c2


@njit(error_model="numpy", fastmath=CONTRACT)
def _first_guess(coef, outer):
    """Where a polynomial, negative at 0 and positive at `outer`, may vanish: a kick of 1e-9 turns the disk at 1e-9.

    The root of its first three terms; if these never turn positive, a point within eight times of the root.
    """
    a, b, c = coef[0], math.copysign(1.0, outer) * coef[1], coef[2]
    root = math.sqrt(b * b - 4.0 * a * c)
    guess = -2.0 * a / (b + root) if b > 0.0 else (root - b) / (2.0 * c)
    if 0.0 < guess < abs(outer) and (b > 0.0 or c > 0.0):
        return math.copysign(guess, outer)
    for _ in range(350):
        if not value(coef, 0.125 * outer) > 0.0:
            break
        outer *= 0.125
    return outer


@njit(error_model="numpy", fastmath=CONTRACT)
def _near_turn(side, near, reach, y0, work):
    """Distance in y from the start to the turning point inside the start's own expansion, and dV/dy there."""
    rest = near[0] == 0.0
    for n in range(TERMS - 1):
        work[n] = side * near[n + 1] if rest else near[n]
    work[TERMS - 1] = 0.0 if rest else near[TERMS - 1]
    dy, slope = zero(work, 0.0, side * reach, _first_guess(work, side * reach), abs(y0))
    # without its root at the start the excess is dy times the quotient
    return dy, side * dy * slope if rest else slope


@njit(error_model="numpy", fastmath=CONTRACT)
def turn(side, motion, panels, nodes, barrier, y_fall, near, work):
    """First turning point on one side (+1 or -1) of the start.

    `barrier` is the saddle, if the motion cannot pass it: the turning point is then before it; otherwise the excess
    has one zero only on this side. Returns the outcome, the distance from the start in y, the tilt, and dV/dy there.
    """
    alpha, table, y0, k0, x0, c1, c2, base = motion
    reach = NEAR - side * x0
    blocked = side * (barrier - y0) > 0.0
    within = blocked and abs(barrier - y0) <= reach
    if within:
        reach = abs(barrier - y0)
    excess = value(near, side * reach)
    if within or excess > 0.0:
        dy, slope = _near_turn(side, near, reach, y0, work)
        return TURNS, dy, row_value(panels, table * PANELS + REACH + k0, TILT, x0 + dy), slope
    inner, outer, k = side * (NEAR - PANEL), side * NODE, k0 + side
    while abs(k) <= REACH:
        if side * (k * PANEL + inner) >= y_fall:
            return BEYOND, 0.0, 0.0, 0.0
        before, excess = excess, rise(alpha, nodes, table * NODES + 2 * (REACH + k) + side, c1, c2) - base
        within = blocked and side * (barrier - k * PANEL) <= NODE
        if within or excess > 0.0:
            guess = inner - before * (outer - inner) / (excess - before)
            if within:
                outer = barrier - k * PANEL
                guess = 0.5 * (inner + outer)
            expand_excess(alpha, table, panels, nodes, k, c1, c2, base, work)
            x, slope = zero(work, inner, outer, guess, abs(k) * PANEL)
            return TURNS, (k * PANEL - y0) + x, row_value(panels, table * PANELS + REACH + k, TILT, x), slope
        inner = -outer
        k += side
    return (BEYOND if y_fall <= Y_END else OFF_TABLE), 0.0, 0.0, 0.0


@njit(error_model="numpy", fastmath=CONTRACT)
def height_of(motion, panels, nodes, top, near, work):
    """V at the saddle minus h."""
    alpha, table, y0, k0, x0, c1, c2, base = motion
    if abs(x0 + (top - y0)) <= NEAR:
        return value(near, top - y0)
    k = int(round(top / PANEL))
    expand_excess(alpha, table, panels, nodes, k, c1, c2, base, work)
    return value(work, top - k * PANEL)
