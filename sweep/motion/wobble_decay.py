"""How a steady wobble ends: the power law of each loss near flat, and the time that is left until flat.

In the steady wobble the centre is at rest, and an inclination a small against 1 has the precession rate
sqrt(2/(alpha a)) and the energy 3/2 a above flat, in units of sqrt(g/R) and m g R. A loss of the power p a^(-q) then
lets a fall as (t_f - t)^(1/(1 + q)), and the precession rate grow with -1/2 of that exponent.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from sweep.motion.kind import TIME
from sweep.motion.sampling import ending_of, request_of

if TYPE_CHECKING:
    import xarray as xr

#: Turns of the heading of a wobble: a disk that falls over makes fewer before it is flat.
_LEAST_TURNS = 3.0

#: Points of the quadrature of the time that is left.
_FINE = 2001


@dataclass(frozen=True)
class WobbleLoss:
    """The power of one loss in the steady wobble near flat: `coefficient` * a^(-`power`), over m g R sqrt(g/R).

    `name` is the variable of a motion with what it has taken.
    """

    name: str
    coefficient: float
    power: Fraction

    @property
    def exponent(self) -> Fraction:
        """The exponent n of a ~ (t_f - t)^n if nothing else takes energy; the precession rate has -n/2."""
        return 1 / (1 + self.power)


def wobble_losses(dataset: "xr.Dataset") -> tuple[WobbleLoss, ...]:
    """Return the losses of a motion that a power law describes near flat, in the order of its ledger.

    Pivoting friction has none: it holds the turn about the vertical, which is slow near flat, and then takes nothing.

    Notes
    -----
    Contour friction (dry) c sqrt(2/(alpha a)), rolling friction c sqrt(2 a/alpha), viscous contour friction
    2 k/(alpha a), with arms over R. Air by Moffatt, Nature 404 (2000) 833: pi mu R sqrt(R/g)/(2 alpha m) a^(-2); by
    Bildsten, Phys. Rev. E 66 (2002) 056309: sqrt(mu rho) R^(9/4) (2/alpha)^(5/4) / (sqrt(2) m g^(1/4)) a^(-5/4). The
    prefactors of both are estimates.
    """
    disk = {name: float(dataset[name]) for name in request_of(dataset).kind.fixed}
    alpha, radius, gravity, mass = (disk[name] for name in ("alpha", "radius", "gravity", "mass"))
    unit, turn = math.sqrt(radius / gravity), math.sqrt(2.0 / alpha)
    viscosity, density = disk["air_viscosity"], disk["air_density"]
    air: Mapping[str, tuple[float, Fraction]] = {
        "none": (0.0, Fraction(0)),
        "moffatt": (math.pi * viscosity * radius * unit / (2.0 * alpha * mass), Fraction(2)),
        "bildsten": (
            math.sqrt(viscosity * density)
            * radius**2.25
            * turn**2.5
            / (math.sqrt(2.0) * mass * gravity**0.25),
            Fraction(5, 4),
        ),
    }
    damping = disk["contour_damping"] * unit / (mass * radius**2)
    found = (
        WobbleLoss("rolling_loss", disk["rolling_friction"] / radius * turn, Fraction(-1, 2)),
        WobbleLoss("contour_loss", disk["contour_friction"] / radius * turn, Fraction(1, 2)),
        WobbleLoss("damping_loss", damping * turn**2, Fraction(1)),
        WobbleLoss("air_loss", *air[request_of(dataset).air_law]),
    )
    return tuple(each for each in found if each.coefficient > 0.0)


def wobbles(dataset: "xr.Dataset") -> bool:
    """Return whether a motion is a wobble that becomes flat: it goes round before, and does not fall over."""
    turned = abs(float(dataset["heading"][-1] - dataset["heading"][0])) / (2.0 * math.pi)
    return ending_of(dataset) == "flat" and turned > _LEAST_TURNS


def flat_time(dataset: "xr.Dataset") -> float:
    """Return when a wobble would be flat [s]: its end at flat_tilt, and what is left then by the closed forms.

    For a motion that is no wobble this is its end.
    """
    losses, end = wobble_losses(dataset), float(dataset["end_time"].fillna(dataset[TIME.name][-1]))
    if not losses or not wobbles(dataset):
        return end
    # with a = a_end x^2 the integrand is smooth down to flat, whatever the losses
    x = np.linspace(0.0, 1.0, _FINE)[1:]
    last = 0.5 * math.pi - request_of(dataset).flat_tilt
    power = sum(each.coefficient * (last * x**2) ** -float(each.power) for each in losses)
    integrand = np.concatenate([[0.0], 1.5 * last * 2.0 * x / power])
    unit = math.sqrt(float(dataset["radius"] / dataset["gravity"]))
    return end + unit * float(np.trapezoid(integrand, dx=1.0 / (_FINE - 1)))
