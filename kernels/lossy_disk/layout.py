"""The rows of a cell with losses in the flat array of LANES cells (`kernels.lanes.layout`)."""

from kernels.lanes.layout import LANES, offsets

# What a step changes: the state (scaled, T = S K, see `kernels.lossy_disk.equations`), the time,
S, C, T, W, O_RATE, P, TIME = offsets(0, 7)
#: the ledger: heading, path over R, and what each law took over m g R,
TURNED, PATH, ROLLED, PIVOTED, RUBBED, DAMPED, BLOWN = offsets(7, 14)
#: sines of the extreme tilts before the last two steps, half the length of one of them,
LEAST, GREATEST, LAST = offsets(14, 17)
#: sines of the extreme tilts in the last two steps, steps until the lane is looked at, half the length of each of the
#: next two; and of the present ones.
LATEST_LEAST, LATEST_GREATEST, STEPS_LEFT, HALF, TAKEN = offsets(17, 22)

# What a step only reads: `kernels.lossy_disk.rk4.Inertia`,
I_TILT, I_ROLL, I_SPIN, I_INVERSE, DRAG, INVERSE_SPIN = offsets(22, 28)
#: `kernels.lossy_disk.loss_laws.Losses`, the friction coefficient,
CONTOUR, DAMPING, ROLLING, PIVOTING, FILM, LAYER, FRICTION = offsets(28, 35)
#: signs of the roll rate and of the turning rate about the vertical, the scaled duration,
ROLL_SENSE, TURN_SENSE, END = offsets(35, 38)
#: half the relative step, half the longest step,
SCALE, LONGEST = offsets(38, 40)
#: sines of the tilts where the criterion is broken.
LOW, HIGH = offsets(40, 42)

#: Numbers of the lanes while they step; of these, the numbers that a block needs back after an event.
STEPPING, RETURNED = 42 * LANES, TAKEN

# What is kept of a cell between its events: the start,
S_0, C_0, W_0, O_RATE_0, P_0, ENERGY_0 = offsets(42, 48)
#: alpha, sqrt(R/g) in s, the radius,
ALPHA, UNIT, RADIUS = offsets(48, 51)
#: tilt from which the criterion measures, distance that breaks it [rad], sines of both tilts where that is,
REFERENCE, REACH, LOW_0, HIGH_0 = offsets(51, 55)
#: where the next leg begins: state, time, signs,
LEG_S, LEG_C, LEG_T, LEG_W, LEG_O_RATE, LEG_P, LEG_TIME, LEG_ROLL_SENSE, LEG_TURN_SENSE = offsets(55, 64)
#: ledger,
LEG_TURNED, LEG_PATH, LEG_ROLLED, LEG_PIVOTED, LEG_RUBBED, LEG_DAMPED, LEG_BLOWN = offsets(64, 71)
#: sines of the extreme tilts.
LEG_LEAST, LEG_GREATEST = offsets(71, 73)

#: When the criterion was first broken, the largest imbalance, steps, switches, reductions of the step, steps of a leg.
BREACH, IMBALANCE, STEPS_KEPT, SWITCHES, REFINED, STEPS = offsets(73, 79)
#: `kernels.lossy_disk.step_control`: the largest SCALE and that of the start; steps of the cell when it is looked at
#: next; what was spent, the part of the way and the steps when it was last.
COARSEST, FIRST_SCALE, CHECK, SPENT, PROGRESS, LOOKED = offsets(79, 85)

#: Numbers of LANES cells.
SIZE = 85 * LANES
