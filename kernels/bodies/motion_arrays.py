"""Rows of the arrays of a single motion of a body without losses, in the same form as `kernels.disk.arrays`."""

from kernels.disk.arrays import STATE

#: Settings of a single trajectory: longest step [s] (0: no limit), step times the fastest frequency of the state [1],
#: fall_tilt [rad], the number of the body (`kernels.bodies.shapes`).
SETTINGS = ("step", "relative_step", "fall_tilt", "body")
STEP, RELATIVE_STEP, FALL_TILT, BODY = range(len(SETTINGS))

#: One sample: `STATE`, heading and roll angle [rad], contact point and centre of mass [m], energy over m g R, its
#: relative change since the start, vertical angular momentum about the contact point per mass [m^2/s], its rate of
#: change [m^2/s^2], the integral of this rate [m^2/s], forces over m g. Heading, roll angle, contact point and
#: integral start at 0.
SAMPLES = (
    *STATE, "heading", "roll_angle", "contact_x", "contact_y", "centre_x", "centre_y", "centre_z", "energy",
    "energy_drift", "vertical_momentum", "vertical_momentum_rate", "momentum_gained", "normal_force",
    "friction_across", "friction_along",
)  # fmt: skip
(
    HEADING, ROLL_ANGLE, CONTACT_X, CONTACT_Y, CENTRE_X, CENTRE_Y, CENTRE_Z, ENERGY, ENERGY_DRIFT, MOMENTUM,
    MOMENTUM_RATE, GAINED, NORMAL, ACROSS, ALONG,
) = range(len(STATE), len(SAMPLES))  # fmt: skip
