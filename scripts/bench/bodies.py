"""The cost of other bodies: a step relative to a step of the thin disk, the reduction, and the errors of the engine.

Balls and spheroids have only the reduction.
"""

import statistics
import sys
import time
from typing import Any

import numpy as np

import sweep
from bench.problem import use_threads
from sweep.engine import compute
from sweep.engine.grid import whole

#: Body -> its words; empty for the thin disk, with which the others are compared.
BODIES = {
    "disk": {},
    "torus": {"body": "torus", "tube": 0.25},
    "rounded": {"body": "rounded", "thickness": 0.2},
    "rim": {"body": "rim", "thickness": 0.2, "fillet": 0.02},
    "arc": {"body": "arc", "fillet": 0.3, "offset": -0.1, "axial_moment": 0.4, "transverse_moment": 0.3},
    "ball": {"body": "ball", "offset": 0.2, "axial_moment": 0.42, "transverse_moment": 0.38},
    "spheroid": {"body": "spheroid", "flattening": 0.3},
}

_REDUCED = ("ball", "spheroid")

#: Scaled rates and tilts of random starts, in units of sqrt(gravity/radius), where both are 1.
_STARTS = {
    "radius": 1.0, "gravity": 1.0, "seed": 5, "tilt": "uniform:-80deg:80deg", "tilt_rate": "normal:0:0.5",
    "precession_rate": "normal:0:1.5", "roll_rate": "normal:0:1.5",
}  # fmt: skip


def _step_times(cells: int, repeats: int) -> dict[str, float]:
    """Return the time of an equal step of each body [ns], with one thread, measured by turns."""
    specs = {
        name: sweep.SweepSpec(**_STARTS, **words, samples=cells, step=0.01, duration=100, tolerance=0.1)
        for name, words in BODIES.items()
        if name not in _REDUCED
    }
    starts = {name: whole(spec) for name, spec in specs.items()}
    times: dict[str, list[float]] = {name: [] for name in specs}
    for turn in range(repeats + 1):
        for name, spec in specs.items():
            began = time.process_time()
            found = compute.measure(spec, starts[name])
            if turn:
                times[name].append((time.process_time() - began) / found["steps"].sum() * 1e9)
    return {name: statistics.median(each) for name, each in times.items()}


def _errors(name: str, cells: int) -> dict[str, float]:
    """Return the cost of a body's reduction, and how far default-tolerance extremes differ from it."""
    spec = sweep.SweepSpec(**_STARTS, **BODIES[name], samples=cells, duration=1e4)
    starts = whole(spec)
    reduced = spec.replace(method="exact")
    compute.measure(reduced, starts)
    began = time.process_time()
    exact = compute.measure(reduced, starts)
    seconds = time.process_time() - began
    if name in _REDUCED:
        return {"cells": cells, "reduction_us": seconds / cells * 1e6}
    engine = compute.measure(spec, starts)
    apart = np.fmax(
        np.abs(engine["tilt_min"] - exact["tilt_min"]), np.abs(engine["tilt_max"] - exact["tilt_max"])
    )
    bounded = exact["ending"] == spec.model.endings.code("bounded")
    beyond = apart > 2.0 * engine["tilt_error"] + np.nan_to_num(exact["tilt_error"]) + 2e-14
    return {
        "cells": cells,
        "other_endings": int((engine["ending"] != exact["ending"]).sum()),
        "largest_error": float(np.nanmax(apart)),
        "beyond_twice_stated": float(beyond[bounded].mean()),
        "reduction_us": seconds / cells * 1e6,
    }


def measure(quick: bool, repeats: int) -> dict[str, Any]:
    """Return the cost of a step and of the reduction, and the errors, for each body; one thread."""
    use_threads(1)
    steps = _step_times(300 if quick else 2000, repeats)
    print("benchmark: steps of other bodies", file=sys.stderr)
    errors = {name: _errors(name, 2000 if quick else 25_000) for name in BODIES if name != "disk"}
    return {"ns_per_step": steps, "errors": errors}
