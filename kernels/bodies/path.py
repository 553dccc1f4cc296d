"""Where a body goes: what its heading and its contact point gain over a nutation, and the ring that the path fills.

Over a whole nutation the heading gains the same angle each time, and the contact point the same displacement in the
turned frame: the path lies on a ring about a centre. A nutation is symmetric in time about its turning points, so that
one way between them says all. It is cut into pieces of chi (`kernels.bodies.reduction.place_of`), on each of which
heading and path are integrals of polynomials through Gauss's nodes.
"""

import math

import numpy as np
from numpy.polynomial import legendre

from kernels.bodies import arrays as row
from kernels.bodies import ellipse
from kernels.bodies.equations import curvature_radius, levers, per_inertia
from kernels.bodies.reduction import (
    _WAY,
    GAUSS,
    OF_ALONG,
    OF_KINETIC,
    OF_SPIN,
    memory_of_thread,
    place_of,
    reduced,
    stretched,
    value_on,
)
from kernels.bodies.stages import body_of
from kernels.disk.endings import BOUNDED
from kernels.jit import kernel
from kernels.lanes.binding import variant
from kernels.native.entry import parallel

_CHUNK = 128
_NODES, _WEIGHTS = GAUSS
_COUNT = _NODES.size


def _sums():
    """Matrix of the integrals from -1 to each node of the polynomial through values at the nodes; and to the ends.

    The polynomials that are 1 at one node and 0 at the others are sums of Legendre's, whose integrals are known.
    """
    degrees = np.arange(_COUNT)
    at_nodes = legendre.legvander(_NODES, _COUNT - 1)
    shares = (degrees[:, None] + 0.5) * at_nodes.T * _WEIGHTS
    integrals = np.stack(
        [legendre.legval(_NODES, legendre.legint(np.eye(_COUNT)[n], lbnd=-1.0)) for n in degrees],
        axis=1,
    )
    ends = legendre.legvander(np.array([-1.0, 1.0]), _COUNT - 1)
    return np.ascontiguousarray(integrals @ shares), np.ascontiguousarray(ends @ shares)


#: Integral to node j of values at nodes k; values at both ends from those at nodes.
_TO_NODE, _AT_END = _sums()
#: Weights of barycentric interpolation at the nodes.
_BARYCENTRIC = np.sqrt((1.0 - _NODES**2) * _WEIGHTS) * (-1.0) ** np.arange(_COUNT)

#: A piece is short enough where halves change its time and its turn by this share, and it turns by no more than this
#: [rad]; halvings, and pieces kept, at most.
_SETTLED, _LARGEST_TURN, _MOST_HALVINGS, _MOST_PIECES = 1e-10, 2.0, 2000, 1024

#: Kept of a piece: its ends in chi, the heading and the contact point at the first of them.
_LOW, _HIGH, _HEADING, _X, _Y = range(5)

#: Rows of the numbers at the nodes of a piece: slopes of the contact point, squared distance from the centre and the
#: slope of that.
_DX, _DY, _SQUARED, _SLOPE = range(4)

#: Where a nutation turns the path by whole turns to within this [rad], it goes ever further.
_RESONANT = 1e-8


@kernel
def _rates(chi, y_start, body, panels, sides):
    """What time, heading, and the contact point across and along its track gain over chi, at one place; scaled."""
    y, side, number, stretch = place_of(chi, panels, sides)
    own, away = panels[side], abs(y)
    kinetic, s = value_on(own, number, OF_KINETIC, away), value_on(own, number, OF_SPIN, away)
    o = value_on(own, number, OF_ALONG, away)
    # the panels of the side of negative tilts are those of the mirror image
    o = o if side == 0 else -o
    S, C, T = math.tanh(y_start + y), 1.0 / math.cosh(y_start + y), math.sinh(y_start + y)
    time = C * stretch * math.sqrt(0.5 / (kinetic * per_inertia(S, C, body)))
    a, _, _ = levers(S, C, body)
    return time, o / C * time, curvature_radius(S, C, body) * C * stretch, a * (s - o * T) * time


@kernel
def _gains(low, high, y_start, body, panels, sides):
    """(time, turn) of a piece, by Gauss's rule."""
    middle, half, time, turn = 0.5 * (low + high), 0.5 * (high - low), 0.0, 0.0
    for j in range(_COUNT):
        gained, turned, _, _ = _rates(middle + half * _NODES[j], y_start, body, panels, sides)
        time += _WEIGHTS[j] * gained
        turn += _WEIGHTS[j] * turned
    return half * time, half * turn


@kernel
def _pass(piece, y_start, body, panels, sides, nodes):
    """Follow heading and contact point over a piece; slopes at its nodes are written. Returns them at its end."""
    low, high = piece[_LOW], piece[_HIGH]
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    heading, x, y = piece[_HEADING], piece[_X], piece[_Y]
    for j in range(_COUNT):
        _, nodes[_SLOPE, j], nodes[_DX, j], nodes[_DY, j] = _rates(
            middle + half * _NODES[j], y_start, body, panels, sides
        )
    turn = 0.0
    for j in range(_COUNT):
        turned = 0.0
        for k in range(_COUNT):
            turned += _TO_NODE[j, k] * nodes[_SLOPE, k]
        there = heading + half * turned
        across, along = nodes[_DX, j], nodes[_DY, j]
        nodes[_DX, j] = half * (across * math.cos(there) - along * math.sin(there))
        nodes[_DY, j] = half * (across * math.sin(there) + along * math.cos(there))
        turn += _WEIGHTS[j] * nodes[_SLOPE, j]
        x += _WEIGHTS[j] * nodes[_DX, j]
        y += _WEIGHTS[j] * nodes[_DY, j]
    return heading + half * turn, x, y


@kernel
def _cut(y_start, body, panels, sides, waiting, pieces, nodes):
    """Cut the way between the turning points into pieces, from the first to the last; how many, or 0 if too many.

    Returns
    -------
    (count, heading, x, y)
        With the heading and the contact point at the end; both are 0 at the beginning.
    """
    waiting[0, 0], waiting[0, 1] = -0.5 * math.pi, 0.5 * math.pi
    time, turn = _gains(waiting[0, 0], waiting[0, 1], y_start, body, panels, sides)
    waiting[0, 2], waiting[0, 3], total = time, turn, time
    heading, x, y, left, count = 0.0, 0.0, 0.0, 1, 0
    for _ in range(_MOST_HALVINGS):
        if left == 0:
            return count, heading, x, y
        left -= 1
        low, high, time, turn = waiting[left, 0], waiting[left, 1], waiting[left, 2], waiting[left, 3]
        middle = 0.5 * (low + high)
        first, first_turn = _gains(low, middle, y_start, body, panels, sides)
        second, second_turn = _gains(middle, high, y_start, body, panels, sides)
        total += first + second - time
        fine = abs(first + second - time) <= _SETTLED * total
        fine &= abs(first_turn + second_turn - turn) <= _SETTLED * (1.0 + abs(turn))
        if fine and max(abs(first_turn), abs(second_turn)) <= _LARGEST_TURN:
            if count + 2 > pieces.shape[0]:
                return 0, heading, x, y
            for begin, end in ((low, middle), (middle, high)):
                piece = pieces[count]
                piece[_LOW], piece[_HIGH], piece[_HEADING], piece[_X], piece[_Y] = begin, end, heading, x, y
                heading, x, y = _pass(piece, y_start, body, panels, sides, nodes)
                count += 1
        elif left + 2 > waiting.shape[0]:
            return 0, heading, x, y
        else:
            # the first half is looked at next
            waiting[left, 0], waiting[left, 1], waiting[left, 2], waiting[left, 3] = (
                middle,
                high,
                second,
                second_turn,
            )
            left += 1
            waiting[left, 0], waiting[left, 1], waiting[left, 2], waiting[left, 3] = (
                low,
                middle,
                first,
                first_turn,
            )
            left += 1
    return 0, heading, x, y


@kernel
def _between(nodes, which, x):
    """Value at x of the polynomial through a row of numbers at the nodes."""
    above, below = 0.0, 0.0
    for j in range(_COUNT):
        apart = x - _NODES[j]
        if apart == 0.0:
            return nodes[which, j]
        share = _BARYCENTRIC[j] / apart
        above += share * nodes[which, j]
        below += share
    return above / below


@kernel
def _extremes(pieces, count, centre_x, centre_y, y_start, body, panels, sides, nodes):
    """Least and greatest squared distance of the contact point from the centre."""
    least, greatest = math.inf, 0.0
    for number in range(count):
        piece = pieces[number]
        _pass(piece, y_start, body, panels, sides, nodes)
        for j in range(_COUNT):
            x, y = piece[_X] - centre_x, piece[_Y] - centre_y
            for k in range(_COUNT):
                x += _TO_NODE[j, k] * nodes[_DX, k]
                y += _TO_NODE[j, k] * nodes[_DY, k]
            nodes[_SQUARED, j], nodes[_SLOPE, j] = x * x + y * y, x * nodes[_DX, j] + y * nodes[_DY, j]
        before, slope = -1.0, _between(nodes, _SLOPE, -1.0)
        for j in range(_COUNT + 1):
            after = _NODES[j] if j < _COUNT else 1.0
            there = _between(nodes, _SLOPE, after)
            value = _between(nodes, _SQUARED, before)
            least, greatest = min(least, value), max(greatest, value)
            if slope * there < 0.0:
                low, high = before, after
                for _ in range(50):
                    middle = 0.5 * (low + high)
                    if _between(nodes, _SLOPE, middle) * slope > 0.0:
                        low = middle
                    else:
                        high = middle
                value = _between(nodes, _SQUARED, 0.5 * (low + high))
                least, greatest = min(least, value), max(greatest, value)
            before, slope = after, there
        value = _between(nodes, _SQUARED, 1.0)
        least, greatest = min(least, value), max(greatest, value)
    return max(least, 0.0), greatest


@kernel
def _seen_from_start(centre_x, centre_y, way, y_start, body, panels, sides, pieces, count, nodes):
    """Where a centre is from the contact point of the start, in the directions that its heading has.

    `way` is the sign of its rate of the tilt. On the way back to the smallest tilt heading and contact point are the
    mirror images of those on the way from there.
    """
    half = 0.5 * (sides[0, _WAY] + sides[1, _WAY])
    chi = math.asin(max(-1.0, min(1.0, (sides[1, _WAY] - half) / half)))
    number = 0
    while number < count - 1 and chi > pieces[number, _HIGH]:
        number += 1
    piece = pieces[number]
    end = piece[_HIGH]
    piece[_HIGH] = chi
    heading, x, y = _pass(piece, y_start, body, panels, sides, nodes)
    piece[_HIGH] = end
    heading, y = (-heading, -y) if way < 0.0 else (heading, y)
    x, y, cosine, sine = centre_x - x, centre_y - y, math.cos(heading), math.sin(heading)
    return cosine * x + sine * y, cosine * y - sine * x


@kernel
def _path(way, y_start, body, panels, sides, waiting, pieces, nodes):
    """(heading gained, drift, inner and outer radius, centre, class) over a nutation; lengths over R.

    Notes
    -----
    With h the heading and z the contact point (as a complex number) half a nutation after the smallest tilt, a whole
    one gains 2h and Z = z - exp(2ih) conj(z), because the second half is the first one reversed. The centre is at
    Z/(1 - exp(2ih)), and both halves have the same distances from it.
    """
    count, heading, x, y = _cut(y_start, body, panels, sides, waiting, pieces, nodes)
    if count == 0:
        return math.nan, math.nan, math.nan, math.nan, math.nan, math.nan, row.UNKNOWN_PATH
    turn = 2.0 * heading
    cosine, sine = math.cos(turn), math.sin(turn)
    far_x, far_y = x - (cosine * x + sine * y), y - (sine * x - cosine * y)
    drift = math.hypot(far_x, far_y)
    # |1 - exp(i turn)|
    apart = 2.0 * abs(math.sin(heading))
    if apart < _RESONANT * (1.0 + abs(turn)):
        return turn, drift, math.nan, math.nan, math.nan, math.nan, row.UNBOUNDED_PATH
    # Z (1 - exp(-i turn)) over |1 - exp(i turn)|^2
    real, imaginary = (1.0 - cosine) / (apart * apart), sine / (apart * apart)
    centre_x, centre_y = far_x * real - far_y * imaginary, far_x * imaginary + far_y * real
    least, greatest = _extremes(pieces, count, centre_x, centre_y, y_start, body, panels, sides, nodes)
    x, y = _seen_from_start(centre_x, centre_y, way, y_start, body, panels, sides, pieces, count, nodes)
    return turn, drift, math.sqrt(least), math.sqrt(greatest), x, y, row.ANNULAR_PATH


def _memory_of_thread(*arguments):
    return (
        *memory_of_thread(*arguments), np.empty((64, 4)), np.empty((_MOST_PIECES, _Y + 1)), np.empty((4, _COUNT)),
    )  # fmt: skip


@parallel(
    _CHUNK,
    _memory_of_thread,
    starts="float64[:, ::1]",
    kind="float64",
    fall_tilt="float64",
    measures="float64[:, ::1], written",
    classes="int64[::1], written",
    series="float64[:, ::1]",
    found="float64[::1]",
    panels="float64[:, :, ::1]",
    sides="float64[:, ::1]",
    pieces="float64[:, ::1]",
    waiting="float64[:, ::1]",
    cuts="float64[:, ::1]",
    nodes="float64[:, ::1]",
)
def paths(
    start,
    stop,
    starts,
    kind,
    fall_tilt,
    measures,
    classes,
    series,
    found,
    panels,
    sides,
    pieces,
    waiting,
    cuts,
    nodes,
):
    """Find where bodies go whose nutation is periodic.

    Python calls it without `start`, `stop` and what follows `classes`.

    Parameters
    ----------
    start, stop : int
        The cells of one chunk.
    starts, kind, fall_tilt
        As of `kernels.bodies.reduction.reduce`.
    measures : float64[len(PATH), n], written
        NaN where a cell has no period, one that is not known, or passes through a pole.
    classes : int64[n], written
        `UNKNOWN_PATH`, `ANNULAR_PATH` or `UNBOUNDED_PATH` of `kernels.bodies.arrays`.
    series ... nodes : arrays
        Memory of a thread.

    Notes
    -----
    Never raises. Source of the ring: Borisov, Mamaev and Kilin, Regul. Chaotic Dyn. 8 (2003) 201.
    """
    for cell in range(start, stop):
        ending, least, greatest, period, _, _ = reduced(
            starts, cell, kind, fall_tilt, 1, series, found, panels, sides, pieces
        )
        # through a pole the heading jumps by half a turn: a nutation does not go back on itself
        passes = max(-least, greatest) >= 0.5 * math.pi
        turn, drift, inner, outer, shape = math.nan, math.nan, math.nan, math.nan, row.UNKNOWN_PATH
        x, y = math.nan, math.nan
        if ending == BOUNDED and math.isfinite(period) and not passes:
            y_start, body = stretched(starts[row.TILT, cell]), body_of(starts, cell, kind)
            way = starts[row.TILT_RATE, cell]
            turn, drift, inner, outer, x, y, shape = _path(
                way, y_start, body, panels, sides, waiting, cuts, nodes
            )
        radius = starts[row.RADIUS, cell]
        measures[row.PATH_HEADING, cell], measures[row.PATH_DRIFT, cell] = turn, radius * drift
        measures[row.PATH_INNER, cell], measures[row.PATH_OUTER, cell] = radius * inner, radius * outer
        measures[row.PATH_X, cell], measures[row.PATH_Y, cell] = radius * x, radius * y
        classes[cell] = shape


#: `paths` of bodies whose meridian is an arc of an ellipse.
paths_ellipses = variant(paths, "ellipses", ellipse.FUNCTIONS)
