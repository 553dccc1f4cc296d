"""The path of a body: gains of heading and contact point over a nutation, and the ring that the path fills.

Over each whole nutation the heading gains the same angle, and the contact point the same displacement in the turned
frame, so the path is in a ring about a centre. A nutation is symmetric in time about its turning points, so half of
it is enough. It is cut into pieces of the angle (`kernels.reduction.nutation`). On each piece, heading and path are
integrals of polynomials through Gauss's nodes.
"""

import math

import numpy as np
from numpy.polynomial import legendre

from kernels.bodies import arrays as row
from kernels.disk.endings import BOUNDED
from kernels.jit import kernel
from kernels.native.entry import parallel
from kernels.reduction.cells import CHUNK, MOTION_TYPES, motion_memory, reduce_cell
from kernels.reduction.nutation import (
    CUT_HEADING,
    CUT_HIGH,
    CUT_LOW,
    CUT_TYPES,
    CUT_X,
    CUT_Y,
    NODES,
    WEIGHTS,
    angle_of_start,
    cut_memory,
    cut_nutation,
    describe_nutation,
    is_vague,
    rates_at,
)
from kernels.reduction.panels import TABLE_TYPES, Table, clear_table, table_memory
from kernels.reduction.turning import stretch

_COUNT = NODES.size


def _integral_matrix():
    """Return the matrix of the integrals, from -1 to each node, of the polynomial through values at the nodes.

    The polynomials that are 1 at one node and 0 at the others are sums of Legendre polynomials, whose integrals are
    known.
    """
    degrees = np.arange(_COUNT)
    shares = (degrees[:, None] + 0.5) * legendre.legvander(NODES, _COUNT - 1).T * WEIGHTS
    integrals = [legendre.legval(NODES, legendre.legint(np.eye(_COUNT)[n], lbnd=-1.0)) for n in degrees]
    return np.ascontiguousarray(np.stack(integrals, axis=1) @ shares)


#: Integral to node j of values at nodes k.
_TO_NODE = _integral_matrix()
#: Weights of barycentric interpolation at the nodes.
_BARYCENTRIC = np.sqrt((1.0 - NODES**2) * WEIGHTS) * (-1.0) ** np.arange(_COUNT)

#: Rows of the numbers at the nodes of a piece: slopes of the contact point; its position relative to the centre; half
#: the slope of its squared distance from the centre.
_DX, _DY, _X, _Y, _SLOPE = range(5)

#: If a nutation turns the path by whole turns to within this [rad], the path is unbounded.
_RESONANT = 1e-8


@kernel
def _pass_cut(cut, nutation, nodes):
    """Follow heading and contact point over a piece and write the slopes at its nodes; return both at its end."""
    low, high = cut[CUT_LOW], cut[CUT_HIGH]
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    heading, x, y = cut[CUT_HEADING], cut[CUT_X], cut[CUT_Y]
    if not high > low:
        # a start at rest is the turning point itself, where the motion has no rates by the angle
        return heading, x, y
    for j in range(_COUNT):
        _, nodes[_SLOPE, j], nodes[_DX, j], nodes[_DY, j] = rates_at(nutation, middle + half * NODES[j], True)
    turn = 0.0
    for j in range(_COUNT):
        turned = 0.0
        for k in range(_COUNT):
            turned += _TO_NODE[j, k] * nodes[_SLOPE, k]
        there = heading + half * turned
        across, along = nodes[_DX, j], nodes[_DY, j]
        nodes[_DX, j] = half * (across * math.cos(there) - along * math.sin(there))
        nodes[_DY, j] = half * (across * math.sin(there) + along * math.cos(there))
        turn += WEIGHTS[j] * nodes[_SLOPE, j]
        x += WEIGHTS[j] * nodes[_DX, j]
        y += WEIGHTS[j] * nodes[_DY, j]
    return heading + half * turn, x, y


@kernel
def _pass_all(nutation, count, cuts, nodes):
    """Return (heading, x, y) at the greatest tilt; all are 0 at the smallest one. Writes the beginnings of pieces."""
    heading = x = y = 0.0
    for number in range(count):
        cut = cuts[number]
        cut[CUT_HEADING], cut[CUT_X], cut[CUT_Y] = heading, x, y
        heading, x, y = _pass_cut(cut, nutation, nodes)
    return heading, x, y


@kernel
def _interpolate(nodes, which, x):
    """Return the value at x of the polynomial through a row of numbers at the nodes."""
    above, below = 0.0, 0.0
    for j in range(_COUNT):
        apart = x - NODES[j]
        if apart == 0.0:
            return nodes[which, j]
        share = _BARYCENTRIC[j] / apart
        above += share * nodes[which, j]
        below += share
    return above / below


@kernel
def _distance_at(nodes, x):
    """Return the distance from the centre at x of a piece."""
    return math.hypot(_interpolate(nodes, _X, x), _interpolate(nodes, _Y, x))


@kernel
def _find_stationary(nodes, low, high, slope):
    """Return the distance where its slope, which has the sign of `slope` at `low`, changes its sign."""
    for _ in range(50):
        middle = 0.5 * (low + high)
        if _interpolate(nodes, _SLOPE, middle) * slope > 0.0:
            low = middle
        else:
            high = middle
    return _distance_at(nodes, 0.5 * (low + high))


@kernel
def _find_ring(nutation, count, cuts, centre_x, centre_y, nodes):
    """Return the least and the greatest distance of the contact point from the centre."""
    least, greatest = math.inf, 0.0
    for number in range(count):
        cut = cuts[number]
        _pass_cut(cut, nutation, nodes)
        for j in range(_COUNT):
            x, y = cut[CUT_X] - centre_x, cut[CUT_Y] - centre_y
            for k in range(_COUNT):
                x += _TO_NODE[j, k] * nodes[_DX, k]
                y += _TO_NODE[j, k] * nodes[_DY, k]
            nodes[_X, j], nodes[_Y, j], nodes[_SLOPE, j] = x, y, x * nodes[_DX, j] + y * nodes[_DY, j]
        before, slope = -1.0, _interpolate(nodes, _SLOPE, -1.0)
        for j in range(_COUNT + 1):
            after = NODES[j] if j < _COUNT else 1.0
            there = _interpolate(nodes, _SLOPE, after)
            value = _distance_at(nodes, before)
            least, greatest = min(least, value), max(greatest, value)
            if slope * there < 0.0:
                value = _find_stationary(nodes, before, after, slope)
                least, greatest = min(least, value), max(greatest, value)
            before, slope = after, there
        value = _distance_at(nodes, 1.0)
        least, greatest = min(least, value), max(greatest, value)
    return least, greatest


@kernel
def _see_from_start(centre_x, centre_y, tilt_rate, nutation, count, cuts, nodes):
    """Return the position of a centre relative to the contact point of the start, in the directions of its heading.

    On the way back to the smallest tilt, heading and contact point are mirror images of the way from there.
    """
    angle, number = angle_of_start(nutation), 0
    while number < count - 1 and angle > cuts[number, CUT_HIGH]:
        number += 1
    cut = cuts[number]
    end = cut[CUT_HIGH]
    cut[CUT_HIGH] = angle
    heading, x, y = _pass_cut(cut, nutation, nodes)
    cut[CUT_HIGH] = end
    heading, y = (-heading, -y) if tilt_rate < 0.0 else (heading, y)
    x, y, cosine, sine = centre_x - x, centre_y - y, math.cos(heading), math.sin(heading)
    return cosine * x + sine * y, cosine * y - sine * x


@kernel
def _find_path(tilt_rate, nutation, waiting, cuts, nodes):
    """Return (heading gained, drift, inner and outer radius, centre, class) over a nutation; lengths over R.

    Notes
    -----
    With h the heading and z the contact point (as a complex number) half a nutation after the smallest tilt, a whole
    nutation gains 2h and Z = z - exp(2ih) conj(z), because the second half is the first one reversed. The centre is
    at Z/(1 - exp(2ih)), and both halves have the same distances from it.
    """
    count, _ = cut_nutation(nutation, 0.0, math.pi, True, waiting, cuts)
    if count == 0:
        return math.nan, math.nan, math.nan, math.nan, math.nan, math.nan, row.UNKNOWN_PATH
    heading, x, y = _pass_all(nutation, count, cuts, nodes)
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
    least, greatest = _find_ring(nutation, count, cuts, centre_x, centre_y, nodes)
    x, y = _see_from_start(centre_x, centre_y, tilt_rate, nutation, count, cuts, nodes)
    return turn, drift, least, greatest, x, y, row.ANNULAR_PATH


@parallel(
    CHUNK,
    lambda *_: (*table_memory(), *motion_memory(), *cut_memory(), np.empty((5, _COUNT))),
    starts="float64[:, ::1]",
    kind="float64",
    fall_tilt="float64",
    measures="float64[:, ::1], written",
    classes="int64[::1], written",
    **TABLE_TYPES,
    **MOTION_TYPES,
    **CUT_TYPES,
    nodes="float64[:, ::1]",
)
def paths(
    start, stop, starts, kind, fall_tilt, measures, classes, bodies, edges, made, panels, work, pieces, ways, near,
    waiting, cuts, nodes,
):  # fmt: skip
    """Compute the paths of bodies whose nutation is periodic.

    Python calls it without `start`, `stop` and the arguments after `classes`.

    Parameters
    ----------
    start, stop : int
        The cells of one chunk.
    starts, kind, fall_tilt
        As for `kernels.reduction.cells.reduce`.
    measures : float64[len(PATH), n], written
        NaN if the period of a cell is unknown or does not exist, or if the motion passes through a pole.
    classes : int64[n], written
        `UNKNOWN_PATH`, `ANNULAR_PATH` or `UNBOUNDED_PATH` of `kernels.bodies.arrays`.
    bodies ... nodes : arrays
        Memory of a thread.

    Notes
    -----
    Never raises. Source of the ring: Borisov, Mamaev and Kilin, Regul. Chaotic Dyn. 8 (2003) 201.
    """
    table = Table(bodies, edges, made, panels, work)
    clear_table(table)
    y_fall = stretch(fall_tilt)
    for cell in range(start, stop):
        ending, least, greatest, _ = reduce_cell(
            starts, cell, kind, fall_tilt, y_fall, table, pieces, ways, near
        )
        # through a pole the heading jumps by half a turn: a nutation does not retrace itself
        passes = max(-least, greatest) >= 0.5 * math.pi
        turn, drift, inner, outer, shape = math.nan, math.nan, math.nan, math.nan, row.UNKNOWN_PATH
        x, y = math.nan, math.nan
        if ending == BOUNDED and not passes and not is_vague(near):
            turn, drift, inner, outer, x, y, shape = _find_path(
                starts[row.TILT_RATE, cell],
                describe_nutation(table, pieces, ways, near),
                waiting,
                cuts,
                nodes,
            )
        radius = starts[row.RADIUS, cell]
        measures[row.PATH_HEADING, cell], measures[row.PATH_DRIFT, cell] = turn, radius * drift
        measures[row.PATH_INNER, cell], measures[row.PATH_OUTER, cell] = radius * inner, radius * outer
        measures[row.PATH_X, cell], measures[row.PATH_Y, cell] = radius * x, radius * y
        classes[cell] = shape
