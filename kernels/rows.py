"""Where each number of a lane lies: one flat array holds LANES trajectories side by side, quantity after quantity.

Constant offsets into a single array let the compiler see that no lane touches another one's numbers; with two
dimensions or several arrays it gives up and the lane loop stays scalar (30 times slower).
"""

#: Two AVX-512 or four AVX2 vectors: enough independent chains to hide latency (16, 32 and 64 run equally fast), and
#: the fewest lanes that idle while the last long cell of a chunk ends.
LANES = 32

# The state that a step changes (scaled, see kernels.disk)
S, C, T, W, O_RATE, S_RATE, TIME = (row * LANES for row in range(7))

# What a step reads besides
I_TILT, I_ROLL, I_SPIN, I_INVERSE = (row * LANES for row in range(7, 11))
#: The step is STEP_UNIFORM + STEP_GRADED * C.
STEP_UNIFORM, STEP_GRADED = (row * LANES for row in range(11, 13))
#: Sign of the tilt rate until the next turning point; cos(fall_tilt); the scaled duration.
HEADING, LEAST_C, END = (row * LANES for row in range(13, 16))

# What a cell remembers between its events: the start,
S_0, C_0, W_0, O_RATE_0, S_RATE_0, ENERGY_0 = (row * LANES for row in range(16, 22))
#: the scale of the step, how often it was reduced, the error that was last found too large,
STEP, REFINED, FAILED = (row * LANES for row in range(22, 25))
#: whether the motion is followed backward in time now, the time and the steps of the leg before,
BACKWARD, FIRST_TURN, STEPS_KEPT = (row * LANES for row in range(25, 28))
#: the extreme tilts so far, the worst estimated error, the largest energy change, and sqrt(R/g) in s.
LEAST, GREATEST, ERROR, CHANGE, UNIT = (row * LANES for row in range(28, 33))

SIZE = 33 * LANES
