"""The model of the disk with losses."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from kernels.lossy_disk import arrays
from sweep.errors import RequestError
from sweep.model.description import Columns, LineWords, Model, Reference, Request, Starts, Words
from sweep.model.disk.initial_conditions import check_steady_rates, circling, complete
from sweep.model.disk.model import DISK
from sweep.model.kernel import Kernel
from sweep.model.lossy_disk import tables, theory, upright
from sweep.model.lossy_disk.air import AIR, DRAGS, needs_of
from sweep.model.lossy_disk.audit import SampledAudit
from sweep.model.lossy_disk.tables import ARMS, NO_AIR, UNKNOWN, some
from sweep.model.quantity import Array, Input
from sweep.model.rows import LARGEST, LEAST, spell_values, worst_cases

#: Parameter of the air -> what to write if it is missing.
_USUAL = {
    "air_viscosity": "Add air_viscosity=1.8e-5, in Pa s, for air at room temperature.",
    "air_density": "Add air_density=1.2, in kg m-3, for air at room temperature.",
}


def check_losses(values: Mapping[str, Any]) -> None:
    """Refuse a law without its parameters, and parameters that no law uses.

    Parameters
    ----------
    values : mapping of str to value
        The value of every word of a request.

    Raises
    ------
    RequestError
    """
    law = str(values["air_law"])
    if law == NO_AIR:
        _refuse_unused_air(values)
    for name in needs_of(law):
        if not some(values[name]):
            quantity = tables.PARAMETERS[name]
            raise RequestError(
                f"air_law={law} needs the {quantity.long_name}: {name} is 0.",
                hint=_USUAL.get(name, f"Add {name}, in {quantity.units}."),
                where="air_law",
            )
    if values["mass"] == UNKNOWN:
        _check_no_mass(values, law)
    _check_arms(values)


def _refuse_unused_air(values: Mapping[str, Any]) -> None:
    for name in AIR:
        if some(values[name]):
            raise RequestError(
                f"{name} is given, but no law uses it: air_law is {NO_AIR}.",
                hint=f"Add {' or '.join(f'air_law={law}' for law in DRAGS)}, or write {name}=0.",
                where=name,
            )


def _check_arms(values: Mapping[str, Any]) -> None:
    """Refuse a lever arm as long as the radius: such a disk would not move at all."""
    for name in ARMS:
        worst = worst_cases(values, {name: LARGEST, "radius": LEAST})
        if (wrong := worst[name] >= worst["radius"]).any():
            lengths = spell_values(values, wrong, name, "radius", unit=" m")
            raise RequestError(
                f"A lever arm must be shorter than the radius; got {lengths}.",
                hint="Give a shorter arm, such as 10um: a coin on glass has some micrometres.",
                where=name,
            )


def _check_no_mass(values: Mapping[str, Any], law: str) -> None:
    needing = [name for name in ("contour_damping",) if some(values[name])]
    needing += [f"air_law={law}"] if law != NO_AIR else []
    if needing:
        raise RequestError(
            f"{' and '.join(needing)} {'need' if len(needing) > 1 else 'needs'} the mass of the disk, because this "
            "torque does not grow with the weight.",
            hint="Add the mass, for example mass=0.4kg.",
            where="mass",
        )


def with_constants(spec: Request, starts: Starts, parameters: Mapping[str, Input]) -> dict[str, Array]:
    """Return starts with the numbers that the words for an unknown mass and an unlimited friction stand for."""
    constants = {name: parameters[name].constants.get(getattr(spec, name)) for name in ("mass", "friction")}
    size = starts["tilt"].shape
    return {
        **starts,
        **{name: np.full(size, value) for name, value in constants.items() if value is not None},
    }


_MODULE = "kernels.lossy_disk.integrate"


@lru_cache
def integrator(
    *,
    contour: bool,
    damping: bool,
    rolling: bool,
    pivoting: bool,
    air: str,
    slips: bool,
    module: str = _MODULE,
) -> Kernel:
    """Return the kernel with exactly these laws, under the name that `kernels.lossy_disk.integrate.variant` gives it.

    Parameters
    ----------
    contour, damping, rolling, pivoting : bool
        Whether there is dry contour friction, viscous contour friction, rolling friction, and pivoting friction.
    air : str
        The law of the air.
    slips : bool
        Whether the friction that rolling needs is compared with a friction coefficient.
    module : str
        The module with the kernels of the body.
    """
    # spelled out here, because the kernels are not imported before they are used
    rubbing = ("" if contour else "_viscous") if damping else ("_dry" if contour else "_bare")
    drag = "" if air == NO_AIR else f"_{air}"
    laws = (rubbing, "_rolling" * rolling, "_pivoting" * pivoting, drag, "_slipping" * slips)
    return Kernel(module, "integrate" + "".join(laws), seconds=8.0)


def add_losses(spec: Request, subject: tuple[str, str], called: str) -> tuple[str, str]:
    """Return what moves and what is asked (`Model.subject`), with the losses of a spec."""
    names = [
        name.replace("_", " ")
        for name, (given, _) in tables.LOSSES.items()
        if (spec.air_law != NO_AIR if name == "air" else some(getattr(spec, given)))
    ]
    motion, question = subject
    if spec.criterion.kind == "aloft":
        question = f"how long the {called} stays aloft"
    return f"{motion} {f'with {", ".join(names)}' if names else 'without any loss'}", question


#: Kinds of criterion whose first breach the kernels find -> their numbers (`kernels.lossy_disk.arrays`).
_LIMITED = {"departure": 1.0, "amplification": 2.0}

#: References for the laws of the losses.
SOURCES_OF_LOSSES = (
    "friction: Leine, Arch. Appl. Mech. 79 (2009) 1063; Le Saux, Leine and Glocker, J. Nonlinear Sci. 15 (2005) 27; "
    "air: Moffatt, Nature 404 (2000) 833; Bildsten, Phys. Rev. E 66 (2002) 056309"
)


class LossyDisk(Model):
    """The thin disk that rolls without slipping, with friction at its contact and drag of the air."""

    name = "lossy_disk"
    parameters, settings, options = tables.PARAMETERS, tables.SETTINGS, tables.OPTIONS
    substitutes = tables.SUBSTITUTES
    devices = ("cpu",)
    chosen_by: tuple[str, ...] = (*tables.LOSS_PARAMETERS, "air_law")
    endings, variables = tables.ENDINGS, tables.VARIABLES
    measures, counts = arrays.MEASURES, arrays.COUNTS
    coordinate, extremes, error_name, peak = "tilt", ("tilt_min", "tilt_max"), "tilt_error", "end_time"
    lost_name, of_criterion = "the disk falls flat", ("breach_time",)
    presets = Path(__file__).with_name("presets")
    integrate = integrator(
        contour=True, damping=False, rolling=False, pivoting=False, air=tables.NO_AIR, slips=False
    )
    trajectory, losses = (
        "sweep.figures.disk.stopping_plots:figure_of_cell",
        "sweep.figures.disk.losses_map:figure",
    )
    motion = "sweep.motion.lossy_tables:LOSSY_MOTION"
    words = Words(
        summary="Stability atlas of a thin rigid disk that rolls without slipping on a horizontal plane and loses "
        "energy to friction at its contact and drag of the air. For every start of a grid: how long the disk stays "
        "aloft, the energy that each loss takes and the extreme tilts of the motion, {}, and the verdict of a "
        "criterion.",
        keywords="rolling disk, Euler's disk, dissipation, dry friction, air drag, finite-time singularity, parameter "
        "sweep",
        references=f"equations: McDonald and McDonald, arXiv:physics/0008227; {SOURCES_OF_LOSSES}",
    )
    line_words = LineWords(
        critical="analytic critical {} of the disk without losses, the limit of a vanishing perturbation",
        predicted="estimated {} at the boundary: losses reduce it to the edge of stability by the end",
        limit="without losses, in the limit of no perturbation",
        told="estimated for this start and this criterion: losses reduce it to the edge of stability by the end",
        label="estimated, {}",
        bound=True,
    )
    synonyms = DISK.synonyms
    ambiguous = {  # noqa: RUF012 - the base class declares it a Mapping
        **DISK.ambiguous,
        "fall_tilt": "With losses write flat_tilt, the tilt that counts as flat.",
    }

    def subject(self, spec: Request) -> tuple[str, str]:
        """Return the motion by the rates and the losses of the spec, and what is asked of it."""
        return add_losses(spec, DISK.subject(spec), "disk")

    def undisturbed(self, spec: Request, starts: Starts) -> Array:
        """Return the tilt [rad] of the undisturbed motion of each start, as for the disk without losses."""
        return DISK.undisturbed(spec, starts)

    def perturbation(self, spec: Request, starts: Starts) -> Array:
        """Return the size [rad] of the perturbation of each start, as for the disk without losses."""
        return DISK.perturbation(spec, starts)

    def disturbed_motion(self, spec: Request, start: Mapping[str, float]) -> str:
        """Return the name of the undisturbed motion of a start."""
        return DISK.disturbed_motion(spec, start)

    def check(self, values: Mapping[str, Any]) -> None:
        """Refuse words that do not determine the rates, and laws without their parameters."""
        check_steady_rates(values)
        check_losses(values)

    def complete(self, spec: Request, starts: Starts) -> Starts:
        """Return starts with the rates that cells compute, and numbers for an unknown mass and unlimited friction."""
        return complete(spec, with_constants(spec, starts, self.parameters))

    def reference(self, size: int, seed: int | None = None) -> Reference:
        """Return the audit: the consistency of every cell, and a sample of cells computed by another method."""
        return SampledAudit(size, seed)

    def integrator(self, spec: Request) -> Kernel:
        """Return the kernel with exactly the laws that the cells of a spec need."""
        return integrator(
            contour=tables.some(spec.contour_friction),
            damping=tables.some(spec.contour_damping),
            rolling=tables.some(spec.rolling_friction),
            pivoting=tables.some(spec.pivoting_friction),
            air=spec.air_law,
            slips=spec.friction != tables.UNLIMITED,
            module=self.integrate.module,
        )

    def kernel_settings(self, spec: Request) -> Array:
        """Return the settings, the limit of the criterion, and the law of the air."""
        limited = _LIMITED.get(spec.criterion.kind, 0.0)
        limit = spec.criterion.limit if limited else 0.0
        judged = [limited, limit, float(circling(spec)), float(tables.AIR_LAWS.index(spec.air_law))]
        return np.concatenate([super().kernel_settings(spec), judged])

    def kernels(self, spec: Request) -> tuple[Kernel, ...]:
        """Return the kernel of a spec."""
        return (self.integrator(spec),)

    def code(self, spec: Request) -> Sequence[str | Callable[..., Any]]:
        """Return the code that completes starts and makes settings."""
        return [
            LossyDisk.complete,
            LossyDisk.kernel_settings,
            "kernels.disk.steady",
            complete,
            with_constants,
        ]

    def derive(self, starts: Starts, measured: Columns) -> Columns:
        """Return the peak tilt and the largest loss."""
        least, greatest = measured["tilt_min"], measured["tilt_max"]
        lost = np.stack([np.nan_to_num(measured[measure]) for _, measure in tables.LOSSES.values()])
        largest: npt.NDArray[np.int64] = np.where(lost.max(axis=0) > 0.0, 1 + lost.argmax(axis=0), 0)
        return {"peak_tilt": np.maximum(np.abs(least), np.abs(greatest)), "largest_loss": largest}

    def lines(self, spec: Request, axis: str, starts: Starts) -> dict[str, tuple[Array, Array]]:
        """Return the critical rate without losses, and an estimate with losses: `upright.lines`."""
        return upright.lines(spec, axis, starts, upright.thin(starts))

    def line_label(self, spec: Request, axis: str) -> str:
        """Return the formula of the squared critical rate without losses."""
        return DISK.line_label(spec, axis)

    def unit_of_square(self, spec: Request, axis: str) -> tuple[float, str] | None:
        """Return g/R, the unit of squared rates."""
        return DISK.unit_of_square(spec, axis)

    def may_be_lost(self, spec: Request, measured: Columns, error: Array) -> npt.NDArray[np.bool_]:
        """Return which cells reach flat_tilt within the error."""
        low, high = (np.asarray(measured[name], np.float64) for name in self.extremes)
        return np.asarray(np.maximum(high, -low) + error >= spec.flat_tilt)

    def lost_in_words(self, spec: Request, stored: Mapping[str, float]) -> str:
        """Return when it fell flat."""
        tilt = tables.SETTINGS["flat_tilt"].spell(spec.flat_tilt, 6)
        return (
            f"the tilt reached flat_tilt, {tilt}, after {stored['end_time']:.6g} s, and lying flat is unstable by this "
            "criterion"
        )

    def open_in_words(self, spec: Request, stored: Mapping[str, float]) -> str:
        """Return what ended a motion too early for a verdict."""
        return f"{self.endings.of(stored['ending']).reason} after {stored['end_time']:.6g} s: it may still go further"

    def linear_prediction(
        self, spec: Request, start: Mapping[str, float], stored: Mapping[str, float]
    ) -> Iterable[str]:
        """Return the predictions of theory for a cell: a wobble near flat, or the slowing of an upright disk."""
        return theory.predictions(spec, start, stored)


LOSSY_DISK = LossyDisk()
