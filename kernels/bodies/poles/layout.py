"""The rows of a cell in the flat array of LANES cells; see `kernels.disk.layout`, whose names mean the same."""

from kernels.lanes.layout import LANES, offsets

#: S, y, x, s, n, p, q of `kernels.bodies.poles.equations`.
S, Y, X, SPIN, N, P, Q, TIME, HALF = offsets(0, 9)

# What a step only reads: of `kernels.bodies.poles.equations.Rolling`,
SHIFT, SQUARE, ALPHA, TRANSVERSE, RATIO, ENERGY_0 = offsets(9, 15)
HALF_UNIFORM, HEADING, END = offsets(15, 18)

STEPPING, RETURNED = 18 * LANES, HALF

S_0, C_0, W_0, O_RATE_0, S_RATE_0, UNIT = offsets(18, 24)
STEADY, CURVATURE, STEP, REFINED, FAILED = offsets(24, 29)
BACKWARD, FIRST_TURN, STEPS_KEPT, LEAST, GREATEST, ERROR, CHANGE = offsets(29, 36)
STEPS, LANDED, TILT_END, TIME_END, ESTIMATE_END, ERROR_END, CHANGE_END = offsets(36, 43)

SIZE = 43 * LANES
