"""The reduction of a body to one degree of freedom: extreme tilts for all time and the period, without time stepping.

The kinetic energy of the tilt is followed from the start to both sides, panel after panel (`kernels.bodies.pair`), to
the turning point, where it vanishes first, to the tilt at which motions end, or to a pole. The way to the side of
negative tilts is that of the mirror image to the other, so that mirror images have the same bits.
"""

import math

import numpy as np

from kernels.bodies import arrays as row
from kernels.bodies import ellipse
from kernels.bodies import pair as at
from kernels.bodies.equations import fall_along, force, is_steady, per_inertia, pull_and_terms
from kernels.bodies.pair import expand
from kernels.bodies.shapes import FIRST_WITH_POLES, RIM, Body
from kernels.bodies.stages import body_of, is_possible, side_of
from kernels.disk.arrays import ENDING
from kernels.disk.endings import BOUNDED, EDGE_CHANGE, FELL, INVALID, STEADY, UNRESOLVED
from kernels.disk.equations import scaled_state
from kernels.disk.polynomial_roots import MOST_ROOTS, first_length, first_root, value_at
from kernels.jit import kernel
from kernels.lanes.binding import variant
from kernels.native.entry import parallel

#: Cells that a thread takes at a time.
_CHUNK = 128

#: Panels to one side at most: fewer reach 89.99 degrees.
_MOST_PANELS = 400

#: The stretched tilt of a pole: from there on the cosine of the tilt is below 1e-17.
_POLE = 40.0

#: Rounding of the kinetic energy, over its terms and those of its slope times the way.
_ROUNDING = 4.0 * 2.0**-52

#: Numbers kept of a panel: where it begins and ends, from the start; the coefficients of its kinetic energy, s and o.
_FROM, _TO, OF_KINETIC = range(3)
OF_SPIN, OF_ALONG = OF_KINETIC + at.TERMS, OF_KINETIC + 2 * at.TERMS
_KEPT = OF_KINETIC + 3 * at.TERMS

#: Numbers kept of a side: how many panels; how far it goes, in y; its tilt [rad], the error of that; the least energy
#: between the motion and a maximum of the potential; the rounding of the energy.
_PANELS, _WAY, _TILT, _ERROR, _LEAST, _UNCERTAIN = range(6)
_OF_A_SIDE = 6

#: Nodes and weights of the quadrature of a period; the relative change by halves that is small enough, as their error
#: is much smaller; pieces that wait, and halvings, at most.
GAUSS = np.polynomial.legendre.leggauss(16)
_SETTLED, _MOST_WAITING, _MOST_HALVINGS = 1e-10, 64, 400

#: A period beside a maximum of the potential is not told where the bound of the rounding of the energy is this share of
#: the energy between them: the rounding itself is about a hundredth of its bound.
_VAGUE = 1e-7


@kernel
def _keep(series, number, begun, length, panels):
    panels[number, _FROM], panels[number, _TO] = begun, begun + length
    for k in range(at.TERMS):
        panels[number, OF_KINETIC + k] = series[at.KINETIC, k]
        panels[number, OF_SPIN + k], panels[number, OF_ALONG + k] = series[at.SPIN, k], series[at.ALONG, k]


@kernel
def _saddle(series, slope, length):
    """Least kinetic energy about a minimum that a panel passes, from the parabolas at its ends; infinite if none."""
    kinetic = value_at(series, at.KINETIC, length)
    before, after = series[at.KINETIC, 1], slope
    if not before <= 0.0 < after:
        return math.inf
    bend = (after - before) / length
    return max(
        0.0, min(series[at.KINETIC, 0] - 0.5 * before * before / bend, kinetic - 0.5 * after * after / bend)
    )


@kernel
def _slope_at(series, t):
    total = 0.0
    for k in range(at.TERMS - 1, 0, -1):
        total = total * t + k * series[at.KINETIC, k]
    return total


@kernel
def _arrive(series, t, begun, start_terms, body, side):
    """Put the state at t of a panel at its beginning, and judge the turning point there: `side` is written."""
    at.go_on(series, t)
    S, C, s, o = series[at.SIN, 0], series[at.COS, 0], series[at.SPIN, 0], series[at.ALONG, 0]
    state = S, C, S / C, 0.0, o, s
    pull, curvature = force(state, body)
    _, terms = pull_and_terms(state, body)
    way = (begun + t) * C
    uncertain = _ROUNDING * (4.0 + side[_PANELS]) * (side[_ERROR] + way * max(terms, start_terms))
    side[_WAY], side[_TILT], side[_ERROR] = begun + t, math.atan2(S, C), uncertain / pull
    side[_UNCERTAIN] = uncertain
    if curvature < 0.0:
        # the maximum is higher by this, if it is near
        above = 0.5 * pull * pull / -curvature
        if above < abs(side[_LEAST]):
            side[_LEAST] = above
        if above <= 4.0 * uncertain:
            side[_ERROR] = math.inf


@kernel
def _follow(state, body, limit, series, found, panels, side):
    """Follow a motion towards greater tilts until it turns, or to a tilt `limit` away in y.

    Returns
    -------
    int
        BOUNDED where it turned, FELL where it reached the limit, UNRESOLVED.
    """
    S, C, T, w, o, s = state
    series[at.SIN, 0], series[at.COS, 0], series[at.SPIN, 0], series[at.ALONG, 0] = S, C, s, o
    series[at.KINETIC, 0] = 0.5 * w * w / per_inertia(S, C, body)
    _, terms = pull_and_terms(state, body)
    begun, at_rest = 0.0, w == 0.0
    side[_PANELS] = side[_ERROR] = 0.0
    side[_LEAST] = math.inf
    for number in range(_MOST_PANELS):
        expand(series, body)
        length = at.length_of(series)
        if number == 0:
            length = first_length(series, at.KINETIC, at_rest, length)
        last = begun + length >= limit
        if last:
            length = limit - begun
        side[_PANELS] = number + 1.0
        _keep(series, number, begun, length, panels)
        largest = abs(series[at.KINETIC, 0])
        for k in range(1, at.TERMS):
            largest = max(largest, abs(series[at.KINETIC, k]) * length**k)
        side[_ERROR] = max(side[_ERROR], largest)
        turn = first_root(series, at.KINETIC, at.KINETIC_PER_STRETCH, at_rest and number == 0, length, found)
        if turn == -1.0 or not math.isfinite(largest):
            return UNRESOLVED
        if not math.isnan(turn):
            panels[number, _TO] = begun + turn
            _arrive(series, turn, begun, terms, body, side)
            return BOUNDED
        slope = _slope_at(series, length)
        least = _saddle(series, slope, length)
        if least < abs(side[_LEAST]):
            side[_LEAST] = -least
        if last:
            side[_WAY], side[_TILT] = limit, math.nan
            side[_UNCERTAIN] = side[_ERROR] = _ROUNDING * (4.0 + side[_PANELS]) * side[_ERROR]
            return FELL
        begun += length
        at.go_on(series, length)
    return UNRESOLVED


@kernel
def value_on(panels, number, first, y):
    """Value at y, from the start, of the series whose coefficients begin at `first` of a panel."""
    t, total = y - panels[number, _FROM], 0.0
    for k in range(at.TERMS - 1, -1, -1):
        total = total * t + panels[number, first + k]
    return total


@kernel
def place_of(chi, panels, sides):
    """Where a motion is at chi, where y = middle + half sin(chi) between its turning points.

    Returns
    -------
    (y, side, number, stretch)
        y from the start; the side of the start and the number of the panel there; dy/dchi.
    """
    low, high = -sides[1, _WAY], sides[0, _WAY]
    half, sine, cosine = 0.5 * (high - low), math.sin(chi), math.cos(chi)
    # from the nearer end, without cancellation
    if sine < 0.0:
        y = low + half * cosine * cosine / (1.0 - sine)
    else:
        y = high - half * cosine * cosine / (1.0 + sine)
    side, number = 0 if y >= 0.0 else 1, 0
    while number < int(sides[side, _PANELS]) - 1 and abs(y) > panels[side, number, _TO]:
        number += 1
    return y, side, number, half * cosine


@kernel
def _slowness(chi, y_start, body, panels, sides):
    """Time of a motion over chi (`place_of`), at one place."""
    y, side, number, stretch = place_of(chi, panels, sides)
    kinetic = value_on(panels[side], number, OF_KINETIC, abs(y))
    S, C = math.tanh(y_start + y), 1.0 / math.cosh(y_start + y)
    return C * stretch * math.sqrt(0.5 / (kinetic * per_inertia(S, C, body)))


@kernel
def _over(low, high, y_start, body, panels, sides):
    """Time over a piece of chi, by Gauss's rule."""
    middle, half, total = 0.5 * (low + high), 0.5 * (high - low), 0.0
    for j in range(GAUSS[0].size):
        total += GAUSS[1][j] * _slowness(middle + half * GAUSS[0][j], y_start, body, panels, sides)
    return half * total


@kernel
def _half_period(y_start, body, panels, sides, pieces):
    """Half the scaled period of a motion between its two turning points; NaN where the quadrature does not settle.

    The time over chi is as smooth as the potential, also at the turning points. Beside a maximum of the potential it
    has a peak: pieces are halved until both halves are together what the whole is.
    """
    pieces[0, 0], pieces[0, 1] = -0.5 * math.pi, 0.5 * math.pi
    pieces[0, 2] = _over(pieces[0, 0], pieces[0, 1], y_start, body, panels, sides)
    total, done, count = pieces[0, 2], 0.0, 1
    for _ in range(_MOST_HALVINGS):
        if count == 0:
            return done
        count -= 1
        low, high, whole = pieces[count, 0], pieces[count, 1], pieces[count, 2]
        middle = 0.5 * (low + high)
        left = _over(low, middle, y_start, body, panels, sides)
        right = _over(middle, high, y_start, body, panels, sides)
        total += left + right - whole
        if abs(left + right - whole) <= _SETTLED * total:
            done += left + right
        elif count + 2 > pieces.shape[0]:
            return math.nan
        else:
            pieces[count, 0], pieces[count, 1], pieces[count, 2] = low, middle, left
            pieces[count + 1, 0], pieces[count + 1, 1], pieces[count + 1, 2] = middle, high, right
            count += 2
    return math.nan


@kernel
def _mirrored(body):
    return Body(body.core, -body.shift, body.edge, body.square, body.axial, body.transverse, body.ratio)


@kernel
def stretched(tilt):
    """The stretched tilt y of a tilt."""
    return math.asinh(math.tan(tilt))


@kernel
def _limit(kind, edge, y, heading, fall_tilt):
    """(tilt, ending, way in y) where a motion towards `heading` ends that does not turn; at a pole it turns."""
    if kind >= FIRST_WITH_POLES:
        return heading * 0.5 * math.pi, BOUNDED, _POLE - heading * y
    if kind == RIM and edge * heading < 0.0:
        return 0.0, EDGE_CHANGE, abs(y)
    return heading * fall_tilt, FELL, stretched(fall_tilt) - heading * y


@kernel
def _both_ways(state, tilt, edge, kind, fall_tilt, body, series, found, panels, sides):
    """Follow a motion from its start to both sides; the panels of both are written.

    Returns
    -------
    (ending, least, greatest tilt, separatrix, error, vague)
        Whether it is vague how long the motion lingers beside a maximum of the potential.
    """
    S, C, T, w, o, s = state
    y, least, greatest = stretched(tilt), tilt, tilt
    heading = math.copysign(1.0, w if w != 0.0 else -fall_along(S, C, s, o, body))
    error, separatrix, vague = 0.0, math.inf, False
    for turn in range(2):
        sense = heading if turn == 0 else -heading
        place = 0 if sense > 0.0 else 1
        if turn == 1 and w == 0.0:
            # the start is a turning point
            sides[place, :] = 0.0
            pull, curvature = force(state, body)
            if curvature < 0.0 and 0.5 * pull * pull / -curvature < abs(separatrix):
                separatrix = 0.5 * pull * pull / -curvature
            break
        # the panels of the side of negative tilts are those of the mirror image
        image, own = (sense * S, C, sense * T, abs(w), sense * o, s), body if sense > 0.0 else _mirrored(body)
        limit, beyond, way = _limit(kind, edge, y, sense, fall_tilt)
        end = _follow(image, own, way, series, found, panels[place], sides[place])
        if end == UNRESOLVED:
            return UNRESOLVED, math.nan, math.nan, math.nan, math.inf, True
        if abs(sides[place, _LEAST]) < abs(separatrix):
            separatrix = sides[place, _LEAST]
        if end == FELL and beyond == BOUNDED:
            sides[place, _TILT] = sense * limit
        elif end == FELL:
            return beyond, min(least, limit), max(greatest, limit), separatrix, error, True
        reached = sense * sides[place, _TILT]
        error = max(error, sides[place, _ERROR])
        vague |= abs(sides[place, _LEAST]) * _VAGUE < sides[place, _UNCERTAIN]
        least, greatest = min(least, reached), max(greatest, reached)
    return BOUNDED, least, greatest, separatrix, error, vague


@kernel
def reduced(starts, cell, kind, fall_tilt, timed, series, found, panels, sides, pieces):
    """(ending, least, greatest tilt [rad], period [s], separatrix, error [rad]) of a cell."""
    nan, tilt = math.nan, starts[row.TILT, cell]
    body = body_of(starts, cell, kind)
    if not is_possible(starts, cell, kind, body):
        return INVALID, nan, nan, nan, nan, nan
    if abs(tilt) >= fall_tilt and kind < FIRST_WITH_POLES:
        return FELL, tilt, tilt, nan, nan, 0.0
    if kind == RIM and tilt == 0.0:
        return EDGE_CHANGE, tilt, tilt, nan, nan, 0.0
    unit = math.sqrt(starts[row.RADIUS, cell] / starts[row.GRAVITY, cell])
    rates = starts[row.TILT_RATE, cell], starts[row.PRECESSION_RATE, cell], starts[row.ROLL_RATE, cell]
    state = scaled_state(tilt, rates[0], rates[1], rates[2], unit)
    if is_steady(state, body):
        return STEADY, tilt, tilt, nan, nan, 0.0
    ending, least, greatest, separatrix, error, vague = _both_ways(
        state, tilt, side_of(kind, tilt), kind, fall_tilt, body, series, found, panels, sides
    )
    if not error < math.inf:
        return UNRESOLVED, nan, nan, nan, nan, nan
    period = nan
    if timed and not vague:
        period = 2.0 * _half_period(stretched(tilt), body, panels, sides, pieces)
    return ending, least, greatest, unit * period, separatrix if separatrix < math.inf else nan, error


def memory_of_thread(*_):
    """Arrays of a thread: what follows `counts` in `reduce`."""
    return (
        np.empty((at.ROWS, at.TERMS)), np.empty(MOST_ROOTS), np.empty((2, _MOST_PANELS, _KEPT)),
        np.empty((2, _OF_A_SIDE)),
        np.empty((_MOST_WAITING, 3)),
    )  # fmt: skip


@parallel(
    _CHUNK,
    memory_of_thread,
    starts="float64[:, ::1]",
    kind="float64",
    fall_tilt="float64",
    timed="int64",
    measures="float64[:, ::1], written",
    counts="int32[:, ::1], written",
    series="float64[:, ::1]",
    found="float64[::1]",
    panels="float64[:, :, ::1]",
    sides="float64[:, ::1]",
    pieces="float64[:, ::1]",
)
def reduce(
    start, stop, starts, kind, fall_tilt, timed, measures, counts, series, found, panels, sides, pieces
):
    """Find the extremes of every cell for all time, and its period.

    Python calls it without `start`, `stop` and what follows `counts`.

    Parameters
    ----------
    start, stop : int
        The cells of one chunk.
    starts : float64[len(PARAMETERS), n]
    kind : float
        Number of the body (`kernels.bodies.shapes`).
    fall_tilt : float
        Magnitude of the tilt [rad] that counts as a fall; of bodies with poles it is not read.
    timed : int
        0 to leave out the period.
    measures : float64[len(REDUCED), n], written
    counts : int32[1, n], written
        Codes of `kernels.disk.endings`.
    series, found, panels, sides, pieces : arrays
        Memory of a thread.

    Notes
    -----
    Never raises. Bounded: both extremes hold for all time. Fell and edge_change: the first such tilt reached and the
    extreme before it. Unresolved: on a separatrix to rounding.
    """
    for cell in range(start, stop):
        (
            counts[ENDING, cell],
            measures[row.REDUCED_MIN, cell],
            measures[row.REDUCED_MAX, cell],
            measures[row.REDUCED_PERIOD, cell],
            measures[row.REDUCED_SEPARATRIX, cell],
            measures[row.REDUCED_ERROR, cell],
        ) = reduced(starts, cell, kind, fall_tilt, timed, series, found, panels, sides, pieces)


#: `reduce` of bodies whose meridian is an arc of an ellipse.
reduce_ellipses = variant(reduce, "ellipses", ellipse.FUNCTIONS)
