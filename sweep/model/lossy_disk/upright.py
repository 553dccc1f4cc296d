"""Theory of an upright body with losses, without integration: its slowing, and the position of its boundary.

Friction along the edge and the air slow an upright body that rolls; pivoting friction slows one that spins. Until the
rate has dropped to the critical rate without losses, a perturbation grows by a bounded factor; after that, the fall
takes time. So for a vanishing perturbation the boundary is about the rate that drops to the critical rate by the end.
For a finite perturbation of a rolling body it is higher, because of the factor: the path of a body that slows down
winds up (`grown`).

Losses that brake the roll rate of a disk that spins upright (contour friction, damping, air) make its tilt grow at
every rate. With a small viscous friction k it grows like exp(k t/(1+alpha) (1 + q)/(q - 1)), q = (1 + alpha/2) P^2
(scaled); dry friction holds the disk. If pivoting friction stops the rotation about the vertical of a disk that rolls
upright, the critical rate is 1/sqrt(1 + alpha), higher than for the disk without losses. Such bodies have no line.
"""

import math
from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from kernels.disk.steady import critical_precession_rate_squared, critical_roll_rate_squared
from sweep.model.description import Request, Starts
from sweep.model.disk.initial_conditions import computed_rates
from sweep.model.lossy_disk.air import DRAGS, torque
from sweep.model.quantity import Array

#: Number of steps of a rate back in time, and of nodes of an integral over a rate, both for an error of 1e-9.
_STEPS, _NODES = 256, 400

#: Range of a bisection over the excess of (rate/critical rate)^2 over 1 at the end, as logarithms to base 10, and its
#: number of halvings, to 1e-9 of the logarithm.
_LEAST, _LARGEST, _HALVINGS = -12.0, 8.0, 34

_OTHER = {"roll_rate": "precession_rate", "precession_rate": "roll_rate"}

#: Why there is no prediction for an `unsteadied` body that rolls, or spins.
_UNSTEADIED = {
    "roll_rate": "pivoting friction stops the rotation of the {} about the vertical, so another rate is critical",
    "precession_rate": "friction or drag against its roll rate makes the {} that spins upright unstable at every rate",
}


class Upright(NamedTuple):
    """Upright bodies: arrays, shape (n,).

    Attributes
    ----------
    rolling, spinning : array
        Critical rates [rad/s] without losses.
    axial, transverse : array
        Moments of inertia over m R^2.
    sharpness : array
        1 minus the radius of curvature of the edge over the outer radius.
    face : array or float
        Radius of the flat face over the outer radius.
    """

    rolling: Array
    spinning: Array
    axial: Array
    transverse: Array
    sharpness: Array
    face: Array | float = 1.0

    def critical(self, axis: str) -> Array:
        """Return the critical value [rad/s] of a rate."""
        return self.rolling if axis == "roll_rate" else self.spinning


def thin(starts: Starts) -> Upright:
    """Return the thin disks of starts."""
    disk, alpha = [starts[name] for name in ("alpha", "radius", "gravity")], starts["alpha"]
    rolling, spinning = critical_roll_rate_squared(*disk), critical_precession_rate_squared(*disk)
    return Upright(np.sqrt(rolling), np.sqrt(spinning), alpha, 0.5 * alpha, np.ones_like(alpha))


def lines(spec: Request, axis: str, starts: Starts, body: Upright) -> dict[str, tuple[Array, Array]]:
    """Return the critical rate without losses, and an estimate of the boundary with losses.

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
        As in `sweep.model.description.Model.lines`, in rad/s. NaN for a body that both rolls and precesses, and for an
        `unsteadied` one.
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
    """Return the least initial rate [rad/s] of bodies that are stable until the end, shape (n,); NaN if not known.

    For the departure or amplification of a body that rolls, it is the rate from which a perturbation grows to the limit
    of the criterion by the end (`grown`); otherwise the rate that drops to the critical rate by then.
    """
    slowed, time = slowing(spec, starts, axis, body), lasting(spec)
    sinks = rate_before(critical, time, slowed)
    if axis != "roll_rate" or spec.criterion.kind == "aloft":
        return sinks if spec.criterion.kind != "amplification" else np.full_like(sinks, np.nan)
    limit = spec.criterion.allowed(spec.model.perturbation(spec, starts))

    def initial_rate(excess: Array) -> tuple[Array, Array]:
        """Return the initial rate for an excess of (rate/critical rate)^2 over 1 at the end; which exceed the limit."""
        end = critical * np.sqrt(1.0 + 10.0**excess)
        start = rate_before(end, time, slowed)
        return start, grown(starts, body, (critical, start, end), slowed) > limit

    low, high = np.full_like(critical, _LEAST), np.full_like(critical, _LARGEST)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        _, far = initial_rate(middle)
        low, high = np.where(far, middle, low), np.where(far, high, middle)
    rate, far = initial_rate(high)
    rate = np.where(far, np.nan, np.where(initial_rate(low)[1], rate, sinks))
    return np.where(np.hypot(starts["tilt"], starts["tilt_rate"]) > 0.0, rate, sinks)


def grown(
    starts: Starts, body: Upright, rates: tuple[Array, Array, Array], slowed: tuple[Array, Array, Array]
) -> Array:
    """Return the largest tilt [rad] of a rolling body while losses reduce its rate from one value to another.

    Parameters
    ----------
    starts : mapping of str to array, shape (n,)
        Small tilts and tilt rates, no precession rate.
    body : Upright
    rates : (critical, first, last), arrays of shape (n,)
        The critical rate, and the rates at start and end, which are above it [rad/s].
    slowed
        The coefficients from `slowing`.

    Returns
    -------
    array, shape (n,)

    Notes
    -----
    See docs/losses-theory.md. A and I are the transverse and the axial moment, k is the sharpness of the edge. The
    small c = A o + I s theta is an invariant without losses; losses change it by dc = -k theta ds. The tilt swings
    about r c / (I s (r - 1)), r = (rate/critical)^2, so c grows as (r - 1)^(-k/(2 I)). The volume of (theta, w, c) is
    conserved, so c times the adiabatic invariant of the swing is constant. A kick leads to a small c, because the body
    slows down while it is tilted. Close to r = 1, where r changes much within a swing, everything grows less.
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
    largest: Array = np.maximum(middle + swing, at_end)
    return largest


def unsteadied(spec: Request, starts: Starts, axis: str) -> npt.NDArray[np.bool_]:
    """Return whether a loss acts on the small motions that keep a body with this rate upright; shape (n,).

    For a body that rolls, these are rotations about the vertical; for one that spins, rolling along the rim.
    """
    if axis == "roll_rate":
        return np.asarray(starts["pivoting_friction"] > 0.0)
    braked = (starts["contour_friction"] > 0.0) | (starts["contour_damping"] > 0.0)
    return np.asarray(braked | (torque(spec.air_law, starts, np.ones_like(starts["mass"]), 1.0) > 0.0))


def lasting(spec: Request) -> float:
    """Return the time [s] that a motion must last for the criterion; NaN for other criteria."""
    if spec.criterion.kind in ("departure", "amplification"):
        return float(spec.duration)
    return float(spec.criterion.limit) if spec.criterion.kind == "aloft" else math.nan


def slowing(spec: Request, starts: Starts, axis: str, body: Upright) -> tuple[Array, Array, Array]:
    """Return the coefficients (a, b, d) of the slowing of an upright body, rate' = -(a + b rate + d rate^(3/2)).

    Parameters
    ----------
    spec : Request
    starts : mapping of str to array, shape (n,)
    axis : {"roll_rate", "precession_rate"}
        The nonzero rate.
    body : Upright

    Returns
    -------
    (a, b, d) : arrays, shape (n,)
        In rad s^-2, s^-1 and (rad s)^(-1/2).

    Notes
    -----
    The moment of inertia is (1 + I) m R^2 about the contact for rolling, and A m R^2 about the vertical for spinning.
    The normal force on an upright body is m g. Drag as in `kernels.lossy_disk.loss_laws`.
    """
    radius, gravity, mass = (starts[name] for name in ("radius", "gravity", "mass"))
    none = np.zeros_like(radius)
    if axis == "precession_rate":
        return starts["pivoting_friction"] * gravity / (body.transverse * radius**2), none, none
    inertia = (1.0 + body.axial) * radius**2
    dry = (starts["contour_friction"] + starts["rolling_friction"]) * gravity / inertia
    viscous, layer = starts["contour_damping"] / (mass * inertia), none
    power = DRAGS[spec.air_law].power if spec.air_law in DRAGS else Fraction(1)
    # the torque at one radian per second
    drag = (
        torque(spec.air_law, starts, np.sqrt(radius / gravity), 1.0, body.face) * gravity * radius / inertia
    )
    if power == 1:
        viscous = viscous + drag
    elif power == Fraction(3, 2):
        layer = layer + drag
    else:
        # no closed form: nothing is predicted
        dry = dry + np.nan * drag
    return dry, viscous, layer


def rate_before(rate: Array, time: float, slowed: tuple[Array, Array, Array]) -> Array:
    """Return the rate [rad/s] that drops to `rate` within a time [s], shape (n,); see `slowing`."""
    dry, viscous, layer = slowed
    if not np.any(layer):
        # (rate + a/b) exp(b t) - a/b, also for b = 0
        exponent = viscous * time
        factor = np.where(exponent > 0.0, np.expm1(exponent) / np.where(exponent > 0.0, exponent, 1.0), 1.0)
        before: Array = rate * np.exp(exponent) + dry * time * factor
        return before

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
    """Return the time [s] in which a rate drops to the critical rate; infinite without losses."""
    dry, viscous, layer = slowed
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    rates = 0.5 * (rate + critical) + 0.5 * (rate - critical) * nodes
    power = dry + viscous * rates + layer * rates * np.sqrt(rates)
    return 0.5 * (rate - critical) * float(np.sum(weights / power)) if power.min() > 0.0 else math.inf


def describe_slowing(spec: Request, start: Mapping[str, float], body: Upright, called: str) -> Iterator[str]:
    """Yield the line of `explain` with the prediction for a cell with an upright body; `called` is its name."""
    axis = next((name for name in _OTHER if start[name] != 0.0 and start[_OTHER[name]] == 0.0), None)
    if axis is None:
        return
    arrays = {name: np.array([value]) for name, value in start.items()}
    rate, critical = abs(start[axis]), float(body.critical(axis)[0])
    name = axis.replace("_", " ")
    if not math.isfinite(critical):
        yield f"theory      without losses the upright {called} is stable at every {name}"
        return
    if unsteadied(spec, arrays, axis)[0]:
        yield f"theory      no prediction: {_UNSTEADIED[axis].format(called)}"
        return
    if rate <= critical:
        yield f"theory      the {name} is below {critical:.6g} rad s-1, the critical rate without losses"
        return
    a, b, d = (float(coefficient[0]) for coefficient in slowing(spec, arrays, axis, body))
    time = time_between(rate, critical, (a, b, d))
    if math.isfinite(time):
        yield (
            f"theory      losses reduce the {name} of the upright {called} to {critical:.6g} rad s-1, the critical "
            f"rate without losses, in {time:.6g} s; after a vanishing perturbation it falls later"
        )
    else:
        yield f"theory      the {name} is above {critical:.6g} rad s-1, the critical rate, and no loss slows it"
