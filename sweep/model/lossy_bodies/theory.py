"""Theory of bodies with losses: the duration of a steady wobble near flat, and the slowing of upright bodies."""

import math
from collections.abc import Iterator, Mapping

import numpy as np

from kernels.bodies.shapes import Body
from sweep.model.bodies import theory
from sweep.model.bodies.shape import body_of, with_body
from sweep.model.bodies.tables import CALLED
from sweep.model.description import Request, Starts
from sweep.model.disk.initial_conditions import circling
from sweep.model.disk.tables import WOBBLE
from sweep.model.lossy_bodies.tables import SETTINGS
from sweep.model.lossy_disk import upright
from sweep.model.lossy_disk.air import torque
from sweep.model.quantity import Array

#: Number of nodes of an integral over the logarithm of the inclination; inclination [rad] above which the error of the
#: leading order is more than a few per cent.
_NODES, _STEEP = 2000, math.radians(30.0)


def lines(spec: Request, axis: str, starts: Starts) -> dict[str, tuple[Array, Array]]:
    """Return the critical rate of the upright body without losses, and an estimate with losses.

    See `sweep.model.lossy_disk.upright.lines`.
    """
    if not theory.has_steady_motion(spec):
        return {}
    return upright.lines(spec, axis, starts, _upright(spec, starts))


def _upright(spec: Request, starts: Starts) -> upright.Upright:
    given = with_body(spec, starts)
    body = body_of(spec, given)
    rolling, spinning = (
        theory.FORMULAS.critical(spec, given, axis) for axis in ("roll_rate", "precession_rate")
    )
    sharpness = 1.0 - body.edge * body.square
    return upright.Upright(rolling, spinning, body.axial, body.transverse, sharpness, body.core)


def wobble_time(spec: Request, start: Mapping[str, float]) -> float:
    """Return the time [s] of a steady wobble from the tilt of a start to flat_tilt, to leading order near flat.

    Notes
    -----
    Losses act only on the roll rate f, with a torque Q. The integral of Q dt, q per unit of the inclination e, follows
    from the equation for o (`_drift`), and the time is the integral of q/Q. For a thin disk q f is the slope of the
    energy, 3/2.
    """
    given = with_body(spec, {name: np.array([value]) for name, value in start.items()})
    body = Body(*(float(np.ravel(values)[0]) for values in body_of(spec, given)))
    # the mirror image of a body that leans to the other side
    body = body._replace(shift=math.copysign(1.0, start["tilt"]) * body.shift)
    high, low = (math.pi / 2 - abs(tilt) for tilt in (start["tilt"], float(spec.flat_tilt)))
    inclination = np.geomspace(high, low, _NODES)
    o, taken = _drift(body, inclination)
    torque = _torque(spec, start, inclination, o / inclination, body.core)
    if torque.min() <= 0.0:
        return math.inf
    unit = math.sqrt(start["radius"] / start["gravity"])
    return unit * float(np.trapezoid(taken * inclination / torque, -np.log(inclination)))


def _drift(body: Body, inclination: Array) -> tuple[Array, Array]:
    """Return o and q of a wobble that begins with its centre at rest, at decreasing inclinations.

    Notes
    -----
    Near flat a and b are constants, and a steady wobble with y = s/o has o^2 = L a e/A, L = A/(A + b^2 + a b y); its
    centre rests if y = -b/a. Per unit of q the losses change o by -(I + a^2)/(e D) and s by a b/(e D); without losses o
    grows like 1/e. So unless b = 0 the centre does not stay at rest: with k = a b/(I + a^2),
    dy/d ln e = -(y + 3 k)/2 / [1 - (y + k) L a b/(2 A)], and q = D (o + e do/de)/(I + a^2).
    """
    A, I = float(body.transverse), float(body.axial)  # noqa: N806, E741
    a, b = float(body.core), -float(body.shift + body.edge)
    k, whole = a * b / (I + a * a), (I * A + I * b * b + A * a * a) / (I + a * a)

    def share(y: float) -> float:
        return A / (A + b * b + a * b * y)

    def slope(y: float) -> float:
        return -0.5 * (y + 3.0 * k) / (1.0 - 0.5 * (y + k) * share(y) * a * b / A)

    y, o, taken = -b / a, np.empty(inclination.size), np.empty(inclination.size)
    h = math.log(inclination[1] / inclination[0])
    for n, e in enumerate(inclination):
        o[n] = math.sqrt(share(y) * a * e / A)
        taken[n] = whole * o[n] * (1.5 - 0.5 * share(y) * a * b / A * slope(y))
        first = slope(y)
        second = slope(y + 0.5 * h * first)
        third = slope(y + 0.5 * h * second)
        y += h / 6.0 * (first + 2.0 * (second + third) + slope(y + h * third))
    return o, taken


def _torque(spec: Request, start: Mapping[str, float], inclination: Array, roll: Array, core: float) -> Array:
    """Return the torque of all laws against the roll of a wobble near flat, over m g R."""
    radius, gravity, mass = (start[name] for name in ("radius", "gravity", "mass"))
    unit = math.sqrt(radius / gravity)
    dry = (start["contour_friction"] * core + start["rolling_friction"] * inclination) / radius
    viscous = start["contour_damping"] * unit / (mass * radius**2) * core**2 * roll
    return np.asarray(dry + viscous + torque(spec.air_law, start, roll, inclination, core))


def predictions(spec: Request, start: Mapping[str, float], stored: Mapping[str, float]) -> Iterator[str]:
    """Yield the lines of `explain` with the predictions for a cell, from its start and its stored measures [SI]."""
    if not all(math.isfinite(start[name]) for name in ("tilt", "precession_rate", "roll_rate")):
        return
    if spec.precession_rate == WOBBLE:
        yield from _of_a_wobble(spec, start, stored)
    elif theory.has_steady_motion(spec) and not circling(spec):
        starts = {name: np.array([value]) for name, value in start.items()}
        yield from upright.describe_slowing(spec, start, _upright(spec, starts), CALLED[spec.body])


def _of_a_wobble(spec: Request, start: Mapping[str, float], stored: Mapping[str, float]) -> Iterator[str]:
    inclination = math.pi / 2 - abs(start["tilt"])
    if not math.pi / 2 - spec.flat_tilt < inclination <= _STEEP:
        return
    time = wobble_time(spec, start)
    if not math.isfinite(time):
        yield "theory      these losses take no energy from a steady wobble near flat"
        return
    measured = stored["end_time"]
    in_cell = f" (the cell has {measured:.6g} s)" if math.isfinite(measured) else ""
    flat = SETTINGS["flat_tilt"].spell(spec.flat_tilt, 6)
    yield f"theory      a steady wobble reaches {flat} after {time:.6g} s{in_cell}, to leading order near flat"
