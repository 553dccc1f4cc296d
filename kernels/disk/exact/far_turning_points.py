"""Turning points far from the start: find the panel on which the excess changes sign, then the root on that panel.

Every search looks outward along positive y: under y -> -y, p -> -p nothing changes, and the tables are bit-symmetric.
All functions treat a block of searches (`kernels.disk.exact.layout`).
"""

import math

from kernels.disk.exact import layout as at
from kernels.disk.exact.layout import LANES
from kernels.disk.exact.legendre import NODES, PANEL, PANELS, REACH, Y_END
from kernels.disk.exact.near_turning_points import tilts_and_errors
from kernels.disk.exact.potential import NEAR, NODE, rise, rise_at
from kernels.disk.exact.root import find_roots
from kernels.disk.exact.saddle import expand_excess
from kernels.jit import internal

#: How a search for a turning point ends.
TURNS, BEYOND, OFF_TABLE, OPEN = 0.0, 1.0, 2.0, 3.0


@internal
def _pass_panel(block, alpha, nodes, node, k, inner):
    """Bracket the roots on panel k of the searches that are still active; whether any search goes on."""
    there, outer, left = rise_at(nodes, node), NODE, 0
    for lane in range(LANES):
        before = block[at.EXCESS + lane]
        excess = rise(alpha, there, block[at.C_1 + lane], block[at.Q + lane]) - block[at.BASE + lane]
        on = block[at.ACTIVE + lane] > 0.0
        barrier = block[at.BARRIER + lane] - k * PANEL
        within = barrier <= NODE
        hit = on & (within | (excess > 0.0))
        end = barrier if within else outer
        guess = inner - before * (outer - inner) / (excess - before)
        guess = 0.5 * (inner + end) if within else guess
        block[at.EXCESS + lane] = excess
        block[at.PANEL + lane] = k if hit else block[at.PANEL + lane]
        block[at.INNER + lane] = inner if hit else block[at.INNER + lane]
        block[at.OUTER + lane] = end if hit else block[at.OUTER + lane]
        block[at.ROOT + lane] = guess if hit else block[at.ROOT + lane]
        block[at.ACTIVE + lane] = 0.0 if hit else block[at.ACTIVE + lane]
        left |= int(on) & int(not hit)
    return left != 0


@internal
def bracket_turning_points(block, alpha, table, nodes, start, y_fall):
    """Bracket the root of the excess of searches that begin on panel `start`.

    Writes PANEL, INNER, OUTER and ROOT (a guess); PANEL is NaN where the search passed y_fall or the table's end.
    Returns which of the two these have passed.
    """
    for lane in range(LANES):
        block[at.ACTIVE + lane] = 1.0
        block[at.PANEL + lane] = math.nan
    inner = NEAR - PANEL
    for k in range(start + 1, REACH):
        if k * PANEL + inner >= y_fall:
            return BEYOND
        if not _pass_panel(block, alpha, nodes, table * NODES + 2 * (REACH + k) + 1, k, inner):
            return BEYOND
        inner = -NODE
    return BEYOND if y_fall <= Y_END else OFF_TABLE


@internal
def far_turning_points(block, alpha, table, panels, nodes, k):
    """Find the turning points that `bracket_turning_points` bracketed on panel k.

    Writes DISTANCE and TILT (both outward), ERROR and SLOPE.
    """
    expand_excess(block, alpha, table, panels, nodes, k)
    for lane in range(LANES):
        block[at.ACTIVE + lane] = 1.0
    find_roots(block, abs(k) * PANEL)
    for lane in range(LANES):
        block[at.X + lane] = block[at.ROOT + lane]
        block[at.DISTANCE + lane] = (k * PANEL - block[at.Y_0 + lane]) + block[at.ROOT + lane]
    tilts_and_errors(block, panels, table * PANELS + REACH + k)
