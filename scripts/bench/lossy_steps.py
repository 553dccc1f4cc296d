"""The cost of one Runge-Kutta step with each law of friction and drag, relative to a step of the disk without losses.

The same nutating wobbles of a toy are run on one thread, by turns; the least of several times counts, because the
machine may have other work. Motions are long compared with the overhead before and after their steps.
"""

import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from bench.problem import Array
from kernels.disk.arrays import COUNTS as DISK_COUNTS
from kernels.disk.arrays import MEASURES as DISK_MEASURES
from kernels.disk.arrays import STEPS as DISK_STEPS
from kernels.lossy_disk import arrays
from kernels.lossy_disk.integrate import variant
from sweep.model.disk.model import DISK
from sweep.model.kernel import Kernel

#: Parameters of each law, all too weak to change the motion in this time.
_LAWS = {
    "contour friction": {"contour_friction": 4e-6},
    "contour damping": {"contour_damping": 1e-7},
    "contour friction and damping": {"contour_friction": 4e-6, "contour_damping": 1e-7},
    "air, Moffatt": {"air_viscosity": 1.8e-5},
    "air, Bildsten": {"air_viscosity": 1.8e-5, "air_density": 1.2},
    "contour friction and air, Bildsten": {
        "contour_friction": 4e-6,
        "air_viscosity": 1.8e-5,
        "air_density": 1.2,
    },
    "rolling friction": {"rolling_friction": 4e-6},
    "contour and rolling friction": {"contour_friction": 4e-6, "rolling_friction": 4e-6},
}
_TOY = {"alpha": 0.5, "radius": 0.03755, "gravity": 9.81, "mass": 0.4387, "friction": math.inf}

#: Duration [s] with losses; step [s] without losses, which makes motions between turning points about as long.
_LONG, _SHORT = 120.0, 5e-6

#: Solves once and returns processor time [s] and steps.
_Timed = Callable[[], tuple[float, float]]


def _wobbles(cells: int) -> tuple[Array, Array, Array]:
    """Return tilts, precession rates and roll rates of nutating wobbles at inclinations of 0.3 to 0.5."""
    rng = np.random.default_rng(3)
    inclination = rng.uniform(0.3, 0.5, cells)
    rate = np.sqrt(4.0 / np.sin(inclination)) * rng.uniform(0.97, 1.03, cells)
    rate /= math.sqrt(_TOY["radius"] / _TOY["gravity"])
    return 0.5 * math.pi - inclination, rate, -rate * np.cos(inclination)


def _prepare_without_losses(cells: int) -> _Timed:
    kernel = DISK.integrate.load()
    tilts, rates, rolls = _wobbles(cells)
    rows = (
        tilts,
        0.0 * tilts,
        rates,
        rolls,
        *(_TOY[name] + 0.0 * tilts for name in ("alpha", "radius", "gravity")),
    )
    given, settings = np.stack(rows), np.array([_LONG, _SHORT, math.radians(89.9), 1e-8])
    measures, counts = np.empty((len(DISK_MEASURES), cells)), np.zeros((len(DISK_COUNTS), cells), np.int32)

    def timed() -> tuple[float, float]:
        began = time.process_time()
        kernel(given, settings, measures, counts)
        return time.process_time() - began, float(counts[DISK_STEPS].sum())

    return timed


def _prepare_with_law(law: dict[str, float], cells: int) -> _Timed:
    tilts, rates, rolls = _wobbles(cells)
    code = int("air_viscosity" in law) + int("air_density" in law)
    has = ("contour_friction" in law, "contour_damping" in law, "rolling_friction" in law)
    kernel = Kernel(
        "kernels.lossy_disk.integrate", variant(*has, pivoting=False, air_law=code, slips=False)
    ).load()
    state = {"tilt": tilts, "precession_rate": rates, "roll_rate": rolls}
    values: dict[str, Any] = {**dict.fromkeys(arrays.PARAMETERS, 0.0), **_TOY, **law, **state}
    given = np.stack([values[name] + 0.0 * tilts for name in arrays.PARAMETERS])
    named = {"duration": _LONG, "flat_tilt": math.radians(89.9), "tolerance": 1e-8, "air_law": float(code)}
    settings = np.array([named.get(name, 0.0) for name in arrays.SETTINGS])
    measures = np.empty((len(arrays.MEASURES), cells))
    counts = np.zeros((len(arrays.COUNTS), cells), np.int32)

    def timed() -> tuple[float, float]:
        began = time.process_time()
        kernel(given, settings, measures, counts)
        return time.process_time() - began, float(counts[arrays.STEPS].sum())

    return timed


def measure(repeats: int, cells: int = 240) -> dict[str, float]:
    """Return the time of a step [ns] without losses (named "none") and with each law, whose first pass is included.

    Requires that one thread is set.
    """
    timed = {"none": _prepare_without_losses(cells)} | {
        name: _prepare_with_law(law, cells) for name, law in _LAWS.items()
    }
    least = dict.fromkeys(timed, math.inf)
    for _ in range(repeats):
        for name, solve in timed.items():
            seconds, steps = solve()
            least[name] = min(least[name], 1e9 * seconds / steps)
    return least
