"""The saddle of the potential between its two wells, for a block of motions (`kernels.disk.exact.layout`).

V has one well unless V'' < 0 at upright (checked along the whole curve of folds). The saddle lies on the side on which
V rises from upright; with c1 c2 = 0 it is upright itself. The side of the saddle counts as positive y: under y -> -y,
p -> -p nothing changes, so that the sign of c2 tells one side from the other.

Source: Borisov, Mamaev, Kilin, Regul. Chaotic Dyn. 8 (2003) 201.
"""

import math

from kernels.disk.exact import layout as at
from kernels.disk.exact.layout import LANES
from kernels.disk.exact.legendre import COS1, DO1, DO2, DP1, DP2, DS1, DS2, NODES, PANEL, PANELS, REACH, SIN
from kernels.disk.exact.near_turning_points import expand
from kernels.disk.exact.polynomial import slopes, value
from kernels.disk.exact.potential import NEAR, NODE, rise, rise_at
from kernels.disk.exact.root import MOST_STEPS
from kernels.jit import kernel

#: Saddles of V stay below 19.3 degrees for every alpha in (0, 1] (the top of the dome of unstable circling: 17.6 for
#: alpha -> 0, 18.62 disk, 19.20 hoop), which is y = 0.342; six half panels end at 0.375.
_SADDLE_NODES = 6
#: The panels that these lie on.
_SADDLE_PANELS = 4
#: A saddle and a minimum can hide between two nodes; at the nearest node V' is then below NODE^2/2 max|V'''|.
_HIDDEN = 0.016
#: max|V'''| there.
_THIRD = 2.0 * _HIDDEN / NODE**2
#: Bisections after which a bracket is as small as rounding.
_MOST_HALVES = 60


@kernel
def _two_well_candidates(block, alpha):
    """Which potentials may have two wells (WANTED), and on which side their saddle is then; whether any."""
    some = 0
    for lane in range(LANES):
        c1, c2 = block[at.C_1 + lane], block[at.C_2 + lane]
        side = -1.0 if c1 * c2 > 0.0 else 1.0
        trapped = 2.0 * (1.0 + alpha) * c1 * c1 + (1.0 + 0.5 * alpha) * c2 * c2 < 1.0
        climb = (1.0 + alpha) * abs(c1 * c2)
        block[at.TOP + lane] = block[at.HEIGHT + lane] = block[at.BEND + lane] = math.nan
        block[at.SIDE + lane], block[at.Q + lane] = side, side * c2
        block[at.BEFORE + lane] = block[at.LEAST + lane] = climb
        block[at.NODE + lane] = 0.0
        block[at.WANTED + lane] = 1.0 if trapped else 0.0
        # upright is the saddle: no bracket is needed
        block[at.PANEL + lane] = 0.0 if climb == 0.0 else -1.0
        block[at.INNER + lane] = block[at.OUTER + lane] = block[at.ROOT + lane] = 0.0
        some |= int(trapped)
    return some != 0


@kernel
def _bracket(block, alpha, nodes, upright):
    """Bracket each saddle by the first node beyond which V falls (INNER, OUTER), with a guess in ROOT."""
    for i in range(1, _SADDLE_NODES + 1):
        node = upright + i
        ds1, ds2, do1, do2 = nodes[node, DS1], nodes[node, DS2], nodes[node, DO1], nodes[node, DO2]
        cos, sin = 1.0 + nodes[node, COS1], nodes[node, SIN]
        for lane in range(LANES):
            c1, q = block[at.C_1 + lane], block[at.Q + lane]
            before, least, panel = block[at.BEFORE + lane], block[at.LEAST + lane], block[at.PANEL + lane]
            s, o = c1 + (ds1 * c1 + ds2 * q), q + (do1 * c1 + do2 * q)
            climb = 0.5 * alpha * sin * o * o - cos * ((1.0 + alpha) * s * o + sin)
            sought = panel < 0.0
            found = sought & (climb < 0.0)
            block[at.PANEL + lane] = i // 2 if found else panel
            block[at.INNER + lane] = (i - 1) * NODE if found else block[at.INNER + lane]
            block[at.OUTER + lane] = i * NODE if found else block[at.OUTER + lane]
            guess = (i - 1 + before / (before - climb)) * NODE
            block[at.ROOT + lane] = guess if found else block[at.ROOT + lane]
            block[at.BEFORE + lane] = climb
            block[at.LEAST + lane] = climb if climb < least else least
            block[at.NODE + lane] = i if climb < least else block[at.NODE + lane]


@kernel
def _bracket_hidden(block):
    """Where V' > 0 at all nodes, bracket a saddle that may lie between two; clear WANTED where none can."""
    for lane in range(LANES):
        wanted, panel, where = block[at.WANTED + lane], block[at.PANEL + lane], block[at.NODE + lane]
        lost = panel < 0.0
        low, high = NODE * (where - 1.0 if where > 0.0 else 0.0), NODE * (where + 1.0)
        block[at.WANTED + lane] = 0.0 if lost & (block[at.LEAST + lane] > _HIDDEN) else wanted
        block[at.PANEL + lane] = math.floor(0.5 * (where + 1.0)) if lost else panel
        block[at.INNER + lane] = low if lost else block[at.INNER + lane]
        block[at.BEFORE + lane] = low
        block[at.LEAST + lane] = high if lost else 0.0


@kernel
def expand_excess(block, alpha, table, panels, nodes, k):
    """Excess on panel k as seen by motions with rates C_1 and Q at upright, into WORK."""
    panel, node = table * PANELS + REACH + k, table * NODES + 2 * (REACH + k)
    ds1, ds2, dp1, dp2 = nodes[node, DS1], nodes[node, DS2], nodes[node, DP1], nodes[node, DP2]
    for lane in range(LANES):
        c1, q = block[at.C_1 + lane], block[at.Q + lane]
        block[at.S_HERE + lane] = c1 + (ds1 * c1 + ds2 * q)
        block[at.P_HERE + lane] = q + (dp1 * c1 + dp2 * q)
    expand(block, panels, panel, at.WORK)
    there = rise_at(nodes, node)
    for lane in range(LANES):
        c1, q = block[at.C_1 + lane], block[at.Q + lane]
        block[at.WORK + lane] = rise(alpha, there, c1, q) - block[at.BASE + lane]


@kernel
def _bisect(block, centre):
    """Halve the brackets (BEFORE, LEAST) of the least V' in every active lane, until V' < 0 somewhere or nowhere."""
    left = 0
    for lane in range(LANES):
        low, high, active = block[at.BEFORE + lane], block[at.LEAST + lane], block[at.ACTIVE + lane]
        t = 0.5 * (low + high)
        first, second = slopes(block, at.WORK + lane, LANES, t - centre)
        low = t if second < 0.0 else low
        high = high if second < 0.0 else t
        rest = high - low
        on = active > 0.0
        found = on & (first < 0.0)
        none = on & (first > (abs(second) + 0.5 * _THIRD * rest) * rest)
        block[at.OUTER + lane] = t if found else block[at.OUTER + lane]
        block[at.ROOT + lane] = 0.5 * (block[at.INNER + lane] + t) if found else block[at.ROOT + lane]
        # lanes that wait for another panel keep their brackets
        block[at.BEFORE + lane] = low if on else block[at.BEFORE + lane]
        block[at.LEAST + lane] = high if on else block[at.LEAST + lane]
        block[at.ACTIVE + lane] = 0.0 if found | none else active
        left |= int(on) & int(not (found | none))
    return left != 0


@kernel
def _find_hidden(block, centre):
    """Bracket the saddles that hide between nodes of this panel; a potential without one has one well."""
    some = 0
    for lane in range(LANES):
        hidden = (block[at.HERE + lane] > 0.0) & (block[at.LEAST + lane] > 0.0)
        block[at.ACTIVE + lane] = 1.0 if hidden else 0.0
        some |= int(hidden)
    if some == 0:
        return
    for _ in range(_MOST_HALVES):
        if not _bisect(block, centre):
            break
    for lane in range(LANES):
        hidden = (block[at.HERE + lane] > 0.0) & (block[at.LEAST + lane] > 0.0)
        none = hidden & (block[at.OUTER + lane] == 0.0)
        block[at.WANTED + lane] = 0.0 if none else block[at.WANTED + lane]
        block[at.HERE + lane] = 0.0 if none else block[at.HERE + lane]


@kernel
def _newton_step(block, centre):
    """One Newton step on V' in every active lane; whether any lane is still active."""
    left = 0
    for lane in range(LANES):
        t, inner, outer = block[at.ROOT + lane], block[at.INNER + lane], block[at.OUTER + lane]
        active = block[at.ACTIVE + lane]
        first, second = slopes(block, at.WORK + lane, LANES, t - centre)
        outer = t if first < 0.0 else outer
        inner = inner if first < 0.0 else t
        new = t - first / second
        new = new if (new - inner) * (new - outer) <= 0.0 else 0.5 * (inner + outer)
        # V' = 0 there: half of the digits of the saddle's tilt are enough for all digits of its height
        close = abs(new - t) <= 1e-5 * t
        on = active > 0.0
        block[at.ROOT + lane] = new if on else t
        block[at.INNER + lane] = inner if on else block[at.INNER + lane]
        block[at.OUTER + lane] = outer if on else block[at.OUTER + lane]
        block[at.ACTIVE + lane] = 0.0 if close else active
        left |= int(on) & int(not close)
    return left != 0


@kernel
def _maxima_on_panel(block, alpha, table, panels, nodes, k):
    """Find the maxima of V that were bracketed on panel k, and their heights over h."""
    some = 0
    for lane in range(LANES):
        here = (block[at.WANTED + lane] > 0.0) & (block[at.PANEL + lane] == k)
        block[at.HERE + lane] = 1.0 if here else 0.0
        some |= int(here)
    if some == 0:
        return
    centre = k * PANEL
    expand_excess(block, alpha, table, panels, nodes, k)
    _find_hidden(block, centre)
    for lane in range(LANES):
        moves = (block[at.HERE + lane] > 0.0) & (block[at.OUTER + lane] > 0.0)
        block[at.ACTIVE + lane] = 1.0 if moves else 0.0
    for _ in range(MOST_STEPS):
        if not _newton_step(block, centre):
            break
    for lane in range(LANES):
        t, here = block[at.ROOT + lane], block[at.HERE + lane] > 0.0
        height = value(block, at.WORK + lane, LANES, t - centre)
        block[at.TOP + lane] = block[at.SIDE + lane] * t if here else block[at.TOP + lane]
        block[at.HEIGHT + lane] = height if here else block[at.HEIGHT + lane]
        _, bend = slopes(block, at.WORK + lane, LANES, t - centre)
        block[at.BEND + lane] = bend if here else block[at.BEND + lane]


@kernel
def find_saddles(block, alpha, table, panels, nodes):
    """Find the saddles of the potentials, into TOP, HEIGHT (V there minus h) and BEND (V''): NaN with one well only.

    Needs what `kernels.disk.exact.near_turning_points.expand_about_starts` leaves.
    """
    if not _two_well_candidates(block, alpha):
        return
    _bracket(block, alpha, nodes, table * NODES + 2 * REACH)
    _bracket_hidden(block)
    for k in range(_SADDLE_PANELS):
        _maxima_on_panel(block, alpha, table, panels, nodes, k)
    for lane in range(LANES):
        away = block[at.TOP + lane] - block[at.Y_0 + lane]
        # about the start the excess is known without a difference of potentials
        near = abs(block[at.X_0 + lane] + away) <= NEAR
        height = value(block, at.NEAR + lane, LANES, away)
        block[at.HEIGHT + lane] = height if near else block[at.HEIGHT + lane]
