"""Theory of a wobble near flat with losses: its duration, without integration. `upright` treats upright bodies."""

import math
from collections.abc import Iterator, Mapping

import numpy as np

from sweep.model.description import Request
from sweep.model.disk.initial_conditions import circling
from sweep.model.disk.tables import WOBBLE
from sweep.model.lossy_disk import upright
from sweep.model.lossy_disk.air import torque
from sweep.model.lossy_disk.tables import SETTINGS

#: Number of nodes of an integral over the logarithm of the inclination, for an error of 1e-9.
_NODES = 400

#: Inclination [rad] above which the error of the closed forms of the wobble is more than a few per cent.
_STEEP = math.radians(30.0)


def wobble_time(spec: Request, start: Mapping[str, float]) -> float:
    """Return the time [s] of a steady wobble from the tilt of a start to flat_tilt, to leading order near flat.

    Notes
    -----
    Energy balance: 3/2 a' = -power, with roll rate^2 = 2/(alpha a) (scaled): the closed forms of all laws in one
    integral. Pivoting friction takes no power: it stops the rotation about the vertical.
    """
    high, low = (math.pi / 2 - abs(tilt) for tilt in (start["tilt"], float(spec.flat_tilt)))
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    middle, half = 0.5 * math.log(high * low), 0.5 * math.log(high / low)
    inclination = np.exp(middle + half * nodes)
    radius, gravity, mass = (start[name] for name in ("radius", "gravity", "mass"))
    unit, roll = math.sqrt(radius / gravity), np.sqrt(2.0 / (start["alpha"] * inclination))
    power = (start["contour_friction"] + start["rolling_friction"] * inclination) / radius * roll
    power = power + start["contour_damping"] * unit / (mass * radius**2) * roll**2
    power = power + torque(spec.air_law, start, roll, inclination) * roll
    if power.min() <= 0.0:
        return math.inf
    return unit * float(np.sum(1.5 * inclination / power * weights) * half)


def predictions(spec: Request, start: Mapping[str, float], stored: Mapping[str, float]) -> Iterator[str]:
    """Yield the lines of `explain` with the predictions for a cell, from its start and its stored measures [SI]."""
    if not all(math.isfinite(start[name]) for name in ("tilt", "precession_rate", "roll_rate")):
        return
    if spec.precession_rate == WOBBLE:
        yield from _of_a_wobble(spec, start, stored)
    elif not circling(spec):
        starts = {name: np.array([value]) for name, value in start.items()}
        yield from upright.describe_slowing(spec, start, upright.thin(starts), "disk")


def _of_a_wobble(spec: Request, start: Mapping[str, float], stored: Mapping[str, float]) -> Iterator[str]:
    inclination = math.pi / 2 - abs(start["tilt"])
    if abs(start["tilt"]) >= spec.flat_tilt or inclination > _STEEP:
        return
    time = wobble_time(spec, start)
    if not math.isfinite(time):
        yield "theory      these losses take no energy from a steady wobble near flat"
        return
    measured = stored["end_time"]
    in_cell = f" (the cell has {measured:.6g} s)" if math.isfinite(measured) else ""
    flat = SETTINGS["flat_tilt"].spell(spec.flat_tilt, 6)
    yield f"theory      a steady wobble reaches {flat} after {time:.6g} s{in_cell}, to leading order near flat"
