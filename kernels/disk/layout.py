"""The rows of a cell of the disk in the flat array of LANES cells (`kernels.lanes.layout`)."""

from kernels.lanes.layout import place_rows

#: Rows that a step changes: the state (scaled, see `kernels.disk.equations`; P is (1 + alpha) s), the time, half the
#: next step.
CHANGED = "S C T W O_RATE P TIME HALF"

#: Rows that a step only reads: the inertia of the disk;
_INERTIA = "I_TILT I_SPIN DRAG"
#: half the step, which is HALF_UNIFORM + HALF_GRADED * C; the sign of the tilt rate until the next turning point; the
#: scaled duration.
READ = "HALF_UNIFORM HALF_GRADED HEADING END"

#: Rows kept for a cell between its events: the start;
START = "S_0 C_0 W_0 O_RATE_0 S_RATE_0 ENERGY_0"
#: alpha, 1 + alpha and its reciprocal; sqrt(R/g) in s;
_OF_DISK, UNIT_ROW = "ALPHA I_ROLL I_INVERSE", "UNIT"
#: whether its start is a steady motion, the second derivative of its potential;
STEADINESS = "STEADY CURVATURE"
#: the scale of the step, the number of its refinements, the last estimated error that was too large;
REFINEMENT = "STEP REFINED FAILED"
#: whether the present leg goes backward in time, the time and the steps of the first leg;
FIRST_LEG = "BACKWARD FIRST_TURN STEPS_KEPT"
#: the extreme tilts so far, the largest stated error, the largest energy change.
FOUND = "LEAST GREATEST ERROR CHANGE"

#: The end of the present leg: its steps, whether the first correction led to a turning point; tilt and time at the
#: end, the estimated error that decides whether the leg is accepted, the error that is stated if it is, the energy
#: change.
LEG_END = "STEPS LANDED TILT_END TIME_END ESTIMATE_END ERROR_END CHANGE_END"

globals().update(
    place_rows(
        (CHANGED, _INERTIA, READ),
        (START, _OF_DISK, UNIT_ROW, STEADINESS, REFINEMENT, FIRST_LEG, FOUND, LEG_END),
        returned="HALF",
    )
)
