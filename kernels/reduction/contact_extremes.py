"""Extremes of the contact forces along motions, with error bounds; values not known to 1e-6 are omitted.

A motion is followed in its tilt, not in time. If it returns to the saddle from which it was kicked, an integration in
time can carry it past the saddle, to the wrong side. The reduction finds the pieces of a motion (`kernels.reduction`);
on each piece the extremes are roots of series without poles (`kernels.bodies.forces`), even if the normal force
vanishes. A piece towards a smaller |tilt| is followed as its mirror image, so that mirror images have the same bits.
"""

import math

import numpy as np

from kernels.bodies import arrays as row
from kernels.bodies import ellipse, forces, pair
from kernels.bodies.forces import expand_forces
from kernels.bodies.pair import expand, go_on, length_of
from kernels.bodies.shapes import FIRST_WITH_POLES, Body
from kernels.bodies.starts import body_of
from kernels.disk.endings import EDGE_CHANGE, FELL, INVALID, UNRESOLVED
from kernels.jit import kernel
from kernels.lanes.binding import variant
from kernels.native.entry import parallel
from kernels.reduction.cells import CHUNK, MOTION_TYPES, motion_memory, reduce_cell, scaled_start
from kernels.reduction.panels import TABLE_TYPES, Table, body_on, clear_table, pair_at, table_memory
from kernels.reduction.pieces import (
    CENTRE,
    FROM,
    HIGH,
    KINETIC,
    LENGTH,
    LOW,
    P_CENTRE,
    PANEL,
    S_CENTRE,
    SIDE,
    SIGN,
)
from kernels.reduction.polynomial_roots import (
    AMBIGUOUS,
    MOST_ROOTS,
    largest_value,
    roots,
    value_and_slope,
    value_at,
)
from kernels.reduction.turning import COUNT, END_SLOPE, ROUNDING, TURNS, stretch

#: Bound of the rounding errors of a panel, in units of the size of the terms.
_ROUNDING = 4.0 * 2.0**-52

#: A value is known if its error bound is below this times 1 + |value|; the promised error is 1e-6.
_KNOWN = 2.5e-7

#: Maximum number of panels of the series of forces on one piece of a motion.
_MOST_PANELS = 64

#: Numbers kept along a motion: the least normal force found and its lower and upper bound, the same for the largest
#: friction coefficient; the number of pieces passed.
_LEAST, _LEAST_LOW, _LEAST_HIGH, _MOST, _MOST_LOW, _MOST_HIGH, _PASSED = range(7)
_KEPT = 7


@kernel
def _bound_rounding(series, end, kept):
    """Return a bound of the rounding errors of the forces on a panel up to `end`."""
    o, s = largest_value(series, pair.ALONG, end), largest_value(series, pair.SPIN, end)
    sec, v = largest_value(series, forces.SEC, end), largest_value(series, pair.SPEED, end)
    square = largest_value(series, forces.RATE_SQUARED, end)
    size = 1.0 + square + o * (s + sec * (o + v)) + largest_value(series, forces.PULL, end)
    arm = 1.0 + largest_value(series, pair.HEIGHT, end) + largest_value(series, pair.LEVER, end)
    return _ROUNDING * (2.0 + kept[_PASSED]) * size * arm


@kernel
def _look(series, t, apart, rounding, kept):
    """Include the forces at t, which is known to within `apart`, in the extremes."""
    normal, slope = value_and_slope(series, forces.NORMAL, t)
    error = rounding + abs(slope) * apart
    kept[_LEAST] = min(kept[_LEAST], normal)
    kept[_LEAST_LOW] = min(kept[_LEAST_LOW], normal - error)
    kept[_LEAST_HIGH] = min(kept[_LEAST_HIGH], normal + error)
    if not normal > error:
        kept[_MOST_HIGH] = math.inf
        return
    squared, slope = value_and_slope(series, forces.FRICTION_SQUARED, t)
    horizontal = math.sqrt(max(0.0, squared))
    beyond = rounding + math.sqrt(max(0.0, squared) + abs(slope) * apart) - horizontal
    needed = horizontal / normal
    error = (beyond + needed * error) / (normal - error)
    kept[_MOST] = max(kept[_MOST], needed)
    kept[_MOST_LOW] = max(kept[_MOST_LOW], needed - error)
    kept[_MOST_HIGH] = max(kept[_MOST_HIGH], needed + error)


@kernel
def _search_panel(series, end, apart, found, kept):
    """Find the extremes of the forces from the beginning of a panel to `end`, which is known to within `apart`."""
    rounding = _bound_rounding(series, end, kept)
    _look(series, 0.0, 0.0, rounding, kept)
    _look(series, end, apart, rounding, kept)
    count = roots(series, forces.NORMAL_SLOPE, end, rounding, found)
    if count == AMBIGUOUS:
        kept[_LEAST_LOW] = -math.inf
        return
    least = min(value_at(series, forces.NORMAL, 0.0), value_at(series, forces.NORMAL, end))
    for i in range(count):
        _look(series, found[i], 0.0, rounding, kept)
        least = min(least, value_at(series, forces.NORMAL, found[i]))
    if not least > rounding:
        return
    # terms omitted from the square of the coefficient are at most 1e-14
    count = roots(series, forces.FRICTION_SLOPE, end, 1e-14 * least * least * least, found)
    if count == AMBIGUOUS:
        kept[_MOST_HIGH] = math.inf
    for i in range(count):
        _look(series, found[i], 0.0, rounding, kept)


@kernel
def _mirror(body):
    return Body(body.core, -body.shift, body.edge, body.square, body.axial, body.transverse, body.ratio)


@kernel
def _begin_series(series, y, s, o, kinetic):
    """Begin the series of a motion at a stretched tilt y."""
    series[pair.SIN, 0], series[pair.COS, 0] = math.tanh(y), 1.0 / math.cosh(y)
    series[pair.SPIN, 0], series[pair.ALONG, 0], series[pair.KINETIC, 0] = s, o, kinetic


@kernel
def _search_piece(table, piece, outward, apart_at_end, series, found, kept):
    """Search a piece of a motion, whose end is known to within `apart_at_end` in y."""
    side = int(piece[SIDE])
    x = (piece[FROM] - piece[CENTRE]) / piece[LENGTH]
    s, p = pair_at(table, side, int(piece[PANEL]), x, piece[S_CENTRE], piece[P_CENTRE])
    body, y, o = body_on(table, side), piece[FROM], p * math.cosh(piece[FROM])
    if not outward:
        # towards greater tilts in the mirror image
        body, y, o = _mirror(body), -y, -o
    _begin_series(series, y, s, o, piece[KINETIC])
    left = piece[HIGH] - piece[LOW]
    for _ in range(_MOST_PANELS):
        expand(series, body)
        expand_forces(series, body)
        length = min(length_of(series), left)
        left -= length
        apart = 4.0 * 2.0**-52 * (abs(y) + piece[LENGTH])
        _search_panel(series, length, apart + (apart_at_end if left == 0.0 else 0.0), found, kept)
        if left == 0.0:
            return
        go_on(series, length)
    kept[_MOST] = math.nan


@kernel
def _search_way(table, pieces, way, sign, series, found, kept):
    """Search a motion from its start in one direction; `sign` is the sign of the tilts on its side."""
    count = int(way[COUNT])
    # whether the motion goes to greater |tilt| at first
    outward = count > 0 and pieces[0, HIGH] > 0.0
    for number in range(count):
        piece, apart = pieces[number], 0.0
        if number + 1 == count and way[TURNS] == 1.0:
            # rounding of the energy moves a turning point
            apart = way[ROUNDING] / abs(way[END_SLOPE])
        kept[_PASSED] = float(number)
        _search_piece(table, piece, outward == (piece[SIGN] == sign), apart, series, found, kept)


@kernel
def _search(starts, cell, kind, table, pieces, ways, series, found, kept):
    """Search a motion on both sides of its start; a motion at rest only has its start."""
    _, tilt, _, o, s = scaled_start(starts, cell)
    if ways[0, COUNT] == 0.0 and ways[1, COUNT] == 0.0:
        body = body_of(starts, cell, kind)
        _begin_series(series, stretch(tilt), s, o, 0.0)
        expand(series, body)
        expand_forces(series, body)
        kept[_PASSED] = 0.0
        _look(series, 0.0, 0.0, _bound_rounding(series, 0.0, kept), kept)
    sign = pieces[0, 0, SIGN]
    _search_way(table, pieces[0], ways[0], sign, series, found, kept)
    _search_way(table, pieces[1], ways[1], sign, series, found, kept)


@kernel
def _judge(kept):
    """Return (least normal force, friction needed, state) from the kept numbers; NaN for unknown values."""
    least, most = kept[_LEAST], kept[_MOST]
    error = max(least - kept[_LEAST_LOW], kept[_LEAST_HIGH] - least)
    if not error <= _KNOWN * (1.0 + abs(least)):
        return math.nan, math.nan, row.UNRESOLVED_FORCES
    if kept[_LEAST_HIGH] <= 0.0:
        return least, math.nan, row.LIFTS_OFF
    error = max(most - kept[_MOST_LOW], kept[_MOST_HIGH] - most)
    if not (kept[_LEAST_LOW] > 0.0 and error <= _KNOWN * (1.0 + most)):
        return least, math.nan, row.UNRESOLVED_FORCES
    return least, most, row.PRESSES


@parallel(
    CHUNK,
    lambda *_: (
        *table_memory(), *motion_memory(), np.empty((forces.ROWS, pair.TERMS)), np.empty(MOST_ROOTS), np.empty(_KEPT),
    ),
    starts="float64[:, ::1]",
    kind="float64",
    fall_tilt="float64",
    extremes="float64[:, ::1], written",
    states="int64[::1], written",
    **TABLE_TYPES,
    **MOTION_TYPES,
    series="float64[:, ::1]",
    found="float64[::1]",
    kept="float64[::1]",
)  # fmt: skip
def contact(
    start, stop, starts, kind, fall_tilt, extremes, states, bodies, edges, made, panels, work, pieces, ways, near,
    series, found, kept,
):  # fmt: skip
    """Find the extremes of the contact forces that rolling without slip needs, along the motion of every cell.

    Python calls it without `start`, `stop` and the arguments after `states`.

    Parameters
    ----------
    start, stop : int
        The cells of one chunk.
    starts, kind, fall_tilt
        As for `kernels.reduction.cells.reduce`.
    extremes : float64[len(CONTACT), n], written
        Of the motion for all time: least normal force over m g [1], and largest friction coefficient needed [1], which
        is NaN if the normal force becomes zero or negative. Both are NaN without a motion, and if the error bound
        exceeds a quarter of 1e-6 (1 + |value|).
    states : int64[n], written
        `NO_MOTION`, `PRESSES`, `LIFTS_OFF` or `UNRESOLVED_FORCES` of `kernels.bodies.arrays`.
    bodies ... kept : arrays
        Memory of a thread.

    Notes
    -----
    Never raises. A motion that falls is searched from its start on, and back to its turning point before, if it has
    one.
    """
    table = Table(bodies, edges, made, panels, work)
    clear_table(table)
    y_fall = stretch(fall_tilt)
    for cell in range(start, stop):
        kept[:] = 0.0
        kept[:_MOST] = math.inf
        ending, least, _, _ = reduce_cell(starts, cell, kind, fall_tilt, y_fall, table, pieces, ways, near)
        normal, friction, state = math.nan, math.nan, row.NO_MOTION
        falls_at_once = ending == FELL and kind < FIRST_WITH_POLES and abs(least) >= fall_tilt
        falls_at_once |= ending == EDGE_CHANGE
        if ending == UNRESOLVED:
            state = row.UNRESOLVED_FORCES
        elif ending != INVALID and not (falls_at_once and ways[0, COUNT] + ways[1, COUNT] == 0.0):
            _search(starts, cell, kind, table, pieces, ways, series, found, kept)
            normal, friction, state = _judge(kept)
        extremes[row.CONTACT_LEAST_NORMAL_FORCE, cell] = normal
        extremes[row.CONTACT_FRICTION_NEEDED, cell] = friction
        states[cell] = state


#: For bodies whose meridian is an arc of an ellipse.
contact_ellipses = variant(contact, "ellipses", ellipse.FUNCTIONS)
