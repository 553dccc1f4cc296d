"""The rows of a cell with losses in the flat array of LANES cells (`kernels.lanes.layout`)."""

from kernels.lanes.layout import LANES, offsets

# What a step changes: the state (scaled, T = S K, see `kernels.lossy_disk.equations`), the time,
S, C, T, W, O_RATE, P, TIME = offsets(0, 7)
#: the ledger: heading, path over R, and what each law took over m g R,
TURNED, PATH, ROLLED, PIVOTED, RUBBED, DAMPED, BLOWN = offsets(7, 14)
#: sines of the extreme tilts before the last call of `advance`, half the length of one of its steps,
LEAST, GREATEST, LAST = offsets(14, 17)
#: its state nearest to a turning point: S, C, |w|, acceleration of the tilt, the longest time to that,
NEAR_S, NEAR_C, NEAR_W, NEAR_ACCELERATION, NEAR_REACH = offsets(17, 22)
#: steps until the lane is looked at, half the length of each of the next call, and what the motion asked for last;
#: whether the disk slid as before at all beginnings of steps; half the length of each of the present call;
STEPS_LEFT, HALF, ASKED, SLIDES, TAKEN = offsets(22, 27)
#: of its last stage what `kernels.lossy_disk.loss_laws.rolling_friction_near` starts from, the roll rate and its root.
RATE, INVERSE, SLOWED, RECIPROCAL, ROLL, ROOT = offsets(27, 33)

# What a step only reads: `kernels.lossy_disk.rk4.Inertia`,
I_TILT, I_ROLL, I_SPIN, I_INVERSE, DRAG, INVERSE_SPIN = offsets(33, 39)
#: `kernels.lossy_disk.loss_laws.Losses`, the friction coefficient,
CONTOUR, DAMPING, ROLLING, PIVOTING, FILM, LAYER, FRICTION = offsets(39, 46)
#: signs of the roll rate and of the turning rate about the vertical, the scaled duration,
ROLL_SENSE, TURN_SENSE, END = offsets(46, 49)
#: half the relative step, half the longest step,
SCALE, LONGEST = offsets(49, 51)
#: sines of the tilts where the criterion is broken.
LOW, HIGH = offsets(51, 53)

#: Numbers of the lanes while they step; of these, the numbers that a block needs back after an event.
STEPPING, RETURNED = 53 * LANES, TAKEN

# What is kept of a cell between its events: the start,
S_0, C_0, W_0, O_RATE_0, P_0, ENERGY_0 = offsets(53, 59)
#: alpha, sqrt(R/g) in s, the radius,
ALPHA, UNIT, RADIUS = offsets(59, 62)
#: tilt from which the criterion measures, distance that breaks it [rad], sines of both tilts where that is,
REFERENCE, REACH, LOW_0, HIGH_0 = offsets(62, 66)
#: where the next leg begins: state, time, signs,
LEG_S, LEG_C, LEG_T, LEG_W, LEG_O_RATE, LEG_P, LEG_TIME, LEG_ROLL_SENSE, LEG_TURN_SENSE = offsets(66, 75)
#: ledger,
LEG_TURNED, LEG_PATH, LEG_ROLLED, LEG_PIVOTED, LEG_RUBBED, LEG_DAMPED, LEG_BLOWN = offsets(75, 82)
#: sines of the extreme tilts.
LEG_LEAST, LEG_GREATEST = offsets(82, 84)

#: When the criterion was first broken, the largest imbalance, steps, switches, reductions of the step, steps of a leg.
BREACH, IMBALANCE, STEPS_KEPT, SWITCHES, REFINED, STEPS = offsets(84, 90)
#: `kernels.lossy_disk.step_control`: the largest SCALE and that of the start; steps of the cell when it is looked at
#: next; what was spent, the part of the way and the steps when it was last.
COARSEST, FIRST_SCALE, CHECK, SPENT, PROGRESS, LOOKED = offsets(90, 96)

#: Numbers of LANES cells.
SIZE = 96 * LANES
