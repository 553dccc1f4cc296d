"""Theory of an upright body with losses, without integration: how losses slow it, and where its boundary lies.

An upright body that rolls is slowed by friction along its edge and by the air, one that spins by pivoting friction.
Until its rate has sunk to the critical one without losses a perturbation grows by no more than a factor, and afterwards
falling takes time. So the boundary of a vanishing perturbation is about the rate that sinks to the critical one by the
end. That of a finite perturbation of a body that rolls is above it, for the factor is not 1: a path that is slowed
winds up (`grown`).

What brakes the roll rate of a disk that spins upright (contour friction, damping, air) lets its tilt grow at every
rate: with a small viscous friction k like exp(k t/(1+alpha) (1 + q)/(q - 1)), q = (1 + alpha/2) P^2 (scaled), and dry
friction holds it. Pivoting friction holds the turning about the vertical of a disk that rolls upright: while it does
the critical rate is 1/sqrt(1 + alpha), above that of the disk without losses. Such bodies have no line.
"""

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from kernels.disk.steady import critical_precession_rate_squared, critical_roll_rate_squared
from sweep.model.description import Request, Starts
from sweep.model.disk.initial_conditions import computed_rates
from sweep.model.lossy_disk.tables import BILDSTEN, MOFFATT
from sweep.model.quantity import Array

#: Steps in which a rate is followed back in time, and nodes of an integral over a rate: both are then known to 1e-9.
_STEPS, _NODES = 256, 400

#: Logarithms to base 10 of the least and the largest excess of (rate/critical rate)^2 over 1 at the end that is looked
#: at, and halvings between them: to 1e-9 of the logarithm.
_LEAST, _LARGEST, _HALVINGS = -12.0, 8.0, 34

_OTHER = {"roll_rate": "precession_rate", "precession_rate": "roll_rate"}

#: The meaning of `unsteadied` for a rolling and for a spinning body.
_UNSTEADIED = {
    "roll_rate": "pivoting friction holds the turning of a {} that rolls upright, and another rate is critical",
    "precession_rate": "what brakes the roll rate leaves no {} stable that spins upright",
}


class Upright(NamedTuple):
    """Bodies that stand upright: arrays, shape (n,).

    Attributes
    ----------
    rolling, spinning : array
        Critical rates [rad/s] without losses.
    axial, transverse : array
        Moments of inertia over m R^2.
    sharpness : array
        1 less the radius of curvature of the edge over the outer radius.
    face : array or float
        Radius of the face over the air, over the outer radius.
    """

    rolling: Array
    spinning: Array
    axial: Array
    transverse: Array
    sharpness: Array
    face: Array | float = 1.0

    def critical(self, axis: str) -> Array:
        """Return the critical rate [rad/s] of the body that has this rate."""
        return self.rolling if axis == "roll_rate" else self.spinning


def thin(starts: Starts) -> Upright:
    """Return the thin disks of starts."""
    disk, alpha = [starts[name] for name in ("alpha", "radius", "gravity")], starts["alpha"]
    rolling, spinning = critical_roll_rate_squared(*disk), critical_precession_rate_squared(*disk)
    return Upright(np.sqrt(rolling), np.sqrt(spinning), alpha, 0.5 * alpha, np.ones_like(alpha))


def lines(spec: Request, axis: str, starts: Starts, body: Upright) -> dict[str, tuple[Array, Array]]:
    """Return the critical rate without losses, and an estimate of where the boundary lies with them.

    Parameters
    ----------
    spec : Request
    axis : str
        A rate that is an axis of the spec.
    starts : mapping of str to array, shape (n,)
        The starts of the rows along the axis.
    body : Upright

    Returns
    -------
    dict of str to (critical, predicted)
        As `sweep.model.description.Model.lines`, in rad/s. NaN for a body that rolls and precesses at once, and for one
        that is `unsteadied`.
    """
    if computed_rates(spec) or axis not in _OTHER:
        return {}
    known = starts[_OTHER[axis]] == 0.0
    known = known & ~unsteadied(spec, starts, axis)
    if not known.any():
        return {}
    critical = np.where(known, body.critical(axis), np.nan)
    with np.errstate(all="ignore"):
        slowed = _estimate(spec, axis, starts, body, critical)
    edge = critical, np.where(np.isfinite(slowed), slowed, np.nan)
    low, high = getattr(spec, axis).ends()
    if low < 0.0 < high:
        return {"upper": edge, "lower": (-edge[0], -edge[1])}
    return {"upper": edge} if high > 0.0 else {"lower": (-edge[0], -edge[1])}


def _estimate(spec: Request, axis: str, starts: Starts, body: Upright, critical: Array) -> Array:
    """Return the rate [rad/s] at the start of a body that is stable until the end, shape (n,); NaN where none is known.

    By an amplification, and for the departure of a body that rolls, the rate from which a perturbation grows to the
    limit of the criterion by the end (`grown`); else the rate that sinks to the critical one by then.
    """
    slowed, time = slowing(spec, starts, axis, body), lasting(spec)
    sinks = rate_before(critical, time, slowed)
    if axis != "roll_rate" or spec.criterion.kind == "aloft":
        return sinks if spec.criterion.kind != "amplification" else np.full_like(sinks, np.nan)
    limit = spec.criterion.allowed(spec.model.perturbation(spec, starts))

    def tried(excess: Array) -> tuple[Array, Array]:
        """Rates at the start of bodies with an excess of (rate/critical rate)^2 over 1 at the end; which go too far."""
        end = critical * np.sqrt(1.0 + 10.0**excess)
        start = rate_before(end, time, slowed)
        return start, grown(starts, body, (critical, start, end), slowed) > limit

    low, high = np.full_like(critical, _LEAST), np.full_like(critical, _LARGEST)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        _, far = tried(middle)
        low, high = np.where(far, middle, low), np.where(far, high, middle)
    found, far = tried(high)
    found = np.where(far, np.nan, np.where(tried(low)[1], found, sinks))
    return np.where(np.hypot(starts["tilt"], starts["tilt_rate"]) > 0.0, found, sinks)


def grown(
    starts: Starts, body: Upright, rates: tuple[Array, Array, Array], slowed: tuple[Array, Array, Array]
) -> Array:
    """Return how far [rad] from upright a body that rolls has come while losses took its rate from one to another.

    Parameters
    ----------
    starts : mapping of str to array, shape (n,)
        With small tilts and tilt rates, and without a precession rate.
    body : Upright
    rates : (critical, first, last), arrays of shape (n,)
        The critical rate, and those at start and end, which are above it [rad/s].
    slowed
        As of `slowing`.

    Returns
    -------
    array, shape (n,)

    Notes
    -----
    docs/losses-theory.md. With A and I the transverse and the axial moment and k the sharpness of the edge, the losses
    that slow the rolling leave dc = -k theta ds of the small c = A o + I s theta, which without them is an invariant.
    The tilt swings about r c / (I s (r - 1)), r = (rate/critical)^2, so c grows as (r - 1)^(-k/(2 I)); the volume of
    (theta, w, c) is conserved, so c times the adiabatic invariant of the swing is constant. A kick leaves a little c,
    as the body is slowed while it is tilted. Close to r = 1, where r changes much within a swing, all of it grows less.
    """
    critical, first, last = rates
    dry, viscous, layer = slowed
    tilt, exponent = starts["tilt"], body.sharpness / body.axial
    r, s = (first / critical) ** 2, last / first
    stiffness = body.sharpness * (r - 1.0) / (1.0 + body.transverse) * starts["gravity"] / starts["radius"]
    kick = starts["tilt_rate"] / np.sqrt(stiffness)
    lost = (dry / first + viscous + layer * np.sqrt(first)) / np.sqrt(stiffness)
    middle = (tilt + kick * lost * exponent) * r / (r - 1.0)
    growth = (r - 1.0) / ((last / critical) ** 2 - 1.0)
    swing, middle = np.hypot(middle - tilt, kick), np.abs(middle)
    at_end = middle * s * growth ** (1.0 + 0.5 * exponent) + swing * growth ** (0.25 - 0.25 * exponent)
    found: Array = np.maximum(middle + swing, at_end)
    return found


def unsteadied(spec: Request, starts: Starts, axis: str) -> npt.NDArray[np.bool_]:
    """Whether a loss acts on the small motions that keep an upright body upright which has a rate; shape (n,).

    Of one that rolls that is turning about the vertical, of one that spins rolling along the rim.
    """
    if axis == "roll_rate":
        return np.asarray(starts["pivoting_friction"] > 0.0)
    braked = (starts["contour_friction"] > 0.0) | (starts["contour_damping"] > 0.0)
    if spec.air_law == MOFFATT:
        braked = braked | (starts["air_viscosity"] > 0.0)
    if spec.air_law == BILDSTEN:
        braked = braked | (starts["air_viscosity"] * starts["air_density"] > 0.0)
    return np.asarray(braked)


def lasting(spec: Request) -> float:
    """Return the time [s] for which the criterion asks that a motion lasts; NaN if it asks something else."""
    if spec.criterion.kind in ("departure", "amplification"):
        return float(spec.duration)
    return float(spec.criterion.limit) if spec.criterion.kind == "aloft" else math.nan


def slowing(spec: Request, starts: Starts, axis: str, body: Upright) -> tuple[Array, Array, Array]:
    """Return how losses slow an upright body: the coefficients (a, b, d) of rate' = -(a + b rate + d rate^(3/2)).

    Parameters
    ----------
    spec : Request
    starts : mapping of str to array, shape (n,)
    axis : {"roll_rate", "precession_rate"}
        The rate that it has.
    body : Upright

    Returns
    -------
    (a, b, d) : arrays, shape (n,)
        In rad s^-2, s^-1 and (rad s)^(-1/2).

    Notes
    -----
    With the moment of inertia (1 + I) m R^2 about the contact for rolling, A m R^2 about the vertical for spinning. An
    upright body weighs m g on the contact. Drag as in `kernels.lossy_disk.loss_laws`.
    """
    radius, gravity, mass = (starts[name] for name in ("radius", "gravity", "mass"))
    none = np.zeros_like(radius)
    if axis == "precession_rate":
        return starts["pivoting_friction"] * gravity / (body.transverse * radius**2), none, none
    inertia = (1.0 + body.axial) * radius**2
    dry = (starts["contour_friction"] + starts["rolling_friction"]) * gravity / inertia
    viscous, layer = starts["contour_damping"] / (mass * inertia), none
    if spec.air_law == MOFFATT:
        film = 0.25 * math.pi * body.face**3 * starts["air_viscosity"] * radius**3
        viscous = viscous + film / (mass * inertia)
    if spec.air_law == BILDSTEN:
        air = np.sqrt(0.5 * starts["air_viscosity"] * starts["air_density"])
        layer = air * body.face**4 * radius**4 / (mass * inertia)
    return dry, viscous, layer


def rate_before(rate: Array, time: float, slowed: tuple[Array, Array, Array]) -> Array:
    """Return the rate [rad/s] that sinks to `rate` within a time [s], shape (n,); see `slowing`."""
    dry, viscous, layer = slowed
    if not np.any(layer):
        # (rate + a/b) exp(b t) - a/b, also where b vanishes
        exponent = viscous * time
        grown = np.where(exponent > 0.0, np.expm1(exponent) / np.where(exponent > 0.0, exponent, 1.0), 1.0)
        found: Array = rate * np.exp(exponent) + dry * time * grown
        return found

    def gain(value: Array) -> Array:
        return np.asarray(dry + viscous * value + layer * value * np.sqrt(value))

    step = time / _STEPS
    for _ in range(_STEPS):
        first = gain(rate)
        second = gain(rate + 0.5 * step * first)
        third = gain(rate + 0.5 * step * second)
        fourth = gain(rate + step * third)
        rate = rate + step / 6.0 * (first + 2.0 * (second + third) + fourth)
    return rate


def time_between(rate: float, critical: float, slowed: tuple[float, float, float]) -> float:
    """Return the time [s] in which a rate sinks to the critical one; infinite without losses."""
    dry, viscous, layer = slowed
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    rates = 0.5 * (rate + critical) + 0.5 * (rate - critical) * nodes
    power = dry + viscous * rates + layer * rates * np.sqrt(rates)
    return 0.5 * (rate - critical) * float(np.sum(weights / power)) if power.min() > 0.0 else math.inf


def told(spec: Request, start: Mapping[str, float], body: Upright, called: str) -> Iterator[str]:
    """Yield what theory says of a cell with an upright body, which is `called` so."""
    axis = next((name for name in _OTHER if start[name] != 0.0 and start[_OTHER[name]] == 0.0), None)
    if axis is None:
        return
    arrays = {name: np.array([value]) for name, value in start.items()}
    rate, critical = abs(start[axis]), float(body.critical(axis)[0])
    words = axis.replace("_", " ")
    if not math.isfinite(critical):
        yield f"theory      without losses the upright {called} is stable at every {words}"
        return
    if unsteadied(spec, arrays, axis)[0]:
        yield f"theory      no prediction: {_UNSTEADIED[axis].format(called)}"
        return
    if rate <= critical:
        yield f"theory      the {words} is below {critical:.6g} rad s-1, the critical one without losses"
        return
    a, b, d = (float(each[0]) for each in slowing(spec, arrays, axis, body))
    time = time_between(rate, critical, (a, b, d))
    if math.isfinite(time):
        yield (
            f"theory      losses take the {words} of the upright {called} down to {critical:.6g} rad s-1, the critical "
            f"one without losses, in {time:.6g} s; after a vanishing perturbation it falls later"
        )
    else:
        yield f"theory      the {words} is above {critical:.6g} rad s-1, the critical one, and no loss slows it"
