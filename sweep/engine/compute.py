"""Computation of the columns of an atlas from starts: the measured variables of each cell, and the derived ones."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from importlib import import_module
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep import platforms
from sweep.engine.grid import Span, completed, starts_at, starts_of
from sweep.errors import RequestError, shown
from sweep.model.description import Columns, Model, Starts
from sweep.model.kernel import Kernel, code_hash
from sweep.model.quantity import Quantity
from sweep.request.sources import Distribution, Range, Values, philox
from sweep.request.spec import SweepSpec
from sweep.request.start_table import Column

#: The thread loop of an NVIDIA device.
_CUDA = "kernels.lanes.cuda"


@dataclass(frozen=True)
class Block:
    """Computed cells: a span and, per variable, an array of shape (len(span),)."""

    span: Span
    columns: Columns


def compute(spec: SweepSpec, starts: Starts, verdicts_only: bool = False) -> Columns:
    """Compute cells, on the grid of the spec or not.

    Parameters
    ----------
    spec : SweepSpec
        How to integrate and judge the cells; its grid does not matter.
    starts : mapping of str to array, shape (n,)
        Every parameter of the model, in SI, as from `grid.starts_of`.
    verdicts_only : bool
        Skip measures that cost time and that the verdicts do not need; they become NaN.

    Returns
    -------
    mapping of str to array, shape (n,)
        Every variable of the atlas, with its type in the table of the model.
    """
    # nothing can be skipped if the criterion needs more than the extremes
    enough = {"ending", *spec.model.from_extremes}.issuperset(spec.criterion.needs(spec.model))
    return derive(spec, starts, measure(spec, starts, verdicts_only and enough))


def measure_block(spec: SweepSpec, span: Span) -> Columns:
    """Compute the variables of a span that must be stored: `derive_block` derives the others."""
    return measure(spec, starts_of(spec, span))


def derive_block(spec: SweepSpec, span: Span, measured: Columns) -> Columns:
    """Return all columns of a span, as from `compute`, from the columns of `measure_block`."""
    return derive(spec, starts_of(spec, span), measured)


def measure(spec: SweepSpec, starts: Starts, verdicts_only: bool = False) -> dict[str, npt.NDArray[Any]]:
    """Integrate cells, or reduce them exactly.

    Returns
    -------
    dict of str to array, shape (n,)
        The measures and counts of the model, with their types in its table, and the parameters that each cell
        computes, NaN where they are not finite.
    """
    model = spec.model
    if spec.method == "exact" and model.exact is not None:
        columns = model.exact.measures(spec, starts, extremes_only=verdicts_only)
    else:
        columns = _integrate(spec, starts)
    columns = {**columns, **model.measure_more(spec, starts, columns)}
    for name in spec.computed:
        columns[name] = np.where(np.isfinite(starts[name]), starts[name], np.nan)
    return {
        name: columns[name].astype(quantity.dtype, copy=False)
        for name, quantity in measured_quantities(spec).items()
    }


def derive(spec: SweepSpec, starts: Starts, measured: Columns) -> Columns:
    """Return all columns of the atlas from the columns of `measure`: adds the verdicts and other derived variables.

    Returns
    -------
    mapping of str to array, shape (n,)
    """
    model, reach, scale = spec.model, *reach_and_scale(spec, starts, measured)
    with np.errstate(divide="ignore", invalid="ignore"):
        amplification = np.where(scale > 0.0, reach / scale, np.nan)
    values: dict[str, npt.NDArray[Any]] = {
        **measured,
        **model.derive(starts, measured),
        "amplification": amplification,
    }
    values["stability"] = spec.criterion.decide(spec, starts, values, reach, scale)
    columns = {
        name: values[name].astype(quantity.dtype, copy=False)
        for name, quantity in model.cell_variables(spec).items()
    }
    columns |= {name: measured[name] for name in spec.computed}
    # the journal does not store the values of a list of starts: computing them again is faster than reading them
    return columns | {name: starts[name] for name in spec.listed}


def reach_and_scale(
    spec: SweepSpec, starts: Starts, measured: Columns
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return the largest distances of cells from their undisturbed value, and the sizes of their perturbations."""
    with np.errstate(invalid="ignore"):
        return spec.model.reach(spec, starts, measured), spec.model.perturbation(spec, starts)


def _integrate(spec: SweepSpec, starts: Starts) -> dict[str, npt.NDArray[Any]]:
    model = spec.model
    rows = np.stack([starts[name] for name in model.parameters])
    settings = model.kernel_settings(spec)
    n = rows.shape[1]
    measures, counts = np.empty((len(model.measures), n)), np.zeros((len(model.counts), n), np.int32)
    _integrator(model.integrator(spec), spec.device)(rows, settings, measures, counts)
    return dict(zip((*model.measures, *model.counts), (*measures, *counts), strict=True))


def arithmetic_hash(spec: SweepSpec) -> str:
    """Return the SHA-256 of the code that determines the bits of the measures: kernels, starts, axes, types."""
    model = spec.model
    kernels = [kernel.module for kernel in model.kernels(spec)]
    device = [_CUDA] if spec.device == "cuda" else []
    axes = (Range.at, Range.array, Values.at, Values.array)
    settings = Model.kernel_settings
    engine: list[Callable[..., Any]] = [
        measure,
        _integrate,
        settings,
        starts_of,
        starts_at,
        completed,
        *axes,
    ]
    engine += [Distribution.at, Distribution._quantile, philox] if spec.samples else []
    engine += [Column.at] if spec.starts else []
    types = [f"{name} {quantity.dtype}" for name, quantity in measured_quantities(spec).items()]
    data = [model.text] if model.text else []
    return code_hash([*kernels, *device, *model.code(spec), *engine], *types, *data)


def measured_quantities(spec: SweepSpec) -> dict[str, Quantity]:
    """Return the variables of an atlas that are measured in each cell; `derive` derives all others."""
    model = spec.model
    derived = {*model.variables, *spec.listed} - model.measured
    return {name: quantity for name, quantity in stored_quantities(spec).items() if name not in derived}


def stored_quantities(spec: SweepSpec) -> dict[str, Quantity]:
    """Return the variables of the cells of an atlas, including the parameters that a list of starts varies."""
    parameters = {name: spec.model.parameters[name] for name in (*spec.computed, *spec.listed)}
    return {**spec.model.cell_variables(spec), **parameters}


@lru_cache
def _integrator(kernel: Kernel, device: str) -> Any:
    """Return the kernel that integrates cells on a device: the processor, or an NVIDIA device."""
    if device == "cpu":
        return kernel.load()
    # checked here too: a file from another machine may name the device
    _check_cuda()
    return import_module(_CUDA).bind(getattr(import_module(kernel.module), kernel.function).lane_model)


def check_device(spec: SweepSpec) -> None:
    """Refuse a spec whose device is missing or cannot use its method, or whose criterion cannot judge new cells.

    No device replaces another one.

    Raises
    ------
    RequestError
    """
    spec.criterion.check_new_cells()
    if spec.device == "cpu":
        return
    if spec.method == "exact":
        raise RequestError(
            f"device=cuda integrates in time; got method={spec.method} device={spec.device}.",
            hint="Leave device out: the exact method is fast without it.",
            where="device",
        )
    _check_cuda()


def _check_cuda() -> None:
    problem = problem_of_cuda()
    if problem:
        raise RequestError(
            f"This machine cannot compute with CUDA: {problem}. device=cuda needs an NVIDIA device, its driver and the "
            "package numba-cuda.",
            hint="Install the driver and `pip install 'numba-cuda[cu13]' 'numpy<2.5'`, or leave device=cuda out.",
            where="device",
        )


@lru_cache
def problem_of_cuda() -> str:
    """Return why no device computes cells, without a period; empty if one does."""
    try:
        problem: str = import_module(_CUDA).problem()
    except ImportError as error:
        return str(error)
    return problem


def check_block_cells(cells: int | None) -> None:
    """Refuse a number of cells per block that is not a positive integer.

    Raises
    ------
    RequestError
    """
    if cells is not None and (not _is_whole(cells) or cells < 1):
        raise RequestError(
            f"The number of cells per block must be a whole number of at least 1; got {shown(cells)}.",
            hint="Leave it out.",
            where="block_cells",
        )


def _is_whole(number: object) -> bool:
    return isinstance(number, int | np.integer) and not isinstance(number, bool)


def use_threads(threads: int | None) -> None:
    """Set the number of threads for kernels called from this Python thread; all if not given.

    Raises
    ------
    RequestError
        If `threads` is out of range.
    """
    import_module("kernels.native.workers").use(usable_threads(threads))


def usable_threads(threads: int | None) -> int:
    """Return the number of threads that a run would use.

    Raises
    ------
    RequestError
        If `threads` is out of range.
    """
    most = platforms.most_threads()
    wanted = platforms.usual_threads() if threads is None else threads
    if not _is_whole(wanted) or not 1 <= wanted <= most:
        raise RequestError(
            f"threads must be a whole number from 1 to {most}; got {shown(threads)}.",
            hint="Leave it out.",
            where="threads",
        )
    return int(wanted)
