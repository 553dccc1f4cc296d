"""From starts to the columns of an atlas: what is measured of each cell, and what follows from it."""

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
    """Compute cells anywhere, on the grid of the spec or not.

    Parameters
    ----------
    spec : SweepSpec
        Says how they are integrated and judged; its grid does not matter.
    starts : mapping of str to array, shape (n,)
        Every parameter of the model, in SI, as from `grid.starts_of`.
    verdicts_only : bool
        Leave out, as NaN, what costs time and the verdicts do not need.

    Returns
    -------
    mapping of str to array, shape (n,)
        Every variable of the atlas, of its type in the table of the model.
    """
    # more than the extremes is left out only where the criterion judges by them alone
    enough = {"ending", *spec.model.from_extremes}.issuperset(spec.criterion.needs(spec.model))
    return derive(spec, starts, measure(spec, starts, verdicts_only and enough))


def measure_block(spec: SweepSpec, span: Span) -> Columns:
    """Compute what has to be kept of the cells of a span: all that does not follow from it (see `derive_block`)."""
    return measure(spec, starts_of(spec, span))


def derive_block(spec: SweepSpec, span: Span, measured: Columns) -> Columns:
    """Return all columns of a span, as from `compute`, from those of `measure_block`."""
    return derive(spec, starts_of(spec, span), measured)


def measure(spec: SweepSpec, starts: Starts, verdicts_only: bool = False) -> dict[str, npt.NDArray[Any]]:
    """Integrate cells, or reduce them exactly.

    Returns
    -------
    dict of str to array, shape (n,)
        The measures and counts of the model, of their types in its table, and the parameters that each cell computed
        for itself, NaN where they are not finite.
    """
    model = spec.model
    if spec.method == "exact" and model.exact is not None:
        found = model.exact.measures(spec, starts, extremes_only=verdicts_only)
    else:
        found = _integrated(spec, starts)
    found = {**found, **model.measure_more(spec, starts, found)}
    for name in spec.computed:
        found[name] = np.where(np.isfinite(starts[name]), starts[name], np.nan)
    return {
        name: found[name].astype(quantity.dtype, copy=False)
        for name, quantity in measured_quantities(spec).items()
    }


def derive(spec: SweepSpec, starts: Starts, measured: Columns) -> Columns:
    """Return all columns of the atlas from those of `measure`: the verdicts, and what else follows.

    Returns
    -------
    mapping of str to array, shape (n,)
    """
    model, reach, scale = spec.model, *reach_and_scale(spec, starts, measured)
    with np.errstate(divide="ignore", invalid="ignore"):
        amplification = np.where(scale > 0.0, reach / scale, np.nan)
    found: dict[str, npt.NDArray[Any]] = {
        **measured,
        **model.derive(starts, measured),
        "amplification": amplification,
    }
    found["stability"] = spec.criterion.decide(spec, starts, found, reach, scale)
    columns = {
        name: found[name].astype(quantity.dtype, copy=False)
        for name, quantity in model.cell_variables(spec).items()
    }
    columns |= {name: measured[name] for name in spec.computed}
    # what a list gives its starts is not kept in the journal: it is found again faster than it is read
    return columns | {name: starts[name] for name in spec.listed}


def reach_and_scale(
    spec: SweepSpec, starts: Starts, measured: Columns
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return how far cells went from their undisturbed value, and the size of their perturbations, same shape."""
    with np.errstate(invalid="ignore"):
        return spec.model.reach(spec, starts, measured), spec.model.perturbation(spec, starts)


def _integrated(spec: SweepSpec, starts: Starts) -> dict[str, npt.NDArray[Any]]:
    model = spec.model
    rows = np.stack([starts[name] for name in model.parameters])
    settings = model.kernel_settings(spec)
    n = rows.shape[1]
    measures, counts = np.empty((len(model.measures), n)), np.zeros((len(model.counts), n), np.int32)
    _integrator(model.integrator(spec), spec.device)(rows, settings, measures, counts)
    return dict(zip((*model.measures, *model.counts), (*measures, *counts), strict=True))


def arithmetic_hash(spec: SweepSpec) -> str:
    """Return the SHA-256 of the code that decides the bits of what is measured: kernels, starts, axes, types."""
    model = spec.model
    kernels = [kernel.module for kernel in model.kernels(spec)]
    device = [_CUDA] if spec.device == "cuda" else []
    axes = (Range.at, Range.array, Values.at, Values.array)
    settings = Model.kernel_settings
    engine: list[Callable[..., Any]] = [
        measure,
        _integrated,
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
    """Return the variables of an atlas that are measured in each cell; all others follow from them (`derive`)."""
    model = spec.model
    derived = {*model.variables, *spec.listed} - model.measured
    return {name: each for name, each in stored_quantities(spec).items() if name not in derived}


def stored_quantities(spec: SweepSpec) -> dict[str, Quantity]:
    """Return the variables of an atlas with one value per cell, those that a list gives its starts among them."""
    parameters = {name: spec.model.parameters[name] for name in (*spec.computed, *spec.listed)}
    return {**spec.model.cell_variables(spec), **parameters}


@lru_cache
def _integrator(kernel: Kernel, device: str) -> Any:
    """Return the kernel that integrates cells on a device: the processor, or an NVIDIA device."""
    if device == "cpu":
        return kernel.load()
    # cells of a file are computed too, which another machine has made
    _check_cuda()
    return import_module(_CUDA).bind(import_module(kernel.module).LANE_MODEL)


def check_device(spec: SweepSpec) -> None:
    """Refuse a spec whose device is not there, or cannot do what is asked for. No device takes the place of another.

    A criterion that cannot judge new cells is refused too.

    Raises
    ------
    RequestError
    """
    spec.criterion.check_new_cells()
    if spec.device == "cpu":
        return
    if spec.method != "rk4":
        raise RequestError(
            f"device=cuda goes with method=rk4; got method={spec.method} device={spec.device}.",
            hint="Leave device out: the exact method is fast without one.",
            where="device",
        )
    _check_cuda()


def _check_cuda() -> None:
    missing = _missing_cuda()
    if missing:
        raise RequestError(
            f"This machine cannot compute with CUDA: {missing}. device=cuda needs an NVIDIA device, its driver and the "
            "package numba-cuda.",
            hint="Install the driver and `pip install numba-cuda`, or leave device=cuda out.",
            where="device",
        )


@lru_cache
def _missing_cuda() -> str:
    """The reason why CUDA cannot be used; empty if it can."""
    try:
        from numba import cuda

        return "" if cuda.is_available() else "no device with a driver was found"
    except ImportError as problem:
        return str(problem)


def check_block_cells(cells: int | None) -> None:
    """Refuse blocks of no cells.

    Raises
    ------
    RequestError
    """
    if cells is not None and (not _is_whole(cells) or cells < 1):
        raise RequestError(
            f"A block has at least one cell, and whole ones; got {shown(cells)}.",
            hint="Leave it out.",
            where="block_cells",
        )


def _is_whole(number: object) -> bool:
    return isinstance(number, int | np.integer) and not isinstance(number, bool)


def use_threads(threads: int | None) -> None:
    """Let the kernels that this Python thread calls use so many threads; all that there are, if not given.

    Raises
    ------
    RequestError
        If `threads` is out of range.
    """
    import_module("kernels.native.workers").use(usable_threads(threads))


def usable_threads(threads: int | None) -> int:
    """Return how many threads a run would use.

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
