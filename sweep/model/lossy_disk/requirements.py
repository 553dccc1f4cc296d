"""What the laws of losses need of a request: a mass, the viscosity and the density of the air."""

from collections.abc import Mapping
from typing import Any

from sweep.errors import RequestError
from sweep.model.lossy_disk.tables import ARMS, BILDSTEN, MOFFATT, NO_AIR, UNKNOWN, some


def check_losses(values: Mapping[str, Any]) -> None:
    """Refuse a law without what it needs, and what no law uses.

    Parameters
    ----------
    values : mapping of str to value
        Of every word of a request.

    Raises
    ------
    RequestError
    """
    law, viscous = str(values["air_law"]), some(values["air_viscosity"])
    if law == NO_AIR:
        _refuse_unused_air(values)
    elif not viscous:
        raise RequestError(
            f"air_law={law} needs the viscosity of the air: air_viscosity is 0.",
            hint="Add air_viscosity=1.8e-5, in Pa s, that of air at room temperature.",
            where="air_law",
        )
    if law == BILDSTEN and not some(values["air_density"]):
        raise RequestError(
            f"air_law={law} needs the density of the air: air_density is 0.",
            hint="Add air_density=1.2, in kg m-3, that of air at room temperature.",
            where="air_law",
        )
    if values["mass"] == UNKNOWN:
        _check_no_mass(values, law)
    _check_arms(values)


def _refuse_unused_air(values: Mapping[str, Any]) -> None:
    for name in ("air_viscosity", "air_density"):
        if some(values[name]):
            raise RequestError(
                f"{name} is given, and no law uses it: air_law is {NO_AIR}.",
                hint=f"Add air_law={MOFFATT} or air_law={BILDSTEN}, or say {name}=0.",
                where=name,
            )


def _check_arms(values: Mapping[str, Any]) -> None:
    """Refuse a lever arm as long as the radius: such a disk would not move at all."""
    radius = _ends(values["radius"])[0]
    for name in ARMS:
        if _ends(values[name])[1] >= radius:
            raise RequestError(
                f"A lever arm must be shorter than the radius of the disk; got {name}={values[name]} "
                f"radius={values['radius']}.",
                hint="Give a shorter arm: that of a coin on glass is some micrometres, as in 10um.",
                where=name,
            )


def _ends(value: Any) -> tuple[float, float]:
    low, high = value.ends() if hasattr(value, "ends") else (value, value)
    return float(low), float(high)


def _check_no_mass(values: Mapping[str, Any], law: str) -> None:
    needing = [name for name in ("contour_damping",) if some(values[name])]
    needing += [f"air_law={law}"] if law != NO_AIR else []
    if needing:
        raise RequestError(
            f"{' and '.join(needing)} {'need' if len(needing) > 1 else 'needs'} the mass of the disk: a torque that "
            "does not grow with the weight slows a heavy disk less.",
            hint="Add the mass, as in mass=0.4kg.",
            where="mass",
        )
