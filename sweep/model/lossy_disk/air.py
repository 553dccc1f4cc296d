"""The laws of the drag of air: what each one needs, and its torque in theory."""

import math
from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from kernels.lossy_disk.arrays import AIR_LAWS


class Drag(NamedTuple):
    """One law: the torque over m g R is coefficient * face^`on_face` * f^`power` / cos(tilt)^`steepness`.

    f is the roll rate in units of sqrt(g/R), and face the radius of the flat face over R, 1 for a thin disk.

    Attributes
    ----------
    needs : tuple of str
        The parameters without which the law takes nothing.
    coefficient : callable
        (parameters of a start, numbers or arrays) -> the coefficient.
    power : Fraction
    steepness, on_face : int
    """

    needs: tuple[str, ...]
    coefficient: Callable[[Mapping[str, Any]], Any]
    power: Fraction
    steepness: int
    on_face: int


def _unit(start: Mapping[str, Any]) -> Any:
    return np.sqrt(start["radius"] / start["gravity"])


def _film(start: Mapping[str, Any]) -> Any:
    return 0.25 * math.pi * start["air_viscosity"] * start["radius"] * _unit(start) / start["mass"]


def _layer(start: Mapping[str, Any]) -> Any:
    air = start["air_viscosity"] * start["air_density"]
    return np.sqrt(0.5 * air * _unit(start)) * start["radius"] ** 2 / start["mass"]


#: Law -> its drag: Moffatt, Nature 404 (2000) 833; Bildsten, Phys. Rev. E 66 (2002) 056309.
DRAGS: Mapping[str, Drag] = {
    "moffatt": Drag(("air_viscosity",), _film, Fraction(1), 1, 3),
    "bildsten": Drag(("air_viscosity", "air_density"), _layer, Fraction(3, 2), 0, 4),
}
assert ("none", *DRAGS) == AIR_LAWS

#: The parameters of the air.
AIR = tuple(dict.fromkeys(name for drag in DRAGS.values() for name in drag.needs))


def needs_of(law: str) -> tuple[str, ...]:
    """Return the parameters that a law needs; none for no law."""
    return DRAGS[law].needs if law in DRAGS else ()


def torque(law: str, start: Mapping[str, Any], roll: Any, cosine: Any, face: Any = 1.0) -> Any:
    """Return the torque of a law against a scaled roll rate above 0, over m g R; 0 for no law."""
    if law not in DRAGS:
        return 0.0 * roll
    drag = DRAGS[law]
    strength = drag.coefficient(start) * face**drag.on_face
    return strength * roll ** float(drag.power) / cosine**drag.steepness
