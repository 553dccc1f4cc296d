"""The disk with losses: how fast toys stop, compared with a plain loop and heyoka, and how full lanes and threads are.

The task is the time until each toy is flat, from nutating starts, with contour friction and the drag of a boundary
layer. The truth is the reference of the tests, DOP853 at 1e-13.
"""

import sys
import time
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import sweep
from bench import lossy_steps
from bench.lossy_loops import FLAT_TILT, Heyoka, plain
from bench.problem import Array, some, use_threads
from kernels.lanes.schedule import CHUNK
from kernels.lossy_disk.arrays import BILDSTEN, COUNTS, END_TIME, ENDING, MEASURES, REFINEMENTS, STEPS
from kernels.lossy_disk.endings import FLAT
from kernels.native.entry import coprime_stride
from sweep.engine.grid import whole
from sweep.model.lossy_disk.model import LOSSY_DISK
from sweep.platforms import most_threads

#: Toys that become flat after 2 to 23 s.
TASK = ("tilt=60deg:80deg:40", "scaled_precession_rate=3:4.5:50", "contour_friction=30um")

#: Toys that take about 100 s.
LONG = ("tilt=45deg:70deg:{0}", "scaled_precession_rate=2.4:4:{0}", "contour_friction=5um")

#: Promised relative error of the times.
TARGET = 1e-6

#: (starts, accuracy setting) -> times until flat [s], steps of all cells
_Solve = Callable[[Array, float], tuple[Array, float]]

#: The default tolerance, with which the long toys run.
TOLERANCE = 1e-8

#: Number of copies of a cell, which fill all lanes twice, and number of cells of a chunk that are copied.
_COPIES, _SAMPLE = 64, 5


def starts(words: tuple[str, ...]) -> Array:
    """Return the starts of a grid of the toy."""
    return np.stack(list(whole(sweep.SweepSpec.from_words("toy", list(words))).values()))


def measure(quick: bool, repeats: int) -> dict[str, Any]:
    """Return the table of contenders and of steps, one thread each, and the time of many toys with all threads."""
    use_threads(1)
    found = {"task": " ".join(TASK), "target": TARGET, "contenders": _contenders(quick, repeats)}
    found["steps"] = lossy_steps.measure(3 * repeats)
    return found | {"toys": _toys(80 if quick else 200)}


@cache
def _kernel() -> Callable[..., Any]:
    return LOSSY_DISK.integrator(sweep.SweepSpec.from_words("toy", list(TASK))).load()


def _integrate(given: Array, tolerance: float) -> tuple[Array, npt.NDArray[np.int32]]:
    """Return the measures and counts of the engine."""
    n = given.shape[1]
    measures, counts = np.empty((len(MEASURES), n)), np.zeros((len(COUNTS), n), np.int32)
    settings = np.array([300.0, 0.0, FLAT_TILT, tolerance, 0.0, 0.0, 0.0, float(BILDSTEN)])
    _kernel()(given, settings, measures, counts)
    return measures, counts


def _engine(given: Array, tolerance: float) -> tuple[Array, float]:
    measures, counts = _integrate(given, tolerance)
    return measures[END_TIME], float(counts[STEPS].sum())


def _true_times(given: Array) -> Array:
    """Return the times from the reference of the tests."""
    sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))
    import lossy_referee

    found = lossy_referee.run(given, air="bildsten", duration=300.0, flat_tilt=FLAT_TILT, rtol=1e-13)
    assert (found.ending == FLAT).all()
    return np.asarray(found.end_time)


def _time(solve: _Solve, given: Array, setting: float) -> tuple[float, Array, float]:
    """Return processor time, times until flat, and steps."""
    began = time.process_time()
    found, steps = solve(given, setting)
    return time.process_time() - began, found, steps


def _contenders(quick: bool, repeats: int) -> list[dict[str, Any]]:
    """Return name, setting, error, and time per cell and step of each contender at its coarsest accurate setting."""
    grid = starts(TASK)
    known = some(grid, 64)
    truth = _true_times(known)
    field: list[tuple[str, Callable[[], _Solve], tuple[float, ...], int]] = [
        ("eulerdisk rk4", lambda: _engine, (1e-6, 1e-7, 1e-8, 1e-9), 2000),
        ("Numba prange RK4", lambda: plain, (0.24, 0.12, 0.06, 0.03), 128),
        ("heyoka batch", Heyoka, (1e-4, 1e-5, 1e-6, 1e-7, 1e-9), 128 if quick else 1024),
    ]
    rows: list[dict[str, Any]] = []
    for name, prepare, settings, count in field:
        try:
            solve = prepare()
        except (ImportError, OSError) as problem:
            print(f"benchmark: {name} is skipped: {problem}", file=sys.stderr)
            continue
        errors = {each: _error(solve(known, each)[0], truth) for each in settings}
        setting = next((each for each in settings if errors[each] <= TARGET), settings[-1])
        rows.append(
            _row(
                name, (solve, some(grid, count), setting), errors[setting], rows[0] if rows else None, repeats
            )
        )
        print(f"benchmark: losses, {name}: {rows[-1]['us_per_cell']:.3g} us", file=sys.stderr)
    return rows


def _error(found: Array, truth: Array) -> float:
    """Return the relative error that 99 % of the times do not exceed."""
    return float(np.quantile(np.abs(found / truth - 1.0), 0.99))


def _row(
    name: str, task: tuple[_Solve, Array, float], error: float, first: dict[str, Any] | None, repeats: int
) -> dict[str, Any]:
    """Return the row of a contender; the least of several times counts, because the machine may have other work."""
    solve, given, setting = task
    runs = [_time(solve, given, setting) for _ in range(repeats)]
    seconds, steps = min(run[0] for run in runs), runs[0][2]
    each = 1e6 * seconds / given.shape[1]
    return {
        "name": name,
        "setting": setting,
        "cells": given.shape[1],
        "error": error,
        "us_per_cell": each,
        "steps_per_cell": steps / given.shape[1],
        "ns_per_step": 1e9 * seconds / steps if steps else 0.0,
        "ratio": each / first["us_per_cell"] if first else 1.0,
    }


def _toys(along: int) -> dict[str, Any]:
    """Return the cost of the toys of a square grid with all threads, and how busy threads and lanes are."""
    threads = most_threads()
    given = starts(tuple(word.format(along) for word in LONG))
    use_threads(threads)
    began, spent = time.perf_counter(), time.process_time()
    measures, counts = _integrate(given, TOLERANCE)
    clock, processor = time.perf_counter() - began, time.process_time() - spent
    use_threads(1)
    chunks, full = _chunk_by_chunk(given)
    steps, repeated = counts[STEPS].astype(float), counts[REFINEMENTS]
    least = sum(seconds * steps[repeated == often].sum() for often, seconds in full.items())
    return {
        "cells": given.shape[1],
        "threads": threads,
        "seconds": clock,
        "processor_seconds": processor,
        "share_of_threads": sum(chunks) / (threads * _longest_thread(chunks, threads)),
        "share_of_lanes": least / sum(chunks),
        "steps_per_cell": float(steps.mean()),
        "ns_per_step": 1e9 * sum(chunks) / float(steps.sum()),
        "repeated": float((repeated > 0).mean()),
        "flat": float((counts[ENDING] == FLAT).mean()),
        "times": [float(each) for each in np.quantile(measures[END_TIME], (0.05, 0.5, 0.95))],
    }


def _chunk_by_chunk(given: Array) -> tuple[list[float], dict[int, float]]:
    """Return the processor time of every chunk, and the time of a step with all lanes busy.

    Lanes that compute copies of one cell end together. Steps that were repeated with a shorter one are not counted, so
    the time of a step is grouped by the number of its cell's repetitions. Both are measured by turns, so that other
    users of the machine slow them equally.
    """
    chunks: list[float] = []
    spent: dict[int, Array] = {}
    for first in range(0, given.shape[1], CHUNK):
        chunk = np.ascontiguousarray(given[:, first : first + CHUNK])
        began = time.process_time()
        _, counts = _integrate(chunk, TOLERANCE)
        chunks.append(time.process_time() - began)
        for cell in np.linspace(0, chunk.shape[1] - 1, _SAMPLE).astype(int):
            copies = np.ascontiguousarray(np.repeat(chunk[:, cell : cell + 1], _COPIES, axis=1))
            seconds, _, steps = _time(_engine, copies, TOLERANCE)
            often = int(counts[REFINEMENTS, cell])
            spent[often] = spent.get(often, np.zeros(2)) + np.array([seconds, steps])
    return chunks, {often: float(seconds / steps) for often, (seconds, steps) in spent.items()}


def _longest_thread(chunks: list[float], threads: int) -> float:
    """Return how long the last thread works if each thread takes the next chunk, as in the kernels."""
    stride, busy = coprime_stride(len(chunks)), [0.0] * threads
    for turn in range(len(chunks)):
        busy[busy.index(min(busy))] += chunks[turn * stride % len(chunks)]
    return max(busy)
