"""Turning points: the first zeros of the kinetic energy of the tilt on both sides of a start."""

import math

from kernels.bodies.shapes import FIRST_WITH_POLES, RIM
from kernels.disk.endings import BOUNDED, EDGE_CHANGE, FELL, STEADY, UNRESOLVED
from kernels.jit import kernel
from kernels.reduction.panels import (
    CLIMB,
    FROM_INNER,
    FROM_OUTER,
    INNER_SLOPE,
    LONGEST,
    MOST_BEND,
    NUMBERS,
    OUTER_SLOPE,
    POLE,
    REACH,
    TO_INNER,
    TO_OUTER,
    body_on,
    meridian,
    pair_at_centre,
    panel_at,
    slope_terms,
)
from kernels.reduction.pieces import (
    AWAY,
    BEND,
    CENTRE,
    FROM,
    HIGH,
    KINETIC,
    LENGTH,
    LOW,
    P_CENTRE,
    PANEL,
    PIECE,
    S_CENTRE,
    SIDE,
    SIGN,
    SLOPE,
    begin_piece,
    find_change,
    find_root,
    form_quotient,
    look_along,
)

_EPS = 2.0**-52

#: Maximum number of pieces of a motion in one direction.
MOST_PIECES = 2 * REACH + 4

#: Numbers of a way, the motion from its start in one direction: number of pieces; bound of the rounding of E - V at
#: its end; slope dV/dy there; 1 if it ends at a turning point, otherwise 0.
COUNT, ROUNDING, END_SLOPE, TURNS = range(4)
WAY = 4

#: Numbers of the maximum of the potential nearest to the energy of a motion: its height over the energy, negative if
#: the motion passes it; its y, measured as that of pieces, or that of the turning point before it; half the distance
#: of the zeros of E - V about it, negative if the motion turns; the rounding of the energy there.
TOP, PLACE, WIDTH, TOP_ROUNDING = range(4)
NEAR = 4


@kernel
def stretch(tilt):
    """Return the stretched tilt y of a tilt."""
    S, C = math.sin(abs(tilt)), math.cos(tilt)
    return math.copysign(0.5 * math.log1p(2.0 * S * (1.0 + S) / (C * C)), tilt)


@kernel
def _note(near, top, place, width, rounding):
    if abs(top) < abs(near[TOP]):
        near[TOP], near[PLACE], near[WIDTH], near[TOP_ROUNDING] = top, place, width, rounding


@kernel
def _note_beyond(piece, place, slope, bend, rounding, near):
    """Note the top of the parabola at a turning point."""
    if bend < 0.0:
        _note(near, -0.5 * slope * slope / bend, place, -abs(slope / bend) * piece[LENGTH], rounding)


@kernel
def _note_passed(piece, top, place, rounding, near):
    """Note the maximum of the potential at the distance `top`."""
    height, _, curvature = look_along(piece, top)
    if height == 0.0:
        _note(near, 0.0, 0.0, 0.0, rounding)
    else:
        width = piece[LENGTH] * math.copysign(math.sqrt(abs(2.0 * height / curvature)), height)
        # a maximum above the energy is beyond the turning point, where it is noted
        if height > 0.0:
            _note(near, -height, place, width, rounding)


@kernel
def _first_turn(piece, sense, most):
    """Find the first turning point within the distance `most`.

    Between the ends the slope is monotone, or has one extremum where its derivative changes sign.

    Returns
    -------
    (t, kinetic, slope, bend, top)
        Distance in `sense`, NaN if there is none; kinetic energy, and both derivatives of the potential, there or at
        the end; distance outward of a maximum of the potential, NaN if there is none.
    """
    bend = piece[BEND]
    end, end_slope, end_bend = look_along(piece, sense * most)
    # at the very bottom of a well, the potential still rises in both directions
    slope, last = sense * piece[SLOPE] if piece[SLOPE] != 0.0 else bend, sense * end_slope
    low, top, begin, stop, hides = 0.0, math.nan, 0.0, most, False
    if slope > 0.0 and last > 0.0 and bend < 0.0 < end_bend:
        stop = find_change(piece, 0.0, sense * most, -1.0, 2) * sense
        hides = sense * look_along(piece, sense * stop)[1] < 0.0
    elif slope < 0.0 and last < 0.0 and bend > 0.0 > end_bend:
        begin = find_change(piece, 0.0, sense * most, 1.0, 2) * sense
        hides = sense * look_along(piece, sense * begin)[1] > 0.0
    if hides or slope > 0.0 >= last:
        low = sense * find_change(piece, sense * begin, sense * stop, sense, 1)
        top, at_top = sense * low, look_along(piece, sense * low)[0]
        if at_top <= 0.0:
            low, end, most = 0.0, at_top, low
    if end <= 0.0:
        t, slope, bend = find_root(piece, sense, low, most, bend)
        return t, 0.0, slope, bend, top
    return math.nan, end, end_slope, end_bend, top


@kernel
def _enter_next(table, piece, following, sense, kinetic, slope):
    """Begin the piece on the next panel, at the common end.

    Returns
    -------
    (whether there is such a panel, direction of the motion on it)
    """
    side, k, sign = int(piece[SIDE]), int(piece[PANEL]), piece[SIGN]
    s, p, numbers = piece[S_CENTRE], piece[P_CENTRE], table.panels[side, k, NUMBERS]
    to = TO_OUTER if sense > 0.0 else TO_INNER
    s, p = numbers[to] * s + numbers[to + 1] * p, numbers[to + 2] * s + numbers[to + 3] * p
    if sense > 0.0:
        k, back, y = k + 1, FROM_INNER, table.edges[k + 1]
    elif k > 0:
        k, back, y = k - 1, FROM_OUTER, table.edges[k]
    else:
        # through upright: outward on the other side, which is the mirror image
        side, sign, p, slope, sense = 1 - side if table.bodies[0, 1] != 0.0 else 0, -sign, -p, -slope, 1.0
        back, y = FROM_INNER, 0.0
    if k >= REACH or table.edges[k] >= POLE:
        return False, sense
    begin_piece(table, following, side, k, sign, y)
    numbers = table.panels[side, k, NUMBERS]
    following[S_CENTRE] = numbers[back] * s + numbers[back + 1] * p
    following[P_CENTRE] = numbers[back + 2] * s + numbers[back + 3] * p
    following[KINETIC], following[SLOPE] = kinetic, slope * (following[LENGTH] / piece[LENGTH])
    return True, sense


@kernel
def _cross(table, piece, sense):
    """Cross a whole panel without forming its series, where the motion is far above its potential.

    Returns
    -------
    (whether that is so, kinetic energy at the other end, slope there)
    """
    numbers, s, p = (
        table.panels[int(piece[SIDE]), int(piece[PANEL]), NUMBERS],
        piece[S_CENTRE],
        piece[P_CENTRE],
    )
    ss, sp, pp = s * s, s * p, p * p
    climb = numbers[CLIMB] * ss + numbers[CLIMB + 1] * sp + numbers[CLIMB + 2] * pp + numbers[CLIMB + 3]
    bend = numbers[MOST_BEND] + numbers[MOST_BEND + 1] * ss + numbers[MOST_BEND + 2] * pp
    to, at = (TO_OUTER, OUTER_SLOPE) if sense > 0.0 else (TO_INNER, INNER_SLOPE)
    s, p = numbers[to] * s + numbers[to + 1] * p, numbers[to + 2] * s + numbers[to + 3] * p
    slope = piece[LENGTH] * (numbers[at] + p * (numbers[at + 1] * s + numbers[at + 2] * p))
    kinetic = piece[KINETIC] - sense * climb
    above = min(kinetic, piece[KINETIC]) > 0.5 * bend
    return above and not sense * piece[SLOPE] > 0.0 >= sense * slope, kinetic, slope


@kernel
def _rounding(number, most, way, terms):
    """Return a bound of the rounding of E - V at a distance from the start, on the piece with this number."""
    # farther out the kinetic energy is larger than what the second derivative at the start adds
    grown = (terms[0] + (terms[1] * way if way < 2.0 * LONGEST else 0.0)) * way
    return 4.0 * _EPS * (4.0 + number) * (most + grown)


@kernel
def _end_way(way, number, rounding, slope, turns):
    way[COUNT], way[ROUNDING], way[END_SLOPE], way[TURNS] = number + 1.0, rounding, slope, turns


@kernel
def _follow(table, pieces, way, sense, limit, ends_upright, terms, near):
    """Follow a motion from the first piece in one direction until it turns; writes `pieces`, `way` and `near`.

    `terms` are sums of the magnitudes of the terms of the slope and of its derivative at the start.

    Returns
    -------
    (ending, |y| there)
        BOUNDED at a turning point, or at a pole (|y| infinite); FELL at |y| = limit; EDGE_CHANGE at upright if the
        motion `ends_upright`; UNRESOLVED.
    """
    number, most, gone, slope, sign, origin = (
        0,
        pieces[0, KINETIC],
        0.0,
        0.0,
        pieces[0, SIGN],
        pieces[0, FROM],
    )
    while number < MOST_PIECES - 1:
        piece = pieces[number]
        own = piece[LENGTH] if piece[SIGN] == sign else -piece[LENGTH]
        end = table.edges[int(piece[PANEL]) + (1 if sense > 0.0 else 0)]
        falls = sense > 0.0 and end >= limit
        end = limit if falls else end
        length, crosses, t, bend = sense * (end - piece[FROM]) / piece[LENGTH], False, math.nan, math.nan
        if number > 0 and not falls:
            crosses, kinetic, slope = _cross(table, piece, sense)
        if not crosses:
            form_quotient(table, piece)
            t, kinetic, slope, bend, top = _first_turn(piece, sense, length)
            if not math.isnan(top):
                rounding = _rounding(number, most, gone + abs(top) * piece[LENGTH], terms)
                _note_passed(piece, top, piece[AWAY] + own * top, rounding, near)
            if not math.isnan(t):
                end, length = piece[FROM] + piece[LENGTH] * sense * t, t
        there = piece[AWAY] + own * sense * length
        gone += abs(there - piece[AWAY])
        piece[LOW], piece[HIGH], most = min(there, piece[AWAY]), max(there, piece[AWAY]), max(most, kinetic)
        rounding = _rounding(number, most, gone, terms)
        if not math.isnan(t):
            _note_beyond(piece, there, slope, bend, rounding, near)
            _end_way(way, number, rounding, slope / piece[LENGTH], 1.0)
            return BOUNDED, end
        _end_way(way, number, rounding, slope / piece[LENGTH], 0.0)
        if falls:
            return FELL, limit
        if ends_upright and sense < 0.0 and piece[PANEL] == 0.0:
            return EDGE_CHANGE, 0.0
        goes_on, sense = _enter_next(table, piece, pieces[number + 1], sense, kinetic, slope)
        if not goes_on:
            return BOUNDED, math.inf
        number += 1
        there = pieces[number, FROM]
        pieces[number, AWAY] = (there if pieces[number, SIGN] == sign else -there) - origin
    return UNRESOLVED, math.nan


@kernel
def _place_start(table, kind, tilt, w, o, s, piece):
    """Describe a scaled start on its panel; `piece` is written.

    Returns
    -------
    (rate of |tilt|, (sums of the magnitudes of the terms of the slope and of its derivative))
        The sums are NaN beyond the last panel.
    """
    S, C = math.sin(abs(tilt)), math.cos(tilt)
    sign = math.copysign(1.0, tilt if tilt != 0.0 else w)
    if tilt == 0.0 and w == 0.0:
        # upright at rest: to the side to which it falls
        constant, mixed, _ = slope_terms(S, C, body_on(table, 0))
        sign = -math.copysign(1.0, constant + mixed * s * o)
    w, o = sign * w, sign * o
    side = 0 if sign > 0.0 or table.bodies[0, 1] == 0.0 or kind == RIM else 1
    body = body_on(table, side)
    a, b, _, _ = meridian(S, C, body)
    constant, mixed, square = slope_terms(S, C, body)
    y, p = stretch(abs(tilt)), o * C
    k = panel_at(table, y)
    if not k < REACH:
        return w, (math.nan, math.nan)
    begin_piece(table, piece, side, k, sign, y)
    piece[KINETIC] = 0.5 * (body.transverse + a * a + b * b) * w * w
    piece[SLOPE] = piece[LENGTH] * (constant + p * (mixed * s + square * p))
    x = (y - piece[CENTRE]) / piece[LENGTH]
    piece[S_CENTRE], piece[P_CENTRE] = pair_at_centre(table, side, k, x, s, p)
    form_quotient(table, piece)
    numbers = table.panels[side, k, NUMBERS]
    bends = numbers[MOST_BEND] + numbers[MOST_BEND + 1] * s * s + numbers[MOST_BEND + 2] * p * p
    terms = abs(constant) + abs(p * mixed * s) + abs(square * p * p)
    return w, (terms, bends / (piece[LENGTH] * piece[LENGTH]))


@kernel
def find_extremes(table, kind, tilt, w, o, s, y_fall, pieces, ways, near):
    """Find the extreme tilts of a scaled start, for all time.

    Parameters
    ----------
    table : Table
        Of the body of the cell.
    kind : float
        Number of the body (`kernels.bodies.shapes`).
    tilt, w, o, s : float
        Tilt [rad], its rate, and the rates across and about the axis, scaled.
    y_fall : float
        Stretched tilt at which motions of bodies without poles end.
    pieces : float64[2, MOST_PIECES, PIECE], written
        The motion in its initial direction, and in the opposite one.
    ways : float64[2, WAY], written
    near : float64[NEAR], written

    Returns
    -------
    (ending, least, greatest tilt [rad], error [rad])
    """
    begin, nan = pieces[0, 0], math.nan
    ways[:] = 0.0
    near[:] = 0.0
    near[TOP] = math.inf
    w, terms = _place_start(table, kind, tilt, w, o, s, begin)
    if math.isnan(terms[0]):
        return UNRESOLVED, nan, nan, math.inf
    sign, length = begin[SIGN], begin[LENGTH]
    if w == 0.0 and abs(begin[SLOPE]) <= 8.0 * _EPS * length * terms[0]:
        return STEADY, tilt, tilt, 0.0
    limit = math.inf if kind >= FIRST_WITH_POLES else y_fall
    sense = math.copysign(1.0, w if w != 0.0 else -begin[SLOPE])
    if begin[SLOPE] == 0.0 and begin[BEND] < 0.0:
        # kicked off the maximum itself
        _note_passed(begin, 0.0, 0.0, 0.0, near)
    for i in range(PIECE):
        pieces[1, 0, i] = begin[i]
    least = greatest = sign * tilt
    error, ending = 0.0, BOUNDED
    for turn in range(2):
        if turn == 1 and w == 0.0:
            # the start is a turning point
            rounding = 16.0 * _EPS * abs(terms[0] * begin[SLOPE] * length / begin[BEND])
            _note_beyond(begin, 0.0, begin[SLOPE], begin[BEND], rounding, near)
            break
        ending, y = _follow(table, pieces[turn], ways[turn], sense, limit, kind == RIM, terms, near)
        if ending == UNRESOLVED or not abs(near[TOP]) > 4.0 * near[TOP_ROUNDING]:
            return UNRESOLVED, nan, nan, math.inf
        half = math.tanh(0.5 * y)
        last = int(ways[turn, COUNT]) - 1
        there = pieces[turn, last, SIGN] * sign * 2.0 * math.atan(half)
        least, greatest = min(least, there), max(greatest, there)
        if ending != BOUNDED:
            break
        if ways[turn, TURNS] == 1.0:
            cosine = (1.0 - half) * (1.0 + half) / (1.0 + half * half)
            error = max(error, ways[turn, ROUNDING] / abs(ways[turn, END_SLOPE]) * cosine)
        sense = -sense
    if sign < 0.0:
        least, greatest = -greatest, -least
    # y becomes a tilt with a few roundings
    return ending, least, greatest, max(error, 4.0 * _EPS * max(abs(least), abs(greatest)))
