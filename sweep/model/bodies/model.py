"""The model of bodies of revolution without losses."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from kernels.bodies import shapes
from kernels.disk import arrays
from sweep.model.bodies import tables, theory
from sweep.model.bodies.exact import (
    REDUCTION,
    BodyReduction,
    contact_of_bodies,
    kernel_of,
    path_of_bodies,
)
from sweep.model.bodies.shape import (
    all_on_end,
    check_no_fall,
    check_shape,
    complete,
    has_poles,
    may_be_on_end,
    on_end,
    with_body,
)
from sweep.model.description import Columns, Model, Request, Starts, Words
from sweep.model.disk import theory as of_disk
from sweep.model.disk.contact import contact_columns, slipping
from sweep.model.disk.exact import ExactReduction, reduce_bodies, without_vague
from sweep.model.disk.initial_conditions import check_steady_rates, circling
from sweep.model.disk.model import DISK, describe_motion, untimed
from sweep.model.disk.path import PATH_VARIABLES, call_by_body, path_columns
from sweep.model.kernel import Kernel
from sweep.model.quantity import Array, Quantity, Truths
from sweep.model.space_sample import SpaceSample


class Bodies(Model):
    """A body of revolution that rolls without slipping and without losses."""

    name = "bodies"
    parameters, settings, options = tables.PARAMETERS, tables.SETTINGS, tables.OPTIONS
    substitutes = tables.SUBSTITUTES
    methods = ("rk4", "exact")
    chosen_by, does_without = tables.CHOOSING, ("alpha",)
    endings, variables = tables.ENDINGS, tables.VARIABLES
    measures, counts = arrays.MEASURES, arrays.COUNTS
    coordinate, extremes, error_name, peak = DISK.coordinate, DISK.extremes, DISK.error_name, DISK.peak
    lost_name = "the body falls"
    presets = Path(__file__).with_name("presets")
    motion = "sweep.motion.tables:BODY_MOTION"
    trajectory, regimes = DISK.trajectory, DISK.regimes
    in_time = DISK.in_time
    integrate = Kernel("kernels.bodies.integrate", "integrate", seconds=8.0)
    words = Words(
        summary="Stability atlas of a body of revolution that rolls without slipping on a horizontal plane. For every "
        "start of a grid: the extreme tilts of the motion, {}, and the verdict of a criterion.",
        keywords="rolling body of revolution, torus, coin, nonholonomic dynamics, stability, parameter sweep",
        references="reduction: Chaplygin 1897; Borisov and Mamaev, Regul. Chaotic Dyn. 7 (2002) 177; equations: "
        "docs/bodies.md of this program",
    )
    synonyms = DISK.synonyms
    ambiguous = {  # noqa: RUF012 - the base class declares it a Mapping
        **{part: text for part, text in DISK.ambiguous.items() if part != "flat_tilt"},
        "alpha": "alpha is for the thin disk; write axial_moment and transverse_moment for a body, or leave both out.",
        "speed": "Write roll_rate: the distance of the contact point from the axis of a body is not constant.",
    }

    exact: BodyReduction = BodyReduction()
    additions = {  # noqa: RUF012 - likewise
        "path=yes": PATH_VARIABLES,
        "contact=yes": tables.CONTACT_VARIABLES,
        "method=exact": REDUCTION,
    }
    unknown_to = DISK.unknown_to

    def subject(self, spec: Request) -> tuple[str, str]:
        """Return the motion by the rates and the body of the spec, and its stability."""
        if all_on_end(spec):
            return f"Spinning on its end, a {spec.body}", "stability of the vertical axis"
        motion, question = describe_motion(spec, "body")
        article = "an" if tables.CALLED[spec.body][0] in "aeiou" else "a"
        return f"{motion}, {article} {tables.CALLED[spec.body]}", question

    def undisturbed(self, spec: Request, starts: Starts) -> Array:
        """Return the tilt [rad] of the undisturbed motion of each start: upright, circling, or a body on its end."""
        vertical = np.copysign(math.pi / 2, starts["tilt"])
        return np.where(on_end(spec, starts), vertical, DISK.undisturbed(spec, starts))

    def perturbation(self, spec: Request, starts: Starts) -> Array:
        """Return the size [rad] of the perturbation of each start.

        Notes
        -----
        sqrt((tilt - steady tilt)^2 + (tilt_rate / W)^2), with W^2 = gravity / ((1 + transverse moment) radius), as for
        the disk, whose transverse moment is alpha/2.
        """
        # an atlas has no coordinate for a moment that follows from the body
        known = starts if "transverse_moment" in starts else with_body(spec, starts)
        slow = np.sqrt((1.0 + known["transverse_moment"]) * starts["radius"] / starts["gravity"])
        return np.hypot(starts["tilt"] - self.undisturbed(spec, starts), starts["tilt_rate"] * slow)

    def drawn_of(self, spec: Request) -> str:
        """Return the variable of maps: the amplification for a body on its end, whose largest tilt is its start's."""
        return "amplification" if all_on_end(spec) else super().drawn_of(spec)

    def disturbed_motion(self, spec: Request, start: Mapping[str, float]) -> str:
        """Return the name of the undisturbed motion of a start."""
        if on_end(spec, start):
            return f"a {spec.body} that spins on its end, about the vertical"
        called = tables.CALLED[spec.body]
        return f"a {called} that circles at this tilt" if circling(spec) else f"the upright {called}"

    def methods_for(self, values: Mapping[str, Any]) -> tuple[str, ...]:
        """Return the methods for a body: RK4 loses the rates near the poles of a ball or a spheroid."""
        return ("exact",) if has_poles(values["body"]) else self.methods

    def check(self, values: Mapping[str, Any]) -> None:
        """Refuse words that do not determine the rates, and impossible bodies."""
        check_steady_rates(values)
        check_shape(values)
        check_no_fall(values, tables.SETTINGS["fall_tilt"])

    def cell_variables(self, spec: Request) -> Mapping[str, Quantity]:
        """Return the variables of an atlas; without time, the variables that need it have a remark on that."""
        variables = {
            **super().cell_variables(spec),
            **(PATH_VARIABLES if spec.path == "yes" else {}),
            **(tables.CONTACT_VARIABLES if spec.contact == "yes" else {}),
        }
        return untimed(variables) if spec.method == "exact" else variables

    def reference(self, size: int, seed: int | None = None) -> BodyReduction:
        """Return the reduction; if it made the atlas, it is checked with a sample of cells in space."""
        return BodyReduction(SpaceSample(size, seed))

    def kernels(self, spec: Request) -> tuple[Kernel, ...]:
        """Return the kernels of the method, and of path and contact forces if the spec asks for them."""
        names = [name for name, word in (("paths", spec.path), ("contact", spec.contact)) if word == "yes"]
        first = kernel_of(spec.body, "reduce") if spec.method == "exact" else self.integrator(spec)
        return (first, *(kernel_of(spec.body, name) for name in names))

    def complete(self, spec: Request, starts: Starts) -> Starts:
        """Return starts with the moments of their bodies, and the rates that keep the tilt of each cell constant."""
        return complete(spec, starts)

    def kernel_settings(self, spec: Request) -> Array:
        """Return the settings, and the number of the body."""
        return np.append(super().kernel_settings(spec), float(shapes.NAMES.index(spec.body)))

    def code(self, spec: Request) -> Sequence[str | Callable[..., Any]]:
        """Return the code that completes starts and makes settings, exact values, paths and contact forces."""
        return [
            "kernels.bodies.steady",
            "kernels.bodies.shapes",
            complete.__module__,
            Bodies.kernel_settings,
            ExactReduction.measures,
            BodyReduction.rows,
            reduce_bodies,
            without_vague,
            path_of_bodies,
            path_columns,
            call_by_body,
            contact_columns,
            contact_of_bodies,
        ]

    def measure_more(self, spec: Request, starts: Starts, measured: Columns) -> Columns:
        """Return the paths of the contact points and the extremes of the contact forces, if the spec asks for them."""
        return {
            **(path_of_bodies(spec, starts) if spec.path == "yes" else {}),
            **(contact_of_bodies(spec, starts) if spec.contact == "yes" else {}),
        }

    def slipping(self, dataset: Any, friction: float) -> Any:
        """Return which cells need more friction than a coefficient, or lift off."""
        return slipping(dataset, friction)

    def derive(self, starts: Starts, measured: Columns) -> Columns:
        """Return the peak tilt."""
        return DISK.derive(starts, measured)

    def may_be_lost(self, spec: Request, measured: Columns, error: Array) -> Truths:
        """Return which cells reach fall_tilt within the error."""
        if has_poles(spec.body):
            return np.zeros(error.shape, bool)
        return DISK.may_be_lost(spec, measured, error)

    def lines(self, spec: Request, axis: str, starts: Starts) -> dict[str, tuple[Array, Array]]:
        """Return the critical lines and the lines predicted for the criterion; see `sweep.model.disk.theory.lines`."""
        ends = on_end(spec, starts)
        if ends.all():
            return theory.pole_lines(spec, axis, starts)
        if not theory.has_steady_motion(spec):
            return {}
        edges = of_disk.lines(spec, axis, starts, theory.FORMULAS)
        if not circling(spec):
            # upright, a prolate spheroid is stable at every rate
            edges = {edge: both for edge, both in edges.items() if np.isfinite(both[0]).any()}
        if not spec.criterion.limits_reach:
            edges = {
                edge: (critical, np.full_like(critical, np.nan)) for edge, (critical, _) in edges.items()
            }
        return theory.of_both(ends, theory.pole_lines(spec, axis, starts), edges) if ends.any() else edges

    def line_label(self, spec: Request, axis: str) -> str:
        """Return the formula of the squared critical rate, or k = 0."""
        if all_on_end(spec):
            return theory.critical_pole_square(spec) if axis == "roll_rate" else ""
        # one formula for all rows, or none
        if not theory.has_steady_motion(spec) or may_be_on_end(spec):
            return ""
        return "k = 0" if circling(spec) else theory.critical_square(spec, axis)

    def unit_of_square(self, spec: Request, axis: str) -> tuple[float, str] | None:
        """Return g/R, the unit of squared rates."""
        return DISK.unit_of_square(spec, axis)

    def lost_in_words(self, spec: Request, stored: Mapping[str, float]) -> str:
        """Return when the body fell."""
        return DISK.lost_in_words(spec, stored)

    def open_in_words(self, spec: Request, stored: Mapping[str, float]) -> str:
        """Return what ended a motion too early for a verdict."""
        if self.endings.among(np.array(stored["ending"]), "edge_change"):
            return self.endings.of(stored["ending"]).reason
        return super().open_in_words(spec, stored)

    def reason_without_verdicts(self, spec: Request) -> str:
        """Return that a body with two edges has no steady upright motion, and the presets with a steady motion."""
        if all_on_end(spec) or theory.has_steady_motion(spec):
            return ""
        return (
            f"a {tables.CALLED[spec.body]} has no steady upright motion, and the model does not follow a motion past a "
            "tilt of 0. The presets thick_coin and true_edge disturb a circling body (roll_rate=steady or wobble); "
            "the presets rolling, spinning and torus disturb an upright one"
        )

    def linear_prediction(
        self, spec: Request, start: Mapping[str, float], stored: Mapping[str, float]
    ) -> Iterable[str]:
        """Return the prediction of small oscillations about the steady motion for a cell."""
        if on_end(spec, start):
            return (theory.pole_prediction(spec, start),)
        if not theory.has_steady_motion(spec):
            return (f"linear      no prediction: a {tables.CALLED[spec.body]} has no steady upright motion",)
        return of_disk.linear_prediction(spec, start, stored, theory.FORMULAS)


BODIES = Bodies()
