"""The rows of a disk's cell in the flat array of LANES cells (`kernels.lanes.layout`)."""

from kernels.lanes.layout import place_rows

#: What a step changes: the state (scaled, see `kernels.disk.equations`; P is 1 + alpha times s), the time, half the
#: next step.
CHANGED = "S C T W O_RATE P TIME HALF"

#: What a step only reads: the inertia of the disk;
_INERTIA = "I_TILT I_SPIN DRAG"
#: half the step, which is HALF_UNIFORM + HALF_GRADED * C; the sign of the tilt rate until the next turning point; the
#: scaled duration.
READ = "HALF_UNIFORM HALF_GRADED HEADING END"

#: What is kept of a cell between its events: the start,
START = "S_0 C_0 W_0 O_RATE_0 S_RATE_0 ENERGY_0"
#: alpha, 1 + alpha and its reciprocal; sqrt(R/g) in s,
_OF_DISK, UNIT_ROW = "ALPHA I_ROLL I_INVERSE", "UNIT"
#: whether its start is a steady motion, the second derivative of its potential,
STEADINESS = "STEADY CURVATURE"
#: the scale of the step, how often it was reduced, the estimated error that was last found too large,
REFINEMENT = "STEP REFINED FAILED"
#: whether the motion is followed backward in time now, the time and the steps of the leg before,
FIRST_LEG = "BACKWARD FIRST_TURN STEPS_KEPT"
#: the extreme tilts so far, the worst stated error, the largest energy change.
FOUND = "LEAST GREATEST ERROR CHANGE"

#: The end of the present leg: its steps, whether the first correction led to a turning point; the tilt where it
#: ended, the time, the estimated error that decides whether the leg is accepted; the error that is stated if it is,
#: the energy change there.
LEG_END = "STEPS LANDED TILT_END TIME_END ESTIMATE_END ERROR_END CHANGE_END"

globals().update(
    place_rows(
        (CHANGED, _INERTIA, READ),
        (START, _OF_DISK, UNIT_ROW, STEADINESS, REFINEMENT, FIRST_LEG, FOUND, LEG_END),
        returned="HALF",
    )
)
