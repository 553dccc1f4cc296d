"""How many wells the potential has that belongs to the constants of a motion of a body.

Along the linear pair (`kernels.bodies.pair`) the kinetic energy of the tilt is a constant less the potential: a well is
where its slope passes from above zero to below. The pair is carried from the start to both sides.
"""

import math

import numpy as np

from kernels.bodies import arrays as row
from kernels.bodies import ellipse
from kernels.bodies import pair as at
from kernels.bodies.pair import expand
from kernels.bodies.reduction import _mirrored, _slope_at
from kernels.bodies.shapes import RIM
from kernels.bodies.stages import body_of, is_possible, side_of
from kernels.disk.equations import scaled_state
from kernels.jit import kernel
from kernels.lanes.binding import variant
from kernels.native.entry import parallel

#: Cells that a thread takes at a time; panels to one side at most; how far they go, in y: to 0.04 degrees from flat.
_CHUNK, _MOST_PANELS, _FARTHEST = 32, 400, 8.0

#: Places in a panel at which the slope is looked at.
_PLACES = 4


@kernel
def _to_one_side(state, body, limit, has_wall, series):
    """(wells, slope next to the start) on the way towards greater tilts, as far as `limit` in y.

    Beyond that the potential has a wall, so that it has a well where it still falls there.
    """
    S, C, _, _, o, s = state
    series[at.SIN, 0], series[at.COS, 0] = S, C
    series[at.SPIN, 0], series[at.ALONG, 0], series[at.KINETIC, 0] = s, o, 0.0
    begun, wells, first, before = 0.0, 0, 0.0, 0.0
    # a start beyond the wall is looked at where it is
    limit = max(limit, 1e-9)
    for number in range(_MOST_PANELS):
        if begun >= limit:
            break
        expand(series, body)
        length = min(at.length_of(series), limit - begun)
        if number == 0:
            first = before = series[at.KINETIC, 1]
        for j in range(_PLACES):
            slope = _slope_at(series, length * (j + 1) / _PLACES)
            if before > 0.0 and slope <= 0.0:
                wells += 1
            # the bottom itself is no slope before the next place
            before = slope if slope != 0.0 else -abs(before)
            first = before if first == 0.0 else first
        at.go_on(series, length)
        begun += length
    if has_wall and before > 0.0:
        wells += 1
    return wells, first


@kernel
def _wells(starts, cell, kind, series):
    body, tilt = body_of(starts, cell, kind), starts[row.TILT, cell]
    if not is_possible(starts, cell, kind, body):
        return 0
    unit = math.sqrt(starts[row.RADIUS, cell] / starts[row.GRAVITY, cell])
    rates = starts[row.TILT_RATE, cell], starts[row.PRECESSION_RATE, cell], starts[row.ROLL_RATE, cell]
    S, C, T, w, o, s = scaled_state(tilt, rates[0], rates[1], rates[2], unit)
    y, edge = math.asinh(T), side_of(kind, tilt)
    # a rim stays on the edge on which it starts
    no_up, no_down = kind == RIM and edge < 0.0, kind == RIM and edge > 0.0
    up, down = -y if no_up else _FARTHEST - y, y if no_down else _FARTHEST + y
    above, slope = _to_one_side((S, C, T, w, o, s), body, up, not no_up, series)
    below, back = _to_one_side((-S, C, -T, -w, -o, s), _mirrored(body), down, not no_down, series)
    # the start itself is the bottom of a well
    at_bottom = 1 if slope <= 0.0 and back <= 0.0 else 0
    return above + below + at_bottom


@parallel(
    _CHUNK,
    lambda *_: (np.empty((at.ROWS, at.TERMS)),),
    starts="float64[:, ::1]",
    kind="float64",
    counts="int64[::1], written",
    series="float64[:, ::1]",
)
def wells(start, stop, starts, kind, counts, series):
    """Count the wells of the potential of cells.

    Python calls it without `start`, `stop` and `series`.

    Parameters
    ----------
    start, stop : int
        The cells of one chunk.
    starts : float64[len(PARAMETERS), n]
    kind : float
        Number of the body (`kernels.bodies.shapes`).
    counts : int64[n], written
        0 where there is no such start.
    series : float64[ROWS, TERMS]
        Memory of a thread.

    Notes
    -----
    Never raises. Of a rim they are those at tilts to the side of its start.
    """
    for cell in range(start, stop):
        counts[cell] = _wells(starts, cell, kind, series)


#: `wells` of bodies whose meridian is an arc of an ellipse.
wells_ellipses = variant(wells, "ellipses", ellipse.FUNCTIONS)
