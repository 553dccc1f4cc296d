"""The linear pair of bodies, carried from one tilt to another: what theory without time asks of it."""

import math

import numpy as np

from kernels.bodies import ellipse
from kernels.bodies import pair as at
from kernels.bodies.equations import energy_gained, per_inertia
from kernels.bodies.pair import expand
from kernels.bodies.shapes import Body
from kernels.jit import kernel
from kernels.lanes.binding import variant
from kernels.native.entry import parallel

#: Cells that a thread takes at a time; panels from one tilt to another at most.
_CHUNK, _MOST_PANELS = 128, 800


@kernel
def _carried(tilt, there, s, o, body, series):
    """Rates (s, o) at the tilt `there` of a motion that has s and o at `tilt`."""
    heading = 1.0 if there >= tilt else -1.0
    # towards smaller tilts by the mirror image
    own = (
        body
        if heading > 0.0
        else Body(body.core, -body.shift, body.edge, body.square, body.axial, body.transverse, body.ratio)
    )
    series[at.SIN, 0], series[at.COS, 0] = heading * math.sin(tilt), math.cos(tilt)
    series[at.SPIN, 0], series[at.ALONG, 0], series[at.KINETIC, 0] = s, heading * o, 0.0
    left = heading * (math.asinh(math.tan(there)) - math.asinh(math.tan(tilt)))
    for _ in range(_MOST_PANELS):
        if not left > 0.0:
            break
        expand(series, own)
        length = min(at.length_of(series), left)
        at.go_on(series, length)
        left -= length
    return series[at.SPIN, 0], heading * series[at.ALONG, 0]


@kernel
def _square(tilt, there, w, before, after, body):
    """Square of the factor of the rates (s, o) before and after with which a motion turns at the tilt `there`.

    Its energy is a sum of what the rates hold, with that square, and of the rest.
    """
    S, C, S_there, C_there = math.sin(tilt), math.cos(tilt), math.sin(there), math.cos(there)
    kinetic = 0.5 * w * w / per_inertia(S, C, body)
    still, start = (S_there, C_there, 0.0, 0.0, 0.0, 0.0), (S, C, 0.0, 0.0, 0.0)
    higher = energy_gained(still, start, body, body.axial)
    moving, begun = (S_there, C_there, 0.0, 0.0, after[1], after[0]), (S, C, 0.0, before[1], before[0])
    barrier = energy_gained(moving, begun, body, body.axial) - higher
    return max(kinetic - higher, 0.0) / barrier if barrier > 0.0 else math.inf


@parallel(
    _CHUNK,
    lambda *_: (np.empty((at.ROWS, at.TERMS)),),
    tilts="float64[:, ::1]",
    bodies="float64[:, ::1]",
    rates="float64[:, ::1], written",
    squares="float64[::1], written",
    series="float64[:, ::1]",
)
def carry(start, stop, tilts, bodies, rates, squares, series):
    """Carry the rates s and o of motions from one tilt to another, and say which multiple of them turns there.

    Python calls it without `start`, `stop` and `series`.

    Parameters
    ----------
    start, stop : int
        The cells of one chunk.
    tilts : float64[3, n]
        From where and to where [rad], inside 90 degrees, and the scaled rate of the tilt.
    bodies : float64[7, n]
        Rows as `kernels.bodies.shapes.Body`.
    rates : float64[2, n], written
        s and o in any one unit: at the first tilts, then at the second ones.
    squares : float64[n], written
        Square of the factor of scaled rates with which the motion turns at the second tilt; infinite if none does.
    series : float64[ROWS, TERMS]
        Memory of a thread.
    """
    for cell in range(start, stop):
        body = Body(
            bodies[0, cell],
            bodies[1, cell],
            bodies[2, cell],
            bodies[3, cell],
            bodies[4, cell],
            bodies[5, cell],
            bodies[6, cell],
        )
        tilt, there, w = tilts[0, cell], tilts[1, cell], tilts[2, cell]
        before = rates[0, cell], rates[1, cell]
        after = _carried(tilt, there, before[0], before[1], body, series)
        squares[cell] = _square(tilt, there, w, before, after, body)
        rates[0, cell], rates[1, cell] = after


#: `carry` of bodies whose meridian is an arc of an ellipse.
carry_ellipses = variant(carry, "ellipses", ellipse.FUNCTIONS)
