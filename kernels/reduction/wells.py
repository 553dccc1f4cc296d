"""The number of wells of the potential of a motion of a body.

In a well, the slope of the potential changes from negative to positive. The linear pair is carried from the start to
upright, and from there outward on each side.
"""

import math

from kernels.bodies.shapes import RIM
from kernels.bodies.starts import body_of, is_possible
from kernels.jit import kernel
from kernels.native.entry import parallel
from kernels.reduction.carry import carry_on_side
from kernels.reduction.cells import CHUNK, own_body, scaled_start
from kernels.reduction.panels import (
    FROM_INNER,
    HALF,
    INNER_SLOPE,
    MOST_BEND,
    NUMBERS,
    ONE,
    OUTER_SLOPE,
    PP,
    SP,
    SS,
    TABLE_TYPES,
    TERMS,
    TO_OUTER,
    Table,
    clear_table,
    need_panel,
    table_memory,
    take_body,
)
from kernels.reduction.turning import stretch

#: Largest y at which the slope is evaluated: 0.04 degrees from flat. Number of points on a panel where its sign is
#: read.
_FARTHEST, _PLACES = 8.0, 4
#: Rounding of the slope, over the sum of its terms.
_ROUNDING = 1e-14


@kernel
def _slope_on(table, side, k, x, s, p):
    """Return the slope of the potential per x, 0 if it is rounding, and its derivative, from (s, p) at the centre."""
    panel, slope, bend, size = table.panels[side, k], 0.0, 0.0, 0.0
    for n in range(TERMS - 1, -1, -1):
        climb = (n + 1) * (s * s * panel[SS, n] + s * p * panel[SP, n] + p * p * panel[PP, n] + panel[ONE, n])
        bend = bend * x + slope
        slope = slope * x + climb
        size += abs(climb)
    return slope if abs(slope) > _ROUNDING * size else 0.0, bend


@kernel
def _dips(table, side, k, low, high, s, p):
    """Return whether the slope, with one sign at both ends, has the other sign near its extremum in between."""
    for _ in range(40):
        middle = 0.5 * (low[0] + high[0])
        slope, bend = _slope_on(table, side, k, middle, s, p)
        if slope * low[1] < 0.0:
            return True
        if bend * low[2] > 0.0:
            low = middle, slope, bend
        else:
            high = middle, slope, bend
    return False


@kernel
def _look_across(numbers, s, p):
    """Return quantities of the slope of the potential on a panel, from (s, p) at its inner end.

    Returns
    -------
    (slope per x at the inner end, at the outer end, bound of its derivative on the panel, (s, p) at the centre, (s, p)
    at the outer end)
    """
    half = numbers[HALF]
    inner = half * (numbers[INNER_SLOPE] + p * (numbers[INNER_SLOPE + 1] * s + numbers[INNER_SLOPE + 2] * p))
    s, p = (
        numbers[FROM_INNER] * s + numbers[FROM_INNER + 1] * p,
        numbers[FROM_INNER + 2] * s + numbers[FROM_INNER + 3] * p,
    )
    bend = numbers[MOST_BEND] + numbers[MOST_BEND + 1] * s * s + numbers[MOST_BEND + 2] * p * p
    centre = s, p
    s, p = (
        numbers[TO_OUTER] * s + numbers[TO_OUTER + 1] * p,
        numbers[TO_OUTER + 2] * s + numbers[TO_OUTER + 3] * p,
    )
    outer = half * (numbers[OUTER_SLOPE] + p * (numbers[OUTER_SLOPE + 1] * s + numbers[OUTER_SLOPE + 2] * p))
    return inner, outer, bend, centre, (s, p)


@kernel
def _count_on_side(table, side, s, p):
    """Return (wells on a side of upright, slope next to upright), from (s, p) upright.

    Beyond the end the potential rises, so there is a well if it still falls at the end.
    """
    k, wells, before, nearest = 0, 0, 0.0, 0.0
    while table.edges[k] < _FARTHEST:
        need_panel(table, side, k)
        at_inner, at_outer, bend, centre, outer = _look_across(table.panels[side, k, NUMBERS], s, p)
        if min(abs(at_inner), abs(at_outer)) > bend and at_inner * at_outer > 0.0:
            # the slope keeps its sign on the whole panel
            wells += 1 if before < 0.0 < at_inner else 0
            nearest = at_inner if k == 0 else nearest
            before, k, (s, p) = at_outer, k + 1, outer
            continue
        s, p = centre
        slope, bend = _slope_on(table, side, k, -1.0, s, p)
        low = -1.0, slope, bend
        if k == 0:
            # if the potential is even about upright, its slope there is 0
            before = nearest = slope if slope != 0.0 else bend
        for j in range(1, _PLACES + 1):
            x = 2.0 * j / _PLACES - 1.0
            slope, bend = _slope_on(table, side, k, x, s, p)
            high = x, slope, bend
            # the minimum itself counts once
            if before < 0.0 and slope >= 0.0:
                wells += 1
            elif low[1] * slope > 0.0 > low[1] * low[2] and slope * bend > 0.0:
                wells += 1 if _dips(table, side, k, low, high, s, p) else 0
            before = slope if slope != 0.0 else abs(before)
            nearest = before if nearest == 0.0 else nearest
            low = high
        k, (s, p) = k + 1, outer
    return wells + (1 if before < 0.0 else 0), nearest


@kernel
def _count(starts, cell, kind, table):
    if not is_possible(starts, cell, kind, body_of(starts, cell, kind)):
        return 0
    take_body(table, own_body(starts, cell, kind))
    _, tilt, _, o, s = scaled_start(starts, cell)
    sign = math.copysign(1.0, tilt)
    side = 0 if sign > 0.0 or kind == RIM else 1
    s, p = carry_on_side(table, side, abs(stretch(tilt)), 0.0, s, sign * o * math.cos(tilt))
    own, slope = _count_on_side(table, side, s, p)
    if kind == RIM:
        # a rim stays on the edge on which it starts
        return own
    other, back = _count_on_side(table, 1 - side, s, -p)
    return own + other + (1 if slope > 0.0 and back > 0.0 else 0)


@parallel(
    CHUNK,
    lambda *_: table_memory(),
    starts="float64[:, ::1]",
    kind="float64",
    counts="int64[::1], written",
    **TABLE_TYPES,
)
def wells(start, stop, starts, kind, counts, bodies, edges, made, panels, work):
    """Count the wells of the potential of cells.

    Python calls it without `start`, `stop` and the arguments after `counts`.

    Parameters
    ----------
    start, stop : int
        The cells of one chunk.
    starts : float64[len(PARAMETERS), n]
    kind : float
        Number of the body (`kernels.bodies.shapes`).
    counts : int64[n], written
        0 if there is no such start.
    bodies ... work : arrays
        Memory of a thread.

    Notes
    -----
    Never raises. A rim has only the wells at tilts on the side of its start.
    """
    table = Table(bodies, edges, made, panels, work)
    clear_table(table)
    for cell in range(start, stop):
        counts[cell] = _count(starts, cell, kind, table)
