"""The model of bodies of revolution with losses, based on the disk with losses."""

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
from sweep.model.lossy_disk.model import (
    LOSSY_DISK,
    SOURCES_OF_LOSSES,
    LossyDisk,
    add_losses,
    check_losses,
    integrator,
    with_constants,
)
from sweep.model.lossy_disk.tables import NO_AIR, some
from sweep.model.quantity import Array
from sweep.model.rows import LARGEST, spell_values, worst_cases


def check_body(values: Mapping[str, Any]) -> None:
    """Refuse bodies for which there is no formula of a loss.

    Parameters
    ----------
    values : mapping of str to value
        The value of every word of a request.

    Raises
    ------
    RequestError
    """
    body = str(values["body"])
    for name, nothing in (("air_law", NO_AIR), ("air_viscosity", "0"), ("air_density", "0")):
        given = values[name] != NO_AIR if name == "air_law" else some(values[name])
        if given and body not in tables.FACED:
            raise RequestError(
                f"The laws of the air describe the air under a flat face, and a {CALLED[body]} has none; got "
                f"body={body} {name}={values[name]}.",
                hint=f"Write {name}={nothing}, or body={' or body='.join(tables.FACED)}.",
                where=name,
            )
    for faced, name, whole in (("rounded", "thickness", 2.0), ("rim", "fillet", 1.0), ("arc", "fillet", 1.0)):
        if body == faced and (wrong := worst_cases(values, {name: LARGEST})[name] >= whole).any():
            raise RequestError(
                f"A {CALLED[body]} has no face left to lie on: with losses {name} < {whole:g}, in radii; got "
                f"{spell_values(values, wrong, name)}.",
                hint=f"Give a smaller {name}.",
                where=name,
            )


class LossyBodies(LossyDisk):
    """A body of revolution that rolls without slipping, with friction at its contact and drag of the air."""

    name = "lossy_bodies"
    parameters, settings, options = tables.PARAMETERS, tables.SETTINGS, tables.OPTIONS
    substitutes = tables.SUBSTITUTES
    # words of losses together with words of a body choose it: `sweep.model.registry.chosen`
    chosen_by: tuple[str, ...] = ()
    does_without = ("alpha", "fall_tilt")
    endings, variables = tables.ENDINGS, tables.VARIABLES
    lost_name = "the body falls flat"
    presets = Path(__file__).with_name("presets")
    integrate = integrator(
        contour=True, damping=False, rolling=False, pivoting=False, air=NO_AIR, slips=False,
        module="kernels.lossy_bodies.integrate",
    )  # fmt: skip
    motion = "sweep.motion.lossy_tables:LOSSY_BODY_MOTION"
    words = Words(
        summary="Stability atlas of a body of revolution that rolls without slipping on a horizontal plane and loses "
        "energy to friction at its contact and drag of the air. For every start of a grid: how long it stays aloft, "
        "the energy that each loss takes and the extreme tilts of the motion, {}, and the verdict of a criterion.",
        keywords="rolling body of revolution, torus, Euler's disk, dissipation, dry friction, air drag, "
        "parameter sweep",
        references=f"equations: docs/bodies.md of this program; {SOURCES_OF_LOSSES}",
    )
    line_words = LineWords(
        critical="analytic critical {} of the body without losses, the limit of a vanishing perturbation",
        limit="without losses, in the limit of no perturbation",
    )
    synonyms = BODIES.synonyms
    ambiguous = {**BODIES.ambiguous, "fall_tilt": LOSSY_DISK.ambiguous["fall_tilt"]}  # noqa: RUF012 - likewise

    def subject(self, spec: Request) -> tuple[str, str]:
        """Return the motion by the rates, the body and the losses of the spec, and what is asked of it."""
        return add_losses(spec, BODIES.subject(spec), "body")

    def undisturbed(self, spec: Request, starts: Starts) -> Array:
        """Return the tilt [rad] of the undisturbed motion of each start, as for the body without losses."""
        return BODIES.undisturbed(spec, starts)

    def perturbation(self, spec: Request, starts: Starts) -> Array:
        """Return the size of the perturbation of each start, as for the body without losses."""
        return BODIES.perturbation(spec, starts)

    def disturbed_motion(self, spec: Request, start: Mapping[str, float]) -> str:
        """Return the name of the undisturbed motion of a start."""
        return BODIES.disturbed_motion(spec, start)

    def check(self, values: Mapping[str, Any]) -> None:
        """Refuse words that do not determine the rates, impossible bodies, and laws without their parameters."""
        check_body(values)
        check_steady_rates(values)
        check_shape(values, tables.OPTIONAL, tables.BODIES)
        check_losses(values)

    def complete(self, spec: Request, starts: Starts) -> Starts:
        """Return starts with the moments of their bodies, and the rates that keep the tilt of each cell constant."""
        return complete(spec, with_constants(spec, starts, self.parameters))

    def reference(self, size: int, seed: int | None = None) -> Reference:
        """Return the audit: the consistency of every cell, and a sample of cells computed by another method."""
        return SampledAudit(size, seed, MECHANICS)

    def kernel_settings(self, spec: Request) -> Array:
        """Return the settings, the limit of the criterion, the law of the air, and the number of the body."""
        return np.append(super().kernel_settings(spec), float(shapes.NAMES.index(spec.body)))

    def code(self, spec: Request) -> Sequence[str | Callable[..., Any]]:
        """Return the code that completes starts and makes settings."""
        own = ["kernels.bodies.steady", "kernels.bodies.shapes", complete.__module__]
        return [
            *own,
            LossyBodies.complete,
            LossyBodies.kernel_settings,
            LossyDisk.kernel_settings,
            with_constants,
        ]

    def lines(self, spec: Request, axis: str, starts: Starts) -> dict[str, tuple[Array, Array]]:
        """Return the critical rate without losses, and an estimate with losses."""
        return theory.lines(spec, axis, starts)

    def line_label(self, spec: Request, axis: str) -> str:
        """Return the formula of the squared critical rate without losses."""
        return BODIES.line_label(spec, axis)

    def reason_without_verdicts(self, spec: Request) -> str:
        """Return that a body with two edges has no steady upright motion, as for the body without losses."""
        return BODIES.reason_without_verdicts(spec)

    def linear_prediction(
        self, spec: Request, start: Mapping[str, float], stored: Mapping[str, float]
    ) -> Iterable[str]:
        """Return the predictions of theory for a cell: a wobble near flat, or the slowing of an upright body."""
        return theory.predictions(spec, start, stored)


LOSSY_BODIES = LossyBodies()
