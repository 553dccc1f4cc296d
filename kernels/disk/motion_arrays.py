"""Rows of the arrays of contact forces, in the same form as `kernels.disk.arrays`."""

from kernels.disk.arrays import EXTREME_TILTS

#: Range of a motion: its extreme tilts and their estimated error [rad].
EXTENT = (*EXTREME_TILTS, "tilt_error")
EXTENT_TILT_MIN, EXTENT_TILT_MAX, EXTENT_TILT_ERROR = range(len(EXTENT))

#: Extremes of the contact forces of a motion: least normal force over m g [1], largest friction coefficient needed [1].
CONTACT = ("least_normal_force", "friction_needed")
CONTACT_LEAST_NORMAL_FORCE, CONTACT_FRICTION_NEEDED = range(len(CONTACT))

#: State of these extremes: there is no motion; the disk is always in contact, and both are known; it lifts off during
#: the motion; one or both are not known to the promised error.
NO_MOTION, PRESSES, LIFTS_OFF, UNRESOLVED_FORCES = range(4)
