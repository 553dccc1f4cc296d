"""The rows of a cell with losses in the flat array of LANES cells (`kernels.lanes.layout`)."""

from kernels.lanes.layout import place_rows
from kernels.lossy_disk.loss_coefficients import ROWS as LOSSES

#: Rows that a step changes: the state (scaled, T = S K, see `kernels.lossy_disk.equations`) and the time; the ledger
#: (heading, path over R, energy lost to each law over m g R); sines of the extreme tilts before the last call of
#: `advance`, half the length of each of its steps; its state nearest to a turning point (S, C, |w|, tilt
#: acceleration, longest time to the turning point).
CHANGED = """
    S C T W O_RATE P TIME
    TURNED PATH ROLLED PIVOTED RUBBED DAMPED BLOWN
    LEAST GREATEST LAST
    NEAR_S NEAR_C NEAR_W NEAR_ACCELERATION NEAR_REACH
"""
#: Steps until the cell is checked again, half the step length of the next call, and the half step that the motion
#: last asked for; whether the disk slid in the same way at the beginning of every step; half the step length of the
#: present call.
CALL = "STEPS_LEFT HALF ASKED SLIDES TAKEN"
#: Values of the last stage that `kernels.lossy_disk.loss_laws.rolling_friction_near` starts from; the roll rate and
#: its root.
STAGE = "RATE INVERSE SLOWED RECIPROCAL ROLL ROOT"

#: Rows that a step only reads: `kernels.lossy_disk.rk4.Inertia`.
_INERTIA = "I_TILT I_ROLL I_SPIN I_INVERSE DRAG INVERSE_SPIN"
#: `kernels.lossy_disk.loss_coefficients.Losses` and the friction coefficient; signs of the roll rate and of the turning
#: rate about the vertical, scaled duration; half the relative step, half the longest step; sines of the tilts that
#: break the criterion.
READ = f"""
    {LOSSES} FRICTION
    ROLL_SENSE TURN_SENSE END
    SCALE LONGEST
    LOW HIGH
"""

#: Rows kept for a cell between its events: the start.
START = "S_0 C_0 W_0 O_RATE_0 P_0 ENERGY_0"
#: alpha; sqrt(R/g) in s and the radius.
_OF_DISK, UNITS = "ALPHA", "UNIT RADIUS"
#: Tilt from which the criterion measures, distance that breaks it [rad], sines of the two tilts at that distance.
CRITERION = "REFERENCE REACH LOW_0 HIGH_0"
#: Beginning of the next leg: state, time, signs; ledger; sines of the extreme tilts.
NEXT_LEG = """
    LEG_S LEG_C LEG_T LEG_W LEG_O_RATE LEG_P LEG_TIME LEG_ROLL_SENSE LEG_TURN_SENSE
    LEG_TURNED LEG_PATH LEG_ROLLED LEG_PIVOTED LEG_RUBBED LEG_DAMPED LEG_BLOWN
    LEG_LEAST LEG_GREATEST
"""
#: Time of the first breach, largest imbalance, steps, switches of friction, refinements of the step, steps of a leg.
FOUND = "BREACH IMBALANCE STEPS_KEPT SWITCHES REFINED STEPS"
#: `kernels.lossy_disk.step_control`: tolerance of the present pass; the largest SCALE and its value at the start;
#: number of steps at the next check; error spent, progress and number of steps at the last check.
CONTROL = "ALLOWED COARSEST FIRST_SCALE CHECK SPENT PROGRESS LOOKED"
#: `kernels.lossy_disk.error_estimate.Outcome` of the pass before.
PASS = "PASS_ENDING PASS_TIME PASS_TILT PASS_LEAST PASS_GREATEST PASS_TURNED PASS_PATH"

globals().update(
    place_rows(
        (CHANGED, CALL, STAGE, _INERTIA, READ),
        (START, _OF_DISK, UNITS, CRITERION, NEXT_LEG, FOUND, CONTROL, PASS),
        returned="TAKEN",
    )
)
