"""What theory says of bodies with losses: the time of a steady wobble near flat, critical rates without losses."""

import math
from collections.abc import Iterator, Mapping

import numpy as np

from sweep.model.bodies import theory
from sweep.model.bodies.shape import body_of, with_body
from sweep.model.description import Request, Starts
from sweep.model.disk.initial_conditions import computed_rates
from sweep.model.disk.tables import WOBBLE
from sweep.model.lossy_bodies.tables import SETTINGS
from sweep.model.lossy_disk.tables import BILDSTEN, MOFFATT
from sweep.model.lossy_disk.theory import unsteadied
from sweep.model.quantity import Array

#: Nodes of an integral over the logarithm of an inclination; beyond this inclination [rad] its closed forms are off by
#: more than a few per cent.
_NODES, _STEEP = 400, math.radians(30.0)

_OTHER = {"roll_rate": "precession_rate", "precession_rate": "roll_rate"}


def lines(spec: Request, axis: str, starts: Starts) -> dict[str, tuple[Array, Array]]:
    """Return the critical rate of the upright body without losses; nothing is predicted for a criterion."""
    if computed_rates(spec) or axis not in _OTHER or spec.body not in theory.IN_BALANCE:
        return {}
    known = (starts[_OTHER[axis]] == 0.0) & ~unsteadied(spec, starts, axis)
    if not known.any():
        return {}
    critical = np.where(known, theory.FORMULAS.critical(spec, with_body(spec, starts), axis), np.nan)
    low, high = getattr(spec, axis).ends()
    none = np.full_like(critical, np.nan)
    both = {"upper": (critical, none), "lower": (-critical, none)}
    return {edge: both[edge] for edge, there in (("upper", high > 0.0), ("lower", low < 0.0)) if there}


def wobble_time(spec: Request, start: Mapping[str, float]) -> float:
    """Return how long [s] a steady wobble lasts from the tilt of a start to flat_tilt, to leading order near flat.

    Notes
    -----
    At the inclination e the centre of mass rests, the square of the roll rate is c/(A e), and the energy above flat
    e [3c/2 + I r^2/(2 A c)]: c and r are core and edge of the body, A and I its transverse and axial moment.
    """
    given = with_body(spec, {name: np.array([value]) for name, value in start.items()})
    core, _, edge, _, axial, transverse, _ = (float(np.ravel(each)[0]) for each in body_of(spec, given))
    high, low = (math.pi / 2 - abs(tilt) for tilt in (start["tilt"], float(spec.flat_tilt)))
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    middle, half = 0.5 * math.log(high * low), 0.5 * math.log(high / low)
    inclination = np.exp(middle + half * nodes)
    radius, gravity, mass = (start[name] for name in ("radius", "gravity", "mass"))
    unit, roll = math.sqrt(radius / gravity), np.sqrt(core / (transverse * inclination))
    power = (start["contour_friction"] * core + start["rolling_friction"] * inclination) / radius * roll
    power = power + start["contour_damping"] * unit / (mass * radius**2) * (core * roll) ** 2
    if spec.air_law == MOFFATT:
        film = 0.25 * math.pi * start["air_viscosity"] * radius * unit / mass
        power = power + film * core**3 * roll**2 / inclination
    if spec.air_law == BILDSTEN:
        layer = math.sqrt(0.5 * start["air_viscosity"] * start["air_density"] * unit) * radius**2 / mass
        power = power + layer * core**4 * roll**2.5
    if power.min() <= 0.0:
        return math.inf
    slope = 1.5 * core + 0.5 * axial * edge**2 / (transverse * core)
    return unit * slope * float(np.sum(inclination / power * weights) * half)


def predictions(spec: Request, start: Mapping[str, float], stored: Mapping[str, float]) -> Iterator[str]:
    """Yield what theory says of one cell, from its start and its stored measures [SI]."""
    inclination = math.pi / 2 - abs(start["tilt"])
    if spec.precession_rate != WOBBLE or not math.pi / 2 - spec.flat_tilt < inclination <= _STEEP:
        return
    time = wobble_time(spec, start)
    if not math.isfinite(time):
        yield "theory      a steady wobble near flat loses no energy to these losses"
        return
    measured = stored["end_time"]
    beside = f" (the cell has {measured:.6g} s)" if math.isfinite(measured) else ""
    flat = SETTINGS["flat_tilt"].spell(spec.flat_tilt, 6)
    yield f"theory      the energy of a steady wobble lasts {time:.6g} s to {flat}{beside}, to leading order near flat"
