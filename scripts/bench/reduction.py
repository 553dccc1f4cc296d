"""The exact reduction of a million cells and of the presets, with and without the period."""

import statistics
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import sweep
from bench.problem import reduce_disks, use_threads
from sweep.engine.grid import whole
from sweep.platforms import most_threads


def _median(work: Callable[[], object], repeats: int) -> float:
    """Return the median seconds of several runs, after one that is not counted."""
    work()
    times = []
    for _ in range(repeats):
        began = time.perf_counter()
        work()
        times.append(time.perf_counter() - began)
    return statistics.median(times)


def _rates(words: list[str], preset: str, repeats: int) -> dict[str, Any]:
    """Return cells per second for the starts of a preset, with and without the period."""
    spec = sweep.SweepSpec.from_words(preset, words)
    starts = np.stack(list(whole(spec).values()))

    def reduce(with_period: bool) -> None:
        reduce_disks(starts, with_period)

    return {
        "cells": spec.size,
        "extremes_per_s": spec.size / _median(lambda: reduce(False), repeats),
        "with_period_per_s": spec.size / _median(lambda: reduce(True), repeats),
    }


def measure(quick: bool, repeats: int) -> dict[str, Any]:
    """Return cells per second with and without the period, all threads, for rolling disks and for the presets.

    Circling disks are released next to separatrices, where a period needs several times as many points.
    """
    side = 300 if quick else 1000
    threads = most_threads()
    use_threads(threads)
    rolling = _rates([f"roll_rate=2:4:{side}", f"tilt=0.001deg:5deg:{side}:log"], "rolling", repeats)
    presets = {name: _rates([], name, repeats) for name in ("rolling", "spinning", "circling")}
    print(f"benchmark: {rolling['cells']} cells reduced, and the cells of the presets", file=sys.stderr)
    return {**rolling, "threads": threads, "presets": presets}
