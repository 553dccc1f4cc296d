"""Extremes of the contact forces of bodies along their motions; see `kernels.disk.contact_extremes`.

The reduction finds the pieces of a motion (`kernels.reduction`); on each piece the extremes are roots of series
(`kernels.bodies.forces`). Errors are judged as for the disk.
"""

import math

import numpy as np

from kernels.bodies import ellipse, forces
from kernels.bodies.forces import expand_forces
from kernels.bodies.pair import expand, go_on, length_of
from kernels.bodies.shapes import FIRST_WITH_POLES, Body
from kernels.bodies.starts import body_of
from kernels.disk import motion_arrays as motion_row
from kernels.disk.contact_extremes import _KEPT, _MOST, _judge, _look, _search_panel
from kernels.disk.contact_extremes import _PANELS as PASSED
from kernels.disk.endings import EDGE_CHANGE, FELL, INVALID, UNRESOLVED
from kernels.disk.polynomial_roots import MOST_ROOTS, largest_value
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
from kernels.reduction.turning import COUNT, END_SLOPE, ROUNDING, TURNS, stretch

#: Bound of the rounding errors of a panel, in units of the size of the terms.
_ROUNDING = 4.0 * 2.0**-52

#: Maximum number of panels of the series of forces on one piece of a motion.
_MOST_PANELS = 64


@kernel
def rounding_errors(series, end, kept):
    """Return a bound of the rounding errors of the forces on a panel up to `end`."""
    o, s = largest_value(series, forces.ALONG, end), largest_value(series, forces.SPIN, end)
    sec, v = largest_value(series, forces.SEC, end), largest_value(series, forces.SPEED, end)
    square = largest_value(series, forces.RATE_SQUARED, end)
    size = 1.0 + square + o * (s + sec * (o + v)) + largest_value(series, forces.PULL, end)
    arm = 1.0 + largest_value(series, forces.HEIGHT, end) + largest_value(series, forces.LEVER, end)
    return _ROUNDING * (2.0 + kept[PASSED]) * size * arm


@kernel
def _mirror(body):
    return Body(body.core, -body.shift, body.edge, body.square, body.axial, body.transverse, body.ratio)


@kernel
def _begin_series(series, y, s, o, kinetic):
    """Begin the series of a motion at a stretched tilt y."""
    series[forces.SIN, 0], series[forces.COS, 0] = math.tanh(y), 1.0 / math.cosh(y)
    series[forces.SPIN, 0], series[forces.ALONG, 0], series[forces.KINETIC, 0] = s, o, kinetic


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
        kept[PASSED] = float(number)
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
        kept[PASSED] = 0.0
        _look(series, 0.0, 0.0, rounding_errors(series, 0.0, kept), kept)
    sign = pieces[0, 0, SIGN]
    _search_way(table, pieces[0], ways[0], sign, series, found, kept)
    _search_way(table, pieces[1], ways[1], sign, series, found, kept)


@parallel(
    CHUNK,
    lambda *_: (
        *table_memory(), *motion_memory(), np.empty((forces.ROWS, forces.TERMS)), np.empty(MOST_ROOTS), np.empty(_KEPT),
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
def _contact(
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
        As for `kernels.disk.contact_extremes.contact_extremes`, of the motion for all time.
    states : int64[n], written
        `NO_MOTION`, `PRESSES`, `LIFTS_OFF` or `UNRESOLVED_FORCES` of `kernels.disk.motion_arrays`.
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
        normal, friction, state = math.nan, math.nan, motion_row.NO_MOTION
        falls_at_once = ending == FELL and kind < FIRST_WITH_POLES and abs(least) >= fall_tilt
        falls_at_once |= ending == EDGE_CHANGE
        if ending == UNRESOLVED:
            state = motion_row.UNRESOLVED_FORCES
        elif ending != INVALID and not (falls_at_once and ways[0, COUNT] + ways[1, COUNT] == 0.0):
            _search(starts, cell, kind, table, pieces, ways, series, found, kept)
            normal, friction, state = _judge(kept)
        extremes[motion_row.CONTACT_LEAST_NORMAL_FORCE, cell] = normal
        extremes[motion_row.CONTACT_FRICTION_NEEDED, cell] = friction
        states[cell] = state


_FLAGS = {"at": forces, "_rounding_errors": rounding_errors}

#: For bodies whose meridian is an arc of a circle, and for an arc of an ellipse.
contact = variant(_contact, "bodies", _FLAGS)
contact_ellipses = variant(_contact, "ellipses", _FLAGS | ellipse.FUNCTIONS)
