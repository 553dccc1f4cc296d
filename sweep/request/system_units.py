"""Units of a user's system: read from an annotation, spelled as in files, and compared between the parts of a sum.

The dimension of a part is the powers of m, g, s, rad and K. Angles count as pure numbers where dimensions are compared:
``speed*time`` and ``angle`` are alike, so are ``sin(angle)`` and ``angle``.
"""

import re

from sweep.errors import RequestError, shown
from sweep.request.units import read_unit

#: Powers of m, g, s, rad and K, broken ones too: that of ``sqrt(length)`` is a half.
Dimension = tuple[float, ...]

PURE: Dimension = (0.0,) * 5
SECOND: Dimension = (0.0, 0.0, 1.0, 0.0, 0.0)
ANGLE: Dimension = (0.0, 0.0, 0.0, 1.0, 0.0)
_METRE, _GRAM, _SECOND, _RADIAN, _KELVIN = range(5)

#: The names of a dimension's powers in the order in which they are written.
_WRITTEN = ((_GRAM, "kg"), (_METRE, "m"), (_RADIAN, "rad"), (_KELVIN, "K"), (_SECOND, "s"))

#: Temperatures that do not begin at absolute zero.
_SHIFTED = re.compile(r"deg[CF]")

#: Halves to sixths, and roots of roots, are whole numbers of this part.
_PARTS = 3600
#: Powers of a unit at most.
_MOST_POWER = 99


def read_dimension(text: str) -> Dimension:
    """Return the dimension of a unit: that of ``m/s2``, ``deg``, ``1/s``; ``1`` and nothing are pure numbers.

    Raises
    ------
    RequestError
        If it is no unit.
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
    """Refuse a unit whose zero lies elsewhere: 20 degC would be read as 20 K."""
    if _SHIFTED.search(text):
        raise RequestError(f"the zero of {shown(text)!r} is not that of K", hint="Write temperatures in K.")


def written(dimension: Dimension) -> str | None:
    """Return the SI unit of a dimension as files spell it, ``kg m2 s-2``; None if a power is no small whole number."""
    if any(power != round(power) or abs(power) > _MOST_POWER for power in dimension):
        return None
    powers = ((name, int(dimension[at])) for at, name in _WRITTEN)
    return " ".join(f"{name}{power if power != 1 else ''}" for name, power in powers if power) or "1"


def told(dimension: Dimension) -> str:
    """Return a dimension as a message says it."""
    if not any(dimension):
        return "a pure number"
    powers = ((name, dimension[at]) for at, name in _WRITTEN)
    return "in " + " ".join(f"{name}{f'{power:g}' if power != 1 else ''}" for name, power in powers if power)


def alike(one: Dimension, other: Dimension) -> bool:
    """Return whether two dimensions are the same, angles taken as pure numbers."""
    return _without_angle(one) == _without_angle(other)


def product(one: Dimension, other: Dimension, power: float = 1.0) -> Dimension:
    """Return the dimension of a part times a power of another one."""
    return tuple(_fraction(a + power * b) for a, b in zip(one, other, strict=True))


def _fraction(power: float) -> float:
    """Return the fraction that a power is, up to rounding: that of a third of a third, three times, is one third."""
    nearest = round(power * _PARTS) / _PARTS
    return nearest + 0.0 if abs(power - nearest) < 1e-9 else power


def of_result(dimension: Dimension) -> Dimension:
    """Return the dimension of a result: an angle, an angle per time to some power, or no angle in it.

    A length times an angle is a length, and the square of an angle is a pure number.
    """
    others = [power for at, power in enumerate(dimension) if at not in (_SECOND, _RADIAN)]
    return _without_angle(dimension) if any(others) or dimension[_RADIAN] != 1.0 else dimension


def wider(one: Dimension, other: Dimension) -> Dimension:
    """Return the dimension of a sum of parts that are alike: an angle if one of them is an angle."""
    return max(one, other, key=lambda each: abs(each[_RADIAN]))


def _without_angle(dimension: Dimension) -> Dimension:
    return tuple(0.0 if at == _RADIAN else power for at, power in enumerate(dimension))
