"""Where each number of a cell lies: one flat array holds LANES trajectories side by side, quantity after quantity.

Constant offsets into a single array let the compiler see that no lane touches another one's numbers; with two
dimensions or several arrays it gives up and the lane loop stays scalar (30 times slower).
"""

#: Four AVX-512 or eight AVX2 vectors: enough independent chains to hide latency. With 16 a run takes 6 % longer, with
#: 48 it takes 3 % less where there are cells enough, but more lanes idle while the last long cell of a chunk ends.
LANES = 32

# The state that a step changes (scaled, see kernels.disk.equations; P is 1 + alpha times s), the time, and half the step to come
S, C, T, W, O_RATE, P, TIME, HALF = (row * LANES for row in range(8))

# What a step reads besides
I_TILT, I_SPIN, DRAG = (row * LANES for row in range(8, 11))
#: Half the step is HALF_UNIFORM + HALF_GRADED * C.
HALF_UNIFORM, HALF_GRADED = (row * LANES for row in range(11, 13))
#: Sign of the tilt rate until the next turning point; the scaled duration.
HEADING, END = (row * LANES for row in range(13, 15))

#: Numbers of the lanes while they step.
MOVING = 15 * LANES

# What a cell remembers between its events: the start,
S_0, C_0, W_0, O_RATE_0, S_RATE_0, ENERGY_0 = (row * LANES for row in range(15, 21))
#: alpha, 1 + alpha and its reciprocal, sqrt(R/g) in s,
ALPHA, I_ROLL, I_INVERSE, UNIT = (row * LANES for row in range(21, 25))
#: whether it is at rest for ever, the second derivative of its potential,
STEADY, STIFFNESS = (row * LANES for row in range(25, 27))
#: the scale of the step, how often it was reduced, the error that was last found too large,
STEP, REFINED, FAILED = (row * LANES for row in range(27, 30))
#: whether the motion is followed backward in time now, the time and the steps of the leg before,
BACKWARD, FIRST_TURN, STEPS_KEPT = (row * LANES for row in range(30, 33))
#: the extreme tilts so far, the worst estimated error, the largest energy change.
LEAST, GREATEST, ERROR, CHANGE = (row * LANES for row in range(33, 37))

# What has become of the present leg: its steps, whether a turning point was reached with the first correction,
STEPS, LANDED = (row * LANES for row in range(37, 39))
#: the tilt where it ended, the time, the estimated error and the energy change there.
TILT_END, TIME_END, ERROR_END, CHANGE_END = (row * LANES for row in range(39, 43))

#: Numbers of LANES cells.
SIZE = 43 * LANES
