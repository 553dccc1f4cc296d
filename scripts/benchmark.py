"""How fast the engine is: the lane kernel against a plain RK4 loop, the exact reduction, a whole run and its audit.

Both RK4 kernels integrate the same cells with the same number of steps on the same threads, alternating in one run
after compiling; the ratio is what counts, seconds vary with the machine and its other users.
"""

import argparse
import math
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numba
import numpy as np

import sweep
from sweep import cells
from sweep.blocks import Span
from sweep.compiled import extremes, integrate

_STEP = 0.01  # s, about 0.044 sqrt(R/g)
_DURATION = 300.0  # s
_FALL_TILT = math.radians(85.0)
_LOOSE = 0.1  # rad: no cell is integrated twice, so that steps can be counted


@numba.njit(error_model="numpy")
def _textbook_rates(tilt, tilt_rate, precession_rate, roll_rate, alpha, radius, gravity):
    sin, cos = math.sin(tilt), math.cos(tilt)
    acceleration = (
        4.0 * gravity * sin
        + (2.0 + alpha) * radius * precession_rate**2 * math.sin(2.0 * tilt)
        + 4.0 * (1.0 + alpha) * radius * roll_rate * precession_rate * cos
    ) / (2.0 * (2.0 + alpha) * radius)
    precession = -2.0 * roll_rate * tilt_rate / cos
    roll = (
        tilt_rate
        * (2.0 * (1.0 + alpha) * roll_rate * sin - (2.0 + alpha) * precession_rate * cos**2)
        / ((1.0 + alpha) * cos)
    )
    return tilt_rate, acceleration, precession, roll


@numba.njit(error_model="numpy", parallel=True)
def _textbook(starts, steps, h, final):
    """RK4 on the equations as they stand in a book, one cell after another in a parallel loop."""
    for cell in numba.prange(starts.shape[1]):
        a, b, c, d = starts[0, cell], starts[1, cell], starts[2, cell], starts[3, cell]
        alpha, radius, gravity = starts[4, cell], starts[5, cell], starts[6, cell]
        half = 0.5 * h
        for _ in range(steps[cell]):
            a1, b1, c1, d1 = _textbook_rates(a, b, c, d, alpha, radius, gravity)
            a2, b2, c2, d2 = _textbook_rates(
                a + half * a1, b + half * b1, c + half * c1, d + half * d1, alpha, radius, gravity
            )
            a3, b3, c3, d3 = _textbook_rates(
                a + half * a2, b + half * b2, c + half * c2, d + half * d2, alpha, radius, gravity
            )
            a4, b4, c4, d4 = _textbook_rates(
                a + h * a3, b + h * b3, c + h * c3, d + h * d3, alpha, radius, gravity
            )
            a += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
            b += h / 6.0 * (b1 + 2.0 * b2 + 2.0 * b3 + b4)
            c += h / 6.0 * (c1 + 2.0 * c2 + 2.0 * c3 + c4)
            d += h / 6.0 * (d1 + 2.0 * d2 + 2.0 * d3 + d4)
        final[0, cell], final[1, cell], final[2, cell], final[3, cell] = a, b, c, d


def _seconds(work: Callable[[], object]) -> float:
    began = time.perf_counter()
    work()
    return time.perf_counter() - began


def compare_kernels(threads: int, repeats: int) -> None:
    """Print RK4 steps per second of both kernels, and their ratio pair by pair."""
    numba.set_num_threads(threads)
    spec = sweep.SweepSpec.from_words("rolling", ["roll_rate=2:4:300", "tilt=0.001deg:5deg:200:log"])
    starts = np.stack(list(cells.starts(spec, Span(0, spec.size)).values()))
    settings = np.array([_DURATION, _STEP, _FALL_TILT, _LOOSE])
    measures, counts = np.empty((6, spec.size)), np.zeros((3, spec.size), np.int32)
    final = np.empty((4, spec.size))

    def lanes() -> None:
        with numba.parallel_chunksize(1):
            integrate()(starts, settings, measures, counts)

    lanes()
    steps = counts[1].astype(np.int64)
    _textbook(starts, steps, _STEP, final)
    ours, theirs = [], []
    for _ in range(repeats):
        ours.append(_seconds(lanes))
        theirs.append(_seconds(lambda: _textbook(starts, steps, _STEP, final)))
    ratios = [slow / fast for slow, fast in zip(theirs, ours, strict=True)]
    total = steps.sum() / 1e9
    print(f"{spec.size} cells, {total:.3g}e9 RK4 steps, {threads} threads, median of {repeats} pairs")
    print(f"  plain prange loop   {total / statistics.median(theirs):8.3f} e9 steps/s")
    print(f"  lane kernel         {total / statistics.median(ours):8.3f} e9 steps/s, with all diagnostics")
    print(f"  ratio               {statistics.median(ratios):8.1f}  ({min(ratios):.1f} to {max(ratios):.1f})")


def exact_reduction(threads: int, repeats: int) -> None:
    """Print cells per second of the exact reduction, with and without the period, tables of one alpha included."""
    numba.set_num_threads(threads)
    spec = sweep.SweepSpec.from_words("rolling", ["roll_rate=2:4:1000", "tilt=0.001deg:5deg:1000:log"])
    starts = np.stack(list(cells.starts(spec, Span(0, spec.size)).values()))
    print(f"exact reduction, 1000 x 1000 cells of the rolling preset, {threads} threads, median of {repeats}")
    for words, with_period in (("extremes", False), ("with the period", True)):

        def reduce(with_period: bool = with_period) -> None:
            with numba.parallel_chunksize(1):
                extremes()(starts, _FALL_TILT, with_period)

        reduce()
        times = [_seconds(reduce) for _ in range(repeats)]
        print(
            f"  {words:<19} {spec.size / statistics.median(times) / 1e6:8.2f} e6 cells/s  "
            f"({spec.size / max(times) / 1e6:.2f} to {spec.size / min(times) / 1e6:.2f})"
        )


def whole_run(threads: int, repeats: int) -> None:
    """Print the time and memory of `eulerdisk run` on a million cells, file included, kernels in the cache."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "atlas.nc"
        grid = ["roll_rate=2:4:1000", "tilt=0.001deg:5deg:1000:log"]
        command = [sys.executable, "-m", "sweep", "run", "rolling", *grid, "-o", str(path), "--overwrite"]
        command += ["--threads", str(threads)]
        times = [
            _seconds(lambda: subprocess.run(command, check=True, capture_output=True)) for _ in range(repeats)
        ]
        peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
        print(f"eulerdisk run, 1000 x 1000 cells of the rolling preset, {threads} threads, {repeats} runs")
        print(
            f"  start to file       {statistics.median(times):8.2f} s  ({min(times):.2f} to {max(times):.2f})"
        )
        print(f"  resident at most    {peak:8.0f} MB")
        print(f"  file                {os.path.getsize(path) / 1e6:8.1f} MB")
        command = [sys.executable, "-m", "sweep", "verify", str(path)]
        environment = {**os.environ, "NUMBA_NUM_THREADS": str(threads)}
        times = [
            _seconds(lambda: subprocess.run(command, check=True, capture_output=True, env=environment))
            for _ in range(repeats + 1)
        ][1:]
        with sweep.open_atlas(path) as dataset:
            sweep.verify(dataset)
            inside = [_seconds(lambda: sweep.verify(dataset)) for _ in range(repeats)]
        print("eulerdisk verify, the same atlas")
        print(
            f"  start to verdict    {statistics.median(times):8.2f} s  ({min(times):.2f} to {max(times):.2f})"
        )
        print(
            f"  sweep.verify        {statistics.median(inside):8.2f} s  ({min(inside):.2f} to {max(inside):.2f})"
        )


def main() -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--threads", type=int, default=numba.config.NUMBA_NUM_THREADS)
    parser.add_argument("--repeats", type=int, default=5)
    given = parser.parse_args()
    compare_kernels(given.threads, given.repeats)
    exact_reduction(given.threads, given.repeats)
    whole_run(given.threads, given.repeats)


if __name__ == "__main__":
    main()
