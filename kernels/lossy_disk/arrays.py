"""The arrays that Python and the kernels with losses exchange; see also `kernels.disk.arrays`.

Units are SI, angles in rad. A torque of dry friction is its lever arm times the instantaneous normal force.
"""

from kernels.disk.arrays import STATE as STATE

#: Start of a cell: the start of a disk without losses; mass [kg]; lever arms of rolling, pivoting and contour
#: friction [m]; viscous contour friction [N m s]; viscosity [Pa s] and density [kg m^-3] of the air; friction
#: coefficient [1], infinite if the disk cannot slip.
PARAMETERS = (
    *STATE,
    "alpha",
    "radius",
    "gravity",
    "mass",
    "rolling_friction",
    "pivoting_friction",
    "contour_friction",
    "contour_damping",
    "air_viscosity",
    "air_density",
    "friction",
)
(
    TILT,
    TILT_RATE,
    PRECESSION_RATE,
    ROLL_RATE,
    ALPHA,
    RADIUS,
    GRAVITY,
    MASS,
    ROLLING_FRICTION,
    PIVOTING_FRICTION,
    CONTOUR_FRICTION,
    CONTOUR_DAMPING,
    AIR_VISCOSITY,
    AIR_DENSITY,
    FRICTION,
) = range(len(PARAMETERS))

#: Laws of air drag, and their numbers in the settings.
AIR_LAWS = ("none", "moffatt", "bildsten")
NONE, MOFFATT, BILDSTEN = range(len(AIR_LAWS))

#: Settings of an integration: duration [s]; longest step [s] (0: no limit); flat_tilt [rad]; tolerance of the energy
#: balance over m g R [1]; the criterion whose first breach is recorded: its kind (0: none; 1: a distance from the
#: undisturbed tilt [rad]; 2: that distance over the size of the perturbation), its limit, and whether the undisturbed
#: tilt is the tilt of the start (1) or upright (0); number of the air drag law.
SETTINGS = ("duration", "step", "flat_tilt", "tolerance", "limited", "limit", "from_start", "air_law")
DURATION, STEP, FLAT_TILT, TOLERANCE, LIMITED, LIMIT, FROM_START, AIR_LAW = range(len(SETTINGS))

#: Measures of a cell: extreme tilts [rad]; time until the ending [s]; tilt there [rad]; heading turned [rad]; path
#: length of the contact point [m]; energy lost to rolling, pivoting and contour friction, contour damping and air,
#: each over m g R [1]; time of the first breach of the criterion [s], or NaN; largest imbalance of the energy, over m
#: g R [1]; estimated errors of the tilts [rad], of the time [s], of the heading turned [rad] and of the path length
#: [m].
MEASURES = (
    "tilt_min",
    "tilt_max",
    "end_time",
    "end_tilt",
    "heading_turned",
    "path_length",
    "rolling_loss",
    "pivoting_loss",
    "contour_loss",
    "damping_loss",
    "air_loss",
    "breach_time",
    "energy_imbalance",
    "tilt_error",
    "time_error",
    "heading_error",
    "path_error",
)
(
    TILT_MIN,
    TILT_MAX,
    END_TIME,
    END_TILT,
    HEADING_TURNED,
    PATH_LENGTH,
    ROLLING_LOSS,
    PIVOTING_LOSS,
    CONTOUR_LOSS,
    DAMPING_LOSS,
    AIR_LOSS,
    BREACH_TIME,
    ENERGY_IMBALANCE,
    TILT_ERROR,
    TIME_ERROR,
    HEADING_ERROR,
    PATH_ERROR,
) = range(len(MEASURES))

#: Counts of a cell: code of `kernels.lossy_disk.endings`; steps of the accepted integration; refinements of the step;
#: how often dry friction reversed, seized or let go.
COUNTS = ("ending", "steps", "refinements", "switches")
ENDING, STEPS, REFINEMENTS, SWITCHES = range(len(COUNTS))

#: Losses in the ledger, in the order of `MEASURES` and of the trajectory.
LOSSES = MEASURES[ROLLING_LOSS : AIR_LOSS + 1]

#: Settings of a single motion: longest step [s] (0: no limit), relative step [1] (0: half the relative step of
#: atlases), flat_tilt [rad], law of air drag.
TRAJECTORY_SETTINGS = ("step", "relative_step", "flat_tilt", "air_law")
TRAJECTORY_STEP, TRAJECTORY_RELATIVE_STEP, TRAJECTORY_FLAT_TILT, TRAJECTORY_AIR_LAW = range(
    len(TRAJECTORY_SETTINGS)
)

#: One sample of a motion: `STATE`; heading and roll angle [rad], contact point [m]; the losses so far, each over m g
#: R; normal force and horizontal forces across and along the track over m g; which rates friction holds (bits: 1 roll
#: rate held by contour friction, 2 turning about the vertical held by pivoting friction, 4 tilt and roll held by
#: rolling friction); centre of mass [m]; energy over m g R.
SAMPLES = (
    *STATE,
    "heading",
    "roll_angle",
    "contact_x",
    "contact_y",
    *LOSSES,
    "normal_force",
    "friction_across",
    "friction_along",
    "held",
    "centre_x",
    "centre_y",
    "centre_z",
    "energy",
)
(
    SAMPLE_HEADING,
    SAMPLE_ROLL_ANGLE,
    SAMPLE_CONTACT_X,
    SAMPLE_CONTACT_Y,
    SAMPLE_ROLLING_LOSS,
    SAMPLE_PIVOTING_LOSS,
    SAMPLE_CONTOUR_LOSS,
    SAMPLE_DAMPING_LOSS,
    SAMPLE_AIR_LOSS,
    SAMPLE_NORMAL_FORCE,
    SAMPLE_FRICTION_ACROSS,
    SAMPLE_FRICTION_ALONG,
    SAMPLE_HELD,
    SAMPLE_CENTRE_X,
    SAMPLE_CENTRE_Y,
    SAMPLE_CENTRE_Z,
    SAMPLE_ENERGY,
) = range(len(STATE), len(SAMPLES))
