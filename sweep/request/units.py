"""From the spelling of a unit to its factor to SI."""

import re
from functools import lru_cache
from typing import Any

from sweep.errors import RequestError
from sweep.schema import EVERYDAY_UNITS, FITTING, Quantity


def factor_to_si(unit: str, quantity: Quantity) -> float:
    """Return what to multiply a number in `unit` with, to have it in the quantity's SI units.

    Parameters
    ----------
    unit : str
        Any spelling that pint knows, CF's (``m s-2``) and the plain hand's (``m/s2``); empty for none.
    quantity : Quantity
        Says which units fit.

    Raises
    ------
    RequestError
        If the unit is not known, or measures something else.

    Notes
    -----
    An angle is not a pure number here: ``alpha=3deg`` does not fit, nor does ``precession_rate=5Hz``, which leaves
    open whether it counts radians or turns (say rad/s or turn/s).
    """
    if not unit:
        return 1.0
    units, factor = EVERYDAY_UNITS.get(unit) or _ask_pint(unit)
    if units != quantity.units:
        raise RequestError(
            f"the unit {unit!r} does not fit",
            f"{quantity.name} takes {FITTING[quantity.units]}",
            unit,
            "use a unit that fits, or a bare number in SI",
        )
    return factor


@lru_cache
def _ask_pint(unit: str) -> tuple[str, float]:
    try:
        root = _root(unit)
    except Exception as problem:  # pint meets bad text with assertions, tokenizer errors and more of its own
        raise RequestError(
            f"the unit {unit!r} is not known",
            "units are those of pint",
            unit,
            "check the spelling, as in deg, rpm, m/s2",
        ) from problem
    units, one = _si_spellings().get(str(root.units), ("", 1.0))
    return units, float(root.magnitude) / one


def _root(unit: str) -> Any:
    # Roots, not dimensions, are compared: in pint an angle has no dimension, but its root unit is the radian.
    # pint wants s**-1 where CF writes s-1 and a hand writes m/s2.
    spelled = re.sub(r"(?<=[A-Za-z])([+-]?\d+)", r"**\1", unit)
    return _registry().Quantity(1.0, spelled).to_root_units()


@lru_cache
def _si_spellings() -> dict[str, tuple[str, float]]:
    # the size of the SI unit in roots: pint's root of mass is the gram
    roots = {units: _root(units) for units in FITTING if units != "1"}
    spelled = {str(root.units): (units, float(root.magnitude)) for units, root in roots.items()}
    return spelled | {"dimensionless": ("1", 1.0)}


@lru_cache
def _registry() -> Any:
    from pint import UnitRegistry

    return UnitRegistry()
