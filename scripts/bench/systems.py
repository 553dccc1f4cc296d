"""Systems of ten lines: the cost of one integration at equal error, compared with heyoka, a compiled loop and SciPy.

The error of a cell is the largest error of its states at the end of the duration; 90 % of the cells must be within
`TARGET`. Each contender is timed at the two settings whose errors are on either side of it, and the time is
interpolated between them. The truth is heyoka's in long double. `eulerdisk` is one pass; a whole run makes four passes
and states errors.
"""

import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import sweep
from bench import problem
from bench.loops import contenders
from bench.problem import Array, peaks, periods, scaled, some, use_threads
from bench.system_loops import Loop, Scipy
from bench.ten_systems import RANGES, Heyoka, bare, random_starts, thin_disk
from kernels.disk.arrays import GRAVITY, RADIUS
from kernels.system import integrate
from kernels.system.lanes import LEGS
from sweep.engine.compute import compute
from sweep.model.system.definition import Definition
from sweep.model.system.model import model_of
from sweep.systems import System

TARGET = 1e-8

#: (starts, setting) -> states at the end
_Solve = Callable[[Array, float], Array]

_SETTINGS = tuple(10.0**-k for k in range(5, 15))
_CELLS, _SCIPY_CELLS = 1024, 12


def measure(quick: bool, repeats: int) -> dict[str, Any] | None:
    """Return the costs of ten systems, one thread each; None without heyoka, which provides the truth."""
    try:
        import heyoka  # noqa: F401 - only whether it is there
    except (ImportError, OSError) as missing:
        print(f"benchmark: systems are skipped: {missing}", file=sys.stderr)
        return None
    use_threads(1)
    cells = 256 if quick else _CELLS
    rows = [_row(each, cells, repeats) for each in RANGES]
    day = time.strftime("%Y-%m-%d", time.gmtime())
    found = {"target": TARGET, "cells": cells, "rows": rows, "disk": _disk(cells, repeats), "day": day}
    return found | _commands()


def _row(chosen: System, cells: int, repeats: int) -> dict[str, Any]:
    definition = bare(chosen.definition)
    given = random_starts(chosen, cells, np.random.default_rng(3))
    truth = Heyoka(definition, 1e-20, np.longdouble).motions(given)[0].T.astype(np.float64)
    began = time.process_time()
    pass_alone = Pass(definition)
    compiled = time.process_time() - began
    field: Mapping[str, tuple[_Solve, int]] = {
        "eulerdisk": (pass_alone, cells),
        **{f"heyoka batch {width}": (_Batches(definition, width), cells) for width in (1, 4, 8)},
        "compiled DOP853": (Loop(definition), cells),
        "SciPy DOP853": (Scipy(definition), _SCIPY_CELLS),
    }
    brackets = {name: _bracket(solve, given[:, :n], truth[:, :n]) for name, (solve, n) in field.items()}
    turns = [
        {name: _cost(solve, given[:, :n], brackets[name]) for name, (solve, n) in field.items()}
        for _ in range(repeats)
    ]
    row: dict[str, Any] = {
        "name": definition.name, "compiled_s": compiled,
        "us_per_cell": {name: 1e6 * min(turn[name] for turn in turns) for name in field},
        "ratio": {name: float(np.median([turn[name] / turn["eulerdisk"] for turn in turns])) for name in field},
    }  # fmt: skip
    row |= _whole(definition, given, brackets["eulerdisk"][1][0], truth)
    print(f"benchmark: systems, {definition.name}: {row['us_per_cell']['eulerdisk']:.3g} us", file=sys.stderr)
    return row


#: A system as a user writes it.
_FILE = """
@system(duration="30", ends={"over": "abs(angle) > pi"}, measures={"greatest": "max abs(rate)"}, stable="runs on")
def pendulum(angle=0.2, rate=0.0, *, damping=0.5, torque=0.9, drive=0.6667, t):
    return rate, torque*cos(drive*t) - damping*rate - sin(angle)
"""


def _commands() -> dict[str, float]:
    """Return the processor seconds of a run of 2,500 cells, for a new file and with another parameter."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        (place / "mine.py").write_text(_FILE, encoding="utf-8")
        environment = os.environ | {"EULERDISK_CACHE_DIR": str(place / "cache")}
        taken = []
        for most in ("1.5", "1.4"):
            words = (
                str(place / "mine.py"),
                "angle=-3:3:50",
                f"torque=0.5:{most}:50",
                "-o",
                str(place / f"{most}.nc"),
            )
            before = os.times()
            command = (sys.executable, "-m", "sweep", "run", *words)
            subprocess.run(command, check=True, capture_output=True, env=environment)
            after = os.times()
            taken.append(
                after.children_user + after.children_system - before.children_user - before.children_system
            )
    return {"first_s": taken[0], "changed_s": taken[1]}


def _disk(cells: int, repeats: int) -> dict[str, float]:
    """Return the cost of a unit of scaled time of the thin disk, with its own kernels and as a system.

    The disk's own kernels find the turning point after half a period; the system is followed for the median of these
    times.
    """
    given = some(problem.starts(), cells)
    state, constants = scaled(given)
    halves = 0.5 * periods(given) * np.sqrt(given[GRAVITY] / given[RADIUS])
    known = np.isfinite(halves)
    definition = replace(bare(thin_disk.definition), duration=float(np.median(halves[known])))
    starts = np.ascontiguousarray(np.vstack([state, constants[1] - 1.0])[:, known])
    truth = Heyoka(definition, 1e-20, np.longdouble).motions(starts)[0].T.astype(np.float64)
    own, written = next(iter(contenders(True))), Pass(definition)
    solve = own.prepare()
    kernel: _Solve = lambda cells, setting: solve(cells, setting)[1][None]  # noqa: E731 - one line
    turning = np.ascontiguousarray(given[:, known])
    kernel_bracket = _bracket(kernel, turning, peaks(turning)[None], own.settings)
    bracket = _bracket(written, starts, truth)
    turns = [
        (
            _cost(kernel, turning, kernel_bracket) / float(halves[known].mean()),
            _cost(written, starts, bracket) / definition.duration,
        )
        for _ in range(repeats)
    ]
    return {
        "own_us": 1e6 * min(turn[0] for turn in turns),
        "system_us": 1e6 * min(turn[1] for turn in turns),
        "ratio": float(np.median([turn[1] / turn[0] for turn in turns])),
    }


class Pass:
    """One pass of a system: a call makes several, with equal tolerances, and each counts its share of the time."""

    def __init__(self, definition: Definition) -> None:
        self._model = model_of(definition)
        given: Any = (*integrate.program_of(self._model.integrate.function), (1.0,) * len(LEGS))
        self._entry = integrate.entry_point(*given)
        self._entry.make_ready()

    #: Number of passes per call.
    share = len(LEGS)

    def __call__(self, starts: Array, tolerance: float) -> Array:
        """Return the states at the end."""
        model, n = self._model, starts.shape[1]
        measures, counts = np.empty((len(model.measures), n)), np.zeros((len(model.counts), n), np.int32)
        settings = np.array([model.definition.duration, 0.0, tolerance])
        self._entry(np.ascontiguousarray(starts), settings, measures, counts)
        return measures[: len(model.definition.states)]


class _Batches:
    """heyoka with one batch size, created once for each tolerance."""

    def __init__(self, definition: Definition, width: int) -> None:
        self._definition, self._width, self._made = definition, width, dict[float, Heyoka]()

    def __call__(self, starts: Array, tolerance: float) -> Array:
        if tolerance not in self._made:
            self._made[tolerance] = Heyoka(self._definition, tolerance, float, self._width)
        return self._made[tolerance].ends(starts)


def _error(found: Array, truth: Array) -> float:
    """Return the error that 90 % of the cells do not exceed."""
    worst = np.abs(found - truth).max(axis=0)
    return max(float(np.quantile(worst, 0.9)), 1e-300)


def _bracket(
    solve: _Solve, given: Array, truth: Array, settings: tuple[float, ...] = _SETTINGS
) -> list[tuple[float, float]]:
    """Return the two settings, and their errors, between which the error is `TARGET`."""
    last: tuple[float, float] | None = None
    for setting in settings:
        found = setting, _error(solve(given, setting), truth)
        if found[1] <= TARGET:
            return [last or found, found]
        last = found
    raise RuntimeError(f"no setting reaches an error of {TARGET:g}")


def _cost(solve: _Solve, given: Array, bracket: list[tuple[float, float]]) -> float:
    """Return the processor time per cell at the error `TARGET`, interpolated between two settings."""
    times: list[float] = []
    for setting, _ in bracket:
        began = time.process_time()
        solve(given, setting)
        times.append((time.process_time() - began) / given.shape[1] / float(getattr(solve, "share", 1)))
    errors = [error for _, error in bracket]
    if errors[0] == errors[1]:
        return times[1]
    along = math.log(errors[0] / TARGET) / math.log(errors[0] / errors[1])
    return times[0] * math.exp(along * math.log(times[1] / times[0]))


def _whole(definition: Definition, given: Array, tolerance: float, truth: Array) -> dict[str, float]:
    """Return the cost of all passes and stated errors, from starts to columns, and their accuracy."""
    model = model_of(definition)
    spec = sweep.SweepSpec(model=model).replace(tolerance=tolerance)
    starts = dict(zip(model.parameters, given, strict=True))
    columns = compute(spec, starts)
    began = time.process_time()
    compute(spec, starts)
    names = [each.name for each in definition.states]
    found = np.array([columns[f"{name}_end"] for name in names])
    return {
        "whole_us_per_cell": 1e6 * (time.process_time() - began) / given.shape[1],
        "whole_error": _error(found, truth),
        "whole_tolerance": tolerance,
    }
