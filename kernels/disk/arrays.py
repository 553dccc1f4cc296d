"""The rows of the arrays that Python and the kernels of the disk exchange: one table for each array.

The index of a name in its table is its row in the array; the constant next to a table is that row. If the same name
occurs in two tables, the constant has the prefix of its table. `len(TABLE)` is the number of rows. Units are SI,
angles in rad.
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
#: energy [1], estimated error of the extreme tilts [rad]. NaN if a measure does not exist.
MEASURES = ("tilt_min", "tilt_max", "fall_time", "nutation_period", "energy_drift", "tilt_error")
TILT_MIN, TILT_MAX, FALL_TIME, NUTATION_PERIOD, ENERGY_DRIFT, TILT_ERROR = range(len(MEASURES))

#: Counts of an integrated cell: code of `kernels.disk.endings`, steps of the accepted integration, refinements of the
#: step.
COUNTS = ("ending", "steps", "refinements")
ENDING, STEPS, REFINEMENTS = range(len(COUNTS))

#: Extreme tilts [rad] of a motion: the first rows of both tables of measures.
EXTREME_TILTS = MEASURES[:2]

#: Tilt [rad] and its rate, precession rate and roll rate [rad/s]: the first rows of `PARAMETERS`.
STATE = PARAMETERS[:4]
