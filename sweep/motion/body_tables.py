"""The motions of bodies of revolution without losses: words and variables (`sweep.motion.tables`)."""

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
    """Return a word of a motion of the disk as one of a body."""
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
    Word("title", "what the motion is, in one line", ""),
    Word("method", "how the motion is integrated", "rk4", ("rk4",)),
    OPTIONS["body"],
    OPTIONS["filling"],
)

#: Stated error -> the unit, and what is known to it.
ERRORS: Mapping[str, tuple[str, str]] = {
    "orientation_error": ("rad", "angle by which the body may be turned from where it is said to be"),
    "path_error": ("m", "distance by which contact point and centre of mass may be off"),
    "rate_error": ("rad s-1", "by which the angular velocity may be off"),
    "force_error": ("N", "by which the contact force may be off"),
}

_WHICH = {
    "tilt": "orientation_error", "heading": "orientation_error", "roll_angle": "orientation_error",
    "contact_x": "path_error", "contact_y": "path_error", "centre_x": "path_error", "centre_y": "path_error",
    "centre_z": "path_error", "tilt_rate": "rate_error", "precession_rate": "rate_error", "roll_rate": "rate_error",
    "normal_force": "force_error", "friction_across": "force_error", "friction_along": "force_error",
}  # fmt: skip

#: Variables with another meaning than for the disk.
_DESCRIBED = {
    "heading": "counted on from 0; beside a pole it turns by half a turn at once, and is known to orientation_error "
    "over cos(tilt); where it passes a pole within that error, it may have turned the other way",
    "vertical_momentum_rate": "tilt_rate times (height of the centre of mass times the speed of the contact point "
    "along the track, minus radius of curvature times the speed of the centre of mass)",
}


def variable(row: Quantity) -> Quantity:
    """Return a variable of a motion of the disk as one of a body, known to its stated error."""
    within = row.tolerance
    if row.name in _WHICH:
        within = Tolerance(1e-9, 1e-9, "each value is within its stated error", _WHICH[row.name])
    symbol = "" if row.name == "vertical_momentum_rate" else row.symbol
    described = _DESCRIBED.get(row.name, row.description)
    return replace(
        row,
        symbol=symbol,
        tolerance=within,
        long_name=_in_words(row.long_name),
        description=_in_words(described),
    )


def error_of(name: str, units: str, words: str) -> Quantity:
    """Return a variable that states an error."""
    told = "from how far two integrations with different steps have been apart until then"
    return Quantity(name, "", units, words, ERROR_GAUGE, told, "f4")


# fmt: off
#: The variables of the file of one motion; all but the last two have the dimension elapsed_time.
VARIABLES: Mapping[str, Quantity] = table(
    *(variable(row) for name, row in TRAJECTORY.items() if name not in ("ending", "fall_time")),
    *(error_of(name, *told) for name, told in ERRORS.items()),
    Quantity("ending", "", "1", "how the motion ended", DECISION,
             "horizon: the duration was over; fell: the tilt reached fall_tilt; edge_change: the tilt reached 0, where "
             "a disk with a rim comes down on its other edge",
             "i1", {HORIZON: "horizon", FELL: "fell", EDGE_CHANGE: "edge_change"}),
    Quantity("end_time", "t_f", "s", "time until the motion came to its end", TRAJECTORY["tilt"].tolerance,
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
    # beside a pole the heading turns at once: only the motion itself knows what is close
    turning=(),
    keywords="rolling body of revolution, torus, coin, nonholonomic dynamics, trajectory, contact forces",
    sample_size=250,
    called="body",
    rolls_on=lambda body: has_poles(body.body),
)
