"""The rows of a cell in the flat array of LANES cells; see `kernels.lossy_disk.layout`, whose names mean the same."""

from kernels.lanes.layout import LANES, offsets

S, C, T, W, O_RATE, P, TIME = offsets(0, 7)
TURNED, PATH, ROLLED, PIVOTED, RUBBED, DAMPED, BLOWN = offsets(7, 14)
LEAST, GREATEST, LAST = offsets(14, 17)
NEAR_S, NEAR_C, NEAR_W, NEAR_ACCELERATION, NEAR_REACH = offsets(17, 22)
STEPS_LEFT, HALF, ASKED, SLIDES, TAKEN = offsets(22, 27)
RATE, INVERSE, SLOWED, RECIPROCAL, ROLL, ROOT = offsets(27, 33)

# What a step only reads: `kernels.lossy_bodies.equations.Rolling`,
CORE, SHIFT, EDGE, AXIAL, TRANSVERSE, RATIO, INVERSE_SPIN, SIDE = offsets(33, 41)
CONTOUR, DAMPING, ROLLING, PIVOTING, FILM, LAYER, FRICTION = offsets(41, 48)
ROLL_SENSE, TURN_SENSE, END = offsets(48, 51)
SCALE, LONGEST = offsets(51, 53)
LOW, HIGH = offsets(53, 55)

STEPPING, RETURNED = 55 * LANES, TAKEN

S_0, C_0, W_0, O_RATE_0, P_0, ENERGY_0 = offsets(55, 61)
UNIT, RADIUS = offsets(61, 63)
REFERENCE, REACH, LOW_0, HIGH_0 = offsets(63, 67)
LEG_S, LEG_C, LEG_T, LEG_W, LEG_O_RATE, LEG_P, LEG_TIME, LEG_ROLL_SENSE, LEG_TURN_SENSE = offsets(67, 76)
LEG_TURNED, LEG_PATH, LEG_ROLLED, LEG_PIVOTED, LEG_RUBBED, LEG_DAMPED, LEG_BLOWN = offsets(76, 83)
LEG_LEAST, LEG_GREATEST = offsets(83, 85)

BREACH, IMBALANCE, STEPS_KEPT, SWITCHES, REFINED, STEPS = offsets(85, 91)
COARSEST, FIRST_SCALE, CHECK, SPENT, PROGRESS, LOOKED = offsets(91, 97)

SIZE = 97 * LANES
