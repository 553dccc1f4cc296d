"""From text to values: ``0.5``, ``10deg``, ``0.5,1``, ``0.01deg:20deg:300:log``.

A value is a number, a list or a range (both ends included), each number with a unit of its own or bare in SI. A
list or a range is an axis of the grid even if it holds one value; a number is not.
"""

import math
import re
from collections.abc import Mapping, Sequence
from numbers import Real
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt

from sweep.errors import RequestError, shown
from sweep.model.quantity import Quantity
from sweep.request.axes import AxisError, Range, Values
from sweep.request.units import read_unit

Value = float | Range | Values

_VALUE = (
    "a number, a list a,b,c or a range start:stop:count[:log], each number finite and with an optional unit"
)
_NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*)", re.ASCII | re.DOTALL)
NOT_FINITE = re.compile(r"[+-]?(inf|infinity|nan)", re.IGNORECASE)
#: Signs that printed pages have for minus: the hyphens and dashes of Unicode, and its minus.
_MINUS = "\u2010\u2011\u2012\u2013\u2014\u2212"
_COUNT = re.compile(r"[+-]?\d{1,18}", re.ASCII)

#: units -> what a request may write, for messages.
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


class NoCountError(RequestError):
    """Two numbers that would be a range with a count."""


def read_value(raw: object, quantity: Quantity) -> Value:
    """Return the number, range or list that was given for a quantity, in its SI units.

    Parameters
    ----------
    raw : str, number, sequence, 1-d array, Range or Values
        Text is read in the language of the module docstring; bare numbers are SI.
    quantity : Quantity
        Says which units fit.

    Returns
    -------
    float, Range or Values

    Raises
    ------
    RequestError
        If it is none of these, or a unit does not fit the quantity.
    """
    try:
        if isinstance(raw, Range | Values):
            return raw
        if isinstance(raw, str):
            return _read_text(raw, quantity)
        if isinstance(raw, np.ndarray):
            return _read_array(raw, quantity)
        if isinstance(raw, Sequence) and not isinstance(raw, bytes | bytearray):
            return Values(_read_numbers(raw, quantity))
        return _read_numbers([raw], quantity)[0]
    except AxisError as error:
        # the ends of a range are in SI by now
        said = error.with_given(raw.strip() if isinstance(raw, str) else raw) if _has_text(raw) else error
        raise said.at(f"{quantity.name}={shown(raw)}") from None
    except RequestError as error:
        raise error.at(f"{quantity.name}={shown(raw)}") from None


def read_number(raw: object, quantity: Quantity) -> float:
    """Return the one number that was given for a quantity, in its SI units; a list or a range is refused.

    Raises
    ------
    RequestError
        If it is not a single number, or a unit does not fit the quantity.
    """
    try:
        value = read_value(raw, quantity)
        if isinstance(value, float):
            return value
    except NoCountError:
        # with a count it would be a range, which is refused too
        pass
    raise RequestError(
        f"{quantity.name} must be one number here; it cannot be an axis.",
        hint="Give one number, and run once per value.",
        where=f"{quantity.name}={shown(raw)}",
    )


def read_numbers(raw: Sequence[object], quantity: Quantity) -> tuple[float, ...]:
    """Return numbers that were given together for a quantity, in its SI units: all with a unit, or none.

    Raises
    ------
    RequestError
        If one of them cannot be read, or a unit does not fit the quantity.
    """
    return _read_numbers(raw, quantity)


def _has_text(raw: object) -> bool:
    """Return whether what was given is text or a list that holds text: numbers that may have units."""
    return isinstance(raw, str) or (
        isinstance(raw, list | tuple) and any(isinstance(each, str) for each in raw)
    )


def _read_text(text: str, quantity: Quantity) -> Value:
    if ":" in text and "," in text:
        _refuse(text)
    if ":" in text:
        return _read_range(text, quantity)
    if "," in text:
        return Values(_read_numbers(text.removesuffix(",").split(","), quantity))
    return _read_numbers([text], quantity)[0]


def _read_range(text: str, quantity: Quantity) -> Range:
    parts = [part.strip() for part in text.split(":")]
    if len(parts) == 2 and all(map(number_and_unit, parts)):
        raise NoCountError(
            f"A range is start:stop:count, with how many values it has; got {shown(text)}.",
            hint=f"Write {shown(text.strip())}:100, for instance.",
        )
    if len(parts) not in (3, 4):
        _refuse(text)
    start, stop = _read_numbers(parts[:2], quantity)
    return Range(start, stop, _read_count(parts[2]), parts[3] if len(parts) == 4 else "linear")


def _read_array(raw: npt.NDArray[Any], quantity: Quantity) -> Value:
    if raw.ndim == 0:
        return _read_numbers([raw.item()], quantity)[0]
    if raw.ndim > 1:
        raise RequestError(
            f"An axis has one dimension; got an array of shape {raw.shape}.", hint="Flatten it."
        )
    return Values(_read_numbers(raw.tolist(), quantity))


def _read_numbers(raw: Sequence[object], quantity: Quantity) -> tuple[float, ...]:
    pairs = [_read_number(each, quantity) for each in raw]
    # Zero is zero in every unit; any other bare number beside 20deg is more likely degrees than the radians it says.
    if any(unit for _, unit in pairs) and any(number and not unit for number, unit in pairs):
        raise RequestError(
            "Some numbers have a unit and some do not. Each number takes its own unit; a bare one is SI.",
            hint="Write the unit after every number, as in 1deg:20deg:300.",
        )
    return tuple(number for number, _ in pairs)


def _read_number(raw: object, quantity: Quantity) -> tuple[float, str]:
    number, unit = _split(raw.strip()) if isinstance(raw, str) else (_plain(raw), "")
    number = number * factor_to_si(unit, quantity) + 0.0
    if not math.isfinite(number):
        raise RequestError(f"Every number must be finite; got {shown(raw)}.", hint="Give a finite number.")
    return number, unit


def _split(text: str) -> tuple[float, str]:
    if NOT_FINITE.fullmatch(text):
        return math.nan, ""
    found = number_and_unit(text)
    if found is None:
        _refuse(text)
    return float(found[0]), found[1]


def _plain(raw: object) -> float:
    # bool is an int to Python; as a tilt it is a mistake.
    if isinstance(raw, bool | np.bool_) or not isinstance(raw, Real):
        _refuse(raw)
    try:
        return float(raw)
    except OverflowError:
        return math.inf


def _read_count(text: str) -> int:
    if _COUNT.fullmatch(text):
        return int(text)
    raise RequestError(
        f"The count of a range must be a whole number; got {shown(text)}.",
        hint="Write a range as in 0.5:6:400.",
    )


def _refuse(raw: object) -> NoReturn:
    hint = "Write one of these, as in 0.01deg:20deg:300:log."
    if isinstance(raw, str) and any(sign in raw for sign in _MINUS):
        hint = "Write the minus sign as a hyphen, as in -1deg."
    raise RequestError(f"{shown(raw)} is no value. A value is {_VALUE}.", hint=hint)


def number_and_unit(text: str) -> tuple[str, str] | None:
    """Return the texts of the number and of the unit behind it, which may be empty; None if there is no number."""
    match = _NUMBER.fullmatch(text.strip())
    return (match[1], " ".join(match[2].split())) if match else None


def plain_number(text: str) -> float:
    """Return the number that a text spells in ASCII, without a unit; NaN if it spells none."""
    match = _NUMBER.fullmatch(text.strip())
    return float(match[1]) if match and not match[2] else math.nan


def factor_to_si(unit: str, quantity: Quantity) -> float:
    """Return the factor from a number in `unit` to the SI units of a quantity.

    Parameters
    ----------
    unit : str
        Names of `sweep.request.units`, multiplied and divided, with whole powers below 100: ``m s-2`` as in CF,
        ``m/s2``, ``m/s**2``, ``m/(s*s)``, ``m·s⁻²``, ``meter per second``; empty for none.
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
    found, si = read_unit(unit), read_unit("dimensionless" if quantity.units == "1" else quantity.units)
    if unit.startswith("."):
        raise RequestError(
            f"Behind a number comes its unit, not {shown(unit)!r}.",
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
