"""Calls of the kernel that integrates the disk: starts in, named results out."""

import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import referee
from referee import FALL_TILT

from kernels.disk import equations as disk
from kernels.disk.arrays import (
    COUNTS,
    ENDING,
    ENERGY_DRIFT,
    FALL_TIME,
    MEASURES,
    NUTATION_PERIOD,
    REFINEMENTS,
    STEPS,
    TILT_ERROR,
    TILT_MAX,
    TILT_MIN,
)
from kernels.native import workers
from sweep import platforms
from sweep.engine.compute import Block, compute, use_threads
from sweep.engine.grid import BLOCK_CELLS, blocks, starts_of, whole
from sweep.model.disk.model import DISK
from sweep.request.sources import Range
from sweep.request.spec import SweepSpec

_TESTS = Path(__file__).parent


@dataclass(frozen=True)
class Results:
    """Measures and counts of each cell (`kernels.disk.arrays`); arrays of shape (n,)."""

    least: np.ndarray
    greatest: np.ndarray
    fall_time: np.ndarray
    period: np.ndarray
    energy_drift: np.ndarray
    tilt_error: np.ndarray
    ending: np.ndarray
    steps: np.ndarray
    refinements: np.ndarray

    @classmethod
    def of(cls, measures, counts):
        """Return the results from the arrays that the kernel has written."""
        return cls(
            least=measures[TILT_MIN],
            greatest=measures[TILT_MAX],
            fall_time=measures[FALL_TIME],
            period=measures[NUTATION_PERIOD],
            energy_drift=measures[ENERGY_DRIFT],
            tilt_error=measures[TILT_ERROR],
            ending=counts[ENDING],
            steps=counts[STEPS],
            refinements=counts[REFINEMENTS],
        )

    @property
    def peak(self):
        """Return the largest magnitude of the tilt [rad]."""
        return np.maximum(np.abs(self.least), np.abs(self.greatest))

    def bits(self, cells=slice(None)):
        """Return all results of some cells as bytes, one row per cell."""
        columns = [np.ascontiguousarray(column[cells]) for column in vars(self).values()]
        return np.concatenate([column.view(np.uint8).reshape(len(column), -1) for column in columns], axis=1)


def run(starts, *, duration=300.0, step=0.0, fall_tilt=FALL_TILT, tolerance=1e-8, threads=None):
    """Integrate starts, float64[len(PARAMETERS), n], by default with all threads."""
    n = starts.shape[1]
    measures, counts = unwritten(n)
    workers.use(platforms.processors() if threads is None else threads)
    try:
        # Without the compiler the kernels are plain Python, whose floats warn where compiled ones do not.
        with np.errstate(all="ignore"):
            given = np.ascontiguousarray(starts)
            DISK.integrate.load()(given, np.array([duration, step, fall_tilt, tolerance]), measures, counts)
    finally:
        workers.use(None)
    return Results.of(measures, counts)


def run_blocks(spec, threads=None, block_cells=BLOCK_CELLS):
    """Yield the computed cells of a spec, block by block in C order."""
    use_threads(threads)
    for span in blocks(spec.size, block_cells):
        yield Block(span, compute(spec, starts_of(spec, span)))


def unwritten(n):
    """Return arrays of measures and counts of n cells, filled with numbers that no kernel writes."""
    return np.full((len(MEASURES), n), -777.0), np.full((len(COUNTS), n), -777, np.int32)


def flow(state, alpha):
    """Return the time derivatives of a scaled state (S, C, T, w, o, s), shape (6,)."""
    S, C, T, w, o, s = state
    i_tilt, i_roll, i_spin, i_inverse = disk.inertia(alpha)
    (dS, minus_dC, dT, do, minus_dp), acceleration = disk.slopes(
        (S, C, T, o, i_roll * s), i_spin, 2.0 * i_inverse
    )
    rates = [w * dS, -w * minus_dC, w * dT, i_tilt * acceleration, w * do, -w * minus_dp * i_inverse]
    return np.array(rates)


def scattered(n, seed):
    """Return random starts over all seven parameters, a third of them released at rest."""
    rng = np.random.default_rng(seed)
    radius, gravity = 10.0 ** rng.uniform(-2.0, 1.0, n), 10.0 ** rng.uniform(-0.5, 1.5, n)
    unit = np.sqrt(radius / gravity)
    return referee.starts(
        tilt=rng.uniform(-1.4, 1.4, n),
        tilt_rate=rng.uniform(-1.5, 1.5, n) / unit * (rng.random(n) < 0.7),
        precession_rate=rng.uniform(-3.0, 3.0, n) / unit * (rng.random(n) < 0.9),
        roll_rate=rng.uniform(-3.0, 3.0, n) / unit * (rng.random(n) < 0.9),
        alpha=rng.uniform(0.02, 1.0, n),
        radius=radius,
        gravity=gravity,
    )


def errors(found, truth):
    """Return the largest error of the two extreme tilts of each cell [rad]."""
    return np.maximum(np.abs(found.least - truth.least), np.abs(found.greatest - truth.greatest))


def coarse(preset):
    """Return the starts of 40 x 30 cells over the ranges of a preset."""
    spec = SweepSpec.preset(preset)
    axes = {name: getattr(spec, name) for name in spec.axes}
    counts = {name: 30 if name == "tilt" else 40 for name in axes}
    spec = spec.replace(
        **{name: Range(axis.start, axis.stop, counts[name], axis.spacing) for name, axis in axes.items()}
    )
    return np.stack(list(whole(spec).values()))


def process(words, *, simulator, folder):
    """Run Python in a separate process, with or without Numba's CUDA simulator."""
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(map(str, (_TESTS.parent, _TESTS))),
        "NUMBA_ENABLE_CUDASIM": str(int(simulator)),
    }
    return subprocess.run(
        [sys.executable, *map(str, words)],
        cwd=folder, env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
