"""How fast this machine computes a spec, and how large a block is best: measured on a coarse grid of the same cells."""

import time
from collections.abc import Callable

from sweep.engine import estimate
from sweep.engine.blocks import MOST_BLOCK_CELLS, Span
from sweep.engine.runner import compute, usable_threads, use_threads
from sweep.request.spec import SweepSpec

#: Cells that one thread takes at a time (`kernels.lanes.schedule.CHUNK`): a block gives every thread one at least.
_SHARE = 2048


def cells_per_second(
    spec: SweepSpec,
    threads: int | None = None,
    *,
    patience: float = 0.2,
    clock: Callable[[], float] = time.perf_counter,
) -> float:
    """Measure how many cells of a spec are computed in a second.

    Parameters
    ----------
    spec : SweepSpec
    threads : int, optional
        As in `runner.use_threads`.
    patience : float
        Seconds of computing that are measurement enough.
    clock : callable
        What a second is.

    Raises
    ------
    RequestError
        If `threads` is out of range.
    """
    use_threads(threads)
    wanted = usable_threads(threads)
    # loading or compiling the kernels is not what is measured
    _seconds(coarse(spec, 1), clock)
    cells = 256
    while True:
        sample = coarse(spec, cells)
        took = _seconds(sample, clock)
        if took < patience:
            # the shorter of two: on a busy machine a short measurement may have waited more than it worked
            took = min(took, _seconds(sample, clock))
        if took >= patience or cells >= min(spec.size, MOST_BLOCK_CELLS):
            # a small sample does not keep all threads busy
            return sample.size / took * wanted / min(wanted, -(-sample.size // _SHARE))
        # no further than needed: the next one must not take for ever
        cells *= 4 if 8 * took < patience else 2


def _seconds(spec: SweepSpec, clock: Callable[[], float]) -> float:
    began = clock()
    compute(spec, Span(0, spec.size))
    return clock() - began


def block_cells(spec: SweepSpec, threads: int | None = None) -> int:
    """Choose the cells of a block: some seconds of work, but not more than memory and a small loss allow.

    Raises
    ------
    RequestError
        If `threads` is out of range.
    """
    least = least_cells(threads)
    if spec.size <= least:
        return least
    # the processor's time: on a busy machine the clock on the wall would lead to blocks too small to be worth a file
    rate = cells_per_second(spec, 1, patience=0.02, clock=time.process_time) * usable_threads(threads)
    return estimate.block_cells(rate, least)


def least_cells(threads: int | None = None) -> int:
    """Return the cells of a block that gives every thread something to do.

    Raises
    ------
    RequestError
        If `threads` is out of range.
    """
    return _SHARE * usable_threads(threads)


def coarse(spec: SweepSpec, cells: int) -> SweepSpec:
    """Return a spec of about so many cells of another, spread evenly over its grid."""
    share = (min(cells, spec.size) / spec.size) ** (1.0 / max(len(spec.axes), 1))
    picked: dict[str, list[float]] = {}
    for name in spec.axes:
        values = getattr(spec, name).array()
        count = max(1, round(len(values) * share))
        picked[name] = [float(values[(2 * i + 1) * len(values) // (2 * count)]) for i in range(count)]
    return spec.replace(**picked)
