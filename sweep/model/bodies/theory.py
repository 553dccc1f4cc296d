"""Theory of bodies without time stepping: edges of stability, small oscillations.

As for the disk (`sweep.model.disk.theory`), along any motion the two scaled rates s and o are linear combinations of
two fixed functions of the tilt (`kernels.bodies.pair`).
"""

import math
from collections.abc import Mapping

import numpy as np

from kernels.bodies import steady
from sweep.model.bodies.shape import body_of, off_centre, scaled_rates
from sweep.model.description import Request, Starts
from sweep.model.disk.initial_conditions import circling
from sweep.model.disk.theory import Formulas
from sweep.model.kernel import Kernel
from sweep.model.quantity import Array, Truths

CARRY = Kernel("kernels.reduction.carry", "carry", seconds=4.0)

#: Bodies that are in balance upright, at a tilt of 0; an arc and a spheroid only if their centre is the centre of mass.
IN_BALANCE = ("torus", "rounded", "arc", "spheroid")


def has_steady_motion(spec: Request) -> bool:
    """Return whether starts that are not on their end disturb a steady motion: circling, or upright in balance.

    The bodies in `IN_BALANCE` are in balance upright. With an offset, a spheroid is on its end and an arc is not in
    balance.
    """
    if circling(spec):
        return True
    return spec.body in IN_BALANCE and not (spec.body == "arc" and off_centre(spec.offset))


def critical_square(spec: Request, rate: str) -> str:
    """Return the squared critical rate of the upright body, in mathtext."""
    radius = "q^2" if spec.body == "spheroid" else "r"
    if rate == "roll_rate":
        return rf"A(1{{-}}{radius})/[I(1{{+}}I)]\;g/R"
    return rf"(1{{-}}{radius})/(1{{+}}A)\;g/R"


def critical_pole_square(spec: Request) -> str:
    """Return the squared critical spin of the body on its end, in mathtext."""
    if spec.body == "ball":
        return r"4e(A{+}h^2)/(I{+}h)^2\;g/R"
    return r"4(A{+}h^2)(h{-}1/q)/(I{+}h/q)^2\;g/R"


def _unit(starts: Starts) -> Array:
    return np.asarray(np.sqrt(starts["radius"] / starts["gravity"]))


def _square(spec: Request, starts: Starts, axis: str) -> Array:
    """Return the square of the scaled critical rate; negative where the upright body is stable at every rate."""
    body = body_of(spec, starts)
    if axis == "roll_rate":
        return np.asarray(steady.critical_spin_square(body))
    return np.asarray(steady.critical_precession_square(body))


def _critical(spec: Request, starts: Starts, axis: str) -> Array:
    with np.errstate(invalid="ignore"):
        return np.asarray(np.sqrt(_square(spec, starts, axis)) / _unit(starts))


def _marginal(spec: Request, starts: Starts, coefficient: Array | float) -> tuple[Array, Array]:
    unit = _unit(starts)
    slow, fast = steady.marginal_precession_rates(
        starts["tilt"], coefficient * unit * unit, body_of(spec, starts)
    )
    return slow / unit, fast / unit


def _turning(spec: Request, given: Starts, tilt: Array, axis: str) -> Array:
    """Return the rate [rad/s] along `axis` at which a start turns back exactly at `tilt` [rad]; infinite if none."""
    start, unit = given["tilt"], _unit(given)
    f = np.ones_like(start) if axis == "roll_rate" else np.sin(start)
    g = np.zeros_like(start) if axis == "roll_rate" else np.cos(start)
    bodies = np.stack([np.broadcast_to(values, start.shape) for values in body_of(spec, given)])
    squares = np.empty(start.size)
    CARRY.load()(np.stack([start, tilt, given["tilt_rate"] * unit]), bodies, np.stack([f, g]), squares)
    return np.asarray(np.sqrt(squares) / unit)


def coefficient(spec: Request, start: Mapping[str, float]) -> float:
    """Return k [rad2 s-2] of the undisturbed motion of a cell: upright, or circling at its own tilt."""
    given = {name: np.array([value]) for name, value in start.items()}
    tilt, (o, s) = given["tilt"] if circling(spec) else 0.0 * given["tilt"], scaled_rates(spec, given)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        scaled = steady.stability_coefficient(tilt, o, s, body_of(spec, given))
    return float(scaled[0] / _unit(given)[0] ** 2)


def _released(spec: Request, start: Mapping[str, float], axis: str) -> float:
    """Return the largest tilt after a release from rest over the tilt of the start, in linear theory.

    Notes
    -----
    The release itself changes the steady motion: with r = (rate / critical rate)^2 the slope of the potential is
    (r-1) t - c r t0, with c = 1 if it rolls and (2+I-r0)/(1+A) if it spins; r0 is the radius of curvature upright.
    """
    given = {name: np.array([value]) for name, value in start.items()}
    body = body_of(spec, given)
    with np.errstate(divide="ignore"):
        r = float(((start[axis] * _unit(given)) ** 2 / _square(spec, given, axis))[0])
    r0 = body.edge * body.square
    c = 1.0 if axis == "roll_rate" else float(((2.0 + body.axial - r0) / (1.0 + body.transverse))[0])
    # a body that is stable at every rate swings back past its start
    return max(1.0, (2.0 * c - 1.0) + 2.0 * c / (r - 1.0))


def pole_lines(spec: Request, axis: str, starts: Starts) -> dict[str, tuple[Array, Array]]:
    """Return the critical spin of bodies on their end, which is the upper edge; a criterion gets no prediction."""
    if axis != "roll_rate" or np.all(starts["precession_rate"] != 0.0):
        return {}
    along = spec.roll_rate.ends()
    if along[0] < 0.0:
        return {}
    square = steady.critical_pole_spin_square(body_of(spec, starts), np.copysign(1.0, starts["tilt"]))
    known = (square > 0.0) & (starts["precession_rate"] == 0.0)
    critical = np.where(known, np.sqrt(np.abs(square)) / _unit(starts), np.nan)
    return {"upper": (critical, np.full_like(critical, np.nan))}


def of_both(
    ends: Truths, on_end: Mapping[str, tuple[Array, Array]], upright: Mapping[str, tuple[Array, Array]]
) -> dict[str, tuple[Array, Array]]:
    """Return lines for starts of which some are on their end; NaN where a start has no such edge."""
    missing = np.full(ends.shape, np.nan)
    none, lines = (missing, missing), {}
    for edge in {**upright, **on_end}:
        of_ends, of_others = on_end.get(edge, none), upright.get(edge, none)
        lines[edge] = (
            np.asarray(np.where(ends, of_ends[0], of_others[0]), np.float64),
            np.asarray(np.where(ends, of_ends[1], of_others[1]), np.float64),
        )
    return lines


def critical_pole_spin(spec: Request, start: Mapping[str, float]) -> float | None:
    """Return the spin [rad s-1] above which a body on its end is stable; None if it is stable at every spin."""
    given = {name: np.array([value]) for name, value in start.items()}
    square = float(steady.critical_pole_spin_square(body_of(spec, given), np.copysign(1.0, given["tilt"]))[0])
    return math.sqrt(square) / float(_unit(given)[0]) if square > 0.0 else None


def pole_prediction(spec: Request, start: Mapping[str, float]) -> str:
    """Return the line of `explain` with the prediction of linear theory for a body that spins on its end."""
    critical = critical_pole_spin(spec, start)
    if critical is None:
        return "linear      stable on its end at every spin"
    spin = abs(start["roll_rate"] + start["precession_rate"] * math.sin(start["tilt"]))
    verdict, side = ("stable", "above") if spin > critical else ("unstable", "at or below")
    return f"linear      {verdict} on its end: its spin, {spin:.6g} rad/s, is {side} the critical {critical:.6g} rad/s"


FORMULAS = Formulas(_critical, _marginal, _turning, coefficient, _released)
