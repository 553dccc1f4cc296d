"""The words and the variables of one motion of the disk without losses."""

from collections.abc import Mapping
from dataclasses import replace

from kernels.disk.endings import FELL, HORIZON
from sweep.model.disk.model import DISK
from sweep.model.disk.tables import PARAMETERS, SETTINGS, VARIABLES
from sweep.model.quantity import ERROR_GAUGE, GRID, Input, Quantity, Tolerance, Word, positive, table
from sweep.motion.kind import MotionKind

#: The methods of integration: the engine's own, and SciPy's for comparison.
MOTION_METHODS = ("rk4", "dop853")

ROLLS, SLIPS, LIFTS = 0, 1, 2

_EXACT = VARIABLES["ending"].tolerance
_STATE = Tolerance(1e-8, 1e-8, "the report's motions agree to this with an integrator of order 8")
_FORCE = Tolerance(1e-6, 1e-6, "forces follow from the squares of rates and a second derivative")


#: The words of a request for one motion whose values are numbers.
MOTION_INPUTS: Mapping[str, Input] = table(
    *PARAMETERS.values(),
    Input("mass", "m", "kg", "mass of the disk", GRID, default=1.0, rule="mass > 0", allows=positive),
    Input(
        "friction", r"\mu", "1", "friction coefficient of disk and plane", GRID,
        default=0.5, rule="friction > 0", allows=positive,
    ),
    replace(SETTINGS["duration"], long_name="time simulated", default=10.0),
    Input(
        "interval", r"\Delta t", "s", "time between samples at most", GRID,
        default="auto", rule="interval > 0, or auto", allows=positive, words=("auto",),
    ),
    replace(SETTINGS["step"], long_name="longest time step"),
    SETTINGS["fall_tilt"],
)  # fmt: skip

MOTION_WORDS: Mapping[str, Word] = table(
    Word("title", "what the motion is, in one line", ""),
    Word("method", "how the motion is integrated", MOTION_METHODS[0], MOTION_METHODS),
)

# fmt: off
#: The variables of the file of one motion; all but the last two have the dimension elapsed_time.
TRAJECTORY: Mapping[str, Quantity] = table(
    Quantity("tilt", r"\theta", "rad", "tilt of the plane of the disk from the vertical", _STATE,
             "0 = upright; positive towards (cos heading, sin heading)"),
    Quantity("tilt_rate", r"\dot\theta", "rad s-1", "rate of the tilt", _STATE),
    Quantity("precession_rate", r"\dot\psi", "rad s-1", "rate of the heading about the vertical", _STATE),
    Quantity("roll_rate", r"\dot\phi", "rad s-1", "rate of roll about the axis of the disk, in the precessing frame",
             _STATE),
    Quantity("heading", r"\psi", "rad", "heading, counted on from 0", _STATE,
             "the disk rolls towards (-sin heading, cos heading) while its roll rate is positive"),
    Quantity("roll_angle", r"\phi", "rad", "roll angle about the axis of the disk, counted on from 0", _STATE),
    Quantity("contact_x", "", "m", "x of the contact point on the plane", _STATE),
    Quantity("contact_y", "", "m", "y of the contact point on the plane", _STATE),
    Quantity("centre_x", "x_c", "m", "x of the centre of mass", _STATE),
    Quantity("centre_y", "y_c", "m", "y of the centre of mass", _STATE),
    Quantity("centre_z", "z_c", "m", "height of the centre of mass over the plane", _STATE),
    Quantity("energy", "E", "J", "energy, kinetic and potential", _STATE),
    Quantity("energy_drift", r"\Delta E/E", "1", "relative change of the energy since the start", ERROR_GAUGE,
             "the exact motion conserves energy, so this is an error of the integration"),
    Quantity("vertical_momentum", r"H\cdot e_3", "kg m2 s-1",
             "vertical angular momentum about the contact point", _STATE,
             "not conserved: the contact point moves, and not along the velocity of the centre"),
    Quantity("vertical_momentum_rate", r"m R^2 \dot\phi\,\dot\theta\cos\theta", "kg m2 s-2",
             "right-hand side of the balance law of the vertical momentum", _STATE,
             "mass radius^2 roll_rate tilt_rate cos(tilt)"),
    Quantity("vertical_momentum_residual", r"\delta H", "kg m2 s-1",
             "change of the vertical momentum less the integral of its rate", ERROR_GAUGE,
             "zero for the exact motion: the check of the balance law"),
    Quantity("normal_force", "N", "N", "normal force of the plane on the disk", _FORCE),
    Quantity("friction_across", r"\lambda_1", "N", "horizontal force across the track", _FORCE,
             "towards (cos heading, sin heading); multiplier of the first constraint"),
    Quantity("friction_along", r"\lambda_2", "N", "horizontal force along the track", _FORCE,
             "towards (-sin heading, cos heading); multiplier of the second constraint"),
    Quantity("friction_needed", r"\mu", "1", "friction coefficient needed to roll without slipping", _FORCE,
             "horizontal over normal force; missing where the normal force is not positive"),
    Quantity("contact", "", "1", "whether rolling without slipping is believable", _EXACT,
             "the motion itself never slips: slips marks where it would need more than the friction coefficient, "
             "lifts_off where the plane would have to pull",
             "i1", {ROLLS: "rolls", SLIPS: "slips", LIFTS: "lifts_off"}),
    Quantity("ending", "", "1", "how the integration ended", _EXACT,
             "horizon: the duration was over; fell: the tilt reached fall_tilt",
             "i1", {HORIZON: "horizon", FELL: "fell"}),
    VARIABLES["fall_time"],
)
# fmt: on

DISK_MOTION = MotionKind(
    model=DISK,
    inputs=MOTION_INPUTS,
    words=MOTION_WORDS,
    variables=TRAJECTORY,
    # a parameter that the disk gets is one of the file too
    fixed=(*(name for name in PARAMETERS if name not in TRAJECTORY), "mass", "friction"),
    largest_tilt="fall_tilt",
    ending_time="fall_time",
    endings={"fell": "fell"},
    headline="Motion of a rolling disk",
    summary="One motion of a thin rigid disk that rolls without slipping on a horizontal plane: tilt and rates, path "
    "of the contact point, energy, vertical angular momentum with its balance law, and contact forces.",
    kernels="kernels.disk.trajectory",
    figure="sweep.figures.disk.motion_plots:figure",
)
