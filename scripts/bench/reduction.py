"""The exact reduction of a million cells, with the period and without."""

import statistics
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import sweep
from bench.problem import FALL_TILT, use_threads
from sweep.engine.grid import whole
from sweep.model.disk.exact import EXTREMES
from sweep.platforms import most_threads


def _median(work: Callable[[], object], repeats: int) -> float:
    """Return the seconds of the median run after one that is not counted."""
    work()
    times = []
    for _ in range(repeats):
        began = time.perf_counter()
        work()
        times.append(time.perf_counter() - began)
    return statistics.median(times)


def measure(quick: bool, repeats: int) -> dict[str, Any]:
    """Return cells per second with and without the period, all threads."""
    side = 300 if quick else 1000
    words = [f"roll_rate=2:4:{side}", f"tilt=0.001deg:5deg:{side}:log"]
    spec = sweep.SweepSpec.from_words("rolling", words)
    starts = np.stack(list(whole(spec).values()))
    threads = most_threads()
    use_threads(threads)

    def reduce(with_period: bool) -> None:
        EXTREMES.load()(starts, FALL_TILT, with_period)

    found = {
        "cells": spec.size,
        "threads": threads,
        "extremes_per_s": spec.size / _median(lambda: reduce(False), repeats),
        "with_period_per_s": spec.size / _median(lambda: reduce(True), repeats),
    }
    print(f"benchmark: {spec.size} cells reduced", file=sys.stderr)
    return found
