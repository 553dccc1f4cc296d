"""Units of a user's system: reading annotations, writing units for files, and comparing the dimensions in a sum.

A dimension is the powers of m, g, s, rad, K and A. Comparisons treat angles as pure numbers: ``sin(angle)`` and
``angle`` are alike.
"""

import re

from sweep.errors import RequestError, shown
from sweep.request.units import read_unit

#: Powers of m, g, s, rad, K and A, which may be fractions: ``sqrt(length)`` has the power 1/2 of m.
Dimension = tuple[float, ...]

PURE: Dimension = (0.0,) * 6
SECOND: Dimension = (0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
ANGLE: Dimension = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0)
_METRE, _GRAM, _SECOND, _RADIAN, _KELVIN, _AMPERE = range(6)

#: The index and the unit of each power, in the order of writing.
_WRITTEN = ((_GRAM, "kg"), (_METRE, "m"), (_RADIAN, "rad"), (_KELVIN, "K"), (_SECOND, "s"), (_AMPERE, "A"))

#: Temperature scales whose zero is not absolute zero.
_SHIFTED = re.compile(r"deg[CF]")

#: Electrical units that are written by their own name: nobody reads kg m2 s-3 A-2 as ohm.
_NAMED = {
    tuple(map(float, unit[0])): name
    for name in ("C", "V", "ohm", "S", "F", "H", "Wb", "T")
    if (unit := read_unit(name)) is not None
}

#: Powers are rounded to multiples of 1/3600, which include halves to sixths and roots of roots.
_PARTS = 3600
#: Largest power of a unit.
_MOST_POWER = 99


def read_dimension(text: str) -> Dimension:
    """Return the dimension of a unit such as ``m/s2``, ``deg`` or ``1/s``; ``1`` and empty text are pure numbers.

    Raises
    ------
    RequestError
        If the unit is unknown.
    """
    found = read_unit(text.strip()) if text.strip() not in ("", "1") else ((0,) * len(PURE), 1.0)
    if found is None:
        raise RequestError(
            f"the unit {shown(text)!r} is not known",
            hint="Units are names such as m, deg, kg, N or 1/s, multiplied and divided, as in rad/s, m/s2, kg m2.",
        )
    check_scale(text)
    return tuple(map(float, found[0]))


def check_scale(text: str) -> None:
    """Refuse a temperature scale with another zero than K: 20 degC would be read as 20 K."""
    if _SHIFTED.search(text):
        raise RequestError(
            f"the zero of {shown(text)!r} is not the zero of K", hint="Write temperatures in K."
        )


def written(dimension: Dimension) -> str | None:
    """Return the SI unit of a dimension in files, ``kg m2 s-2`` or ``ohm``; None if a power is not a small integer."""
    if any(power != round(power) or abs(power) > _MOST_POWER for power in dimension):
        return None
    if dimension in _NAMED:
        return _NAMED[dimension]
    powers = ((name, int(dimension[at])) for at, name in _WRITTEN)
    return " ".join(f"{name}{power if power != 1 else ''}" for name, power in powers if power) or "1"


def told(dimension: Dimension) -> str:
    """Return a dimension in words for messages."""
    if not any(dimension):
        return "a pure number"
    if dimension in _NAMED:
        return f"in {_NAMED[dimension]}"
    powers = ((name, dimension[at]) for at, name in _WRITTEN)
    return "in " + " ".join(f"{name}{f'{power:g}' if power != 1 else ''}" for name, power in powers if power)


def alike(one: Dimension, other: Dimension) -> bool:
    """Return whether two dimensions are the same, angles taken as pure numbers."""
    return _without_angle(one) == _without_angle(other)


def product(one: Dimension, other: Dimension, power: float = 1.0) -> Dimension:
    """Return the dimension of a product of one part and a power of another."""
    return tuple(_fraction(a + power * b) for a, b in zip(one, other, strict=True))


def _fraction(power: float) -> float:
    """Return a power after removing rounding errors: three times a third of a third is one third."""
    nearest = round(power * _PARTS) / _PARTS
    return nearest + 0.0 if abs(power - nearest) < 1e-9 else power


def of_result(dimension: Dimension) -> Dimension:
    """Return the dimension of a result; only an angle, possibly times a power of time, keeps its angle.

    A length times an angle becomes a length, and the square of an angle a pure number.
    """
    others = [power for at, power in enumerate(dimension) if at not in (_SECOND, _RADIAN)]
    return _without_angle(dimension) if any(others) or dimension[_RADIAN] != 1.0 else dimension


def wider(one: Dimension, other: Dimension) -> Dimension:
    """Return the dimension of a sum of two alike parts: an angle if one of the parts is an angle."""
    return max(one, other, key=lambda each: abs(each[_RADIAN]))


def _without_angle(dimension: Dimension) -> Dimension:
    return tuple(0.0 if at == _RADIAN else power for at, power in enumerate(dimension))
