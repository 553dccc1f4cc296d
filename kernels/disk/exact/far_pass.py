"""The second and third pass over a chunk: turning points beyond the expansions about the starts."""

import math

from kernels.disk.exact import layout as at
from kernels.disk.exact import motion as of
from kernels.disk.exact.chunk import EXCESS_THERE, GUESS, INNER, OUTER, P_THERE, S_THERE, SEARCH_COLUMNS
from kernels.disk.exact.counting_sort import FIRST, KEY, STOP, blocks_of
from kernels.disk.exact.far_turning_points import OPEN, TURNS, bracket_turning_points, far_turning_points
from kernels.disk.exact.layout import LANES
from kernels.disk.exact.legendre import PANELS, REACH
from kernels.jit import kernel


@kernel
def _sought(chunk, j):
    """Motion of a search, its direction in y (+1, -1), and where the motion's columns for it begin."""
    i, behind = chunk.sought[j] // 2, chunk.sought[j] % 2
    ahead = chunk.motions[i, of.AHEAD]
    return i, -ahead if behind else ahead, of.BEHIND if behind else 0


@kernel
def _load(chunk, first, last):
    block, motions, searches = chunk.block, chunk.motions, chunk.searches
    for lane in range(LANES):
        j = chunk.order[min(first + lane, last - 1)]
        i, side, column = _sought(chunk, j)
        y0, barrier = side * motions[i, of.Y_0], side * motions[i, of.TOP]
        block[at.SIDE + lane], block[at.Y_0 + lane] = side, y0
        block[at.S_HERE + lane], block[at.P_HERE + lane] = searches[j, S_THERE], searches[j, P_THERE]
        block[at.CENTRE + lane] = searches[j, EXCESS_THERE]
        # a motion below its saddle turns before it
        blocked = motions[i, of.HEIGHT] > 0.0 and barrier > y0
        block[at.BARRIER + lane] = barrier if blocked else math.inf
        block[at.KINETIC + lane], block[at.PULL + lane] = motions[i, of.KINETIC], motions[i, of.PULL]
        block[at.CURVATURE + lane], block[at.LEVEL + lane] = motions[i, of.CURVATURE], motions[i, of.LEVEL]
        block[at.EXCESS + lane], block[at.ROOT + lane] = motions[i, column + of.EXCESS], searches[j, GUESS]
        block[at.INNER + lane], block[at.OUTER + lane] = searches[j, INNER], searches[j, OUTER]


@kernel
def _store_brackets(chunk, table, end, first, last):
    """Store the brackets of searches; a search without a bracket ends."""
    block = chunk.block
    for lane in range(last - first):
        j, k = chunk.order[first + lane], block[at.PANEL + lane]
        i, _, column = _sought(chunk, j)
        if math.isnan(k):
            chunk.keys[j] = -1
            chunk.motions[i, column + of.END] = end
        else:
            chunk.keys[j] = table * PANELS + REACH + int(k)
            chunk.searches[j, INNER], chunk.searches[j, OUTER] = (
                block[at.INNER + lane],
                block[at.OUTER + lane],
            )
            chunk.searches[j, GUESS] = block[at.ROOT + lane]
            chunk.searches[j, S_THERE], chunk.searches[j, P_THERE] = (
                block[at.S_HERE + lane],
                block[at.P_HERE + lane],
            )
            chunk.searches[j, EXCESS_THERE] = block[at.CENTRE + lane]


@kernel
def _collect(n, chunk):
    """List the searches of n motions, and the panel on which each begins; returns their number."""
    count = 0
    for i in range(n):
        if chunk.motions[i, of.KIND] != of.OSCILLATES:
            continue
        for behind in range(2 if chunk.motions[i, of.W] != 0.0 else 1):
            if chunk.motions[i, of.END + behind * of.BEHIND] == OPEN:
                chunk.sought[count] = 2 * i + behind
                _, side, _ = _sought(chunk, count)
                panel = int(side * chunk.motions[i, of.PANEL_0])
                chunk.keys[count] = int(chunk.motions[i, of.TABLE]) * PANELS + REACH + panel
                chunk.searches[count, S_THERE] = chunk.motions[i, of.S_HERE]
                chunk.searches[count, P_THERE] = side * chunk.motions[i, of.P_HERE]
                chunk.searches[count, EXCESS_THERE] = chunk.motions[i, of.CENTRE]
                count += 1
    return count


@kernel
def _bracket_all(n, tables, chunk, y_fall):
    """Bracket n searches; their keys become the panels of the brackets, or -1."""
    for b in range(blocks_of(chunk.keys, n, LANES, chunk.order, chunk.ends, chunk.blocks)):
        panel, first, last = chunk.blocks[KEY, b], chunk.blocks[FIRST, b], chunk.blocks[STOP, b]
        table = panel // PANELS
        _load(chunk, first, last)
        k = panel - table * PANELS - REACH
        end = bracket_turning_points(chunk.block, table, tables.panels, k, y_fall)
        _store_brackets(chunk, table, end, first, last)


@kernel
def _drop_ended(n, chunk):
    """Move the searches that have not ended to the front; returns their number."""
    count = 0
    for j in range(n):
        if chunk.keys[j] >= 0:
            chunk.keys[count], chunk.sought[count] = chunk.keys[j], chunk.sought[j]
            for column in range(SEARCH_COLUMNS):
                chunk.searches[count, column] = chunk.searches[j, column]
            count += 1
    return count


@kernel
def _store_turning_points(chunk, first, last):
    block, motions = chunk.block, chunk.motions
    for lane in range(last - first):
        i, side, column = _sought(chunk, chunk.order[first + lane])
        motions[i, column + of.END], motions[i, column + of.TURN] = TURNS, side * block[at.TILT + lane]
        motions[i, column + of.ERROR] = block[at.ERROR + lane]
        motions[i, column + of.DISTANCE] = side * block[at.DISTANCE + lane]
        motions[i, column + of.SLOPE] = block[at.SLOPE + lane]


@kernel
def _refine_all(n, tables, chunk):
    """Find the turning points of n searches, each on its panel."""
    for b in range(blocks_of(chunk.keys, n, LANES, chunk.order, chunk.ends, chunk.blocks)):
        panel, first, last = chunk.blocks[KEY, b], chunk.blocks[FIRST, b], chunk.blocks[STOP, b]
        table = panel // PANELS
        _load(chunk, first, last)
        k = panel - table * PANELS - REACH
        far_turning_points(chunk.block, table, tables.panels, k)
        _store_turning_points(chunk, first, last)


@kernel
def find_far(n, tables, chunk, y_fall):
    """Find the turning points of n motions that do not lie within the expansions about their starts."""
    count = _collect(n, chunk)
    if count > 0:
        _bracket_all(count, tables, chunk, y_fall)
        count = _drop_ended(count, chunk)
    if count > 0:
        _refine_all(count, tables, chunk)
