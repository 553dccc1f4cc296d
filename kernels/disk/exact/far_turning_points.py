"""Turning points far from the start: find the panel on which the excess changes sign, then the root on that panel.

Every search looks outward along positive y: under y -> -y, p -> -p nothing changes, and the tables are bit-symmetric.
Rates and excess go along from centre to centre. By way of the rates at upright a nearly flat motion would keep few
digits of p = o cos(tilt), which can be 1e-5 of them there: 1e-12 rad of a turning point, 1e-9 of a period.
All functions treat a block of searches (`kernels.disk.exact.layout`).
"""

import math

from kernels.disk.exact import layout as at
from kernels.disk.exact.layout import LANES
from kernels.disk.exact.legendre import (
    DP_P,
    DP_S,
    DS_P,
    DS_S,
    END_ONE,
    END_PP,
    END_SP,
    END_SS,
    PANEL,
    PANELS,
    REACH,
    STEP,
    STEP_ONE,
    STEP_PP,
    STEP_SP,
    STEP_SS,
    Y_END,
)
from kernels.disk.exact.near_turning_points import expand, tilts_and_errors
from kernels.disk.exact.potential import NEAR, NODE
from kernels.disk.exact.root import find_roots
from kernels.jit import kernel

#: How a search for a turning point ends.
TURNS, BEYOND, OFF_TABLE, OPEN = 0.0, 1.0, 2.0, 3.0


@kernel
def _pass_panel(block, panels, panel, k):
    """Carry the searches that are still active over a panel, up to the one with the root; whether any goes on."""
    ds_s, ds_p = panels[panel, STEP, DS_S], panels[panel, STEP, DS_P]
    dp_s, dp_p = panels[panel, STEP, DP_S], panels[panel, STEP, DP_P]
    ss, sp = panels[panel, STEP, STEP_SS], panels[panel, STEP, STEP_SP]
    pp, one = panels[panel, STEP, STEP_PP], panels[panel, STEP, STEP_ONE]
    end_ss, end_sp = panels[panel, STEP, END_SS], panels[panel, STEP, END_SP]
    end_pp, end_one = panels[panel, STEP, END_PP], panels[panel, STEP, END_ONE]
    left = 0
    for lane in range(LANES):
        s, p, before = block[at.S_HERE + lane], block[at.P_HERE + lane], block[at.EXCESS + lane]
        on = block[at.ACTIVE + lane] > 0.0
        climb = s * (s * ss + p * sp) + (p * p * pp + one)
        s, p = s + ((ds_s * s + ds_p * p) if on else 0.0), p + ((dp_s * s + dp_p * p) if on else 0.0)
        centre = block[at.CENTRE + lane] + (climb if on else 0.0)
        excess = centre + (s * (s * end_ss + p * end_sp) + (p * p * end_pp + end_one))
        hit = on & ((block[at.BARRIER + lane] <= k * PANEL + NODE) | (excess > 0.0))
        block[at.S_HERE + lane], block[at.P_HERE + lane], block[at.CENTRE + lane] = s, p, centre
        block[at.BEFORE + lane] = before if on else block[at.BEFORE + lane]
        block[at.EXCESS + lane] = excess if on else before
        block[at.PANEL + lane] = k if hit else block[at.PANEL + lane]
        block[at.ACTIVE + lane] = 0.0 if hit else block[at.ACTIVE + lane]
        left |= int(on) & int(not hit)
    return left != 0


@kernel
def _pass_panels(block, table, panels, start, y_fall):
    """Carry searches from panel `start` to those with their roots (PANEL); what the others have passed."""
    for k in range(start + 1, REACH):
        inner = NEAR - PANEL if k == start + 1 else -NODE
        if k * PANEL + inner >= y_fall:
            return BEYOND
        if not _pass_panel(block, panels, table * PANELS + REACH + k, k):
            return BEYOND
    return BEYOND if y_fall <= Y_END else OFF_TABLE


@kernel
def bracket_turning_points(block, table, panels, start, y_fall):
    """Bracket the root of the excess of searches that begin on panel `start`.

    S_HERE, P_HERE and CENTRE go with them to the panel found. Writes PANEL, INNER, OUTER and ROOT (a guess); PANEL is
    NaN where the search passed y_fall or the table's end. Returns which of the two these have passed.
    """
    for lane in range(LANES):
        block[at.ACTIVE + lane] = 1.0
        block[at.PANEL + lane] = math.nan
    end = _pass_panels(block, table, panels, start, y_fall)
    for lane in range(LANES):
        k, before, excess = block[at.PANEL + lane], block[at.BEFORE + lane], block[at.EXCESS + lane]
        barrier = block[at.BARRIER + lane] - k * PANEL
        within = barrier <= NODE
        # the expansion about the start goes beyond the end of its panel
        inner = NEAR - PANEL if k == start + 1 else -NODE
        outer = barrier if within else NODE
        guess = inner - before * (outer - inner) / (excess - before)
        block[at.INNER + lane], block[at.OUTER + lane] = inner, outer
        block[at.ROOT + lane] = 0.5 * (inner + outer) if within else guess
    return end


@kernel
def far_turning_points(block, table, panels, k):
    """Find the turning points that `bracket_turning_points` bracketed on panel k.

    Writes DISTANCE and TILT (both outward), ERROR and SLOPE.
    """
    panel = table * PANELS + REACH + k
    expand(block, panels, panel, at.WORK)
    for lane in range(LANES):
        block[at.WORK + lane] = block[at.CENTRE + lane]
        block[at.ACTIVE + lane] = 1.0
    find_roots(block, abs(k) * PANEL)
    for lane in range(LANES):
        block[at.X + lane] = block[at.ROOT + lane]
        block[at.DISTANCE + lane] = (k * PANEL - block[at.Y_0 + lane]) + block[at.ROOT + lane]
    tilts_and_errors(block, panels, panel)
