"""Units of numbers in a request: names from a fixed table, multiplied and divided, as in ``rad s-1`` or ``m/(s*s)``."""

import math
import re
from collections.abc import Mapping
from functools import lru_cache

from sweep.errors import RequestError, shown
from sweep.model.quantity import Quantity

#: Powers of m, g, s, rad, K and A: an angle is not a pure number here.
Dimension = tuple[int, ...]


def _powers(m: int = 0, g: int = 0, s: int = 0, *, rad: int = 0, K: int = 0, A: int = 0) -> Dimension:  # noqa: N803
    return m, g, s, rad, K, A


_LENGTH, _MASS, _TIME, _ANGLE, _NUMBER = (
    _powers(1),
    _powers(0, 1),
    _powers(0, 0, 1),
    _powers(rad=1),
    _powers(),
)
_RATE, _SPEED, _ACCELERATION = _powers(s=-1, rad=1), _powers(1, s=-1), _powers(1, s=-2)
_FORCE, _PRESSURE, _ENERGY = _powers(1, 1, -2), _powers(-1, 1, -2), _powers(2, 1, -2)

#: Keep the last digits: canonical texts of specs depend on them.
_ARCMINUTE, _POUND = 0.00029088820866572163, 453.5923700000001

#: The names of a unit -> its dimension, and its size in m, g, s, rad, K and A.
_TABLE: dict[str, tuple[Dimension, float]] = {
    "m metre meter": (_LENGTH, 1.0),
    "micron": (_LENGTH, 1e-6),
    "angstrom": (_LENGTH, 1e-10),
    "in inch inches": (_LENGTH, 0.0254),
    "ft foot feet": (_LENGTH, 12.0 * 0.0254),
    "yd yard": (_LENGTH, 0.9144),
    "mi mile": (_LENGTH, 1609.344),
    "nmi nautical_mile": (_LENGTH, 1852.0),
    "l L litre liter": (_powers(3), 1e-3),
    "g gram": (_MASS, 1.0),
    "t tonne metric_ton": (_MASS, 1e6),
    "lb pound": (_MASS, _POUND),
    "oz ounce": (_MASS, _POUND / 16.0),
    "s sec second": (_TIME, 1.0),
    "min minute": (_TIME, 60.0),
    "h hr hour": (_TIME, 3600.0),
    "d day": (_TIME, 86400.0),
    "week": (_TIME, 604800.0),
    "Hz hertz": (_powers(s=-1), 1.0),
    "rad radian": (_ANGLE, 1.0),
    "deg degree °": (_ANGLE, math.radians(1.0)),
    "arcmin arcminute": (_ANGLE, _ARCMINUTE),
    "arcsec arcsecond": (_ANGLE, math.radians(1.0 / 3600.0)),
    "grad grade gon": (_ANGLE, math.pi / 200.0),
    "turn revolution cycle circle": (_ANGLE, 2.0 * math.pi),
    "rpm revolutions_per_minute": (_RATE, 2.0 * math.pi / 60.0),
    "rps revolutions_per_second": (_RATE, 2.0 * math.pi),
    "kph": (_SPEED, 1000.0 / 3600.0),
    "mph": (_SPEED, 1609.344 / 3600.0),
    "kt knot": (_SPEED, 1852.0 / 3600.0),
    "g_0 g_n gravity standard_gravity": (_ACCELERATION, 9.80665),
    "N newton": (_FORCE, 1000.0),
    "dyn dyne": (_FORCE, 0.01),
    "lbf pound_force": (_FORCE, 4448.2216152605),
    "Pa pascal": (_PRESSURE, 1000.0),
    "bar": (_PRESSURE, 1e8),
    "P poise": (_powers(-1, 1, -1), 100.0),
    "J joule": (_ENERGY, 1000.0),
    "W watt": (_powers(2, 1, -3), 1000.0),
    "cal calorie": (_ENERGY, 4184.0),
    "K kelvin degC degF": (_powers(K=1), 1.0),
    "A amp ampere": (_powers(A=1), 1.0),
    "C coulomb": (_powers(s=1, A=1), 1.0),
    "V volt": (_powers(2, 1, -3, A=-1), 1000.0),
    "ohm Ω Ω": (_powers(2, 1, -3, A=-2), 1000.0),
    "S siemens": (_powers(-2, -1, 3, A=2), 1e-3),
    "F farad": (_powers(-2, -1, 4, A=2), 1e-3),
    "H henry": (_powers(2, 1, -2, A=-2), 1000.0),
    "Wb weber": (_powers(2, 1, -2, A=-1), 1000.0),
    "T tesla": (_powers(0, 1, -2, A=-1), 1000.0),
    "dimensionless": (_NUMBER, 1.0),
    "% percent": (_NUMBER, 0.01),
}
_UNITS = {name: unit for names, unit in _TABLE.items() for name in names.split()}
_PREFIXES = {
    "p": 1e-12, "n": 1e-9, "u": 1e-6, "µ": 1e-6, "μ": 1e-6, "m": 1e-3, "c": 1e-2, "d": 1e-1, "da": 10.0, "h": 100.0,
    "k": 1e3, "M": 1e6, "G": 1e9, "pico": 1e-12, "nano": 1e-9, "micro": 1e-6, "milli": 1e-3, "centi": 1e-2,
    "deci": 1e-1, "deca": 10.0, "hecto": 100.0, "kilo": 1e3, "mega": 1e6, "giga": 1e9,
}  # fmt: skip

#: Translation of superscript digits and signs to ASCII.
_RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺", "0123456789-+")
_TOKEN = re.compile(
    r" ?(?P<sign>[*/·⋅]|\.(?=[^\W\d])|\bper\b) ?|(?P<bracket>[()])"
    r"|(?P<name>g_0\b|[^\W\d⁰¹²³⁴⁵⁶⁷⁸⁹]+|[°%])"
    r"(?P<power>(?:\*\*|\^)[+-]?[0-9]{1,2}(?:\.0+)?|[+-]?[0-9]{1,2}|[⁻⁺]?[⁰¹²³⁴⁵⁶⁷⁸⁹]{1,2})?(?![\w^]|\*\*|\.[0-9])"
    r"|(?P<one>1)(?!\w| [^*/])|(?P<space> )"
)
_MOST_CHARACTERS = 80
#: Names with an s at their end that is read as a plural: longer ones than this, and these.
_LEAST_PLURAL, _SHORT_PLURALS = 3, ("lbs", "hrs", "yds")

_A_NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*)", re.ASCII | re.DOTALL)

#: SI unit -> examples of the allowed units, for messages.
_FITTING: Mapping[str, str] = {
    "1": "no unit, it is a pure number",
    "rad": "deg, rad, arcmin",
    "rad s-1": "rad/s, deg/s, rpm, turn/s",
    "m": "m, cm, inch",
    "m s-1": "m/s, cm/s, km/h",
    "m s-2": "m/s2, cm/s2, g_0",
    "s": "s, ms, min",
    "kg": "kg, g, pound",
    "kg m-3": "kg/m3, g/cm3",
    "Pa s": "Pa s, uPa s",
    "N m s": "N m s",
}


@lru_cache
def read_unit(text: str) -> tuple[Dimension, float] | None:
    """Return the dimension of a unit and its size in m, g, s and rad; None if it is unknown or its size overflows.

    Parameters
    ----------
    text : str
        Names in the table, with or without a prefix, multiplied and divided, each with a whole power below 100.
    """
    if len(text) > _MOST_CHARACTERS:
        return None
    powers, size = [0] * len(_NUMBER), 1.0
    # the sign of the next factor's power, and the sign of each open bracket
    sign, brackets, wanted, named, at = 1, [1], True, False, 0
    while at < len(text):
        found = _TOKEN.match(text, at)
        if found is None:
            return None
        at, kind = found.end(), found.lastgroup
        if found["sign"] or found["space"]:
            if wanted:
                return None
            sign, wanted = (-1 if found["sign"] in ("/", "per") else 1), True
        elif found["bracket"] == ")":
            if wanted or len(brackets) == 1:
                return None
            brackets.pop()
        elif not wanted:
            return None
        elif found["bracket"]:
            brackets.append(brackets[-1] * sign)
            sign = 1
        else:
            wanted = False
            if kind == "one":
                continue
            unit = _unit(found["name"])
            power = (found["power"] or "1").translate(_RAISED).lstrip("*^").partition(".")[0]
            exponent, named = brackets[-1] * sign * int(power), True
            if unit is None or not exponent:
                return None
            powers = [each + exponent * base for each, base in zip(powers, unit[0], strict=True)]
            try:
                size *= unit[1] ** exponent
            except OverflowError:
                return None
    whole = named and not wanted and len(brackets) == 1 and 0.0 < size < math.inf
    return (tuple(powers), size) if whole else None


def _unit(name: str) -> tuple[Dimension, float] | None:
    """Return the unit of a name, which may have a prefix and a plural s."""
    # a plural of a short name could be a product: Vs, As, Pas
    plural = name.removesuffix("s") if len(name) > _LEAST_PLURAL or name in _SHORT_PLURALS else name
    for word in (name, plural):
        if word in _UNITS:
            return _UNITS[word]
        for prefix, scale in _PREFIXES.items():
            if word.startswith(prefix) and (unit := _UNITS.get(word[len(prefix) :])):
                return unit[0], scale * unit[1]
    return None


def number_and_unit(text: str) -> tuple[str, str] | None:
    """Return the texts of a number and of its unit, which may be empty; None if there is no number."""
    match = _A_NUMBER.fullmatch(text.strip())
    return (match[1], " ".join(match[2].split())) if match else None


def plain_number(text: str) -> float:
    """Return the number in a text in ASCII without a unit; NaN if the text is not such a number."""
    match = _A_NUMBER.fullmatch(text.strip())
    return float(match[1]) if match and not match[2] else math.nan


def factor_to_si(unit: str, quantity: Quantity) -> float:
    """Return the factor from a number in `unit` to the SI units of a quantity.

    Parameters
    ----------
    unit : str
        Names in the table of this module, multiplied and divided, with whole powers below 100: ``m s-2`` as in CF,
        ``m/s2``, ``m/s**2``, ``m/(s*s)``, ``m·s⁻²``, ``meter per second``; may be empty.
    quantity : Quantity
        Determines the allowed units.

    Raises
    ------
    RequestError
        If the unit is unknown, or does not fit the quantity.

    Notes
    -----
    An angle is not a pure number here: ``alpha=3deg`` does not fit. ``precession_rate=5Hz`` does not fit either,
    because it could mean 5 rad/s or 5 turn/s.
    """
    if not unit:
        return 1.0
    found, si = read_unit(unit), read_unit("dimensionless" if quantity.units == "1" else quantity.units)
    if unit.startswith("."):
        raise RequestError(
            f"A number is followed by its unit, not by {shown(unit)!r}.",
            hint="A number has one decimal point, as in 0.25; a range is start:stop:count, as in 2:4:300.",
        )
    if found is None or si is None:
        raise RequestError(
            f"The unit {shown(unit)!r} is not known: units are names such as deg, rpm, mm or kg, multiplied and "
            "divided, each with a whole power below 100.",
            hint="Check the spelling, as in deg, rpm, m/s2, rad s-1.",
        )
    if found[0] != si[0]:
        fitting = _FITTING.get(quantity.units, quantity.units)
        raise RequestError(
            f"The unit {shown(unit)!r} does not fit: {quantity.name} takes {fitting}.",
            hint="Use a unit that fits, or a bare number in SI.",
        )
    return found[1] / si[1]
