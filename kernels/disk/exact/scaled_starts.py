"""How cells become motions of the exact reduction: their starts, scaled, and their panels of the table.

A block of cells at a time (`kernels.disk.exact.layout`). The logarithm that finds the panel is an approximation from
the bits of the number, because the library's works on one number at a time.
"""

import math

import numpy as np

from kernels.disk.arrays import GRAVITY, PRECESSION_RATE, RADIUS, ROLL_RATE, TILT, TILT_RATE
from kernels.disk.endings import FELL, INVALID, NOT_COMPUTED, UNRESOLVED
from kernels.disk.exact import arrays as exact_row
from kernels.disk.exact import layout as at
from kernels.disk.exact import motion as of
from kernels.disk.exact.layout import LANES
from kernels.disk.exact.legendre import ONE, PANEL, PANELS, REACH, SIN, Y_END
from kernels.jit import kernel
from kernels.simd_math import sine_cosine_of_tilt

#: log2(1+m) - m is about this times m(1-m) for m from 0 to 1.
_LOG_CURVATURE = 0.346
#: Starts beyond the table's end are taken for ones on its last panel.
_LAST_PANEL = float(REACH)


@kernel
def _scale_block(block, fall_tilt):
    """Scale the starts, find the panel of each to within one, and the endings of cells without a motion (ENDING)."""
    for lane in range(LANES):
        tilt, rate = block[at.TILT_0 + lane], block[at.W_0 + lane]
        precession, roll = block[at.O_0 + lane], block[at.S_0 + lane]
        radius, gravity = block[at.RADIUS + lane], block[at.GRAVITY + lane]
        unit = math.sqrt(radius / gravity)
        S, C = sine_cosine_of_tilt(tilt)
        w, spin = rate * unit, precession * unit
        # the exponent and the mantissa of exp(y) = (1 + |sin|)/cos give its logarithm well enough
        power = np.float64((1.0 + abs(S)) / C).view(np.int64) * 2.0**-52 - 1023.0
        mantissa = power - math.floor(power)
        y = math.log(2.0) * (power + _LOG_CURVATURE * mantissa * (1.0 - mantissa))
        possible = (abs(tilt) < 0.5 * math.pi) & (radius > 0.0) & (radius < math.inf)
        possible &= (gravity > 0.0) & (gravity < math.inf)
        # x - x is zero only for a finite x
        possible &= (rate - rate == 0.0) & (precession - precession == 0.0) & (roll - roll == 0.0)
        ending = FELL if abs(tilt) >= fall_tilt else NOT_COMPUTED
        block[at.ENDING + lane] = ending if possible else INVALID
        panel = math.floor(y * (1.0 / PANEL) + 0.5)
        block[at.PANEL + lane] = panel if panel < _LAST_PANEL else _LAST_PANEL
        block[at.UNIT + lane] = unit
        block[at.W_0 + lane] = w if w * w > 0.0 else 0.0  # a rate whose square underflows counts as rest
        block[at.S_0 + lane], block[at.O_0 + lane] = roll * unit + spin * S, spin * C
        block[at.SIN + lane], block[at.COS + lane] = S, C


@kernel
def _stretched_tilts(block):
    """The stretched tilt, from its distance to the centre of the panel found.

    y = 2 atanh(tan(tilt/2)), and exp(y) = (1 + sin)/cos: the distance is 2 atanh((t - t0)/(1 - t t0)) with the
    tangents t and 2 atanh((u - u0)/(u + u0)) with the exponentials u. The one keeps all digits near upright, the other
    near flat.
    """
    for lane in range(LANES):
        S, C = abs(block[at.SIN + lane]), block[at.COS + lane]
        there, here = block[at.COS_THERE + lane] * (1.0 + S), (1.0 + block[at.SIN_THERE + lane]) * C
        half = block[at.HALF_THERE + lane]
        steep = S > 0.75
        above = there - here if steep else S - half * (1.0 + C)
        below = there + here if steep else (1.0 + C) - half * S
        z = above / below
        zz = z * z
        series = 1.0 + zz * (
            1.0 / 3.0 + zz * (1.0 / 5.0 + zz * (1.0 / 7.0 + zz * (1.0 / 9.0 + zz * (1.0 / 11.0))))
        )
        away = 2.0 * z * series
        next_panel = math.floor(away * (1.0 / PANEL) + 0.5)
        panel = block[at.PANEL + lane] + next_panel
        x0 = math.copysign(1.0, block[at.SIN + lane]) * (away - next_panel * PANEL)
        panel = math.copysign(panel, block[at.SIN + lane])
        y0 = panel * PANEL + x0
        ending = block[at.ENDING + lane]
        block[at.X_0 + lane], block[at.Y_0 + lane], block[at.PANEL + lane] = x0, y0, panel
        block[at.ENDING + lane] = UNRESOLVED if (ending == NOT_COMPUTED) & (not abs(y0) < Y_END) else ending


@kernel
def _write_at_once(cell, ending, tilt, measures, counts):
    fell = ending == FELL
    measures[exact_row.EXACT_TILT_MIN, cell] = measures[exact_row.EXACT_TILT_MAX, cell] = (
        tilt if fell else math.nan
    )
    measures[exact_row.EXACT_NUTATION_PERIOD, cell] = measures[exact_row.EXACT_SEPARATRIX, cell] = math.nan
    measures[exact_row.EXACT_TILT_ERROR, cell] = 0.0 if fell else math.nan
    counts[exact_row.EXACT_ENDING, cell], counts[exact_row.EXACT_WELLS, cell] = ending, 0


@kernel
def _load(block, starts, first, stop):
    for lane in range(LANES):
        cell = min(first + lane, stop - 1)
        block[at.TILT_0 + lane], block[at.W_0 + lane] = starts[TILT, cell], starts[TILT_RATE, cell]
        block[at.O_0 + lane], block[at.S_0 + lane] = starts[PRECESSION_RATE, cell], starts[ROLL_RATE, cell]
        block[at.RADIUS + lane], block[at.GRAVITY + lane] = starts[RADIUS, cell], starts[GRAVITY, cell]


@kernel
def _read_panel_centres(block, tables):
    """What is known of the centre of each start's panel; it is the same in every table."""
    for lane in range(LANES):
        swings = block[at.ENDING + lane] == NOT_COMPUTED
        panel = REACH + (int(block[at.PANEL + lane]) if swings else 0)
        block[at.COS_THERE + lane] = tables.panels[panel, ONE, 0]
        block[at.SIN_THERE + lane] = tables.nodes[2 * panel, SIN]
        # a node is half a panel: y there is half of what it is at the centre of the panel of that number
        block[at.HALF_THERE + lane] = tables.nodes[REACH + panel, SIN]


@kernel
def _store_motion(block, lane, table, motions, i):
    motions[i, of.TILT], motions[i, of.UNIT] = block[at.TILT_0 + lane], block[at.UNIT + lane]
    motions[i, of.Y_0], motions[i, of.X_0] = block[at.Y_0 + lane], block[at.X_0 + lane]
    motions[i, of.S_0], motions[i, of.O_0] = block[at.S_0 + lane], block[at.O_0 + lane]
    motions[i, of.SIN], motions[i, of.COS] = block[at.SIN + lane], block[at.COS + lane]
    motions[i, of.W], motions[i, of.PANEL_0] = block[at.W_0 + lane], block[at.PANEL + lane]
    motions[i, of.TABLE] = table


@kernel
def scale_starts(start, stop, starts, which, fall_tilt, tables, chunk, measures, counts):
    """Make motions of the cells from `start` to `stop`, but for those whose ending is known without (and written).

    Returns their number. Of `chunk`, `motions`, `cells` and `keys` are written.
    """
    n = 0
    for first in range(start, stop, LANES):
        _load(chunk.block, starts, first, stop)
        _scale_block(chunk.block, fall_tilt)
        _read_panel_centres(chunk.block, tables)
        _stretched_tilts(chunk.block)
        for lane in range(min(LANES, stop - first)):
            cell = first + lane
            table = which[cell]
            ending = int(chunk.block[at.ENDING + lane]) if table >= 0 else INVALID
            if ending != NOT_COMPUTED:
                _write_at_once(cell, ending, chunk.block[at.TILT_0 + lane], measures, counts)
                continue
            _store_motion(chunk.block, lane, table, chunk.motions, n)
            chunk.cells[n] = cell
            chunk.keys[n] = table * PANELS + REACH + int(chunk.block[at.PANEL + lane])
            n += 1
    return n
