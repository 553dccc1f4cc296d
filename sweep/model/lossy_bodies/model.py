"""Bodies of revolution with losses: the disk with losses, with another body."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from kernels.bodies import shapes
from sweep.errors import RequestError
from sweep.model.bodies.model import BODIES
from sweep.model.bodies.shape import check_shape, complete
from sweep.model.bodies.tables import CALLED
from sweep.model.description import LineWords, Reference, Request, Starts, Words
from sweep.model.disk.initial_conditions import check_steady_rates
from sweep.model.lossy_bodies import tables, theory
from sweep.model.lossy_bodies.mechanics import MECHANICS
from sweep.model.lossy_disk.audit import SampledAudit
from sweep.model.lossy_disk.model import LOSSY_DISK, LossyDisk, check_losses, integrator, with_constants
from sweep.model.lossy_disk.tables import LOSSES, NO_AIR, some
from sweep.model.quantity import Array
from sweep.model.rows import LARGEST, told, worst_cases


def check_body(values: Mapping[str, Any]) -> None:
    """Refuse bodies for which a loss is not derived.

    Parameters
    ----------
    values : mapping of str to value
        Of every word of a request.

    Raises
    ------
    RequestError
    """
    body = str(values["body"])
    for name, nothing in (("air_law", NO_AIR), ("air_viscosity", "0"), ("air_density", "0")):
        given = values[name] != NO_AIR if name == "air_law" else some(values[name])
        if given and body not in tables.FACED:
            raise RequestError(
                f"The laws of the air are those of a film and a layer under a flat face, and a {CALLED[body]} has "
                f"none; got body={body} {name}={values[name]}.",
                hint=f"Say {name}={nothing}, or body={' or body='.join(tables.FACED)}.",
                where=name,
            )
    for faced, name, whole in (("rounded", "thickness", 2.0), ("rim", "fillet", 1.0), ("arc", "fillet", 1.0)):
        if body == faced and (wrong := worst_cases(values, {name: LARGEST})[name] >= whole).any():
            raise RequestError(
                f"A {CALLED[body]} has no face left to lie on: with losses {name} < {whole:g}, in radii; got "
                f"{told(values, wrong, name)}.",
                hint=f"Give a smaller {name}.",
                where=name,
            )


class LossyBodies(LossyDisk):
    """A body of revolution that rolls without slipping, against friction of its contact and drag of the air."""

    name = "lossy_bodies"
    parameters, settings, options = tables.PARAMETERS, tables.SETTINGS, tables.OPTIONS
    substitutes = tables.SUBSTITUTES
    # words of losses beside those of a body do: `sweep.model.registry.chosen`
    chosen_by: tuple[str, ...] = ()
    does_without = ("alpha", "fall_tilt")
    endings, variables = tables.ENDINGS, tables.VARIABLES
    lost_name = "the body falls flat"
    presets = Path(__file__).with_name("presets")
    integrate = integrator(
        contour=True, damping=False, rolling=False, pivoting=False, air=NO_AIR, slips=False,
        module="kernels.lossy_bodies.integrate",
    )  # fmt: skip
    motion = "sweep.motion.lossy_body_tables:LOSSY_BODY_MOTION"
    words = Words(
        summary="Stability atlas of a body of revolution that rolls without slipping on a horizontal plane and loses "
        "energy by friction of its contact and drag of the air: for every start of a grid how long it stays aloft, "
        "what each loss takes and the extreme tilts of the motion, {}, and the verdict of a criterion.",
        keywords="rolling body of revolution, torus, Euler's disk, dissipation, dry friction, air drag, "
        "parameter sweep",
        references=f"equations: docs/bodies.md of this program; {LOSSY_DISK.words.references.partition('; ')[2]}",
    )
    line_words = LineWords(
        critical="analytic critical {} of the body without losses, the limit of a vanishing perturbation",
        limit="without losses, in the limit of no perturbation",
    )
    synonyms = BODIES.synonyms
    ambiguous = {  # noqa: RUF012 - the base class declares it a Mapping
        **BODIES.ambiguous,
        "fall_tilt": LOSSY_DISK.ambiguous["fall_tilt"].replace("the disk", "the body"),
    }

    def headline(self, spec: Request) -> str:
        """Return what is looked at, and which losses there are."""
        told = [name.replace("_", " ") for name, (given, _) in LOSSES.items() if some(getattr(spec, given))]
        motion, _, looked_at = BODIES.headline(spec).partition(": ")
        if spec.criterion.kind == "aloft":
            looked_at = "how long the body stays aloft"
        losses = f"with {', '.join(told)}" if told else "without any loss"
        return f"{motion} {losses}: {looked_at}"

    def undisturbed(self, spec: Request, starts: Starts) -> Array:
        """Return the tilt [rad] of the motion that each start disturbs, as of the body without losses."""
        return BODIES.undisturbed(spec, starts)

    def perturbation(self, spec: Request, starts: Starts) -> Array:
        """Return the size of the perturbation in each start, as of the body without losses."""
        return BODIES.perturbation(spec, starts)

    def disturbed_motion(self, spec: Request, start: Mapping[str, float]) -> str:
        """Return what a start disturbs."""
        return BODIES.disturbed_motion(spec, start)

    def check(self, values: Mapping[str, Any]) -> None:
        """Refuse rates that do not follow from the others, what no body is, and a law without what it needs."""
        check_body(values)
        check_steady_rates(values)
        check_shape(values, tables.OPTIONAL, tables.BODIES)
        check_losses(values)

    def complete(self, spec: Request, starts: Starts) -> Starts:
        """Return starts with the moments of their bodies, and the rates that keep the tilt of each cell."""
        return complete(spec, with_constants(spec, starts, self.parameters))

    def reference(self, size: int, seed: int | None = None) -> Reference:
        """Return the check of every cell against itself, and of a sample against a second computation."""
        return SampledAudit(size, seed, MECHANICS)

    def kernel_settings(self, spec: Request) -> Array:
        """Return the settings, what the criterion limits, the law of the air, and the number of the body."""
        return np.append(super().kernel_settings(spec), float(shapes.NAMES.index(spec.body)))

    def code(self, spec: Request) -> Sequence[str | Callable[..., Any]]:
        """Return what completes starts and states settings."""
        own = ["kernels.bodies.steady", "kernels.bodies.shapes", complete.__module__]
        return [
            *own,
            LossyBodies.complete,
            LossyBodies.kernel_settings,
            LossyDisk.kernel_settings,
            with_constants,
        ]

    def lines(self, spec: Request, axis: str, starts: Starts) -> dict[str, tuple[Array, Array]]:
        """Return the critical rate without losses, and an estimate with them."""
        return theory.lines(spec, axis, starts)

    def line_label(self, spec: Request, axis: str) -> str:
        """Return the formula of the squared critical rate without losses."""
        return BODIES.line_label(spec, axis)

    def lost_in_words(self, spec: Request, stored: Mapping[str, float]) -> str:
        """Return when the body fell flat."""
        return super().lost_in_words(spec, stored).replace("a disk", "a body")

    def reason_without_verdicts(self, spec: Request) -> str:
        """Return that a body on one of two edges has no upright motion, as of the body without losses."""
        return BODIES.reason_without_verdicts(spec)

    def linear_prediction(
        self, spec: Request, start: Mapping[str, float], stored: Mapping[str, float]
    ) -> Iterable[str]:
        """Return how long losses take to bring a wobble to flat."""
        return theory.predictions(spec, start, stored)


LOSSY_BODIES = LossyBodies()
