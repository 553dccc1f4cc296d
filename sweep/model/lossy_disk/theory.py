"""What theory says of losses without integration: how they slow an upright disk, and how long a wobble lasts near flat.

An upright disk that rolls is slowed by friction along its rim and by the air, one that spins by pivoting friction.
Until its rate has sunk to the critical one of the disk without losses a perturbation grows by no more than a factor,
and afterwards falling takes time. So the boundary of a vanishing perturbation is about the rate that sinks to the
critical one by the end. That of a finite perturbation of a disk that rolls is above it, for the factor is not 1: a path
that is slowed winds up (`grown`).

What brakes the roll rate of a disk that spins upright (contour friction, damping, air) lets its tilt grow at every
rate: with a small viscous friction k like exp(k t/(1+alpha) (1 + q)/(q - 1)), q = (1 + alpha/2) P^2 (scaled), and dry
friction holds it. Pivoting friction holds the turning about the vertical of a disk that rolls upright: while it does
the critical rate is 1/sqrt(1 + alpha), above that of the disk without losses. Such disks have no line.
"""

import math
from collections.abc import Iterator, Mapping

import numpy as np
import numpy.typing as npt

from kernels.disk.steady import critical_precession_rate_squared, critical_roll_rate_squared
from sweep.model.description import Request, Starts
from sweep.model.disk.initial_conditions import circling, computed_rates
from sweep.model.disk.tables import WOBBLE
from sweep.model.lossy_disk.tables import BILDSTEN, MOFFATT, SETTINGS
from sweep.model.quantity import Array

#: Steps in which a rate is followed back in time, and nodes of an integral over a rate or over the logarithm of an
#: inclination: both are then known to 1e-9.
_STEPS, _NODES = 256, 400

#: Logarithms to base 10 of the least and the largest excess of (rate/critical rate)^2 over 1 at the end that is looked
#: at, and halvings between them: to 1e-9 of the logarithm.
_LEAST, _LARGEST, _HALVINGS = -12.0, 8.0, 34

#: Beyond this inclination [rad] the closed forms of the wobble are off by more than a few per cent.
_STEEP = math.radians(30.0)

_OTHER = {"roll_rate": "precession_rate", "precession_rate": "roll_rate"}

#: What `unsteadied` means for a disk that rolls and for one that spins.
_UNSTEADIED = {
    "roll_rate": "pivoting friction holds the turning of a disk that rolls upright, and another rate is critical",
    "precession_rate": "what brakes the roll rate leaves no disk stable that spins upright",
}


def lines(spec: Request, axis: str, starts: Starts) -> dict[str, tuple[Array, Array]]:
    """Return the critical rate without losses, and an estimate of where the boundary lies with them.

    Parameters
    ----------
    spec : Request
    axis : str
        A rate that is an axis of the spec.
    starts : mapping of str to array, shape (n,)
        The starts of the rows along the axis.

    Returns
    -------
    dict of str to (critical, predicted)
        As `sweep.model.description.Model.lines`, in rad/s. NaN for a disk that rolls and precesses at once, and for one
        that is `unsteadied`.
    """
    if computed_rates(spec) or axis not in _OTHER:
        return {}
    known = starts[_OTHER[axis]] == 0.0
    known = known & ~unsteadied(spec, starts, axis)
    if not known.any():
        return {}
    critical = np.where(known, critical_rate(starts, axis), np.nan)
    with np.errstate(all="ignore"):
        slowed = _estimate(spec, axis, starts, critical)
    edge = critical, np.where(np.isfinite(slowed), slowed, np.nan)
    low, high = getattr(spec, axis).ends()
    if low < 0.0 < high:
        return {"upper": edge, "lower": (-edge[0], -edge[1])}
    return {"upper": edge} if high > 0.0 else {"lower": (-edge[0], -edge[1])}


def _estimate(spec: Request, axis: str, starts: Starts, critical: Array) -> Array:
    """Return the rate [rad/s] at the start of a disk that is stable until the end, shape (n,); NaN where none is known.

    By an amplification, and for the departure of a disk that rolls, the rate from which a perturbation grows to the
    limit of the criterion by the end (`grown`); else the rate that sinks to the critical one by then.
    """
    slowed, time = slowing(spec, starts, axis), lasting(spec)
    sinks = rate_before(critical, time, slowed)
    if axis != "roll_rate" or spec.criterion.kind == "aloft":
        return sinks if spec.criterion.kind != "amplification" else np.full_like(sinks, np.nan)
    limit = spec.criterion.allowed(spec.model.perturbation(spec, starts))

    def tried(excess: Array) -> tuple[Array, Array]:
        """Rates at the start of disks with an excess of (rate/critical rate)^2 over 1 at the end; which go too far."""
        end = critical * np.sqrt(1.0 + 10.0**excess)
        start = rate_before(end, time, slowed)
        return start, grown(starts, (critical, start, end), slowed) > limit

    low, high = np.full_like(critical, _LEAST), np.full_like(critical, _LARGEST)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        _, far = tried(middle)
        low, high = np.where(far, middle, low), np.where(far, high, middle)
    found, far = tried(high)
    found = np.where(far, np.nan, np.where(tried(low)[1], found, sinks))
    return np.where(np.hypot(starts["tilt"], starts["tilt_rate"]) > 0.0, found, sinks)


def grown(starts: Starts, rates: tuple[Array, Array, Array], slowed: tuple[Array, Array, Array]) -> Array:
    """Return how far [rad] from upright a disk that rolls has come while losses took its rate from one to another.

    Parameters
    ----------
    starts : mapping of str to array, shape (n,)
        With small tilts and tilt rates, and without a precession rate.
    rates : (critical, first, last), arrays of shape (n,)
        The critical rate, and those at start and end, which are above it [rad/s].
    slowed
        As of `slowing`.

    Returns
    -------
    array, shape (n,)

    Notes
    -----
    docs/losses-theory.md. The losses that slow the rolling leave dc = -theta ds of the small c = (alpha/2) o + alpha s
    theta, which without them is an invariant. The tilt swings about r c / (alpha s (r - 1)), r = (rate/critical)^2, so
    c grows as (r - 1)^(-1/(2 alpha)); the volume of (theta, w, c) is conserved, so c times the adiabatic invariant of
    the swing is constant. A kick leaves a little c, as the disk is slowed while it is tilted. Close to r = 1, where r
    changes much within a swing, all of it grows less.
    """
    critical, first, last = rates
    dry, viscous, layer = slowed
    alpha, tilt = starts["alpha"], starts["tilt"]
    r, s = (first / critical) ** 2, last / first
    stiffness = (r - 1.0) / (1.0 + 0.5 * alpha) * starts["gravity"] / starts["radius"]
    kick = starts["tilt_rate"] / np.sqrt(stiffness)
    lost = (dry / first + viscous + layer * np.sqrt(first)) / np.sqrt(stiffness)
    middle = (tilt + kick * lost / alpha) * r / (r - 1.0)
    growth = (r - 1.0) / ((last / critical) ** 2 - 1.0)
    swing, middle = np.hypot(middle - tilt, kick), np.abs(middle)
    at_end = middle * s * growth ** (1.0 + 0.5 / alpha) + swing * growth ** (0.25 - 0.25 / alpha)
    found: Array = np.maximum(middle + swing, at_end)
    return found


def unsteadied(spec: Request, starts: Starts, axis: str) -> npt.NDArray[np.bool_]:
    """Whether a loss acts on the small motions that keep an upright disk upright which has a rate; shape (n,).

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


def critical_rate(starts: Starts, axis: str) -> Array:
    """Return the critical rate [rad/s] of the upright disk without losses."""
    disk = [starts[name] for name in ("alpha", "radius", "gravity")]
    squared: Array = (
        critical_roll_rate_squared(*disk) if axis == "roll_rate" else critical_precession_rate_squared(*disk)
    )
    return np.sqrt(squared)


def slowing(spec: Request, starts: Starts, axis: str) -> tuple[Array, Array, Array]:
    """Return how losses slow an upright disk: the coefficients (a, b, d) of rate' = -(a + b rate + d rate^(3/2)).

    Parameters
    ----------
    spec : Request
    starts : mapping of str to array, shape (n,)
    axis : {"roll_rate", "precession_rate"}
        The rate that it has.

    Returns
    -------
    (a, b, d) : arrays, shape (n,)
        In rad s^-2, s^-1 and (rad s)^(-1/2).

    Notes
    -----
    With the moment of inertia (1+alpha) m R^2 about the contact for rolling, alpha m R^2 / 2 about the vertical for
    spinning. An upright disk weighs m g on the contact. Drag as in `kernels.lossy_disk.loss_laws`.
    """
    radius, gravity, mass = (starts[name] for name in ("radius", "gravity", "mass"))
    none = np.zeros_like(radius)
    if axis == "precession_rate":
        return 2.0 * starts["pivoting_friction"] * gravity / (starts["alpha"] * radius**2), none, none
    inertia = (1.0 + starts["alpha"]) * radius**2
    dry = (starts["contour_friction"] + starts["rolling_friction"]) * gravity / inertia
    viscous, layer = starts["contour_damping"] / (mass * inertia), none
    if spec.air_law == MOFFATT:
        viscous = viscous + 0.25 * math.pi * starts["air_viscosity"] * radius**3 / (mass * inertia)
    if spec.air_law == BILDSTEN:
        layer = np.sqrt(0.5 * starts["air_viscosity"] * starts["air_density"]) * radius**4 / (mass * inertia)
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


def wobble_time(spec: Request, start: Mapping[str, float]) -> float:
    """Return how long [s] a steady wobble lasts from the tilt of a start to flat_tilt, to leading order near flat.

    Notes
    -----
    Energy balance: 3/2 a' = -power, with roll rate^2 = 2/(alpha a) (scaled): the closed forms of each law in one
    integral. Pivoting friction takes no power: it holds the turning about the vertical.
    """
    high, low = (math.pi / 2 - abs(tilt) for tilt in (start["tilt"], float(spec.flat_tilt)))
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    middle, half = 0.5 * math.log(high * low), 0.5 * math.log(high / low)
    inclination = np.exp(middle + half * nodes)
    radius, gravity, mass = (start[name] for name in ("radius", "gravity", "mass"))
    unit, roll = math.sqrt(radius / gravity), np.sqrt(2.0 / (start["alpha"] * inclination))
    power = (start["contour_friction"] + start["rolling_friction"] * inclination) / radius * roll
    power = power + start["contour_damping"] * unit / (mass * radius**2) * roll**2
    if spec.air_law == MOFFATT:
        film = 0.25 * math.pi * start["air_viscosity"] * radius * unit / mass
        power = power + film * roll**2 / inclination
    if spec.air_law == BILDSTEN:
        layer = math.sqrt(0.5 * start["air_viscosity"] * start["air_density"] * unit) * radius**2 / mass
        power = power + layer * roll**2.5
    if power.min() <= 0.0:
        return math.inf
    return unit * float(np.sum(1.5 * inclination / power * weights) * half)


def predictions(spec: Request, start: Mapping[str, float], stored: Mapping[str, float]) -> Iterator[str]:
    """Yield lines with what theory says of one cell, from its start and its stored measures [SI]."""
    if not all(math.isfinite(start[name]) for name in ("tilt", "precession_rate", "roll_rate")):
        return
    if spec.precession_rate == WOBBLE:
        yield from _of_a_wobble(spec, start, stored)
    elif not circling(spec):
        yield from _of_an_upright_disk(spec, start)


def _of_a_wobble(spec: Request, start: Mapping[str, float], stored: Mapping[str, float]) -> Iterator[str]:
    inclination = math.pi / 2 - abs(start["tilt"])
    if abs(start["tilt"]) >= spec.flat_tilt or inclination > _STEEP:
        return
    time = wobble_time(spec, start)
    if not math.isfinite(time):
        yield "theory      a steady wobble near flat loses no energy to these losses"
        return
    measured = stored["end_time"]
    beside = f" (the cell has {measured:.6g} s)" if math.isfinite(measured) else ""
    flat = SETTINGS["flat_tilt"].spell(spec.flat_tilt, 6)
    yield f"theory      the energy of a steady wobble lasts {time:.6g} s to {flat}{beside}, to leading order near flat"


def _of_an_upright_disk(spec: Request, start: Mapping[str, float]) -> Iterator[str]:
    axis = next((name for name in _OTHER if start[name] != 0.0 and start[_OTHER[name]] == 0.0), None)
    if axis is None:
        return
    arrays = {name: np.array([value]) for name, value in start.items()}
    if unsteadied(spec, arrays, axis)[0]:
        yield f"theory      no prediction: {_UNSTEADIED[axis]}"
        return
    rate, critical = abs(start[axis]), float(critical_rate(arrays, axis)[0])
    words = axis.replace("_", " ")
    if rate <= critical:
        yield f"theory      the {words} is below {critical:.6g} rad s-1, the critical one without losses"
        return
    a, b, d = (float(each[0]) for each in slowing(spec, arrays, axis))
    time = time_between(rate, critical, (a, b, d))
    if math.isfinite(time):
        yield (
            f"theory      losses take the {words} of the upright disk down to {critical:.6g} rad s-1, the critical one "
            f"without losses, in {time:.6g} s; after a vanishing perturbation it falls later"
        )
    else:
        yield f"theory      the {words} is above {critical:.6g} rad s-1, the critical one, and no loss slows it"
