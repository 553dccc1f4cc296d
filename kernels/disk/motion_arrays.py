"""Rows of the arrays of contact forces and trajectories, in the same form as `kernels.disk.arrays`."""

from kernels.disk.arrays import EXTREME_TILTS, STATE

#: Range of a motion: its extreme tilts and their estimated error [rad].
EXTENT = (*EXTREME_TILTS, "tilt_error")
EXTENT_TILT_MIN, EXTENT_TILT_MAX, EXTENT_TILT_ERROR = range(len(EXTENT))

#: Extremes of the contact forces of a motion: least normal force over m g [1], largest friction coefficient needed [1].
CONTACT = ("least_normal_force", "friction_needed")
CONTACT_LEAST_NORMAL_FORCE, CONTACT_FRICTION_NEEDED = range(len(CONTACT))

#: State of these extremes: there is no motion; the disk is always in contact, and both are known; it lifts off during
#: the motion; one or both are not known to the promised error.
NO_MOTION, PRESSES, LIFTS_OFF, UNRESOLVED_FORCES = range(4)

#: Settings of a single trajectory: longest step [s] (0: no limit), step times the fastest frequency of the state [1],
#: fall_tilt [rad].
TRAJECTORY_SETTINGS = ("step", "relative_step", "fall_tilt")
TRAJECTORY_STEP, TRAJECTORY_RELATIVE_STEP, TRAJECTORY_FALL_TILT = range(len(TRAJECTORY_SETTINGS))

#: One sample of a trajectory: `STATE`, heading and roll angle [rad], contact point [m], vertical momentum gained per
#: mass [m^2/s]; all except `STATE` start at 0.
SAMPLES = (*STATE, "heading", "roll_angle", "contact_x", "contact_y", "momentum_gained")
HEADING, ROLL_ANGLE, CONTACT_X, CONTACT_Y, MOMENTUM_GAINED = range(len(STATE), len(SAMPLES))

#: Quantities derived from one sample: energy over m g R; its relative change since the first sample; vertical angular
#: momentum about the contact point per mass [m^2/s] and its rate of change [m^2/s^2]; normal force and horizontal
#: forces across and along the track, over m g; friction coefficient needed, NaN if the normal force is not positive.
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
