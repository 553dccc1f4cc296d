"""Many starts of the lossy disk in SI, each followed by `lossy_motion`, without any of the project's code."""

import math
from dataclasses import dataclass

import numpy as np
from lossy_motion import (
    ALPHA,
    BILDSTEN,
    CONTOUR,
    DAMPING,
    FRICTION,
    HEADING,
    LOSSES,
    MOFFATT,
    PATH,
    PIVOTING,
    PLACE,
    ROLLING,
    SIZE,
    follow,
)

from kernels.lossy_disk import arrays, endings

#: Code of each ending of `lossy_motion.follow`, in its order.
_CODES = np.array(
    [endings.NOT_COMPUTED, endings.FLAT, endings.REST, endings.HORIZON, endings.LIFT_OFF, endings.SLIP,
     endings.UNDISTURBED, endings.UNRESOLVED]
)  # fmt: skip

DEFAULTS = {
    "tilt": 0.0, "tilt_rate": 0.0, "precession_rate": 0.0, "roll_rate": 0.0, "alpha": 0.5, "radius": 1.0,
    "gravity": 1.0, "mass": 1.0, "rolling_friction": 0.0, "pivoting_friction": 0.0, "contour_friction": 0.0,
    "contour_damping": 0.0, "air_viscosity": 0.0, "air_density": 0.0, "friction": np.inf,
}  # fmt: skip

FLAT_TILT = math.radians(89.9)


def starts(**parameters):
    """Return starts, float64[len(arrays.PARAMETERS), n]; by default radius, gravity and mass are 1, without losses."""
    given = DEFAULTS | parameters
    rows = np.broadcast_arrays(*(given[name] for name in arrays.PARAMETERS))
    return np.ascontiguousarray(np.stack([np.atleast_1d(row).ravel() for row in rows]), dtype=np.float64)


def coefficients(start, air):
    """Return the scaled coefficients (`ALPHA` ...) of one start, and the unit of time [s]."""
    given = dict(zip(arrays.PARAMETERS, start, strict=True))
    R, g, m = given["radius"], given["gravity"], given["mass"]
    unit = math.sqrt(R / g)
    par = np.zeros(8)
    par[ALPHA], par[FRICTION] = given["alpha"], given["friction"]
    for place, name in ((ROLLING, "rolling"), (PIVOTING, "pivoting"), (CONTOUR, "contour")):
        par[place] = given[f"{name}_friction"] / R
    par[DAMPING] = given["contour_damping"] / (m * g * R * unit)
    if air == "moffatt":
        par[MOFFATT] = math.pi * given["air_viscosity"] * R * unit / (4.0 * m)
    elif air == "bildsten":
        layer = math.sqrt(given["air_viscosity"] * given["air_density"])
        par[BILDSTEN] = layer * R**2.25 / (m * math.sqrt(2.0) * g**0.25)
    return par, unit


@dataclass(frozen=True)
class Found:
    """Measures of each start by `arrays.MEASURES` in SI; endings, switches, steps; final states.

    The final contact point is among the measures, with its names in `arrays.SAMPLES`.
    """

    measures: dict[str, np.ndarray]
    ending: np.ndarray
    switches: np.ndarray
    steps: np.ndarray
    state: np.ndarray

    def __getattr__(self, name):
        """Return a measure by its name."""
        return self.measures[name]


def run(given, *, air="none", duration=1e3, flat_tilt=FLAT_TILT, limit=np.inf, from_start=False, rtol=1e-12):
    """Follow starts, float64[len(arrays.PARAMETERS), n]; `limit` [rad] of the first breach is one number or n."""
    names, ends, states, places = (*arrays.MEASURES[:12], "energy_imbalance"), [], [], []
    found = np.full((len(names), given.shape[1]), np.nan)
    counts = np.zeros((2, given.shape[1]), int)
    limits = np.broadcast_to(limit, given.shape[1])
    for cell, start in enumerate(given.T):
        par, unit = coefficients(start, air)
        y = np.zeros(SIZE)
        y[:4] = start[:4] * (1.0, unit, unit, unit)
        gauges = np.zeros(7)
        center = y[0] if from_start else 0.0
        ends.append(follow(y, par, duration / unit, flat_tilt, center, limits[cell], rtol, gauges))
        low, high, time, breach, imbalance, steps, switches = gauges
        found[:, cell] = (
            low, high, time * unit, y[0], y[HEADING], y[PATH] * start[arrays.RADIUS],
            *y[LOSSES:PLACE], breach * unit, imbalance,
        )  # fmt: skip
        counts[:, cell] = switches, steps
        states.append(y[:4] / (1.0, unit, unit, unit))
        places.append(y[PLACE:] * start[arrays.RADIUS])
    measures = dict(zip((*names, "contact_x", "contact_y"), (*found, *np.array(places).T), strict=True))
    return Found(measures, _CODES[ends], *counts, np.array(states).T)
