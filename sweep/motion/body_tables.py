"""The kind of motions of bodies of revolution without losses: words and variables (`sweep.motion.tables`)."""

from collections.abc import Mapping
from dataclasses import replace

from kernels.disk.endings import EDGE_CHANGE, FELL, HORIZON
from sweep.model.bodies.model import BODIES
from sweep.model.bodies.shape import has_poles
from sweep.model.bodies.tables import OPTIONS, PARAMETERS, SETTINGS
from sweep.model.quantity import DECISION, ERROR_GAUGE, Input, Quantity, Tolerance, Word, table
from sweep.motion.tables import MOTION_INPUTS, TRAJECTORY, MotionKind


def _in_words(text: str) -> str:
    return text.replace("plane of the disk", "body, of its axis from the horizontal").replace(
        "the disk", "the body"
    )


def of_a_body(row: Input) -> Input:
    """Return a word of the motions of the disk, reworded for a body."""
    return replace(row, long_name=row.long_name.replace("disk", "body"))


_INPUTS: Mapping[str, Input] = table(
    *PARAMETERS.values(),
    of_a_body(MOTION_INPUTS["mass"]),
    of_a_body(MOTION_INPUTS["friction"]),
    MOTION_INPUTS["duration"],
    MOTION_INPUTS["interval"],
    MOTION_INPUTS["step"],
    SETTINGS["fall_tilt"],
)

_WORDS: Mapping[str, Word] = table(
    Word("title", "title of the motion, in one line", ""),
    Word("method", "how the motion is integrated", "rk4", ("rk4",)),
    OPTIONS["body"],
    OPTIONS["filling"],
)

#: Stated error -> its unit and its description.
ERRORS: Mapping[str, tuple[str, str]] = {
    "orientation_error": ("rad", "stated error of the orientation, as an angle"),
    "path_error": ("m", "stated error of contact point and centre of mass, as a distance"),
    "rate_error": ("rad s-1", "stated error of the angular velocity"),
    "force_error": ("N", "stated error of the contact force"),
}

_WHICH = {
    "tilt": "orientation_error", "heading": "orientation_error", "roll_angle": "orientation_error",
    "contact_x": "path_error", "contact_y": "path_error", "centre_x": "path_error", "centre_y": "path_error",
    "centre_z": "path_error", "tilt_rate": "rate_error", "precession_rate": "rate_error", "roll_rate": "rate_error",
    "normal_force": "force_error", "friction_across": "force_error", "friction_along": "force_error",
}  # fmt: skip

#: Descriptions of variables that differ from those of the disk.
_DESCRIBED = {
    "heading": "continuous, from 0; next to a pole it jumps by half a turn, and its error is orientation_error over "
    "cos(tilt); if the body passes a pole within that error, the heading may have turned the other way",
    "vertical_momentum_rate": "tilt_rate times (height of the centre of mass times the speed of the contact point "
    "along the track, minus radius of curvature times the speed of the centre of mass)",
}


def variable(row: Quantity) -> Quantity:
    """Return a variable of the motions of the disk, reworded for a body and with its stated error as tolerance."""
    within = row.tolerance
    if row.name in _WHICH:
        within = Tolerance(1e-9, 1e-9, "each value is within its stated error", _WHICH[row.name])
    symbol = "" if row.name == "vertical_momentum_rate" else row.symbol
    description = _DESCRIBED.get(row.name, row.description)
    return replace(
        row,
        symbol=symbol,
        tolerance=within,
        long_name=_in_words(row.long_name),
        description=_in_words(description),
    )


def error_of(name: str, units: str, words: str) -> Quantity:
    """Return the variable of a stated error."""
    origin = "from the largest difference so far of two integrations with different steps"
    return Quantity(name, "", units, words, ERROR_GAUGE, origin, "f4")


# fmt: off
#: The variables of the file of one motion; all but the last two have the dimension elapsed_time.
VARIABLES: Mapping[str, Quantity] = table(
    *(variable(row) for name, row in TRAJECTORY.items() if name not in ("ending", "fall_time")),
    *(error_of(name, *row) for name, row in ERRORS.items()),
    Quantity("ending", "", "1", "how the motion ended", DECISION,
             "horizon: the duration was over; fell: the tilt reached fall_tilt; edge_change: the tilt reached 0, where "
             "the other edge of a disk with a rim hits the plane",
             "i1", {HORIZON: "horizon", FELL: "fell", EDGE_CHANGE: "edge_change"}),
    Quantity("end_time", "t_f", "s", "time until the motion ended", TRAJECTORY["tilt"].tolerance,
             "missing where the duration was over first: ending is horizon"),
)
# fmt: on

BODY_MOTION = MotionKind(
    model=BODIES,
    inputs=_INPUTS,
    words=_WORDS,
    variables=VARIABLES,
    fixed=(*(name for name in PARAMETERS if name not in VARIABLES), "mass", "friction"),
    largest_tilt="fall_tilt",
    ending_time="end_time",
    endings={"fell": "fell", "edge change": "came down on its other edge"},
    headline="Motion of a body of revolution",
    summary="One motion of a body of revolution that rolls without slipping on a horizontal plane: tilt and rates, "
    "path of contact point and centre of mass, energy, vertical angular momentum with its balance law, and contact "
    "forces, with stated errors.",
    path="sweep.motion.body_path",
    kernels="kernels.bodies.poles.trajectory",
    figure="sweep.figures.disk.motion_plots:figure",
    # the heading jumps next to a pole, so differences of angles do not show whether samples are close enough
    turning=(),
    keywords="rolling body of revolution, torus, coin, nonholonomic dynamics, trajectory, contact forces",
    sample_size=250,
    called="body",
    rolls_on=lambda body: has_poles(body.body),
)
