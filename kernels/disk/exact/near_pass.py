"""The first pass over a chunk: expansions about the starts, near which most turning points of slow motions lie."""

from kernels.disk.exact import layout as at
from kernels.disk.exact import motion as of
from kernels.disk.exact.counting_sort import FIRST, KEY, STOP, blocks_of
from kernels.disk.exact.far_turning_points import OPEN, TURNS
from kernels.disk.exact.layout import LANES
from kernels.disk.exact.legendre import NODES, PANELS
from kernels.disk.exact.near_turning_points import expand_about_starts, near_turning_points, rounding_error
from kernels.disk.exact.root import ROUNDING
from kernels.disk.exact.saddle import find_saddles
from kernels.jit import kernel

#: A force at rest below this share of its terms is rounding (as in `kernels.disk.leg_control`).
_STEADY = 16.0 * ROUNDING


@kernel
def _load(chunk, first, last):
    block, motions = chunk.block, chunk.motions
    for lane in range(LANES):
        i = chunk.order[min(first + lane, last - 1)]
        block[at.Y_0 + lane], block[at.X_0 + lane] = motions[i, of.Y_0], motions[i, of.X_0]
        block[at.S_0 + lane], block[at.O_0 + lane] = motions[i, of.S_0], motions[i, of.O_0]
        block[at.SIN + lane], block[at.COS + lane] = motions[i, of.SIN], motions[i, of.COS]
        block[at.W_0 + lane] = motions[i, of.W]


@kernel
def _classify(block):
    """Write the KIND of each motion; whether one of them starts with a tilt rate."""
    kicked = 0
    for lane in range(LANES):
        w, height, base = block[at.W_0 + lane], block[at.HEIGHT + lane], block[at.BASE + lane]
        at_rest = (w == 0.0) & (abs(block[at.FORCE + lane]) <= _STEADY * block[at.PULL + lane])
        on_separatrix = abs(height) <= rounding_error(
            block, lane, block[at.TOP + lane] - block[at.Y_0 + lane]
        )
        kind = of.ON_SEPARATRIX if on_separatrix else of.OSCILLATES
        kind = of.RESTS if at_rest else kind
        # x - x is zero only for a finite x
        block[at.KIND + lane] = kind if base - base == 0.0 else of.NOT_FINITE
        kicked |= int(w != 0.0)
    return kicked != 0


@kernel
def _store_centres(chunk, first, last):
    """Store rates and excess at the centre of the start's panel; the search for saddles needs their rows."""
    block, motions = chunk.block, chunk.motions
    for lane in range(last - first):
        i = chunk.order[first + lane]
        motions[i, of.S_HERE], motions[i, of.P_HERE] = block[at.S_HERE + lane], block[at.P_HERE + lane]
        motions[i, of.CENTRE] = block[at.CENTRE + lane]


@kernel
def _store_motions(chunk, first, last):
    block, motions = chunk.block, chunk.motions
    for lane in range(last - first):
        i = chunk.order[first + lane]
        motions[i, of.AHEAD], motions[i, of.KIND] = block[at.AHEAD + lane], block[at.KIND + lane]
        motions[i, of.TOP], motions[i, of.HEIGHT] = block[at.TOP + lane], block[at.HEIGHT + lane]
        motions[i, of.C_1], motions[i, of.C_2] = block[at.C_1 + lane], block[at.C_2 + lane]
        motions[i, of.BASE] = block[at.BASE + lane]
        motions[i, of.KINETIC], motions[i, of.PULL] = block[at.KINETIC + lane], block[at.PULL + lane]
        motions[i, of.CURVATURE], motions[i, of.LEVEL] = block[at.CURVATURE + lane], block[at.LEVEL + lane]
        motions[i, of.FORCE], motions[i, of.BEND] = block[at.FORCE + lane], block[at.BEND + lane]


@kernel
def _find_to_one_side(chunk, sense, panels, panel, first, last):
    """Find the turning points of a block on one side; those that lie farther out are left OPEN."""
    block, motions = chunk.block, chunk.motions
    ahead = sense > 0.0
    for lane in range(LANES):
        wanted = (block[at.KIND + lane] == of.OSCILLATES) & (ahead | (block[at.W_0 + lane] != 0.0))
        block[at.WANTED + lane] = 1.0 if wanted else 0.0
    near_turning_points(block, sense, panels, panel)
    column = 0 if ahead else of.BEHIND
    for lane in range(last - first):
        i, wanted = chunk.order[first + lane], block[at.WANTED + lane]
        motions[i, column + of.END] = TURNS if wanted <= 0.0 else OPEN
        motions[i, column + of.TURN] = block[at.TILT + lane]
        motions[i, column + of.ERROR] = block[at.ERROR + lane]
        motions[i, column + of.DISTANCE] = block[at.DISTANCE + lane]
        motions[i, column + of.SLOPE] = block[at.SLOPE + lane]
        motions[i, column + of.EXCESS] = block[at.EXCESS + lane]


@kernel
def find_near(n, tables, chunk):
    """Expand n motions about their starts and find the turning points there."""
    for b in range(blocks_of(chunk.keys, n, LANES, chunk.order, chunk.ends, chunk.blocks)):
        panel, first, last = chunk.blocks[KEY, b], chunk.blocks[FIRST, b], chunk.blocks[STOP, b]
        table = panel // PANELS
        alpha, node = tables.alphas[table], table * NODES + 2 * (panel - table * PANELS)
        _load(chunk, first, last)
        expand_about_starts(chunk.block, alpha, tables.panels, panel, tables.nodes, node)
        _store_centres(chunk, first, last)
        find_saddles(chunk.block, alpha, table, tables.panels, tables.nodes)
        kicked = _classify(chunk.block)
        _store_motions(chunk, first, last)
        _find_to_one_side(chunk, 1.0, tables.panels, panel, first, last)
        if kicked:
            _find_to_one_side(chunk, -1.0, tables.panels, panel, first, last)
