"""The start of a cell: its body, the edge that it rolls on, and whether the start is possible."""

import math

from kernels.bodies import arrays as row
from kernels.bodies.shapes import FIRST_WITH_POLES, RIM, Body, arc_of
from kernels.jit import kernel

_arc_of = kernel(arc_of)


@kernel
def body_of(starts, cell, kind):
    """Return the `Body` of a cell; `kind` is its number."""
    arc = _arc_of(
        kind,
        starts[row.TUBE, cell],
        starts[row.THICKNESS, cell],
        starts[row.FILLET, cell],
        starts[row.OFFSET, cell],
        starts[row.FLATTENING, cell],
    )
    axial, transverse = starts[row.AXIAL_MOMENT, cell], starts[row.TRANSVERSE_MOMENT, cell]
    # on its other edge, a body is replaced by its mirror image
    shift = -arc.shift if kind == RIM and starts[row.TILT, cell] < 0.0 else arc.shift
    return Body(arc.core, shift, arc.edge, arc.square, axial, transverse, axial / transverse)


@kernel
def side_of(kind, tilt):
    """Return the sign of the tilts on the edge that a body rolls on; 0 if it has no other edge."""
    return math.copysign(1.0, tilt) if kind == RIM else 0.0


@kernel
def is_possible(starts, cell, kind, body):
    """Return whether a start is possible: finite, within 90 deg, with moments and an arc that a body can have."""
    tilt_rate, precession_rate = starts[row.TILT_RATE, cell], starts[row.PRECESSION_RATE, cell]
    finite = math.isfinite(tilt_rate) and math.isfinite(precession_rate)
    finite = finite and math.isfinite(starts[row.ROLL_RATE, cell]) and math.isfinite(body.shift)
    heavy = 0.0 < body.axial <= 2.0 * body.transverse < math.inf
    fits = kind != RIM or starts[row.FILLET, cell] <= 0.5 * starts[row.THICKNESS, cell]
    # the centre of mass is between the poles
    fits = fits and (kind < FIRST_WITH_POLES or body.shift * body.shift < body.square)
    convex = body.core >= 0.0 and body.edge >= 0.0 and 0.0 < body.core + body.edge < math.inf
    convex = convex and 0.0 < body.square < math.inf
    inside = abs(starts[row.TILT, cell]) < 0.5 * math.pi
    squared = starts[row.RADIUS, cell] / starts[row.GRAVITY, cell]
    return finite and heavy and fits and convex and inside and 0.0 < squared < math.inf
