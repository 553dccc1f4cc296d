"""Time per cell against the numbers of cells and threads."""

import statistics
import sys
import time
from typing import Any

import numpy as np

import sweep
from bench.problem import FALL_TILT, results, use_threads
from sweep.engine.grid import blocks, starts_of
from sweep.model.disk.model import DISK
from sweep.platforms import most_threads


def grid(count: int) -> list[str]:
    """Return the words of about `count` cells over the ranges of the rolling preset."""
    rates = round((4 * count) ** 0.5)
    return [f"roll_rate=2:4:{rates}", f"tilt=0.001deg:5deg:{count // rates}:log"]


def kernel_seconds(count: int, threads: int) -> float:
    """Return the seconds in the kernel, block by block as in a run."""
    use_threads(threads)
    spec = sweep.SweepSpec.from_words("rolling", grid(count))
    settings = np.array([spec.duration, 0.0, FALL_TILT, spec.tolerance])
    taken = 0.0
    for span in blocks(spec.size):
        given = np.stack(list(starts_of(spec, span).values()))
        measures, counts = results(len(span))
        began = time.perf_counter()
        DISK.integrate.load()(given, settings, measures, counts)
        taken += time.perf_counter() - began
    return taken


def measure(quick: bool, repeats: int) -> list[dict[str, Any]]:
    """Return the time per cell [us] for numbers of cells, with one thread and with all, by turns."""
    most = most_threads()
    rows: list[dict[str, Any]] = []
    for power in range(3, 6 if quick else 8):
        count = 10**power
        # short runs more often: a median of few would depend on the machine's other users
        rounds = 1 if power == 7 else max(repeats, 50 if power == 3 else 0)
        taken: dict[int, list[float]] = {threads: [] for threads in sorted({1, most})}
        for _ in range(rounds):
            for threads, seconds in taken.items():
                seconds.append(kernel_seconds(count, threads))
        rows += [
            {"cells": count, "threads": threads, "us_per_cell": 1e6 * statistics.median(seconds) / count}
            for threads, seconds in taken.items()
        ]
        print(f"benchmark: {count} cells done", file=sys.stderr)
    return rows
