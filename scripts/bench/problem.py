"""The task of every contender: find the peak tilt of cells of the rolling preset; and how it is timed.

A disk released at rest is at one turning point; its peak tilt is the tilt of the other one, or its own. Contenders that
can stop there do so. Starts are float64[len(PARAMETERS), n] (`kernels.disk.arrays`); the truth is the exact reduction.
"""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numba
import numpy as np
import numpy.typing as npt

import sweep
from kernels.bodies.shapes import TORUS
from kernels.disk.arrays import (
    ALPHA,
    COUNTS,
    GRAVITY,
    MEASURES,
    PARAMETERS,
    PRECESSION_RATE,
    RADIUS,
    ROLL_RATE,
    TILT,
    TILT_RATE,
)
from sweep.engine import compute
from sweep.engine.grid import whole
from sweep.model.disk.exact import reduce_bodies
from sweep.model.disk.path import rows_of_disk

Array = npt.NDArray[np.float64]
#: (starts, accuracy setting) -> (seconds of one processor, peak tilts [rad])
Solve = Callable[[Array, float], tuple[float, Array]]

FALL_TILT = math.radians(85.0)
#: Longest time [s] for which a contender integrates; every cell of the task turns earlier.
LONGEST = 30.0
TARGET = 1e-8

#: 200 tilts of all sizes, and 2,000 rates around the critical rate of the disk, 2.557 rad/s.
TASK = ("roll_rate=2:4:2000", "tilt=0.1deg:5deg:200:log")


@dataclass(frozen=True)
class Contender:
    """One way to do the task.

    `prepare` returns its `Solve`, or raises ImportError or OSError if it is not installed. `settings` are ordered from
    coarse to fine; `cells` is the number of cells that are timed.
    """

    name: str
    knob: str
    settings: tuple[float, ...]
    cells: int
    prepare: Callable[[], Solve]


def starts(words: tuple[str, ...] = TASK) -> Array:
    """Return the starts of a grid of the rolling preset."""
    spec = sweep.SweepSpec.from_words("rolling", list(words))
    return np.stack(list(whole(spec).values()))


def some(given: Array, count: int) -> Array:
    """Return about `count` cells, evenly spread over the grid."""
    # an odd stride reaches every tilt and every rate
    stride = max(1, given.shape[1] // count) | 1
    return np.ascontiguousarray(given[:, ::stride][:, :count])


def use_threads(threads: int) -> None:
    """Let this program's kernels, and Numba's parallel loops, use some number of threads."""
    compute.use_threads(threads)
    numba.set_num_threads(threads)


def results(n: int) -> tuple[Array, npt.NDArray[np.int32]]:
    """Return arrays for the measures and counts of n cells (`kernels.disk.arrays`)."""
    return np.empty((len(MEASURES), n)), np.zeros((len(COUNTS), n), np.int32)


def reduce_disks(given: Array, timed: bool) -> dict[str, npt.NDArray[Any]]:
    """Return the results of the exact reduction for cells, by name."""
    rows = rows_of_disk(dict(zip(PARAMETERS, given, strict=True)))
    return reduce_bodies(rows, TORUS, FALL_TILT, timed)


def peaks(given: Array) -> Array:
    """Return the exact peak tilts [rad]."""
    found = reduce_disks(given, False)
    return np.asarray(np.maximum(np.abs(found["tilt_min"]), np.abs(found["tilt_max"])))


def periods(given: Array) -> Array:
    """Return the exact nutation periods [s]."""
    return np.asarray(reduce_disks(given, True)["nutation_period"])


def scaled(given: Array) -> tuple[Array, Array]:
    """Return scaled state [tilt, w, o, s] (4, n) and constants (4, n) (`kernels.disk.equations`)."""
    tilt, rate, precession, roll = given[TILT], given[TILT_RATE], given[PRECESSION_RATE], given[ROLL_RATE]
    alpha, unit = given[ALPHA], np.sqrt(given[RADIUS] / given[GRAVITY])
    state = np.stack(
        [tilt, unit * rate, unit * precession * np.cos(tilt), unit * (roll + precession * np.sin(tilt))]
    )
    constants = np.stack([1.0 / (1.0 + 0.5 * alpha), 1.0 + alpha, 0.5 * alpha, 1.0 / (1.0 + alpha)])
    return state, constants


def headings(given: Array) -> Array:
    """Return the sign of the tilt rate on the way to the other turning point, for cells released at rest."""
    state, constants = scaled(given)
    tilt, _, o, s = state
    return np.asarray(
        np.sign(np.sin(tilt) + o * (constants[1] * s - constants[2] * o * np.tan(tilt))), dtype=np.float64
    )


def longest(given: Array, duration: float = LONGEST) -> float:
    """Return a duration [s] in scaled time (radius and gravity are the same in all cells)."""
    return float(duration / np.sqrt(given[RADIUS, 0] / given[GRAVITY, 0]))


def timed(solve: Callable[[Array, float], Array]) -> Solve:
    """Return a `Solve` that measures the processor time of the whole call, which other work hardly affects."""

    def run(given: Array, setting: float) -> tuple[float, Array]:
        began = time.process_time()
        found = solve(given, setting)
        return time.process_time() - began, found

    return run
