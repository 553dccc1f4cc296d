"""Extremes of the contact forces along motions, with error bounds; values not known to 1e-6 are omitted.

A motion is followed in its tilt, not in time. If it returns to the saddle from which it was kicked, an integration in
time can carry it past the saddle, to the wrong side. It is followed from its start to both ends, panel by panel in
the stretched tilt (`kernels.disk.tilt_series`). On a panel the extremes of the forces are roots of series without
poles, even if the normal force vanishes. The part in the negative direction is followed as the mirror image in the
positive direction, so that mirror images have the same bits.
"""

import math

import numpy as np

from kernels.disk import motion_arrays as motion_row
from kernels.disk import tilt_series as at
from kernels.disk.arrays import ALPHA, GRAVITY, PRECESSION_RATE, RADIUS, ROLL_RATE, TILT, TILT_RATE
from kernels.disk.endings import BOUNDED, FELL, HORIZON
from kernels.disk.equations import inertia, scaled_state
from kernels.disk.polynomial_roots import (
    AMBIGUOUS,
    MOST_ROOTS,
    first_length,
    first_root,
    largest_value,
    roots,
    value_and_slope,
    value_at,
)
from kernels.jit import kernel
from kernels.native.entry import parallel

#: Number of cells that a thread takes at a time.
_CHUNK = 128

#: A value is known if its error bound is below this times 1 + |value|; the promised error is 1e-6.
_KNOWN = 2.5e-7

#: Bound of the rounding errors of a panel, over the magnitude of the terms.
_ROUNDING = 4.0 * 2.0**-52

#: The turning point of a motion is the first root of its kinetic energy. It belongs to the cell if it is within this
#: many estimated errors and this tilt [rad] of the cell's turning point.
_REACH, _SMALLEST_REACH = 100.0, 1e-6

#: A motion shorter than this, in the stretched tilt, needs no matching turning point: its force may be rounding error.
_SHORTEST = 1e-10

#: Panels from -90 to 90 deg, whose tangents are 1.6e16.
_MOST_PANELS = 640

#: Numbers kept along a motion: the least normal force found and its lower and upper bound, the same for the largest
#: friction coefficient; the largest terms so far.
_LEAST, _LEAST_LOW, _LEAST_HIGH, _MOST, _MOST_LOW, _MOST_HIGH = range(6)
_AXIAL_SIZE, _DIAMETRAL_SIZE, _KINETIC_SIZE, _PANELS = range(6, 10)
_KEPT = 10

#: Kinds of ends: the tilt turns; the tilt is known exactly (fall_tilt or the start); the time is over.
_TURNS, _EXACT, _STOPS = range(3)


@kernel
def _rounding_errors(series, end, kept):
    """Return a bound of the rounding errors of the forces on a panel up to `end`."""
    kept[_AXIAL_SIZE] = max(kept[_AXIAL_SIZE], largest_value(series, at.AXIAL, end))
    kept[_DIAMETRAL_SIZE] = max(kept[_DIAMETRAL_SIZE], largest_value(series, at.DIAMETRAL, end))
    kept[_KINETIC_SIZE] = max(kept[_KINETIC_SIZE], largest_value(series, at.KINETIC, end))
    tan, sec = largest_value(series, at.TAN, end), largest_value(series, at.SEC, end)
    spins = kept[_AXIAL_SIZE] + tan * kept[_DIAMETRAL_SIZE]
    size = 1.0 + 2.0 * kept[_KINETIC_SIZE] + 3.0 * kept[_DIAMETRAL_SIZE] * sec * spins
    return _ROUNDING * (2.0 + kept[_PANELS]) * size


@kernel
def _look(series, t, apart, rounding, kept):
    """Include the forces at t, which is known to within `apart`, in the extremes."""
    normal, slope = value_and_slope(series, at.NORMAL, t)
    error = rounding + abs(slope) * apart
    kept[_LEAST] = min(kept[_LEAST], normal)
    kept[_LEAST_LOW] = min(kept[_LEAST_LOW], normal - error)
    kept[_LEAST_HIGH] = min(kept[_LEAST_HIGH], normal + error)
    if not normal > error:
        kept[_MOST_HIGH] = math.inf
        return
    squared, slope = value_and_slope(series, at.FRICTION_SQUARED, t)
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
    rounding = _rounding_errors(series, end, kept)
    _look(series, 0.0, 0.0, rounding, kept)
    _look(series, end, apart, rounding, kept)
    count = roots(series, at.NORMAL_SLOPE, end, rounding, found)
    if count == AMBIGUOUS:
        kept[_LEAST_LOW] = -math.inf
        return
    least = min(value_at(series, at.NORMAL, 0.0), value_at(series, at.NORMAL, end))
    for i in range(count):
        _look(series, found[i], 0.0, rounding, kept)
        least = min(least, value_at(series, at.NORMAL, found[i]))
    if not least > rounding:
        return
    # terms omitted from the square of the coefficient are at most 1e-14
    count = roots(series, at.FRICTION_SLOPE, end, 1e-14 * least * least * least, found)
    if count == AMBIGUOUS:
        kept[_MOST_HIGH] = math.inf
    for i in range(count):
        _look(series, found[i], 0.0, rounding, kept)


@kernel
def _end_on_panel(series, turn, left, length, ends, error):
    """Return the end of a motion on a panel and its uncertainty; NaN if further on, -1 if it contradicts the cell.

    `turn` is the first turning point and `left` the end of the motion according to the cell, both in the stretched
    tilt; `error` is the estimated error of the cell [rad].
    """
    stretch = value_at(series, at.SEC, min(max(left, 0.0), length))
    reach = (_REACH * error + _SMALLEST_REACH) * stretch
    if turn < left - reach or turn < 0.0:
        return -1.0, 0.0
    if ends == _TURNS:
        if turn > left + reach or (math.isnan(turn) and left + reach < length):
            return -1.0, 0.0
        return turn, 0.0
    if left > length:
        return math.nan, 0.0
    early = left - turn if turn < left else 0.0
    return left, (early if ends == _EXACT else early + error * stretch)


@kernel
def _uncertainty(series, end, kept):
    """Return the largest shift, in the stretched tilt, of a root of the kinetic energy by rounding."""
    if end == 0.0:
        return 0.0
    kinetic = max(largest_value(series, at.KINETIC, end), kept[_KINETIC_SIZE])
    return _ROUNDING * (2.0 + kept[_PANELS]) * kinetic / abs(value_and_slope(series, at.KINETIC, end)[1])


@kernel
def _follow(state, constants, alpha, way, ends, error, series, found, kept):
    """Search a motion from a scaled start to its greatest tilt, `way` away; return whether it agrees with the cell."""
    at.set_out(series, state, constants)
    kept[_AXIAL_SIZE] = kept[_DIAMETRAL_SIZE] = kept[_KINETIC_SIZE] = kept[_PANELS] = 0.0
    at_rest, left, length = series[at.KINETIC, 0] == 0.0, way, at.PANEL
    for panel in range(_MOST_PANELS):
        at.expand_motion(series, constants)
        at.expand_forces(series, constants, alpha)
        if panel == 0:
            length = first_length(series, at.KINETIC, at_rest, at.PANEL)
        turn = first_root(series, at.KINETIC, at.KINETIC_PER_STRETCH, at_rest and panel == 0, length, found)
        end, apart = _end_on_panel(series, turn, left, length, ends, error)
        if ends == _TURNS and end >= 0.0:
            apart = _uncertainty(series, end, kept)
        if end < 0.0:
            if panel > 0 or way > _SHORTEST:
                return False
            end = apart = max(way, 0.0)
        further = math.isnan(end)
        _search_panel(series, length if further else end, apart, found, kept)
        if not further:
            return True
        at.go_on(series, length)
        kept[_PANELS] += 1.0
        left, length = left - length, at.PANEL
    return False


@kernel
def _stretched(tilt):
    return math.asinh(math.tan(tilt))


@kernel
def _end_of(end, tilt, tilt_rate, ending, fall_tilt):
    """Return the kind of end of the part from a tilt to the greatest tilt of a motion, from the ending of the cell."""
    if abs(end) >= fall_tilt:
        return _EXACT
    if ending == BOUNDED or (ending == FELL and tilt_rate > 0.0):
        return _TURNS
    # a motion that falls at once has no part before its start, and a steady motion has only its start
    return _STOPS if ending == HORIZON and end != tilt else _EXACT


@kernel
def _search(start, state, least_tilt, greatest_tilt, error, ending, fall_tilt, series, found, kept):
    """Search a motion on both sides of its start; return whether its extreme tilts agree with the cell."""
    alpha, tilt = start[ALPHA], start[TILT]
    constants, fits = inertia(alpha), True
    S, C, T, w, o, s = state
    for side in (1.0, -1.0):
        end = greatest_tilt if side > 0.0 else -least_tilt
        ends = _end_of(end, side * tilt, side * w, ending, fall_tilt)
        way = _stretched(end) - _stretched(side * tilt)
        image = (side * S, C, side * T, w, side * o, s)
        fits &= _follow(image, constants, alpha, way, ends, error, series, found, kept)
    return fits


@kernel
def _judge(kept):
    """Return (least normal force, friction needed, state) from the kept numbers; NaN for unknown values."""
    least, most = kept[_LEAST], kept[_MOST]
    error = max(least - kept[_LEAST_LOW], kept[_LEAST_HIGH] - least)
    if not error <= _KNOWN * (1.0 + abs(least)):
        return math.nan, math.nan, motion_row.UNRESOLVED_FORCES
    if kept[_LEAST_HIGH] <= 0.0:
        return least, math.nan, motion_row.LIFTS_OFF
    error = max(most - kept[_MOST_LOW], kept[_MOST_HIGH] - most)
    if not (kept[_LEAST_LOW] > 0.0 and error <= _KNOWN * (1.0 + most)):
        return least, math.nan, motion_row.UNRESOLVED_FORCES
    return least, most, motion_row.PRESSES


def _memory_of_thread(*_):
    return np.empty((at.ROWS, at.TERMS)), np.empty(MOST_ROOTS), np.empty(_KEPT)


@parallel(
    _CHUNK,
    _memory_of_thread,
    starts="float64[:, ::1]",
    extents="float64[:, ::1]",
    endings="int64[::1]",
    fall_tilt="float64",
    extremes="float64[:, ::1], written",
    states="int64[::1], written",
    series="float64[:, ::1]",
    found="float64[::1]",
    kept="float64[::1]",
)
def contact_extremes(start, stop, starts, extents, endings, fall_tilt, extremes, states, series, found, kept):
    """Find the extremes of the contact forces that rolling without slip needs along the motion of every cell.

    Python calls it without `start`, `stop` and the arguments after `states`.

    Parameters
    ----------
    start, stop : int
        The cells of one chunk.
    starts : float64[len(PARAMETERS), n]
    extents : float64[len(EXTENT), n]
        Least and greatest tilt [rad] of the motion, NaN without a motion, and their estimated error [rad].
    endings : int64[n]
        Codes of `kernels.disk.endings`.
    fall_tilt : float
        Magnitude of the tilt [rad] at which motions end.
    extremes : float64[len(CONTACT), n], written
        Least normal force over m g [1], and largest friction coefficient needed [1], which is NaN if the normal force
        becomes zero or negative. Both are NaN without a motion, and if the error bound exceeds a quarter of 1e-6
        (1 + |value|).
    states : int64[n], written
        `NO_MOTION`, `PRESSES`, `LIFTS_OFF` or `UNRESOLVED_FORCES` of `kernels.disk.motion_arrays`.
    series, found, kept : arrays
        Memory of a thread: series of a panel, their roots, numbers kept along a motion.

    Notes
    -----
    Never raises. A motion that turns is followed to its own turning point, not to the turning point of the cell. The
    latter has an error, over which the forces of a fast motion can change by more than 1e-6. If both are far apart,
    the result is unknown.
    """
    for cell in range(start, stop):
        least, greatest = extents[motion_row.EXTENT_TILT_MIN, cell], extents[motion_row.EXTENT_TILT_MAX, cell]
        normal, friction, state = math.nan, math.nan, motion_row.NO_MOTION
        if least <= greatest:
            own = starts[:, cell]
            unit = math.sqrt(own[RADIUS] / own[GRAVITY])
            scaled = scaled_state(own[TILT], own[TILT_RATE], own[PRECESSION_RATE], own[ROLL_RATE], unit)
            series[:], kept[:] = 0.0, 0.0
            kept[:_MOST] = math.inf
            state = motion_row.UNRESOLVED_FORCES
            if _search(
                own, scaled, least, greatest, extents[motion_row.EXTENT_TILT_ERROR, cell], endings[cell],
                fall_tilt, series, found, kept,
            ):  # fmt: skip
                normal, friction, state = _judge(kept)
        (
            extremes[motion_row.CONTACT_LEAST_NORMAL_FORCE, cell],
            extremes[motion_row.CONTACT_FRICTION_NEEDED, cell],
        ) = normal, friction
        states[cell] = state
