"""Theory of one motion: small oscillations of its tilt, and the end of a steady wobble.

In the steady wobble the centre is at rest. At a small inclination a the precession rate is sqrt(2/(alpha a)) and the
energy above flat is 3/2 a, in units of sqrt(g/R) and m g R. With a loss of the power p a^(-q), a decreases as
(t_f - t)^(1/(1 + q)), and the precession rate grows with -1/2 of that exponent.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from kernels.bodies.shapes import Body, thin_disk
from kernels.bodies.steady import nearby
from sweep.model.bodies.shape import body_of
from sweep.model.lossy_disk.air import DRAGS
from sweep.model.quantity import Array
from sweep.motion.request import MotionRequest
from sweep.motion.sampling import ending_of, request_of
from sweep.motion.tables import TIME

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class LinearMotion:
    """A motion in linear theory, at some times.

    `coefficient` is k [rad2/s2] in d'' + k d = 0: sqrt(k) is the frequency of the nutation, sqrt(-k) its growth rate.
    `tilt` [rad] and the contact point `x`, `y` [m] have the shape of the times.
    """

    coefficient: float
    tilt: Array
    x: Array
    y: Array


def rolling_body(request: MotionRequest, start: Mapping[str, float]) -> Body:
    """Return the body of a motion, from its request and the parameters of its start."""
    return thin_disk(start["alpha"]) if "alpha" in start else body_of(request, start)  # type: ignore[arg-type]


def linear_motion(start: Mapping[str, float], body: Body, times: Array) -> LinearMotion:
    """Return the motion of a start in linear theory.

    Parameters
    ----------
    start : mapping of str to float
        Tilt [rad] and rates [rad/s], radius [m] and gravity [m/s^2].
    body : kernels.bodies.shapes.Body
    times : float64 array, shape (n,)
        Increasing from 0 [s], and close enough to draw the path through.

    Notes
    -----
    Along a motion the rates are functions of the tilt (Chaplygin 1897). To first order in the distance d from the start
    tilt, they are linear in d, and d'' = a - k d, with the acceleration a and the stability coefficient k of the start
    (`kernels.bodies.steady.nearby`). The path follows from the rates.
    """
    radius, unit = start["radius"], math.sqrt(start["radius"] / start["gravity"])
    sin, cos = math.sin(start["tilt"]), math.cos(start["tilt"])
    o, s = unit * start["precession_rate"] * cos, unit * (start["roll_rate"] + start["precession_rate"] * sin)
    near = nearby(start["tilt"], o, s, body)
    k, acceleration = float(near.coefficient) / unit**2, float(near.acceleration) / unit**2
    away = _driven(k, acceleration, start["tilt_rate"], times)
    (turn, turn_slope), (ahead, ahead_slope) = near.turning, near.ahead
    heading = _integral((turn + turn_slope * away) / unit, times)
    speed = radius / unit * (ahead + ahead_slope * away)
    across = radius * float(near.curvature) * np.gradient(away, times)
    x = _integral(across * np.cos(heading) - speed * np.sin(heading), times)
    y = _integral(across * np.sin(heading) + speed * np.cos(heading), times)
    return LinearMotion(k, start["tilt"] + away, x, y)


def _driven(k: float, acceleration: float, rate: float, times: Array) -> Array:
    """Return the solution of d'' = acceleration - k d with d(0) = 0 and d'(0) = rate."""
    if k == 0.0:
        return rate * times + 0.5 * acceleration * times**2
    root = math.sqrt(abs(k))
    with np.errstate(over="ignore"):
        # linear theory fails long before a growing tilt overflows
        swing = np.sin(root * times) if k > 0.0 else np.sinh(root * times)
        turn = 1.0 - np.cos(root * times) if k > 0.0 else 1.0 - np.cosh(root * times)
        return acceleration / k * turn + rate / root * swing


def _integral(values: Array, times: Array) -> Array:
    steps = 0.5 * (values[1:] + values[:-1]) * np.diff(times)
    return np.concatenate([[0.0], np.cumsum(steps)])


#: Least number of turns of the heading in a wobble: a disk that falls over makes fewer before it is flat.
_LEAST_TURNS = 3.0

#: Number of points of the quadrature of the remaining time.
_FINE = 2001


@dataclass(frozen=True)
class WobbleLoss:
    """The power of one loss in the steady wobble near flat: `coefficient` * a^(-`power`), over m g R sqrt(g/R).

    `name` is the variable with the energy that it has taken.
    """

    name: str
    coefficient: float
    power: Fraction

    @property
    def exponent(self) -> Fraction:
        """The exponent n of a ~ (t_f - t)^n if this is the only loss; the precession rate has -n/2."""
        return 1 / (1 + self.power)


def wobble_losses(dataset: "xr.Dataset") -> tuple[WobbleLoss, ...]:
    """Return the losses of a motion that have a power law near flat, in the order of its ledger.

    Pivoting friction has none: it stops the rotation about the vertical, which is slow near flat, and then takes no
    energy.

    Notes
    -----
    Contour friction (dry) c sqrt(2/(alpha a)), rolling friction c sqrt(2 a/alpha), viscous contour friction
    2 k/(alpha a), with arms over R. Air (`sweep.model.lossy_disk.air`) has the power a^(-2) by Moffatt and a^(-5/4) by
    Bildsten. The prefactors of both are estimates.
    """
    disk = {name: float(dataset[name]) for name in request_of(dataset).kind.fixed}
    alpha, radius, gravity, mass = (disk[name] for name in ("alpha", "radius", "gravity", "mass"))
    unit, turn = math.sqrt(radius / gravity), math.sqrt(2.0 / alpha)
    damping = disk["contour_damping"] * unit / (mass * radius**2)
    losses: tuple[WobbleLoss, ...] = (
        WobbleLoss("rolling_loss", disk["rolling_friction"] / radius * turn, Fraction(-1, 2)),
        WobbleLoss("contour_loss", disk["contour_friction"] / radius * turn, Fraction(1, 2)),
        WobbleLoss("damping_loss", damping * turn**2, Fraction(1)),
    )
    if (law := request_of(dataset).air_law) in DRAGS:
        drag = DRAGS[law]
        falls = (drag.power + 1) / 2 + drag.steepness
        losses += (
            WobbleLoss("air_loss", float(drag.coefficient(disk)) * turn ** float(drag.power + 1), falls),
        )
    return tuple(loss for loss in losses if loss.coefficient > 0.0)


def wobbles(dataset: "xr.Dataset") -> bool:
    """Return whether a motion is a wobble that becomes flat: it makes several turns before, and does not fall over."""
    turned = abs(float(dataset["heading"][-1] - dataset["heading"][0])) / (2.0 * math.pi)
    return ending_of(dataset) == "flat" and turned > _LEAST_TURNS


def flat_time(dataset: "xr.Dataset") -> float:
    """Return the time [s] at which a wobble would be flat: its end at flat_tilt, plus the rest from the power laws.

    For other motions this is their end.
    """
    losses, end = wobble_losses(dataset), float(dataset["end_time"].fillna(dataset[TIME.name][-1]))
    if not losses or not wobbles(dataset):
        return end
    # with a = a_end x^2 the integrand is smooth down to flat, for any losses
    x = np.linspace(0.0, 1.0, _FINE)[1:]
    last = 0.5 * math.pi - request_of(dataset).flat_tilt
    power = sum(loss.coefficient * (last * x**2) ** -float(loss.power) for loss in losses)
    integrand = np.concatenate([[0.0], 1.5 * last * 2.0 * x / power])
    unit = math.sqrt(float(dataset["radius"] / dataset["gravity"]))
    return end + unit * float(np.trapezoid(integrand, dx=1.0 / (_FINE - 1)))
