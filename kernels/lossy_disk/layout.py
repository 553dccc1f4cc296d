"""The rows of a cell with losses in the flat array of LANES cells (`kernels.lanes.layout`)."""

from kernels.lanes.layout import LANES, offsets

# What a step changes: the state (scaled, see `kernels.lossy_disk.equations`), the time,
S, C, K, W, O_RATE, P, TIME = offsets(0, 7)
#: the ledger: heading, path over R, and what each law took over m g R,
TURNED, PATH, ROLLED, PIVOTED, RUBBED, DAMPED, BLOWN = offsets(7, 14)
#: sines of the extreme tilts, that of the last step's beginning, which is not among them yet, half the last step,
LEAST, GREATEST, RECENT, LAST = offsets(14, 18)
#: half the next step.
HALF = offsets(18, 19)[0]

# What a step only reads: `kernels.lossy_disk.rk4.Inertia`,
I_TILT, I_ROLL, I_SPIN, I_INVERSE, DRAG, INVERSE_SPIN = offsets(19, 25)
#: `kernels.lossy_disk.loss_laws.Losses`, the friction coefficient,
CONTOUR, DAMPING, ROLLING, PIVOTING, FILM, LAYER, FRICTION = offsets(25, 32)
#: signs of the roll rate and of the turning rate about the vertical, the scaled duration,
ROLL_SENSE, TURN_SENSE, END = offsets(32, 35)
#: half the relative step, the longest and the least half step,
SCALE, LONGEST, SHORTEST = offsets(35, 38)
#: sines of the tilts where the criterion is broken.
LOW, HIGH = offsets(38, 40)

#: Numbers of the lanes while they step; of these, the numbers that a block needs back after an event.
STEPPING, RETURNED = 40 * LANES, HALF

# What is kept of a cell between its events: the start,
S_0, C_0, W_0, O_RATE_0, P_0, ENERGY_0 = offsets(40, 46)
#: alpha, sqrt(R/g) in s, the radius,
ALPHA, UNIT, RADIUS = offsets(46, 49)
#: sines of the tilts where the criterion is broken, before it is,
LOW_0, HIGH_0 = offsets(49, 51)
#: where the next leg begins: state, time, signs,
LEG_S, LEG_C, LEG_K, LEG_W, LEG_O_RATE, LEG_P, LEG_TIME, LEG_ROLL_SENSE, LEG_TURN_SENSE = offsets(51, 60)
#: ledger,
LEG_TURNED, LEG_PATH, LEG_ROLLED, LEG_PIVOTED, LEG_RUBBED, LEG_DAMPED, LEG_BLOWN = offsets(60, 67)
#: sines of the extreme tilts.
LEG_LEAST, LEG_GREATEST = offsets(67, 69)

#: When the criterion was first broken, the largest imbalance, steps, switches, reductions of the step, the imbalance
#: that was last found too large,
BREACH, IMBALANCE, STEPS_KEPT, SWITCHES, REFINED, FAILED = offsets(69, 75)
#: the steps of a leg.
STEPS = offsets(75, 76)[0]

#: Numbers of LANES cells.
SIZE = 76 * LANES
