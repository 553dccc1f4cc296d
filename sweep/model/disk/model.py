"""The disk: the model of a request that names none."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from kernels.disk import arrays
from sweep.model.description import Columns, Model, Request, Starts, Words
from sweep.model.disk import tables, theory
from sweep.model.disk.contact import CONTACT, contact_columns, contact_of_disk, slipping
from sweep.model.disk.exact import REDUCE, WELLS, ExactReduction, count_wells, reduce_bodies, without_vague
from sweep.model.disk.initial_conditions import check_steady_rates, circling, complete, computed_rates
from sweep.model.disk.path import (
    PATH_VARIABLES,
    PATHS,
    call_by_body,
    path_columns,
    path_of_disk,
    rows_of_disk,
)
from sweep.model.kernel import Kernel
from sweep.model.quantity import Array, Quantity, Truths
from sweep.model.space_sample import SpaceSample

#: (whether the disk rolls, whether it precesses) -> what it does.
_MOTIONS = {
    (True, False): "Rolling along a line",
    (False, True): "Spinning about the vertical",
    (True, True): "Rolling and precessing",
    (False, False): "Neither rolling nor spinning",
}


def untimed(variables: Mapping[str, Quantity]) -> dict[str, Quantity]:
    """Return variables of an atlas without time, with a remark on those that need an integration in time."""
    return {
        name: replace(row, description="; ".join(filter(None, (row.description, tables.UNTIMED[name]))))
        if name in tables.UNTIMED
        else row
        for name, row in variables.items()
    }


def describe_motion(spec: Request, called: str) -> tuple[str, str]:
    """Return the motion of a body by the rates of a spec, and what is asked of it."""
    if circling(spec):
        return "Circling at constant tilt", "stability of the steady motion"
    upright = f"stability of the upright {called}"
    if computed_rates(spec):
        return "Wobbling about a centre at rest", upright
    rolls, turns = (getattr(spec, name) != 0.0 for name in ("roll_rate", "precession_rate"))
    return _MOTIONS[rolls, turns], upright


class Disk(Model):
    """The thin disk that rolls without slipping and without losses."""

    name = "disk"
    parameters, settings, options = tables.PARAMETERS, tables.SETTINGS, tables.OPTIONS
    substitutes = tables.SUBSTITUTES
    methods = ("rk4", "exact")
    endings, variables = tables.ENDINGS, tables.VARIABLES
    measures, counts = arrays.MEASURES, arrays.COUNTS
    coordinate, extremes, error_name, peak = "tilt", ("tilt_min", "tilt_max"), "tilt_error", "peak_tilt"
    lost_name = "the disk falls"
    presets = Path(__file__).with_name("presets")
    integrate = Kernel("kernels.disk.integrate", "integrate", seconds=4.0)
    words = Words(
        summary="Stability atlas of a thin rigid disk that rolls without slipping on a horizontal plane. For every "
        "start of a grid: the extreme tilts of the motion, {}, and the verdict of a criterion.",
        keywords="rolling disk, Euler's disk, nonholonomic dynamics, stability, parameter sweep",
        references="equations: McDonald and McDonald, arXiv:physics/0008227; integrals: Chaplygin 1897, Appell 1900, "
        "Korteweg 1899; stability: Borisov, Mamaev and Kilin, Regul. Chaotic Dyn. 8 (2003) 201",
    )
    synonyms = {  # noqa: RUF012 - the base class declares it a Mapping
        "g": "gravity",
        "m": "mass",
        "r": "radius",
        "v": "speed",
        "velocity": "speed",
        "theta": "tilt",
        "theta_dot": "tilt_rate",
        "psi_dot": "precession_rate",
        "phi_dot": "roll_rate",
    }
    # a disk spins about the vertical, and about its own axis
    ambiguous = {  # noqa: RUF012 - likewise
        "spin": "Write roll_rate, about the disk's own axis, or precession_rate, about the vertical.",
        "flat_tilt": "Write fall_tilt; flat_tilt needs the disk with losses, as in rolling_friction=0.1mm.",
    }
    exact: ExactReduction = ExactReduction()
    additions = {  # noqa: RUF012 - likewise
        "contact=yes": tables.CONTACT_VARIABLES,
        "path=yes": PATH_VARIABLES,
        "method=exact": tables.REDUCTION,
    }
    unknown_to = {"exact": [name for name in tables.UNTIMED if name != "ending"]}  # noqa: RUF012 - likewise
    trajectory, regimes = "sweep.figures.disk.cell_plot:figure", "sweep.figures.disk.regimes:figure"
    in_time = "sweep.motion.contact:contact_in_time"
    motion = "sweep.motion.tables:DISK_MOTION"

    def subject(self, spec: Request) -> tuple[str, str]:
        """Return the motion by the rates of the spec, and its stability."""
        return describe_motion(spec, "disk")

    def undisturbed(self, spec: Request, starts: Starts) -> Array:
        """Return the tilt [rad] of the undisturbed motion of each start: its own tilt if circling, 0 if upright."""
        return starts["tilt"] if circling(spec) else np.zeros_like(starts["tilt"])

    def perturbation(self, spec: Request, starts: Starts) -> Array:
        """Return the size [rad] of the perturbation of each start.

        Notes
        -----
        sqrt((tilt - steady tilt)^2 + (tilt_rate / W)^2), with W^2 = 2 gravity / ((2 + alpha) radius). An upright disk
        at rest falls with tilt ~ exp(W t), so a kick tilt_rate is worth a tilt of tilt_rate / W.
        """
        fall_rate = np.sqrt(2.0 * starts["gravity"] / ((2.0 + starts["alpha"]) * starts["radius"]))
        return np.hypot(starts["tilt"] - self.undisturbed(spec, starts), starts["tilt_rate"] / fall_rate)

    def disturbed_motion(self, spec: Request, start: Mapping[str, float]) -> str:
        """Return the name of the undisturbed motion of a start."""
        return "steady circling at this tilt" if circling(spec) else "the upright disk"

    def check(self, values: Mapping[str, Any]) -> None:
        """Refuse words for steady rates that do not determine the rates."""
        check_steady_rates(values)

    def complete(self, spec: Request, starts: Starts) -> Starts:
        """Return starts with the rates that keep the tilt of each cell constant, if the request asks for them."""
        return complete(spec, starts)

    def cell_variables(self, spec: Request) -> Mapping[str, Quantity]:
        """Return the variables of an atlas, with contact forces and path if the spec asks for them.

        With ``method=exact``, the variables that need an integration in time have a remark on that.
        """
        contact = tables.CONTACT_VARIABLES if spec.contact == "yes" else {}
        path = PATH_VARIABLES if spec.path == "yes" else {}
        variables = {**super().cell_variables(spec), **contact, **path}
        return untimed(variables) if spec.method == "exact" else variables

    def reference(self, size: int, seed: int | None = None) -> ExactReduction:
        """Return the reduction; if it made the atlas, it is checked with a sample of cells in space."""
        return ExactReduction(SpaceSample(size, seed))

    def kernels(self, spec: Request) -> tuple[Kernel, ...]:
        """Return the kernels of the method, and of contact forces and path if the spec asks for them."""
        contact = (CONTACT,) if spec.contact == "yes" else ()
        path = (PATHS,) if spec.path == "yes" else ()
        first = (REDUCE, WELLS) if spec.method == "exact" else (self.integrate,)
        return (*first, *contact, *path)

    def code(self, spec: Request) -> Sequence[str | Callable[..., Any]]:
        """Return the code that completes starts and adds exact values, contact forces and the path, as a spec needs."""
        code: list[str | Callable[..., Any]] = [Disk.complete, Disk.measure_more]
        code += ["kernels.disk.steady", complete] if computed_rates(spec) else []
        if spec.method == "exact":
            code += [ExactReduction.measures, ExactReduction.rows, without_vague]
            code += [reduce_bodies, count_wells, rows_of_disk, call_by_body]
        code += (
            [contact_of_disk, contact_columns, rows_of_disk, call_by_body] if spec.contact == "yes" else []
        )
        if spec.path == "yes":
            code += [path_of_disk, path_columns, rows_of_disk, call_by_body]
        return code

    def measure_more(self, spec: Request, starts: Starts, measured: Columns) -> Columns:
        """Return the extremes of the contact forces and the path of the contact point, if the spec asks for them."""
        return {
            **(contact_of_disk(starts, spec.fall_tilt) if spec.contact == "yes" else {}),
            **(path_of_disk(starts, spec.fall_tilt) if spec.path == "yes" else {}),
        }

    def derive(self, starts: Starts, measured: Columns) -> Columns:
        """Return the peak tilt."""
        least, greatest = measured["tilt_min"], measured["tilt_max"]
        return {"peak_tilt": np.maximum(np.abs(least), np.abs(greatest))}

    def slipping(self, dataset: Any, friction: float) -> Any:
        """Return which cells need more friction than a coefficient, or lift off."""
        return slipping(dataset, friction)

    def may_be_lost(self, spec: Request, measured: Columns, error: Array) -> Truths:
        """Return which cells reach fall_tilt within the error."""
        low, high = (np.asarray(measured[name], np.float64) for name in self.extremes)
        return np.asarray(np.maximum(high, -low) + error >= spec.fall_tilt)

    def lines(self, spec: Request, axis: str, starts: Starts) -> dict[str, tuple[Array, Array]]:
        """Return the critical lines and the lines predicted for the criterion; see `sweep.model.disk.theory.lines`."""
        edges = theory.lines(spec, axis, starts)
        if spec.criterion.limits_reach:
            return edges
        # theory predicts only the reach, no time and no other variable
        return {edge: (critical, np.full_like(critical, np.nan)) for edge, (critical, _) in edges.items()}

    def line_label(self, spec: Request, axis: str) -> str:
        """Return the formula of the squared critical rate, or k = 0."""
        return "k = 0" if circling(spec) else theory.critical_square(spec, axis)

    def joined_edges(self, spec: Request) -> tuple[str, str] | None:
        """Return the names of the ends of the curve k = 0: spinning upright and rolling upright."""
        if not circling(spec):
            return None
        fast, slow = (theory.critical_square(spec, rate) for rate in ("precession_rate", "roll_rate"))
        return rf"spinning: $\dot\psi^2 = {fast}$", rf"rolling: $\dot\phi^2 = {slow}$"

    def unit_of_square(self, spec: Request, axis: str) -> tuple[float, str] | None:
        """Return g/R, the unit of squared rates."""
        if isinstance(spec.radius, float) and isinstance(spec.gravity, float):
            return spec.gravity / spec.radius, "g/R"
        return None

    def lost_in_words(self, spec: Request, stored: Mapping[str, float]) -> str:
        """Return when the disk fell."""
        time = f" after {stored['fall_time']:.6g} s" if np.isfinite(stored["fall_time"]) else ""
        tilt = tables.SETTINGS["fall_tilt"].spell(spec.fall_tilt, 6)
        return f"the tilt reached fall_tilt, {tilt}{time}, and a fall is unstable by this criterion"

    def linear_prediction(
        self, spec: Request, start: Mapping[str, float], stored: Mapping[str, float]
    ) -> Iterable[str]:
        """Return the prediction of small oscillations about the steady motion for a cell."""
        return theory.linear_prediction(spec, start, stored)


DISK = Disk()
