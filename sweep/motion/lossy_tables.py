"""The kinds of motions with losses, for the disk and other bodies: words and variables (`sweep.motion.tables`)."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from kernels.lossy_disk import endings as code
from kernels.lossy_disk.arrays import LOSSES
from sweep.model.description import Model
from sweep.model.lossy_bodies.model import LOSSY_BODIES
from sweep.model.lossy_disk.model import LOSSY_DISK
from sweep.model.quantity import DECISION, ERROR_GAUGE, Quantity, Tolerance, table
from sweep.motion.tables import (
    BODY_MOTION,
    ERRORS,
    MOTION_INPUTS,
    SHAPE_WORDS,
    TITLE,
    TRAJECTORY,
    MotionKind,
    error_rows,
    stated,
)

#: Bits of the variable held.
HELD_ROLL, HELD_TURN, HELD_TILT = 1, 2, 4

#: Loss -> the parameter that it is proportional to, and its unit.
COEFFICIENTS: Mapping[str, tuple[str, str]] = {
    "rolling_loss": ("rolling_friction", "m"),
    "pivoting_loss": ("pivoting_friction", "m"),
    "contour_loss": ("contour_friction", "m"),
    "damping_loss": ("contour_damping", "N m s"),
}

#: Loss -> its cause, as part of a sentence.
LAWS: Mapping[str, str] = {
    "rolling_loss": "rolling friction",
    "pivoting_loss": "pivoting friction",
    "contour_loss": "contour friction",
    "damping_loss": "viscous contour friction",
    "air_loss": "the drag of air",
}
assert tuple(LAWS) == LOSSES

#: Stated errors, as in `sweep.motion.tables.ERRORS`.
LOSSY_ERRORS = {
    **ERRORS,
    "energy_error": ("J", "stated error of the energy and of each loss", (*LAWS, "energy")),
}
_WITHIN = stated(LOSSY_ERRORS)
_LATER = Tolerance(1e-6, 1e-6, "the phase of a motion of a thousand turns is less well known than its energy")

#: Variables with the same meaning as without losses.
_SAME = (
    "tilt", "tilt_rate", "precession_rate", "roll_rate", "heading", "roll_angle", "contact_x", "contact_y",
    "centre_x", "centre_y", "centre_z", "energy",
)  # fmt: skip
_FORCES = ("normal_force", "friction_across", "friction_along", "friction_needed")


def _loss(name: str) -> Quantity:
    words = f"energy that {LAWS[name]} has taken since the start"
    return Quantity(name, f"W_{{{name[:4]}}}", "J", words, _WITHIN[name])


# fmt: off
#: The variables of the file of one motion; all but the last two have the dimension elapsed_time.
LOSSY_TRAJECTORY: Mapping[str, Quantity] = table(
    *(replace(TRAJECTORY[name], tolerance=_WITHIN[name]) for name in _SAME),
    Quantity("inclination", "a", "rad", "angle between the axis of the body and the vertical", _WITHIN["inclination"],
             "90 deg - |tilt|: 0 = flat"),
    *map(_loss, LOSSES),
    Quantity("energy_imbalance", r"\delta E", "1", "change of energy plus losses since the start, over m g R",
             ERROR_GAUGE, "0 for the exact motion, so this is an error of the integration"),
    *(TRAJECTORY[name] for name in _FORCES),
    Quantity("held", "", "1", "rates that dry friction holds at 0", DECISION,
             "sum of 1: contour friction holds the roll rate; 2: pivoting friction holds the "
             "rotation about the vertical; 4: rolling friction holds tilt and roll; 0: dry friction holds nothing",
             "i1"),
    *error_rows(LOSSY_ERRORS),
    Quantity("ending", "", "1", "how the motion ended", DECISION,
             "flat: the tilt reached flat_tilt; rest: held by dry friction, forever; horizon: the duration was over; "
             "lift_off: the normal force vanished; slip: rolling needed more than the friction coefficient; "
             "edge_change: the tilt reached 0, where the other edge of a disk with a rim hits the plane", "i1",
             {code.FLAT: "flat", code.REST: "rest", code.HORIZON: "horizon", code.LIFT_OFF: "lift_off",
              code.SLIP: "slip", code.EDGE_CHANGE: "edge_change"}),
    replace(TRAJECTORY["end_time"], tolerance=_LATER),
)
# fmt: on


def _kind(model: Model, **more: Any) -> MotionKind:
    """Return the kind of the motions of a model with losses; `more` are further attributes."""
    options = [option for name, option in model.options.items() if name in (*SHAPE_WORDS, "air_law")]
    longest = replace(MOTION_INPUTS["duration"], default=model.settings["duration"].default)
    return MotionKind(
        model=model,
        inputs=table(
            *model.parameters.values(),
            replace(longest, long_name="longest time simulated: the motion may end earlier"),
            MOTION_INPUTS["interval"],
            MOTION_INPUTS["step"],
            model.settings["flat_tilt"],
        ),
        words=table(TITLE, *options),
        variables=LOSSY_TRAJECTORY,
        fixed=tuple(name for name in model.parameters if name not in LOSSY_TRAJECTORY),
        largest_tilt="flat_tilt",
        ending_time="end_time",
        endings={
            "flat": "flat",
            "rest": "came to rest",
            "lift off": "lifted off",
            "slip": "slipped",
            "edge change": BODY_MOTION.endings["edge change"],
        },
        path="sweep.motion.lossy_path",
        figure="sweep.figures.disk.stopping_plots:figure",
        stops=True,
        sample_size=300,
        **more,
    )


_TELLS = (
    "that rolls without slipping on a horizontal plane and loses energy to friction and air: tilt and rates, path of "
    "contact point and centre of mass, energy, the energy that each law has taken, and contact forces, with stated "
    "errors."
)

LOSSY_MOTION = _kind(
    LOSSY_DISK,
    kernels=("kernels.lossy_disk.trajectory",),
    headline="Motion of a disk that loses energy",
    summary=f"One motion of a thin rigid disk {_TELLS}",
)

LOSSY_BODY_MOTION = _kind(
    LOSSY_BODIES,
    kernels=("kernels.lossy_bodies.trajectory",),
    headline="Motion of a body of revolution that loses energy",
    summary=f"One motion of a body of revolution {_TELLS}",
    keywords="rolling body of revolution, torus, Euler's disk, dissipation, dry friction, trajectory, contact forces",
    called="body",
)
