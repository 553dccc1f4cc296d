"""From a spec to computed blocks: the only caller of the kernels that compute cells."""

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.engine import cells, contact
from sweep.engine.blocks import BLOCK_CELLS, Span, blocks
from sweep.engine.compiled import extremes
from sweep.engine.device import check_device, integrator
from sweep.errors import RequestError
from sweep.request.spec import SweepSpec
from sweep.schema import AUTOMATIC, VARIABLES, Array
from sweep.schema.exact import DERIVED, atlas_variables

Columns = Mapping[str, npt.NDArray[np.generic]]

_UNRESOLVED = next(code for code, name in (VARIABLES["ending"].flags or {}).items() if name == "unresolved")


@dataclass(frozen=True)
class Block:
    """Computed cells: a span and, per variable, an array of shape (len(span),)."""

    span: Span
    columns: Columns


def run_blocks(
    spec: SweepSpec, *, threads: int | None = None, block_cells: int = BLOCK_CELLS
) -> Iterator[Block]:
    """Compute the cells of a spec block by block, in C order.

    Parameters
    ----------
    spec : SweepSpec
    threads : int, optional
        Threads to use; all that this process may use if not given. The bits of the results do not depend on it.
    block_cells : int
        Cells per block; the bits do not depend on it either.

    Yields
    ------
    Block

    Raises
    ------
    RequestError
        If `threads` or `block_cells` is out of range, or the spec's device is not there.
    """
    if block_cells < 1:
        raise RequestError("no block", "block_cells >= 1", str(block_cells), "leave it out", "block_cells")
    use_threads(threads)
    check_device(spec)
    for span in blocks(spec.size, block_cells):
        yield Block(span, compute(spec, span))


def available_threads() -> int:
    """Return how many threads this process may use: its CPU affinity, and the CPU quota of its control group."""
    affinity = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    try:
        with open("/sys/fs/cgroup/cpu.max", encoding="ascii") as file:
            quota, period = file.read().split()
        return max(1, min(affinity, -(-int(quota) // int(period))))
    except (OSError, ValueError):
        return affinity


def compute(spec: SweepSpec, span: Span) -> Columns:
    """Compute the cells of one span.

    Parameters
    ----------
    spec : SweepSpec
    span : Span

    Returns
    -------
    mapping of str to array, shape (len(span),)
        Every variable of the atlas, of its type in the schema; `spec.computed_rate` [rad/s] where there is one; the
        extremes of the contact forces where they are asked for.
    """
    return measure(spec, cells.starts(spec, span))


def completed(spec: SweepSpec, span: Span, measured: Columns) -> Columns:
    """Return the columns of a span, as from `compute`, from those that are not `DERIVED`."""
    return _columns(spec, cells.starts(spec, span), measured)


def measure(spec: SweepSpec, given: dict[str, Array]) -> Columns:
    """Compute cells anywhere, on the grid of the spec or not.

    Parameters
    ----------
    spec : SweepSpec
        Says how they are integrated and judged; its grid does not matter.
    given : dict of str to array, shape (n,)
        The starts, as from `cells.complete`.

    Returns
    -------
    mapping of str to array, shape (n,)
        As `compute`.
    """
    measured = exact_measures(spec, given) if spec.method == "exact" else _integrated(spec, given)
    if spec.contact == "yes":
        measured |= contact.columns(given, measured["tilt_min"], measured["tilt_max"])
    return _columns(spec, given, measured)


def exact_measures(spec: SweepSpec, given: Mapping[str, Array]) -> dict[str, npt.NDArray[Any]]:
    """Return what the exact reduction says of cells, without time stepping (`kernels.disk.exact.extremes`).

    Parameters
    ----------
    spec : SweepSpec
    given : mapping of str to array, shape (n,)
        The starts, as from `cells.starts`.

    Returns
    -------
    dict of str to array, shape (n,)
        Variables of `schema.exact.atlas_variables`; NaN or 0 where the reduction has none. A cell whose extremes are
        not known to the spec's tolerance (on a separatrix) is unresolved.
    """
    measures, counts = extremes()(np.stack(list(given.values())), spec.fall_tilt, True)
    vague = measures[4] > spec.tolerance
    measures[np.ix_((0, 1, 2, 4), vague)] = np.nan
    missing, none = np.full(measures.shape[1], np.nan), np.zeros(measures.shape[1], np.int32)
    return {
        "ending": np.where(vague, _UNRESOLVED, counts[0]),
        "tilt_min": measures[0],
        "tilt_max": measures[1],
        "fall_time": missing,
        "nutation_period": measures[2],
        "energy_drift": missing,
        "tilt_error": measures[4],
        "steps": none,
        "refinements": none,
        "wells": counts[1],
        "separatrix": measures[3],
    }


def _integrated(spec: SweepSpec, given: Mapping[str, Array]) -> dict[str, npt.NDArray[Any]]:

    n = len(given["tilt"])
    step = 0.0 if spec.step == AUTOMATIC else spec.step
    settings = np.array([spec.duration, step, spec.fall_tilt, spec.tolerance])
    measures, counts = np.empty((6, n)), np.zeros((3, n), np.int32)
    integrator(spec)(np.stack(list(given.values())), settings, measures, counts)
    return {
        "ending": counts[0],
        "tilt_min": measures[0],
        "tilt_max": measures[1],
        "fall_time": measures[2],
        "nutation_period": measures[3],
        "energy_drift": measures[4],
        "tilt_error": measures[5],
        "steps": counts[1],
        "refinements": counts[2],
    }


def _columns(
    spec: SweepSpec, given: Mapping[str, Array], measured: Mapping[str, npt.NDArray[Any]]
) -> Columns:
    least, greatest = measured["tilt_min"], measured["tilt_max"]
    steady, scale = cells.steady_tilt(spec, given), cells.scale(spec, given)
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = np.maximum(np.abs(greatest - steady), np.abs(least - steady))
        amplification = np.where(scale > 0.0, reach / scale, np.nan)
    derived: dict[str, npt.NDArray[Any]] = {
        "stability": spec.criterion.verdict(measured["ending"], least, greatest, steady, scale),
        "peak_tilt": np.maximum(np.abs(least), np.abs(greatest)),
        "amplification": amplification,
    }
    table = atlas_variables(spec.method, spec.contact)
    typed: dict[str, npt.NDArray[np.generic]] = {
        name: (derived[name] if name in DERIVED else measured[name]).astype(quantity.dtype, copy=False)
        for name, quantity in table.items()
    }
    if spec.computed_rate is not None:
        # the rate that the cell was computed with, where that is known
        rate = measured.get(spec.computed_rate, given[spec.computed_rate])
        typed[spec.computed_rate] = np.where(np.isfinite(rate), rate, np.nan)
    return typed


def use_threads(threads: int | None) -> None:
    """Let the kernels that this Python thread calls use so many threads; all that there are, if not given.

    Raises
    ------
    RequestError
        If `threads` is out of range.
    """
    import numba

    numba.set_num_threads(usable_threads(threads))


def usable_threads(threads: int | None) -> int:
    """Return how many threads a run would use.

    Raises
    ------
    RequestError
        If `threads` is out of range.
    """
    import numba

    most = int(numba.config.NUMBA_NUM_THREADS)
    wanted = min(available_threads(), most) if threads is None else threads
    if not 1 <= wanted <= most:
        raise RequestError(
            "that many threads are not to be had",
            f"1 <= threads <= {most}",
            str(threads),
            "leave it out",
            "threads",
        )
    return wanted
