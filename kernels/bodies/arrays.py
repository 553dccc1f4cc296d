"""The rows of the arrays that Python and the kernels of bodies exchange, in the same form as `kernels.disk.arrays`.

Measures and counts are the same as for the disk. The thin disk is a torus without a tube.
"""

#: Start of a cell: tilt [rad], three rates [rad/s]; lengths over the outer radius [1]; flattening [1]; moments of
#: inertia about the centre of mass over m R^2 [1]; radius [m], gravity [m/s^2].
PARAMETERS = (
    "tilt", "tilt_rate", "precession_rate", "roll_rate", "tube", "thickness", "fillet", "offset", "flattening",
    "axial_moment", "transverse_moment", "radius", "gravity",
)  # fmt: skip
(
    TILT, TILT_RATE, PRECESSION_RATE, ROLL_RATE, TUBE, THICKNESS, FILLET, OFFSET, FLATTENING, AXIAL_MOMENT,
    TRANSVERSE_MOMENT, RADIUS, GRAVITY,
) = range(len(PARAMETERS))  # fmt: skip

#: Settings of an integration: the settings for the disk, and the number of the body (`kernels.bodies.shapes`).
SETTINGS = ("duration", "step", "fall_tilt", "tolerance", "body")
BODY = SETTINGS.index("body")

#: Measures of the reduction: extreme tilts [rad], nutation period [s], a maximum of the potential next to the motion
#: minus the energy, over m g R [1], estimated error of the extreme tilts [rad]. NaN if a measure does not exist.
REDUCED = ("tilt_min", "tilt_max", "nutation_period", "separatrix", "tilt_error")
REDUCED_MIN, REDUCED_MAX, REDUCED_PERIOD, REDUCED_SEPARATRIX, REDUCED_ERROR = range(len(REDUCED))

#: Path of a body: heading gained per nutation [rad]; distance [m] between the contact points at two successive
#: smallest tilts; least and greatest distance [m] of the contact point from the centre of the ring; position of that
#: centre [m] relative to the contact point of the start, whose heading is 0. Kind of the path.
PATH = ("heading_per_nutation", "path_drift", "ring_inner", "ring_outer", "ring_x", "ring_y")
PATH_HEADING, PATH_DRIFT, PATH_INNER, PATH_OUTER, PATH_X, PATH_Y = range(len(PATH))
UNKNOWN_PATH, ANNULAR_PATH, UNBOUNDED_PATH = range(3)

#: Extremes of the contact forces of a motion: least normal force over m g [1], largest friction coefficient needed [1].
CONTACT = ("least_normal_force", "friction_needed")
CONTACT_LEAST_NORMAL_FORCE, CONTACT_FRICTION_NEEDED = range(len(CONTACT))

#: State of these extremes: there is no motion; the body is always in contact, and both are known; it lifts off during
#: the motion; one or both are not known to the promised error.
NO_MOTION, PRESSES, LIFTS_OFF, UNRESOLVED_FORCES = range(4)
