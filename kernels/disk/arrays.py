"""What stands in the arrays that Python hands to the disk's kernels and takes from them: one table for each array.

A name's place in its table is its row in the array; the constant beside a table is that row. Where the same name stands
in two tables the constant bears the table's prefix. `len(TABLE)` is the number of rows. Units are SI, angles in rad.
"""

#: Start of a cell: tilt [rad], three rates [rad/s], axial moment of inertia over m R^2 [1], radius [m],
#: gravity [m/s^2].
PARAMETERS = ("tilt", "tilt_rate", "precession_rate", "roll_rate", "alpha", "radius", "gravity")
TILT, TILT_RATE, PRECESSION_RATE, ROLL_RATE, ALPHA, RADIUS, GRAVITY = range(len(PARAMETERS))

#: Settings of an integration: duration [s], step [s] (0: chosen for each cell), fall_tilt [rad], tolerance of the
#: extreme tilts [rad].
SETTINGS = ("duration", "step", "fall_tilt", "tolerance")
DURATION, STEP, FALL_TILT, TOLERANCE = range(len(SETTINGS))

#: Measures of an integrated cell: extreme tilts [rad], fall time [s], nutation period [s], relative change of the
#: energy [1], estimated error of the extreme tilts [rad]. NaN where a measure does not exist.
MEASURES = ("tilt_min", "tilt_max", "fall_time", "nutation_period", "energy_drift", "tilt_error")
TILT_MIN, TILT_MAX, FALL_TIME, NUTATION_PERIOD, ENERGY_DRIFT, TILT_ERROR = range(len(MEASURES))

#: Counts of an integrated cell: code of `kernels.disk.endings`, steps of the accepted integration, reductions of the
#: step.
COUNTS = ("ending", "steps", "refinements")
ENDING, STEPS, REFINEMENTS = range(len(COUNTS))

#: Extreme tilts [rad] of a motion: the first rows of both tables of measures.
EXTREME_TILTS = MEASURES[:2]

#: Measures of the exact reduction: extreme tilts [rad], nutation period [s], saddle of the potential minus the energy,
#: over m g R [1], estimated error of the extreme tilts [rad]. NaN where a measure does not exist.
EXACT_MEASURES = ("tilt_min", "tilt_max", "nutation_period", "separatrix", "tilt_error")
EXACT_TILT_MIN, EXACT_TILT_MAX, EXACT_NUTATION_PERIOD, EXACT_SEPARATRIX, EXACT_TILT_ERROR = range(
    len(EXACT_MEASURES)
)

#: Counts of the exact reduction: code of `kernels.disk.endings`, wells of the potential (1, 2; 0 where unknown).
EXACT_COUNTS = ("ending", "wells")
EXACT_ENDING, EXACT_WELLS = range(len(EXACT_COUNTS))

#: Extremes of the contact forces of a motion: least normal force over m g [1], largest friction coefficient needed [1].
CONTACT = ("least_normal_force", "friction_needed")
CONTACT_LEAST_NORMAL_FORCE, CONTACT_FRICTION_NEEDED = range(len(CONTACT))

#: Settings of a single trajectory: longest step [s] (0: follows the state), step times the fastest frequency of the
#: state [1], fall_tilt [rad].
TRAJECTORY_SETTINGS = ("step", "relative_step", "fall_tilt")
TRAJECTORY_STEP, TRAJECTORY_RELATIVE_STEP, TRAJECTORY_FALL_TILT = range(len(TRAJECTORY_SETTINGS))

#: Tilt [rad] and its rate, precession rate and roll rate [rad/s]: the first rows of `PARAMETERS` and of `SAMPLES`.
STATE = PARAMETERS[:4]

#: One sample of a trajectory: `STATE`, heading and roll angle [rad], contact point [m], vertical momentum gained per
#: mass [m^2/s]; all but `STATE` count from 0.
SAMPLES = (*STATE, "heading", "roll_angle", "contact_x", "contact_y", "momentum_gained")
HEADING, ROLL_ANGLE, CONTACT_X, CONTACT_Y, MOMENTUM_GAINED = range(len(STATE), len(SAMPLES))

#: What follows from one sample: energy over m g R; its relative change since the first sample; vertical angular
#: momentum about the contact point per mass [m^2/s] and its rate of change [m^2/s^2]; normal force and horizontal
#: forces across and along the track, over m g; friction coefficient needed, NaN where the normal force is not positive.
DERIVED = (
    "energy",
    "energy_drift",
    "vertical_momentum",
    "vertical_momentum_rate",
    "normal_force",
    "friction_across",
    "friction_along",
    "friction_needed",
)
(
    DERIVED_ENERGY,
    DERIVED_ENERGY_DRIFT,
    DERIVED_VERTICAL_MOMENTUM,
    DERIVED_VERTICAL_MOMENTUM_RATE,
    DERIVED_NORMAL_FORCE,
    DERIVED_FRICTION_ACROSS,
    DERIVED_FRICTION_ALONG,
    DERIVED_FRICTION_NEEDED,
) = range(len(DERIVED))
