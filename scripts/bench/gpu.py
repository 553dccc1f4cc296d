"""RK4 steps per second on a CUDA device, if there is one."""

import statistics
import time
from typing import Any

import numpy as np

from bench.problem import FALL_TILT, results, starts
from kernels.disk.arrays import STEPS

#: Step [s] that makes cells long, so that the arithmetic dominates the transfers to and from the device.
_STEP = 0.0002


def measure(repeats: int, rates: int = 2048, tilts: int = 512, step: float = _STEP) -> dict[str, Any] | None:
    """Return steps/s including transfers for a grid of rates by tilts; None without a device."""
    from numba import config, cuda

    # the simulator's time is meaningless
    if config.ENABLE_CUDASIM or not cuda.is_available():
        return None
    from kernels.disk.integrate import LANE_MODEL
    from kernels.lanes.cuda import bind

    given = starts((f"roll_rate=2:4:{rates}", f"tilt=0.1deg:5deg:{tilts}:log"))
    n = given.shape[1]
    measures, counts = results(n)
    integrate, times = bind(LANE_MODEL), []
    # the first round compiles
    for _ in range(1 + repeats):
        began = time.perf_counter()
        integrate(given, np.array([300.0, step, FALL_TILT, 0.1]), measures, counts)
        times.append(time.perf_counter() - began)
    total = float(counts[STEPS].astype(np.int64).sum())
    name = cuda.current_context().device.name
    return {
        "device": name.decode() if isinstance(name, bytes) else str(name),
        "cells": n,
        "steps_per_cell": total / n,
        "steps_per_s": total / statistics.median(times[1:]),
    }
