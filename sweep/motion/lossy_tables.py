"""The words and the variables of one motion of the disk with losses."""

from collections.abc import Mapping
from dataclasses import replace

from kernels.lossy_disk import endings as code
from kernels.lossy_disk.arrays import LOSSES
from sweep.model.lossy_disk.model import LOSSY_DISK
from sweep.model.lossy_disk.tables import OPTIONS, PARAMETERS, SETTINGS
from sweep.model.quantity import DECISION, ERROR_GAUGE, Input, Quantity, Tolerance, Word, table
from sweep.motion.disk_tables import MOTION_INPUTS, MOTION_METHODS, TRAJECTORY
from sweep.motion.kind import MotionKind

_STATE = Tolerance(
    1e-6, 1e-6, "a motion of a thousand turns keeps its energy to 1e-8, and its phase less well"
)

#: Bits of what dry friction holds.
HELD_ROLL, HELD_TURN, HELD_TILT = 1, 2, 4

#: Loss -> the parameter that it is proportional to, and its unit.
COEFFICIENTS: Mapping[str, tuple[str, str]] = {
    "rolling_loss": ("rolling_friction", "m"),
    "pivoting_loss": ("pivoting_friction", "m"),
    "contour_loss": ("contour_friction", "m"),
    "damping_loss": ("contour_damping", "N m s"),
}

#: Loss -> what takes it, as part of a sentence.
LAWS: Mapping[str, str] = {
    "rolling_loss": "rolling friction",
    "pivoting_loss": "pivoting friction",
    "contour_loss": "contour friction",
    "damping_loss": "viscous contour friction",
    "air_loss": "the drag of air",
}
assert tuple(LAWS) == LOSSES

#: The words of a request for one motion whose values are numbers.
LOSSY_INPUTS: Mapping[str, Input] = table(
    *PARAMETERS.values(),
    replace(SETTINGS["duration"], long_name="longest time simulated: the motion may end before"),
    MOTION_INPUTS["interval"],
    replace(SETTINGS["step"], long_name="longest time step"),
    SETTINGS["flat_tilt"],
)

LOSSY_WORDS: Mapping[str, Word] = table(
    Word("title", "what the motion is, in one line", ""),
    Word("method", "how the motion is integrated", MOTION_METHODS[0], MOTION_METHODS[:1]),
    OPTIONS["air_law"],
)

#: What means the same in a motion without losses; phases are less well known after many turns.
_SAME = (
    "tilt", "tilt_rate", "precession_rate", "roll_rate", "heading", "roll_angle", "contact_x", "contact_y",
    "centre_x", "centre_y", "centre_z", "energy",
)  # fmt: skip
_FORCES = ("normal_force", "friction_across", "friction_along", "friction_needed")


def _loss(name: str) -> Quantity:
    return Quantity(
        name, f"W_{{{name[:4]}}}", "J", f"energy that {LAWS[name]} has taken since the start", _STATE
    )


# fmt: off
LOSSY_TRAJECTORY: Mapping[str, Quantity] = table(
    *(replace(TRAJECTORY[name], tolerance=_STATE) for name in _SAME),
    Quantity("inclination", "a", "rad", "angle between the disk and the plane", _STATE, "90 deg - |tilt|: 0 = flat"),
    *map(_loss, LOSSES),
    Quantity("energy_imbalance", r"\delta E", "1", "change of energy and losses together since the start over m g R",
             ERROR_GAUGE, "the losses of the exact motion are what its energy lacks, so this is an error"),
    *(TRAJECTORY[name] for name in _FORCES),
    Quantity("held", "", "1", "what dry friction holds", DECISION,
             "sum of 1: contour friction holds the roll rate at the rim, 2: pivoting friction holds the turn about the "
             "vertical, 4: rolling friction holds tilt and roll; 0 where all slides", "i1"),
    Quantity("ending", "", "1", "how the motion ended", DECISION,
             "flat: the tilt reached flat_tilt; rest: held by dry friction, for ever; horizon: the duration was over; "
             "lift_off: the normal force vanished; slip: rolling needed more than the friction coefficient", "i1",
             {code.FLAT: "flat", code.REST: "rest", code.HORIZON: "horizon", code.LIFT_OFF: "lift_off",
              code.SLIP: "slip"}),
    Quantity("end_time", "t_f", "s", "time until the motion came to its end", _STATE,
             "missing where the duration was over first: ending is horizon"),
)
# fmt: on

LOSSY_MOTION = MotionKind(
    model=LOSSY_DISK,
    inputs=LOSSY_INPUTS,
    words=LOSSY_WORDS,
    variables=LOSSY_TRAJECTORY,
    fixed=(*(name for name in PARAMETERS if name not in TRAJECTORY),),
    largest_tilt="flat_tilt",
    ending_time="end_time",
    endings={"flat": "flat", "rest": "came to rest", "lift off": "lifted off", "slip": "slipped"},
    headline="Motion of a disk that loses energy",
    summary="One motion of a thin rigid disk that rolls without slipping on a horizontal plane and loses energy to "
    "friction and air: tilt and rates, path of the contact point, energy and what each law of loss has taken, and "
    "contact forces.",
    kernels="kernels.lossy_disk.trajectory",
    figure="sweep.figures.disk.stopping_plots:figure",
    stops=True,
)
