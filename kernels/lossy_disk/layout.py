"""The rows of a cell with losses in the flat array of LANES cells (`kernels.lanes.layout`)."""

from kernels.lanes.layout import place_rows

#: What a step changes: the state (scaled, T = S K, see `kernels.lossy_disk.equations`), the time; the ledger: heading,
#: path over R, and what each law took over m g R; sines of the extreme tilts before the last call of `advance`, half
#: the length of one of its steps; its state nearest to a turning point: S, C, |w|, acceleration of the tilt, the
#: longest time to that;
CHANGED = """
    S C T W O_RATE P TIME
    TURNED PATH ROLLED PIVOTED RUBBED DAMPED BLOWN
    LEAST GREATEST LAST
    NEAR_S NEAR_C NEAR_W NEAR_ACCELERATION NEAR_REACH
"""
#: steps until the lane is looked at, half the length of each of the next call, and what the motion asked for last;
#: whether the disk slid as before at all beginnings of steps; half the length of each of the present call;
CALL = "STEPS_LEFT HALF ASKED SLIDES TAKEN"
#: of its last stage what `kernels.lossy_disk.loss_laws.rolling_friction_near` starts from, the roll rate and its root.
STAGE = "RATE INVERSE SLOWED RECIPROCAL ROLL ROOT"

#: What a step only reads: `kernels.lossy_disk.rk4.Inertia`,
_INERTIA = "I_TILT I_ROLL I_SPIN I_INVERSE DRAG INVERSE_SPIN"
#: `kernels.lossy_disk.loss_laws.Losses`, the friction coefficient; signs of the roll rate and of the turning rate about
#: the vertical, the scaled duration; half the relative step, half the longest step; sines of the tilts where the
#: criterion is broken.
READ = """
    CONTOUR DAMPING ROLLING PIVOTING FILM LAYER FRICTION
    ROLL_SENSE TURN_SENSE END
    SCALE LONGEST
    LOW HIGH
"""

#: What is kept of a cell between its events: the start,
START = "S_0 C_0 W_0 O_RATE_0 P_0 ENERGY_0"
#: alpha; sqrt(R/g) in s, the radius,
_OF_DISK, UNITS = "ALPHA", "UNIT RADIUS"
#: tilt from which the criterion measures, distance that breaks it [rad], sines of both tilts where that is,
CRITERION = "REFERENCE REACH LOW_0 HIGH_0"
#: where the next leg begins: state, time, signs; ledger; sines of the extreme tilts.
NEXT_LEG = """
    LEG_S LEG_C LEG_T LEG_W LEG_O_RATE LEG_P LEG_TIME LEG_ROLL_SENSE LEG_TURN_SENSE
    LEG_TURNED LEG_PATH LEG_ROLLED LEG_PIVOTED LEG_RUBBED LEG_DAMPED LEG_BLOWN
    LEG_LEAST LEG_GREATEST
"""
#: When the criterion was first broken, the largest imbalance, steps, switches, reductions of the step, steps of a leg.
FOUND = "BREACH IMBALANCE STEPS_KEPT SWITCHES REFINED STEPS"
#: `kernels.lossy_disk.step_control`: the largest SCALE and that of the start; steps of the cell when it is looked at
#: next; what was spent, the part of the way and the steps when it was last.
CONTROL = "COARSEST FIRST_SCALE CHECK SPENT PROGRESS LOOKED"

globals().update(
    place_rows(
        (CHANGED, CALL, STAGE, _INERTIA, READ),
        (START, _OF_DISK, UNITS, CRITERION, NEXT_LEG, FOUND, CONTROL),
        returned="TAKEN",
    )
)
