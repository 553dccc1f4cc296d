"""Kinds of motions, with their words and variables; the kinds for the disk without and with losses.

A model names its kind of motions in `Model.motion`; `kind_of_model` returns it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from importlib import import_module
from typing import Any

from kernels.disk.endings import FELL, HORIZON
from kernels.lossy_disk import endings as code
from kernels.lossy_disk.arrays import LOSSES
from sweep.model.description import Model
from sweep.model.disk.model import DISK
from sweep.model.disk.tables import PARAMETERS, SETTINGS, VARIABLES
from sweep.model.lossy_disk import tables as lossy
from sweep.model.lossy_disk.model import LOSSY_DISK
from sweep.model.quantity import (
    DECISION,
    ERROR_GAUGE,
    GRID,
    Input,
    Quantity,
    Tolerance,
    Word,
    positive,
    table,
)

#: The only dimension. Not called time: CF checkers require a calendar date for that name.
TIME = Quantity("elapsed_time", "t", "s", "time since the start", GRID)


@dataclass(frozen=True)
class MotionKind:
    """The motions of one model.

    Attributes
    ----------
    model : Model
    inputs : mapping of str to Input
        The words of a request whose values are numbers: the parameters of the model first.
    words : mapping of str to Word
        The words whose values are text.
    variables : mapping of str to Quantity
        The variables of the file; those with a value for each sample have the dimension elapsed_time.
    fixed : tuple of str
        Inputs that are scalar coordinates in the file; the start is the first sample.
    largest_tilt : str
        The input that limits the tilt of a motion; empty if the model has no tilt, and so no films.
    ending_time : str
        The variable with the time [s] at which the motion ended before its duration.
    endings : mapping of str to str
        Flag of the variable ending -> its description in words.
    headline : str
        The default title of a motion.
    summary : str
        The summary in the attributes of the file.
    path : str
        The module whose ``follow`` integrates a motion; its ``KERNELS`` are the kernels that every motion needs.
    kernels : str
        The module of the compiled functions that integrate it.
    figure : str
        ``module:function`` that draws one motion.
    peaks, results : tuple of str
        Variables whose largest magnitude, or whose last value, reports show.
    stops : bool
        Whether a motion ends by itself: its samples get closer towards the end, and a film that is too short for all of
        it shows the end.
    turning : tuple of str
        Angles whose changes show whether samples are close enough for figures; empty if the angles do not show it.
    keywords : str
        The keywords in the attributes of the file.
    sample_size : int
        Bytes per sample, in memory or in the file.
    time : Quantity
        The only dimension.
    called : str
        The name of the moving body in sentences.
    rolls_on : callable
        (request) -> whether no tilt ends its motion.
    """

    model: Model
    inputs: Mapping[str, Input]
    words: Mapping[str, Word]
    variables: Mapping[str, Quantity]
    fixed: tuple[str, ...]
    largest_tilt: str
    ending_time: str
    endings: Mapping[str, str]
    headline: str
    summary: str
    path: str
    kernels: str
    figure: str
    peaks: tuple[str, ...] = ("tilt",)
    results: tuple[str, ...] = ()
    stops: bool = False
    turning: tuple[str, ...] = ("tilt", "heading", "roll_angle")
    keywords: str = "rolling disk, Euler's disk, nonholonomic dynamics, trajectory, contact forces"
    sample_size: int = 180
    time: Quantity = TIME
    called: str = "disk"
    rolls_on: Callable[[Any], bool] = lambda request: False

    @property
    def rows(self) -> tuple[Input | Word, ...]:
        """The rows of both tables of words."""
        return (*self.inputs.values(), *self.words.values())

    @property
    def names(self) -> tuple[str, ...]:
        """All words of a request."""
        return tuple(dict.fromkeys((*self.inputs, *self.words, *self.model.substitutes)))


@lru_cache(maxsize=64)
def kind_of_model(model: Model) -> MotionKind:
    """Return the kind of motions of a model: `Model.motion` names it, or a function that makes it."""
    module, _, name = model.motion.partition(":")
    found = getattr(import_module(module), name)
    kind: MotionKind = found if isinstance(found, MotionKind) else found(model)
    return kind


#: The methods of integration: by the kernels, and by SciPy for comparison.
MOTION_METHODS = ("rk4", "dop853")

ROLLS, SLIPS, LIFTS = 0, 1, 2

_EXACT = VARIABLES["ending"].tolerance
_STATE = Tolerance(1e-8, 1e-8, "the report's motions agree with an integrator of order 8 to this accuracy")
_FORCE = Tolerance(1e-6, 1e-6, "forces depend on the squares of rates and a second derivative")


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
        "interval", r"\Delta t", "s", "longest time between samples", GRID,
        default="auto", rule="interval > 0, or auto", allows=positive, words=("auto",),
    ),
    replace(SETTINGS["step"], long_name="longest time step"),
    SETTINGS["fall_tilt"],
)  # fmt: skip

MOTION_WORDS: Mapping[str, Word] = table(
    Word("title", "title of the motion, in one line", ""),
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
    Quantity("heading", r"\psi", "rad", "heading, continuous from 0", _STATE,
             "the disk rolls towards (-sin heading, cos heading) while its roll rate is positive"),
    Quantity("roll_angle", r"\phi", "rad", "roll angle about the axis of the disk, continuous from 0", _STATE),
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
             "not conserved: the contact point does not move parallel to the velocity of the centre"),
    Quantity("vertical_momentum_rate", r"m R^2 \dot\phi\,\dot\theta\cos\theta", "kg m2 s-2",
             "right-hand side of the balance law of the vertical momentum", _STATE,
             "mass radius^2 roll_rate tilt_rate cos(tilt)"),
    Quantity("vertical_momentum_residual", r"\delta H", "kg m2 s-1",
             "change of the vertical momentum minus the integral of its rate", ERROR_GAUGE,
             "zero for the exact motion: a check of the balance law"),
    Quantity("normal_force", "N", "N", "normal force of the plane on the disk", _FORCE),
    Quantity("friction_across", r"\lambda_1", "N", "horizontal force across the track", _FORCE,
             "towards (cos heading, sin heading); multiplier of the first constraint"),
    Quantity("friction_along", r"\lambda_2", "N", "horizontal force along the track", _FORCE,
             "towards (-sin heading, cos heading); multiplier of the second constraint"),
    Quantity("friction_needed", r"\mu", "1", "friction coefficient needed to roll without slipping", _FORCE,
             "horizontal over normal force; missing where the normal force is not positive"),
    Quantity("contact", "", "1", "whether rolling without slipping is possible", _EXACT,
             "the computed motion never slips; slips: it would need more than the friction coefficient; lifts_off: the "
             "plane would have to pull",
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
    # a new parameter of the disk is also a coordinate of the file
    fixed=(*(name for name in PARAMETERS if name not in TRAJECTORY), "mass", "friction"),
    largest_tilt="fall_tilt",
    ending_time="fall_time",
    endings={"fell": "fell"},
    headline="Motion of a rolling disk",
    summary="One motion of a thin rigid disk that rolls without slipping on a horizontal plane: tilt and rates, path "
    "of the contact point, energy, vertical angular momentum with its balance law, and contact forces.",
    path="sweep.motion.disk_path",
    kernels="kernels.disk.trajectory",
    figure="sweep.figures.disk.motion_plots:figure",
)


_LOSSY_STATE = Tolerance(
    1e-6, 1e-6, "a motion of a thousand turns keeps its energy to 1e-8, but its phase less well"
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

#: The words of a request for one motion whose values are numbers.
LOSSY_INPUTS: Mapping[str, Input] = table(
    *lossy.PARAMETERS.values(),
    replace(lossy.SETTINGS["duration"], long_name="longest time simulated: the motion may end earlier"),
    MOTION_INPUTS["interval"],
    replace(lossy.SETTINGS["step"], long_name="longest time step"),
    lossy.SETTINGS["flat_tilt"],
)

LOSSY_WORDS: Mapping[str, Word] = table(
    Word("title", "title of the motion, in one line", ""),
    Word("method", "how the motion is integrated", MOTION_METHODS[0], MOTION_METHODS[:1]),
    lossy.OPTIONS["air_law"],
)

#: Variables with the same meaning as without losses; phases are less accurate after many turns.
_SAME = (
    "tilt", "tilt_rate", "precession_rate", "roll_rate", "heading", "roll_angle", "contact_x", "contact_y",
    "centre_x", "centre_y", "centre_z", "energy",
)  # fmt: skip
_FORCES = ("normal_force", "friction_across", "friction_along", "friction_needed")


def _loss(name: str) -> Quantity:
    return Quantity(
        name, f"W_{{{name[:4]}}}", "J", f"energy that {LAWS[name]} has taken since the start", _LOSSY_STATE
    )


# fmt: off
LOSSY_TRAJECTORY: Mapping[str, Quantity] = table(
    *(replace(TRAJECTORY[name], tolerance=_LOSSY_STATE) for name in _SAME),
    Quantity("inclination", "a", "rad", "angle between the disk and the plane", _LOSSY_STATE,
             "90 deg - |tilt|: 0 = flat"),
    *map(_loss, LOSSES),
    Quantity("energy_imbalance", r"\delta E", "1", "change of energy plus losses since the start, over m g R",
             ERROR_GAUGE, "0 for the exact motion, so this is an error of the integration"),
    *(TRAJECTORY[name] for name in _FORCES),
    Quantity("held", "", "1", "rates that dry friction holds at 0", DECISION,
             "sum of 1: contour friction holds the roll rate at the rim; 2: pivoting friction holds the rotation about "
             "the vertical; 4: rolling friction holds tilt and roll; 0: dry friction holds nothing", "i1"),
    Quantity("ending", "", "1", "how the motion ended", DECISION,
             "flat: the tilt reached flat_tilt; rest: held by dry friction, forever; horizon: the duration was over; "
             "lift_off: the normal force vanished; slip: rolling needed more than the friction coefficient", "i1",
             {code.FLAT: "flat", code.REST: "rest", code.HORIZON: "horizon", code.LIFT_OFF: "lift_off",
              code.SLIP: "slip"}),
    Quantity("end_time", "t_f", "s", "time until the motion ended", _LOSSY_STATE,
             "missing where the duration was over first: ending is horizon"),
)
# fmt: on

LOSSY_MOTION = MotionKind(
    model=LOSSY_DISK,
    inputs=LOSSY_INPUTS,
    words=LOSSY_WORDS,
    variables=LOSSY_TRAJECTORY,
    fixed=(*(name for name in lossy.PARAMETERS if name not in TRAJECTORY),),
    largest_tilt="flat_tilt",
    ending_time="end_time",
    endings={"flat": "flat", "rest": "came to rest", "lift off": "lifted off", "slip": "slipped"},
    headline="Motion of a disk that loses energy",
    summary="One motion of a thin rigid disk that rolls without slipping on a horizontal plane and loses energy to "
    "friction and air: tilt and rates, path of the contact point, energy, the energy that each law has taken, and "
    "contact forces.",
    path="sweep.motion.lossy_path",
    kernels="kernels.lossy_disk.trajectory",
    figure="sweep.figures.disk.stopping_plots:figure",
    stops=True,
)
