"""Quadratures over a nutation: the motion from one turning point to the other.

An angle goes from 0 at the smallest tilt to pi at the greatest one. With y = middle - half cos(angle) time and
heading are smooth and even in the angle at both ends, so the midpoint rule converges geometrically; tripling its
nodes keeps the previous ones. Next to a maximum of the potential, where the motion is slow, y follows the angle
through a hyperbolic function instead, and the angle is cut into pieces where the midpoint rule does not settle.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from kernels.jit import kernel
from kernels.reduction.panels import body_on, meridian, pair_at
from kernels.reduction.pieces import (
    AWAY,
    CENTRE,
    FROM,
    HIGH,
    LENGTH,
    LOW,
    P_CENTRE,
    PANEL,
    S_CENTRE,
    SIDE,
    SIGN,
    form_quotient,
    kinetic_at,
)
from kernels.reduction.turning import COUNT, PLACE, TOP, TOP_ROUNDING, WIDTH

#: Number of nodes of the first sum and maximum number of nodes of the last one.
_FIRST, _LAST = 8, 648
#: Relative difference of two sums that settles the quadrature at once, and after two tripled sums: the error of the
#: finer sum is about the third power of the difference, but two sums may agree by accident.
_AT_ONCE, _TWICE, _BEFORE = 1e-11, 1e-8, 1e-2

#: Sines of half the angles at the nodes of the sums with 8, 24, ... nodes, one sum after the other.
_SINES = np.concatenate([np.sin(0.5 * np.pi * (np.arange(n) + 0.5) / n) for n in _FIRST * 3 ** np.arange(5)])

#: Nodes and weights of Gauss's rule on a piece of the angle.
NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)
#: A piece is short enough if halving changes it by less than this share, and if the heading turns by less [rad].
_SETTLED, _LARGEST_TURN = 1e-10, 2.0
#: Maximum numbers of pieces that wait, that are kept, and that are bisected.
_MOST_WAITING, _MOST_KEPT, _MOST_HALVINGS = 64, 1024, 2000

#: Numbers of a piece of the angle that is kept: both ends; heading and contact point at the first (`path`).
CUT_LOW, CUT_HIGH, CUT_HEADING, CUT_X, CUT_Y = range(5)

#: No period is stated if the bound of the rounding of the energy is more than this share of the energy between a motion
#: and a maximum of the potential: the rounding itself is about a hundredth of its bound.
_VAGUE = 1e-7


class Nutation(NamedTuple):
    """A motion between its turning points. A motion that falls ends at fall_tilt, and may begin at its start.

    Attributes
    ----------
    table : kernels.reduction.panels.Table
    pieces, ways : arrays
        As in `kernels.reduction.turning.find_extremes`.
    kind : int
        Map from u to y, where u goes as (1 - cos(angle))/2 over its range: y = u (0); y = place + width sinh(u) past
        a maximum (1); y = place + width (cosh(u) - 1) from the turning point next to a maximum (2), with u as
        sin(angle/2).
    low, high, place, width, begin, length : float
        Both turning points; the constants of the map; where u begins, and its range.
    backward : bool
        Whether the tilt decreases as u grows.
    """

    table: Any
    pieces: Any
    ways: Any
    kind: Any
    low: Any
    high: Any
    place: Any
    width: Any
    begin: Any
    length: Any
    backward: Any


def cut_memory():
    """Return the arrays for the pieces of the angle that wait, and that are kept."""
    return np.empty((_MOST_WAITING, 4)), np.empty((_MOST_KEPT, CUT_Y + 1))


CUT_TYPES = {"waiting": "float64[:, ::1]", "cuts": "float64[:, ::1]"}


@kernel
def describe_nutation(table, pieces, ways, near):
    """Return the `Nutation` between both ends of a motion."""
    low = high = 0.0
    for turn in range(2):
        for number in range(int(ways[turn, COUNT])):
            piece = pieces[turn, number]
            form_quotient(table, piece)
            low, high = min(low, piece[LOW]), max(high, piece[HIGH])
    place, width, begin, length, kind = 0.0, 1.0, low, high - low, 0
    if abs(near[TOP]) < math.inf and abs(near[WIDTH]) < 0.5 * (high - low):
        place, width = near[PLACE], near[WIDTH]
        if width > 0.0:
            kind, begin = 1, math.asinh((low - place) / width)
            length = math.asinh((high - place) / width) - begin
        else:
            width = abs(width) if place - low < high - place else width
            # the inverse of cosh(u) - 1
            kind, begin, length = 2, 0.0, 2.0 * math.asinh(math.sqrt(0.5 * (high - low) / abs(width)))
    tilts_grow = pieces[0, 0, SIGN] if not (kind == 2 and width < 0.0) else -pieces[0, 0, SIGN]
    return Nutation(table, pieces, ways, kind, low, high, place, width, begin, length, tilts_grow < 0.0)


@kernel
def _place_at(nutation, sine, cosine):
    """Return (y, |dy/dangle|) at an angle, from sine and cosine of half of it.

    y is measured from the nearer end, without cancellation.
    """
    low, high, place, width = nutation.low, nutation.high, nutation.place, nutation.width
    length, begin = nutation.length, nutation.begin
    if nutation.backward:
        sine, cosine = cosine, sine
    if nutation.kind == 2:
        u = length * sine
        stretch = abs(width) * math.sinh(u) * 0.5 * length * cosine
        if sine > cosine:
            # length (1 - sine) = length cosine^2/(1 + sine)
            rest = length * cosine * cosine / (1.0 + sine)
            way = 2.0 * math.sinh(0.5 * rest) * math.sinh(0.5 * (length + u)) * width
            return (high if width > 0.0 else low) - way, stretch
        return place + 2.0 * width * math.sinh(0.5 * u) ** 2, stretch
    u, stretch = begin + length * sine * sine, length * sine * cosine
    from_end = length * (sine * sine if sine < cosine else cosine * cosine)
    if nutation.kind == 0:
        return low + from_end if sine < cosine else high - from_end, stretch
    end = begin if sine < cosine else begin + length
    way = 2.0 * width * math.sinh(0.5 * from_end) * math.cosh(0.5 * (u + end))
    y = low + way if sine < cosine else high - way
    # nearer to the maximum than to the end: a distance from the end would have no correct digits
    if abs(u) < max(1.0, 0.5 * abs(end)):
        y = place + width * math.sinh(u)
    return y, stretch * width * math.cosh(u)


@kernel
def angle_of_start(nutation):
    """Return the angle at which y = 0, where the motion starts."""
    if nutation.kind == 2:
        sine = 2.0 * math.asinh(math.sqrt(max(0.0, -0.5 * nutation.place / nutation.width))) / nutation.length
    else:
        u = 0.0 if nutation.kind == 0 else math.asinh(-nutation.place / nutation.width)
        sine = math.sqrt(max(0.0, (u - nutation.begin) / nutation.length))
    angle = 2.0 * math.asin(min(1.0, sine))
    return math.pi - angle if nutation.backward else angle


@kernel
def rates_at(nutation, angle, turns):
    """Return d/dangle of time, heading, and the contact point across and along its track; scaled.

    Only the time is computed unless the heading `turns`.
    """
    return _rates_at(nutation, math.sin(0.5 * angle), math.cos(0.5 * angle), turns)


@kernel
def _rates_at(nutation, sine, cosine, turns):
    """Return `rates_at`, from sine and cosine of half the angle."""
    y, stretch = _place_at(nutation, sine, cosine)
    pieces = nutation.pieces
    turn = number = 0
    for way in range(2):
        for one in range(int(nutation.ways[way, COUNT])):
            if pieces[way, one, LOW] <= y <= pieces[way, one, HIGH]:
                turn, number = way, one
    piece = pieces[turn, number]
    t = (y - piece[AWAY]) / piece[LENGTH]
    t = t if piece[SIGN] == pieces[0, 0, SIGN] else -t
    side = int(piece[SIDE])
    body, decay = body_on(nutation.table, side), math.exp(-(piece[FROM] + t * piece[LENGTH]))
    per = 1.0 / (1.0 + decay * decay)
    S, C = (1.0 - decay * decay) * per, 2.0 * decay * per
    a, b, r, _ = meridian(S, C, body)
    time = C * stretch * math.sqrt(0.5 * (body.transverse + a * a + b * b) / kinetic_at(piece, t))
    if not turns:
        return time, 0.0, 0.0, 0.0
    x = (piece[FROM] - piece[CENTRE]) / piece[LENGTH] + t
    s, p = pair_at(nutation.table, side, int(piece[PANEL]), x, piece[S_CENTRE], piece[P_CENTRE])
    turning = p / (C * C)
    return time, piece[SIGN] * turning * time, r * C * stretch, a * (s - turning * S) * time


@kernel
def _sum_time(nutation):
    """Return the time between the turning points by the midpoint rule; NaN if it does not settle."""
    count, first, before, change, total = _FIRST, 0, math.inf, math.inf, 0.0
    while count <= _LAST:
        for j in range(count):
            # tripling keeps every third node
            if count == _FIRST or j % 3 != 1:
                sine, cosine = _SINES[first + j], _SINES[first + count - 1 - j]
                total += _rates_at(nutation, sine, cosine, False)[0]
        first, time = first + count, total * math.pi / count
        earlier, change = change, abs(time - before)
        if change <= _AT_ONCE * time or (change <= _TWICE * time and earlier <= _BEFORE * time):
            return time
        before, count = time, 3 * count
    return math.nan


@kernel
def _gauss(nutation, low, high, turns):
    """Return (time, heading) over a piece of the angle."""
    middle, half, time, heading = 0.5 * (low + high), 0.5 * (high - low), 0.0, 0.0
    for j in range(NODES.size):
        gained, turned, _, _ = rates_at(nutation, middle + half * NODES[j], turns)
        time += WEIGHTS[j] * gained
        heading += WEIGHTS[j] * turned
    return half * time, half * heading


@kernel
def _wait(waiting, number, low, high, time, heading):
    row = waiting[number]
    row[0], row[1], row[2], row[3] = low, high, time, heading


@kernel
def cut_nutation(nutation, low, high, turns, waiting, cuts):
    """Cut a nutation between two angles into pieces on which Gauss's rule settles.

    Returns
    -------
    (count, time)
        Number of pieces written to `cuts`, 0 if the rule does not settle; the scaled time between the angles.
    """
    time, heading = _gauss(nutation, low, high, turns)
    _wait(waiting, 0, low, high, time, heading)
    total, done, left, count = time, 0.0, 1, 0
    for _ in range(_MOST_HALVINGS):
        if left == 0:
            return count, done
        left -= 1
        low, high, time, heading = waiting[left, 0], waiting[left, 1], waiting[left, 2], waiting[left, 3]
        middle = 0.5 * (low + high)
        first, first_turn = _gauss(nutation, low, middle, turns)
        second, second_turn = _gauss(nutation, middle, high, turns)
        total += first + second - time
        settled = abs(first + second - time) <= _SETTLED * total
        settled &= abs(first_turn + second_turn - heading) <= _SETTLED * (1.0 + abs(heading))
        if settled and max(abs(first_turn), abs(second_turn)) <= _LARGEST_TURN:
            if count + 2 > cuts.shape[0]:
                return 0, math.nan
            cuts[count, CUT_LOW], cuts[count, CUT_HIGH] = low, middle
            cuts[count + 1, CUT_LOW], cuts[count + 1, CUT_HIGH] = middle, high
            count, done = count + 2, done + first + second
        elif left + 2 > waiting.shape[0]:
            return 0, math.nan
        else:
            # the first half is next
            _wait(waiting, left, middle, high, second, second_turn)
            _wait(waiting, left + 1, low, middle, first, first_turn)
            left += 2
    return 0, math.nan


@kernel
def is_vague(near):
    """Return whether rounding decides how long a motion lingers next to a maximum of the potential."""
    return abs(near[TOP]) < math.inf and abs(near[TOP]) * _VAGUE < near[TOP_ROUNDING]


@kernel
def find_period(table, pieces, ways, near, waiting, cuts):
    """Return the scaled period of a bounded motion; NaN on a separatrix to rounding, or if the sums do not settle."""
    if is_vague(near):
        return math.nan
    nutation = describe_nutation(table, pieces, ways, near)
    time = _sum_time(nutation)
    if math.isnan(time):
        _, time = cut_nutation(nutation, 0.0, math.pi, False, waiting, cuts)
    return 2.0 * time
