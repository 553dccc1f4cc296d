"""The rows of a body's cell in the flat array of LANES cells; see `kernels.disk.layout`, whose names mean the same."""

from kernels.lanes.layout import LANES, offsets

S, C, T, W, O_RATE, P, TIME, HALF = offsets(0, 8)

# What a step only reads: `kernels.bodies.shapes.Body`,
CORE, SHIFT, EDGE, ALPHA, TRANSVERSE, RATIO = offsets(8, 14)
HALF_UNIFORM, HALF_GRADED, HEADING, END = offsets(14, 18)
#: sign of the tilts on the edge that a body rolls on; 0 if it has no other edge.
(SIDE,) = offsets(18, 19)

STEPPING, RETURNED = 19 * LANES, HALF

S_0, C_0, W_0, O_RATE_0, S_RATE_0, ENERGY_0, UNIT = offsets(19, 26)
STEADY, CURVATURE, STEP, REFINED, FAILED = offsets(26, 31)
BACKWARD, FIRST_TURN, STEPS_KEPT, LEAST, GREATEST, ERROR, CHANGE = offsets(31, 38)
STEPS, LANDED, TILT_END, TIME_END, ESTIMATE_END, ERROR_END, CHANGE_END = offsets(38, 45)

SIZE = 45 * LANES
