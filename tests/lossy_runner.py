"""Calls of the kernels that integrate the lossy disk: starts in, named results out."""

import contextlib
from types import SimpleNamespace
from unittest import mock

import numpy as np

from kernels.lossy_disk.arrays import COUNTS, FRICTION, LOSSES, MEASURES, SAMPLES, SETTINGS
from kernels.native import workers
from sweep import platforms
from sweep.model.kernel import Kernel
from sweep.model.lossy_disk.model import LossyDisk

FLAT_TILT = np.deg2rad(89.9)

#: The variant with all laws, by air law: each takes ten seconds to compile, so there is no variant for no air law.
WITH_ALL_LAWS = {
    "none": "integrate_rolling_pivoting_moffatt_slipping",
    "moffatt": "integrate_rolling_pivoting_moffatt_slipping",
    "bildsten": "integrate_rolling_pivoting_bildsten_slipping",
}
AIR_LAWS = tuple(WITH_ALL_LAWS)


def run(starts, *, air="none", variant="", threads=None, **settings):
    """Integrate starts, float64[len(PARAMETERS), n], of `lossy_referee.starts`; settings are rows of `SETTINGS`.

    A `limit` without other settings limits the tilt.

    Returns
    -------
    SimpleNamespace
        The measures and counts, each an array of shape (n,).
    """
    values = {"duration": 30.0, "flat_tilt": FLAT_TILT, "tolerance": 1e-8, "air_law": AIR_LAWS.index(air)}
    values["limited"] = float("limit" in settings)
    row = np.array([float({**values, **settings}.get(name, 0.0)) for name in SETTINGS])
    n = starts.shape[1]
    measures, counts = np.full((len(MEASURES), n), -777.0), np.full((len(COUNTS), n), -777, np.int32)
    kernel = Kernel("kernels.lossy_disk.integrate", variant or WITH_ALL_LAWS[air]).load()
    workers.use(platforms.processors() if threads is None else threads)
    try:
        with np.errstate(all="ignore"):
            kernel(np.ascontiguousarray(starts), row, measures, counts)
    finally:
        workers.use(None)
    return SimpleNamespace(**dict(zip((*MEASURES, *COUNTS), (*measures, *counts), strict=True)))


@contextlib.contextmanager
def general_kernels():
    """Use the kernels with all laws: each set of laws has its own, which takes seconds to compile."""

    def integrator(self, spec):
        return Kernel(self.integrate.module, WITH_ALL_LAWS[spec.air_law])

    with mock.patch.object(LossyDisk, "integrator", integrator):
        yield


def bits(results, cells=slice(None)):
    """Return all results of some cells as bytes, one row per cell."""
    columns = [np.ascontiguousarray(column[cells]) for column in vars(results).values()]
    return np.concatenate([column.view(np.uint8).reshape(len(column), -1) for column in columns], axis=1)


def run_single(starts, *, air="none", duration=30.0, flat_tilt=FLAT_TILT, relative_step=0.0):
    """Integrate starts one by one as single motions; return the results of `run` that their ends provide."""
    trajectory = Kernel("kernels.lossy_disk.trajectory", "trajectory").load()
    settings = np.array([0.0, relative_step, flat_tilt, float(AIR_LAWS.index(air))])
    cells = []
    for start in starts.T:
        samples = np.full((len(SAMPLES), 2), np.nan)
        times = np.array([0.0, duration])
        ending, filled, last, steps = trajectory(
            np.ascontiguousarray(start)[:, np.newaxis], settings, times, samples
        )
        end = dict(zip(SAMPLES, samples[:, filled - 1], strict=True))
        named = {name: end[name] for name in LOSSES} | {
            "end_tilt": end["tilt"],
            "heading_turned": end["heading"],
            "contact_x": end["contact_x"],
            "contact_y": end["contact_y"],
        }
        cells.append(named | {"ending": ending, "end_time": last, "steps": steps})
    return SimpleNamespace(**{name: np.array([cell[name] for cell in cells]) for name in cells[0]})


def needed_friction(start, *, air="none", duration=10.0, moments=20001):
    """Return the friction coefficient that a start needs at equal time intervals, until its motion ends."""
    trajectory = Kernel("kernels.lossy_disk.trajectory", "trajectory").load()
    settings = np.array([0.0, 0.0, FLAT_TILT, float(AIR_LAWS.index(air))])
    samples = np.full((len(SAMPLES), moments), np.nan)
    rough = np.array(start)
    rough[FRICTION] = np.inf
    _, filled, _, _ = trajectory(rough[:, np.newaxis], settings, np.linspace(0.0, duration, moments), samples)
    known = dict(zip(SAMPLES, samples[:, : filled - 1], strict=True))
    return np.hypot(known["friction_across"], known["friction_along"]) / known["normal_force"]
