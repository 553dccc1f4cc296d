"""The field: every contender's error against its time per cell, then its speed at equal accuracy."""

import statistics
import sys
from typing import Any

import numpy as np

from bench import libraries, loops, taylor
from bench.problem import TARGET, TASK, Array, Contender, Solve, peaks, some, starts, use_threads

#: Time [s] below which a contender is run a second time before it counts: the first run compiled or loaded something.
_BRIEF = 3.0


def _ladder(contender: Contender, solve: Solve, given: Array, truth: Array) -> list[dict[str, float]]:
    """Return setting, time per cell [us] and error [rad] (of 99 % of the cells) for each setting."""
    rungs: list[dict[str, float]] = []
    for setting in contender.settings:
        seconds, found = solve(given, setting)
        if seconds < _BRIEF or not rungs:
            seconds, found = solve(given, setting)
        error = float(np.quantile(np.abs(found - truth), 0.99))
        rungs.append({"setting": setting, "us_per_cell": 1e6 * seconds / given.shape[1], "error": error})
    return rungs


def _chosen(rungs: list[dict[str, float]]) -> dict[str, float]:
    """Return the coarsest rung that is accurate enough, otherwise the most accurate one."""
    enough = [rung for rung in rungs if rung["error"] <= TARGET]
    return enough[0] if enough else min(rungs, key=lambda rung: rung["error"])


def _spread(values: list[float]) -> dict[str, float]:
    return {"median": statistics.median(values), "least": min(values), "greatest": max(values)}


def measure(quick: bool, repeats: int) -> dict[str, Any]:
    """Return the table of the field, with one thread each; contenders that are not installed are absent."""
    use_threads(1)
    grid = starts()
    rows: list[dict[str, Any]] = []
    base: tuple[Solve, Array, float] | None = None
    for contender in [*loops.contenders(quick), *taylor.contenders(quick), *libraries.contenders(quick)]:
        try:
            solve = contender.prepare()
        except (ImportError, OSError) as problem:
            print(f"benchmark: {contender.name} is skipped: {problem}", file=sys.stderr)
            continue
        given = some(grid, contender.cells)
        rungs = _ladder(contender, solve, given, peaks(given))
        best = _chosen(rungs)
        base = base or (solve, given, best["setting"])
        ours, theirs = _pairs(base, (solve, given, best["setting"]), repeats)
        rows.append(
            {
                "name": contender.name,
                "knob": contender.knob,
                "setting": best["setting"],
                "cells": given.shape[1],
                "error": best["error"],
                "us_per_cell": _spread(theirs),
                "ratio": _spread([slow / fast for slow, fast in zip(theirs, ours, strict=True)]),
                "ladder": rungs,
            }
        )
        print(f"benchmark: {contender.name}: {rows[-1]['us_per_cell']['median']:.3g} us", file=sys.stderr)
    return {"task": " ".join(TASK), "target": TARGET, "contenders": rows}


def _pairs(
    base: tuple[Solve, Array, float], other: tuple[Solve, Array, float], repeats: int
) -> tuple[list[float], list[float]]:
    """Return the times per cell [us] of the engine and of another contender, measured by turns."""
    times: tuple[list[float], list[float]] = ([], [])
    for _ in range(repeats):
        for (solve, given, setting), taken in zip((base, other), times, strict=True):
            taken.append(1e6 * solve(given, setting)[0] / given.shape[1])
    return times
