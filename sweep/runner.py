"""From a spec to computed blocks: the only caller of the lane kernel."""

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sweep import cells
from sweep.blocks import BLOCK_CELLS, Span, blocks
from sweep.compiled import integrate
from sweep.errors import RequestError
from sweep.schema import AUTOMATIC, VARIABLES, Array
from sweep.spec import SweepSpec

Columns = Mapping[str, npt.NDArray[np.generic]]


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
        If `threads` or `block_cells` is out of range.
    """
    if block_cells < 1:
        raise RequestError("no block", "block_cells >= 1", str(block_cells), "leave it out", "block_cells")
    use_threads(threads)
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
        Every variable of the atlas, of its type in `schema.VARIABLES`; `roll_rate` [rad/s] where it is computed.
    """
    import numba

    given = cells.starts(spec, span)
    step = 0.0 if spec.step == AUTOMATIC else spec.step
    settings = np.array([spec.duration, step, spec.fall_tilt, spec.tolerance])
    measures = np.empty((6, len(span)))
    counts = np.zeros((3, len(span)), np.int32)
    # one chunk at a time to whichever thread is free: what a cell costs is known only afterwards
    with numba.parallel_chunksize(1):
        integrate()(np.stack(list(given.values())), settings, measures, counts)
    return _columns(spec, given, measures, counts)


def _columns(
    spec: SweepSpec, given: dict[str, Array], measures: Array, counts: npt.NDArray[np.int32]
) -> Columns:
    ending = counts[0]
    least, greatest = measures[0], measures[1]
    steady, scale = cells.steady_tilt(spec, given), cells.scale(spec, given)
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = np.maximum(np.abs(greatest - steady), np.abs(least - steady))
        amplification = np.where(scale > 0.0, reach / scale, np.nan)
    columns = {
        "ending": ending,
        "stability": spec.criterion.verdict(ending, least, greatest, steady, scale),
        "tilt_min": least,
        "tilt_max": greatest,
        "peak_tilt": np.maximum(np.abs(least), np.abs(greatest)),
        "amplification": amplification,
        "fall_time": measures[2],
        "nutation_period": measures[3],
        "energy_drift": measures[4],
        "tilt_error": measures[5],
        "steps": counts[1],
        "refinements": counts[2],
    }
    typed: dict[str, npt.NDArray[np.generic]] = {
        name: column.astype(VARIABLES[name].dtype, copy=False) for name, column in columns.items()
    }
    if spec.circling:
        typed["roll_rate"] = np.where(np.isfinite(given["roll_rate"]), given["roll_rate"], np.nan)
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
