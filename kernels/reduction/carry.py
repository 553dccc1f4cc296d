"""The linear pair of a body, carried from one tilt to another, for theory without time integration."""

import math

from kernels.bodies.shapes import Body
from kernels.jit import kernel
from kernels.native.entry import parallel
from kernels.reduction.cells import CHUNK
from kernels.reduction.panels import (
    FROM_INNER,
    FROM_OUTER,
    HALF,
    NUMBERS,
    TABLE_TYPES,
    TO_INNER,
    TO_OUTER,
    Table,
    body_on,
    clear_table,
    meridian,
    need_panel,
    pair_at,
    pair_at_centre,
    panel_at,
    table_memory,
    take_body,
)
from kernels.reduction.turning import stretch


@kernel
def _multiply(numbers, first, s, p):
    """Return the product of (s, p) and the matrix whose numbers begin at `first`."""
    return numbers[first] * s + numbers[first + 1] * p, numbers[first + 2] * s + numbers[first + 3] * p


@kernel
def _place_on(table, side, k, y):
    """Return x on a panel."""
    half = table.panels[side, k, NUMBERS, HALF]
    return (y - table.edges[k]) / half - 1.0


@kernel
def carry_on_side(table, side, y, there, s, p):
    """Return (s, p) at the stretched tilt `there` from (s, p) at y; both at least 0, on one side of a table."""
    k, last = panel_at(table, y), panel_at(table, there)
    need_panel(table, side, k)
    s, p = pair_at_centre(table, side, k, _place_on(table, side, k, y), s, p)
    while k != last:
        outward = k < last
        s, p = _multiply(table.panels[side, k, NUMBERS], TO_OUTER if outward else TO_INNER, s, p)
        k += 1 if outward else -1
        need_panel(table, side, k)
        s, p = _multiply(table.panels[side, k, NUMBERS], FROM_INNER if outward else FROM_OUTER, s, p)
    return pair_at(table, side, k, _place_on(table, side, k, there), s, p)


@kernel
def _carry(table, y, there, s, p):
    """Return (s, p) at the stretched tilt `there` from (s, p) at y."""
    side, other = 0 if y >= 0.0 else 1, 0 if there >= 0.0 else 1
    # the side of negative tilts is the mirror image
    p = p if side == 0 else -p
    if side == other:
        s, p = carry_on_side(table, side, abs(y), abs(there), s, p)
    else:
        s, p = carry_on_side(table, side, abs(y), 0.0, s, p)
        s, p = carry_on_side(table, other, 0.0, abs(there), s, -p)
    return s, p if other == 0 else -p


@kernel
def _turning_square(tilt, there, w, before, after, body):
    """Return the squared factor of the rates (s, o), before and after, with which a motion turns at the tilt `there`.

    Its energy is the part with these rates, times that square, plus the rest.
    """
    S, C, S_there, C_there = math.sin(tilt), math.cos(tilt), math.sin(there), math.cos(there)
    a, b, _, _ = meridian(S, C, body)
    a_there, b_there, _, _ = meridian(S_there, C_there, body)
    A, I = body.transverse, body.axial
    v, v_there = a * before[0] + b * before[1], a_there * after[0] + b_there * after[1]
    root = math.sqrt(1.0 - (1.0 - body.square) * S * S)
    root_there = math.sqrt(1.0 - (1.0 - body.square) * S_there * S_there)
    rise = S_there - S
    # cosines and roots differ by the difference of squared sines
    squares = rise * (S_there + S)
    higher = body.core * (-squares / (C_there + C)) + body.shift * rise
    higher += body.edge * (-(1.0 - body.square) * squares / (root_there + root))
    kinetic = 0.5 * (A + a * a + b * b) * w * w
    barrier = 0.5 * (
        A * (after[1] - before[1]) * (after[1] + before[1])
        + I * (after[0] - before[0]) * (after[0] + before[0])
        + (v_there - v) * (v_there + v)
    )
    return max(kinetic - higher, 0.0) / barrier if barrier > 0.0 else math.inf


@parallel(
    CHUNK,
    lambda *_: table_memory(),
    tilts="float64[:, ::1]",
    given="float64[:, ::1]",
    rates="float64[:, ::1], written",
    squares="float64[::1], written",
    **TABLE_TYPES,
)
def carry(start, stop, tilts, given, rates, squares, bodies, edges, made, panels, work):
    """Carry the rates s and o of motions from one tilt to another, and find the multiple with which they turn there.

    Python calls it without `start`, `stop` and the arguments after `squares`.

    Parameters
    ----------
    start, stop : int
        The cells of one chunk.
    tilts : float64[3, n]
        First and second tilt [rad], within 90 degrees, and the scaled tilt rate.
    given : float64[7, n]
        Rows as in `kernels.bodies.shapes.Body`.
    rates : float64[2, n], written
        s and o in any common unit: at the first tilts, then at the second ones.
    squares : float64[n], written
        Square of the factor of scaled rates with which the motion turns at the second tilt; infinite if none does.
    bodies ... work : arrays
        Memory of a thread.
    """
    table = Table(bodies, edges, made, panels, work)
    clear_table(table)
    for cell in range(start, stop):
        take_body(
            table,
            Body(
                given[0, cell],
                given[1, cell],
                given[2, cell],
                given[3, cell],
                given[4, cell],
                given[5, cell],
                given[6, cell],
            ),
        )
        tilt, there, w = tilts[0, cell], tilts[1, cell], tilts[2, cell]
        s, o = rates[0, cell], rates[1, cell]
        s_there, p_there = _carry(table, stretch(tilt), stretch(there), s, o * math.cos(tilt))
        o_there = p_there / math.cos(there)
        squares[cell] = _turning_square(tilt, there, w, (s, o), (s_there, o_there), body_on(table, 0))
        rates[0, cell], rates[1, cell] = s_there, o_there
