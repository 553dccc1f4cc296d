"""Kinds of motions, with their words and variables; the kinds for the disk and other bodies without losses.

A model names its kind of motions in `Model.motion`; `kind_of_model` returns it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from importlib import import_module
from typing import Any

from kernels.disk.endings import EDGE_CHANGE, FELL, HORIZON
from sweep.model.bodies.model import BODIES
from sweep.model.bodies.shape import has_poles
from sweep.model.description import Model
from sweep.model.disk.model import DISK
from sweep.model.quantity import (
    DECISION,
    DURATION,
    ERROR_GAUGE,
    GRID,
    STEP,
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
        The module whose ``follow`` integrates a motion.
    kernels : tuple of str
        The modules of the compiled functions that integrate it.
    method : str
        The method of integration.
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
    kernels: tuple[str, ...]
    figure: str
    method: str = "rk4"
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


ROLLS, SLIPS, LIFTS = 0, 1, 2

#: Words of the requests for motions of the disk and other bodies; models of bodies add `SHAPE_WORDS`.
TITLE = Word("title", "title of the motion, in one line", "")
SHAPE_WORDS = ("body", "filling")

#: The words of a request for one motion whose values are numbers, besides the parameters of its model.
MOTION_INPUTS: Mapping[str, Input] = table(
    Input("mass", "m", "kg", "mass", GRID, default=1.0, rule="mass > 0", allows=positive),
    Input(
        "friction", r"\mu", "1", "friction coefficient of the contact", GRID,
        default=0.5, rule="friction > 0", allows=positive,
    ),
    replace(DURATION, long_name="time simulated", default=10.0),
    Input(
        "interval", r"\Delta t", "s", "longest time between samples", GRID,
        default="auto", rule="interval > 0, or auto", allows=positive, words=("auto",),
    ),
    replace(STEP, long_name="longest time step"),
)  # fmt: skip

#: Stated error -> its unit, its description, and the variables that have it.
ERRORS: Mapping[str, tuple[str, str, tuple[str, ...]]] = {
    "orientation_error": (
        "rad", "stated error of the orientation, as an angle", ("tilt", "heading", "roll_angle", "inclination"),
    ),
    "path_error": (
        "m", "stated error of contact point and centre of mass, as a distance",
        ("contact_x", "contact_y", "centre_x", "centre_y", "centre_z"),
    ),
    "rate_error": (
        "rad s-1", "stated error of the angular velocity", ("tilt_rate", "precession_rate", "roll_rate"),
    ),
    "force_error": (
        "N", "stated error of the contact force", ("normal_force", "friction_across", "friction_along"),
    ),
}  # fmt: skip


def stated(rows: Mapping[str, tuple[str, str, tuple[str, ...]]]) -> dict[str, Tolerance]:
    """Return the tolerance of each variable that has a stated error."""
    why = "each value is within its stated error"
    return {name: Tolerance(1e-9, 1e-9, why, error) for error, row in rows.items() for name in row[2]}


def error_rows(rows: Mapping[str, tuple[str, str, tuple[str, ...]]]) -> tuple[Quantity, ...]:
    """Return the variables of stated errors."""
    origin = "from the largest difference so far of two integrations with different steps"
    return tuple(
        Quantity(name, "", units, words, ERROR_GAUGE, origin, "f4")
        for name, (units, words, _) in rows.items()
    )


_WITHIN = stated(ERRORS)
_STATE = Tolerance(1e-8, 1e-8, "motions agree with an integrator of order 8 to this accuracy")
_FORCE = Tolerance(1e-6, 1e-6, "forces depend on the squares of rates and a second derivative")

# fmt: off
#: The variables of the file of one motion; all but the last two have the dimension elapsed_time.
TRAJECTORY: Mapping[str, Quantity] = table(
    Quantity("tilt", r"\theta", "rad", "tilt of the axis of the body from the horizontal", _WITHIN["tilt"],
             "0 = upright; positive towards (cos heading, sin heading)"),
    Quantity("tilt_rate", r"\dot\theta", "rad s-1", "rate of the tilt", _WITHIN["tilt_rate"]),
    Quantity("precession_rate", r"\dot\psi", "rad s-1", "rate of the heading about the vertical",
             _WITHIN["precession_rate"]),
    Quantity("roll_rate", r"\dot\phi", "rad s-1", "rate of roll about the axis of the body, in the precessing frame",
             _WITHIN["roll_rate"]),
    Quantity("heading", r"\psi", "rad", "heading, continuous from 0", _WITHIN["heading"],
             "the body rolls towards (-sin heading, cos heading) while its roll rate is positive; next to a pole it "
             "jumps by half a turn, and its error is orientation_error over cos(tilt); if the body passes a pole "
             "within that error, the heading may have turned the other way"),
    Quantity("roll_angle", r"\phi", "rad", "roll angle about the axis of the body, continuous from 0",
             _WITHIN["roll_angle"]),
    Quantity("contact_x", "", "m", "x of the contact point on the plane", _WITHIN["contact_x"]),
    Quantity("contact_y", "", "m", "y of the contact point on the plane", _WITHIN["contact_y"]),
    Quantity("centre_x", "x_c", "m", "x of the centre of mass", _WITHIN["centre_x"]),
    Quantity("centre_y", "y_c", "m", "y of the centre of mass", _WITHIN["centre_y"]),
    Quantity("centre_z", "z_c", "m", "height of the centre of mass over the plane", _WITHIN["centre_z"]),
    Quantity("energy", "E", "J", "energy, kinetic and potential", _STATE),
    Quantity("energy_drift", r"\Delta E/E", "1", "relative change of the energy since the start", ERROR_GAUGE,
             "the exact motion conserves energy, so this is an error of the integration"),
    Quantity("vertical_momentum", r"H\cdot e_3", "kg m2 s-1",
             "vertical angular momentum about the contact point", _STATE,
             "not conserved: the contact point does not move parallel to the velocity of the centre"),
    Quantity("vertical_momentum_rate", "", "kg m2 s-2",
             "right-hand side of the balance law of the vertical momentum", _STATE,
             "mass times tilt_rate times (height of the centre of mass times the speed of the contact point along the "
             "track, minus radius of curvature times the speed of the centre of mass); for a thin disk mass radius^2 "
             "roll_rate tilt_rate cos(tilt)"),
    Quantity("vertical_momentum_residual", r"\delta H", "kg m2 s-1",
             "change of the vertical momentum minus the integral of its rate", ERROR_GAUGE,
             "zero for the exact motion: a check of the balance law"),
    Quantity("normal_force", "N", "N", "normal force of the plane on the body", _WITHIN["normal_force"]),
    Quantity("friction_across", r"\lambda_1", "N", "horizontal force across the track", _WITHIN["friction_across"],
             "towards (cos heading, sin heading); multiplier of the first constraint"),
    Quantity("friction_along", r"\lambda_2", "N", "horizontal force along the track", _WITHIN["friction_along"],
             "towards (-sin heading, cos heading); multiplier of the second constraint"),
    Quantity("friction_needed", r"\mu", "1", "friction coefficient needed to roll without slipping", _FORCE,
             "horizontal over normal force; missing where the normal force is not positive"),
    Quantity("contact", "", "1", "whether rolling without slipping is possible", DECISION,
             "the computed motion never slips; slips: it would need more than the friction coefficient; lifts_off: the "
             "plane would have to pull",
             "i1", {ROLLS: "rolls", SLIPS: "slips", LIFTS: "lifts_off"}),
    *error_rows(ERRORS),
    Quantity("ending", "", "1", "how the motion ended", DECISION,
             "horizon: the duration was over; fell: the tilt reached fall_tilt; edge_change: the tilt reached 0, where "
             "the other edge of a disk with a rim hits the plane",
             "i1", {HORIZON: "horizon", FELL: "fell", EDGE_CHANGE: "edge_change"}),
    Quantity("end_time", "t_f", "s", "time until the motion ended", _STATE,
             "missing where the duration was over first: ending is horizon"),
)
# fmt: on


def _kind(model: Model, **more: Any) -> MotionKind:
    """Return the kind of the motions of a model without losses; `more` are further attributes."""
    options = [option for name, option in model.options.items() if name in SHAPE_WORDS]
    return MotionKind(
        model=model,
        inputs=table(*model.parameters.values(), *MOTION_INPUTS.values(), model.settings["fall_tilt"]),
        words=table(TITLE, *options),
        variables=TRAJECTORY,
        # a new parameter of the model is also a coordinate of the file
        fixed=(*(name for name in model.parameters if name not in TRAJECTORY), "mass", "friction"),
        largest_tilt="fall_tilt",
        ending_time="end_time",
        endings={"fell": "fell", "edge change": "came down on its other edge"},
        path="sweep.motion.free_path",
        figure="sweep.figures.disk.motion_plots:figure",
        sample_size=250,
        **more,
    )


_TELLS = (
    "that rolls without slipping on a horizontal plane: tilt and rates, path of contact point and centre of mass, "
    "energy, vertical angular momentum with its balance law, and contact forces, with stated errors."
)

DISK_MOTION = _kind(
    DISK,
    kernels=("kernels.bodies.trajectory",),
    headline="Motion of a rolling disk",
    summary=f"One motion of a thin rigid disk {_TELLS}",
)

BODY_MOTION = _kind(
    BODIES,
    kernels=("kernels.bodies.trajectory", "kernels.bodies.poles.trajectory"),
    headline="Motion of a body of revolution",
    summary=f"One motion of a body of revolution {_TELLS}",
    keywords="rolling body of revolution, torus, coin, nonholonomic dynamics, trajectory, contact forces",
    called="body",
    rolls_on=lambda body: has_poles(body.body),
)
