"""Extremes of the contact forces of bodies along their motions; see `kernels.disk.contact_extremes`.

The reduction says of which panels a motion consists (`kernels.bodies.reduction`); on each the extremes are roots of
series (`kernels.bodies.forces`). The judgement of errors is that of the disk.
"""

import math

import numpy as np

from kernels.bodies import arrays as row
from kernels.bodies import ellipse, forces
from kernels.bodies.forces import expand_forces
from kernels.bodies.pair import expand
from kernels.bodies.reduction import (
    _PANELS,
    _TILT,
    _TO,
    _UNCERTAIN,
    OF_ALONG,
    OF_KINETIC,
    OF_SPIN,
    _mirrored,
    memory_of_thread,
    reduced,
    stretched,
)
from kernels.bodies.shapes import FIRST_WITH_POLES
from kernels.bodies.stages import body_of
from kernels.disk import motion_arrays as motion_row
from kernels.disk.contact_extremes import _KEPT, _MOST, _judge, _look, _search_panel
from kernels.disk.contact_extremes import _PANELS as PASSED
from kernels.disk.endings import EDGE_CHANGE, FELL, INVALID, UNRESOLVED
from kernels.disk.equations import scaled_state
from kernels.disk.polynomial_roots import largest_value, value_and_slope
from kernels.jit import kernel
from kernels.lanes.binding import variant
from kernels.native.entry import parallel

_CHUNK = 128

#: Bound of the rounding errors of a panel, in units of the size of the terms.
_ROUNDING = 4.0 * 2.0**-52


@kernel
def rounding_errors(series, end, kept):
    """Bound of the rounding errors of the forces on a panel up to `end`."""
    o, s = largest_value(series, forces.ALONG, end), largest_value(series, forces.SPIN, end)
    sec, v = largest_value(series, forces.SEC, end), largest_value(series, forces.SPEED, end)
    square = largest_value(series, forces.RATE_SQUARED, end)
    size = 1.0 + square + o * (s + sec * (o + v)) + largest_value(series, forces.PULL, end)
    arm = 1.0 + largest_value(series, forces.HEIGHT, end) + largest_value(series, forces.LEVER, end)
    return _ROUNDING * (2.0 + kept[PASSED]) * size * arm


@kernel
def _set_out(series, y, s, o, kinetic, body):
    """Expand motion and forces about a stretched tilt y."""
    series[forces.SIN, 0], series[forces.COS, 0] = math.tanh(y), 1.0 / math.cosh(y)
    series[forces.SPIN, 0], series[forces.ALONG, 0], series[forces.KINETIC, 0] = s, o, kinetic
    expand(series, body)
    expand_forces(series, body)


@kernel
def _search_side(y, body, panels, side, series, found, kept):
    """Search the panels of one side of a start at the stretched tilt y."""
    count, begun = int(side[_PANELS]), 0.0
    kept[PASSED] = 0.0
    for number in range(count):
        own = panels[number]
        _set_out(series, y + begun, own[OF_SPIN], own[OF_ALONG], own[OF_KINETIC], body)
        end, apart = own[_TO] - begun, 4.0 * 2.0**-52 * (own[_TO] + abs(y))
        if number + 1 == count and abs(side[_TILT]) < 0.5 * math.pi:
            # a turning point, not a limit: rounding of the energy moves it
            apart += side[_UNCERTAIN] / abs(value_and_slope(series, forces.KINETIC, end)[1])
        _search_panel(series, end, apart, found, kept)
        begun, kept[PASSED] = own[_TO], number + 1.0


@kernel
def _search(starts, cell, body, panels, sides, series, found, kept):
    """Search a motion on both sides of its start; one that rests has its start alone."""
    unit, tilt = math.sqrt(starts[row.RADIUS, cell] / starts[row.GRAVITY, cell]), starts[row.TILT, cell]
    rates = starts[row.TILT_RATE, cell], starts[row.PRECESSION_RATE, cell], starts[row.ROLL_RATE, cell]
    _, _, _, w, o, s = scaled_state(tilt, rates[0], rates[1], rates[2], unit)
    y = stretched(tilt)
    if sides[0, _PANELS] == 0.0 and sides[1, _PANELS] == 0.0:
        _set_out(series, y, s, o, 0.0, body)
        kept[PASSED] = 0.0
        _look(series, 0.0, 0.0, rounding_errors(series, 0.0, kept), kept)
    _search_side(y, body, panels[0], sides[0], series, found, kept)
    # the panels of the side of negative tilts are those of the mirror image
    _search_side(-y, _mirrored(body), panels[1], sides[1], series, found, kept)


def _memory_of_thread(*arguments):
    _, *others = memory_of_thread(*arguments)
    return (np.empty((forces.ROWS, forces.TERMS)), *others, np.empty(_KEPT))


@parallel(
    _CHUNK,
    _memory_of_thread,
    starts="float64[:, ::1]",
    kind="float64",
    fall_tilt="float64",
    extremes="float64[:, ::1], written",
    states="int64[::1], written",
    series="float64[:, ::1]",
    found="float64[::1]",
    panels="float64[:, :, ::1]",
    sides="float64[:, ::1]",
    pieces="float64[:, ::1]",
    kept="float64[::1]",
)
def _contact(
    start, stop, starts, kind, fall_tilt, extremes, states, series, found, panels, sides, pieces, kept
):
    """Find the extremes of the contact forces that rolling without slip needs, along the motion of every cell.

    Python calls it without `start`, `stop` and what follows `states`.

    Parameters
    ----------
    start, stop : int
        The cells of one chunk.
    starts, kind, fall_tilt
        As of `kernels.bodies.reduction.reduce`.
    extremes : float64[len(CONTACT), n], written
        As of `kernels.disk.contact_extremes.contact_extremes`, of the motion for all time.
    states : int64[n], written
        `NO_MOTION`, `PRESSES`, `LIFTS_OFF` or `UNRESOLVED_FORCES` of `kernels.disk.motion_arrays`.
    series, found, panels, sides, pieces, kept : arrays
        Memory of a thread.

    Notes
    -----
    Never raises. A motion that falls is searched from its start on, and back to where it turned before if it does.
    """
    for cell in range(start, stop):
        sides[:], kept[:] = 0.0, 0.0
        kept[:_MOST] = math.inf
        ending, least, _, _, _, _ = reduced(
            starts, cell, kind, fall_tilt, 0, series, found, panels, sides, pieces
        )
        normal, friction, state = math.nan, math.nan, motion_row.NO_MOTION
        falls_at_once = ending == FELL and kind < FIRST_WITH_POLES and abs(least) >= fall_tilt
        falls_at_once |= ending == EDGE_CHANGE
        if ending == UNRESOLVED:
            state = motion_row.UNRESOLVED_FORCES
        elif ending != INVALID and not (falls_at_once and sides[0, _PANELS] + sides[1, _PANELS] == 0.0):
            _search(starts, cell, body_of(starts, cell, kind), panels, sides, series, found, kept)
            normal, friction, state = _judge(kept)
        (
            extremes[motion_row.CONTACT_LEAST_NORMAL_FORCE, cell],
            extremes[motion_row.CONTACT_FRICTION_NEEDED, cell],
        ) = normal, friction
        states[cell] = state


_FLAGS = {"at": forces, "_rounding_errors": rounding_errors}

#: Of bodies whose meridian is an arc of a circle, and of an ellipse.
contact = variant(_contact, "bodies", _FLAGS)
contact_ellipses = variant(_contact, "ellipses", _FLAGS | ellipse.FUNCTIONS)
