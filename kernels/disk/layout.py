"""The rows of a disk's cell in the flat array of LANES cells (`kernels.lanes.layout`)."""

from kernels.lanes.layout import LANES, offsets

# The state that a step changes (scaled, see `kernels.disk.equations`; P is 1 + alpha times s), the time, half the next
# step
S, C, T, W, O_RATE, P, TIME, HALF = offsets(0, 8)

# What a step only reads
I_TILT, I_SPIN, DRAG = offsets(8, 11)
#: Half the step is HALF_UNIFORM + HALF_GRADED * C.
HALF_UNIFORM, HALF_GRADED = offsets(11, 13)
#: Sign of the tilt rate until the next turning point; the scaled duration.
HEADING, END = offsets(13, 15)

#: Numbers of the lanes while they step; of these, the numbers that a block needs back after an event.
STEPPING, RETURNED = 15 * LANES, HALF

# What is kept of a cell between its events: the start,
S_0, C_0, W_0, O_RATE_0, S_RATE_0, ENERGY_0 = offsets(15, 21)
#: alpha, 1 + alpha and its reciprocal, sqrt(R/g) in s,
ALPHA, I_ROLL, I_INVERSE, UNIT = offsets(21, 25)
#: whether its start is a steady motion, the second derivative of its potential,
STEADY, CURVATURE = offsets(25, 27)
#: the scale of the step, how often it was reduced, the estimated error that was last found too large,
STEP, REFINED, FAILED = offsets(27, 30)
#: whether the motion is followed backward in time now, the time and the steps of the leg before,
BACKWARD, FIRST_TURN, STEPS_KEPT = offsets(30, 33)
#: the extreme tilts so far, the worst stated error, the largest energy change.
LEAST, GREATEST, ERROR, CHANGE = offsets(33, 37)

# The end of the present leg: its steps, whether the first correction led to a turning point,
STEPS, LANDED = offsets(37, 39)
#: the tilt where it ended, the time, the estimated error that decides whether the leg is accepted,
TILT_END, TIME_END, ESTIMATE_END = offsets(39, 42)
#: the error that is stated if it is, the energy change there.
ERROR_END, CHANGE_END = offsets(42, 44)

#: Numbers of LANES cells.
SIZE = 44 * LANES
