"""From words to values: ``0.5``, ``10deg``, ``0.5,1``, ``0.01deg:20deg:300:log``.

A value is a number, a list or a range (both ends included), each number with a unit of its own or bare in SI. A
list or a range is an axis of the grid even if it holds one value; a number is not.
"""

import math
import re
from collections.abc import Sequence
from numbers import Real
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt

from sweep.errors import RequestError, shown
from sweep.request.axes import Range, Values
from sweep.request.units import factor_to_si
from sweep.schema import Quantity

__all__ = ["Range", "Value", "Values", "read_number", "read_value"]

Value = float | Range | Values

_VALUE = (
    "a number, a list a,b,c or a range start:stop:count[:log], each number finite and with an optional unit"
)
_NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*)", re.ASCII | re.DOTALL)
_NOT_FINITE = re.compile(r"[+-]?(inf|infinity|nan)", re.IGNORECASE)
#: Signs that printed pages have for minus: the hyphens and dashes of Unicode, and its minus.
_MINUS = "\u2010\u2011\u2012\u2013\u2014\u2212"
_COUNT = re.compile(r"[+-]?\d{1,18}", re.ASCII)


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
    except RequestError as error:
        raise error.at(quantity.name, f"{quantity.name}={shown(raw)}") from None


def read_number(raw: object, quantity: Quantity) -> float:
    """Return the one number that was given for a quantity, in its SI units; a list or a range is refused.

    Raises
    ------
    RequestError
        If it is not a single number, or a unit does not fit the quantity.
    """
    value = read_value(raw, quantity)
    if isinstance(value, float):
        return value
    raise RequestError(
        "this cannot be an axis",
        f"{quantity.name} is one number for all cells",
        f"{quantity.name}={shown(raw)}",
        "give one number, and run once per value",
        quantity.name,
    )


def _read_text(text: str, quantity: Quantity) -> Value:
    if ":" in text and "," in text:
        _junk(text)
    if ":" in text:
        return _read_range(text, quantity)
    if "," in text:
        return Values(_read_numbers(text.removesuffix(",").split(","), quantity))
    return _read_numbers([text], quantity)[0]


def _read_range(text: str, quantity: Quantity) -> Range:
    parts = [part.strip() for part in text.split(":")]
    if len(parts) not in (3, 4):
        _junk(text)
    start, stop = _read_numbers(parts[:2], quantity)
    return Range(start, stop, _read_count(parts[2]), parts[3] if len(parts) == 4 else "linear")


def _read_array(raw: npt.NDArray[Any], quantity: Quantity) -> Value:
    if raw.ndim == 0:
        return _read_numbers([raw.item()], quantity)[0]
    if raw.ndim > 1:
        raise RequestError(
            "not a list of values", "an axis has one dimension", f"shape {raw.shape}", "flatten it"
        )
    return Values(_read_numbers(raw.tolist(), quantity))


def _read_numbers(raw: Sequence[object], quantity: Quantity) -> tuple[float, ...]:
    pairs = [_read_number(each, quantity) for each in raw]
    # Zero is zero in every unit; any other bare number beside 20deg is more likely degrees than the radians it says.
    if any(unit for _, unit in pairs) and any(number and not unit for number, unit in pairs):
        raise RequestError(
            "some numbers have a unit and some do not",
            "each number takes its own unit; a bare one is SI",
            "a mixture",
            "write the unit after every number, as in 1deg:20deg:300",
        )
    return tuple(number for number, _ in pairs)


def _read_number(raw: object, quantity: Quantity) -> tuple[float, str]:
    number, unit = _split(raw.strip()) if isinstance(raw, str) else (_plain(raw), "")
    number = number * factor_to_si(unit, quantity) + 0.0
    if not math.isfinite(number):
        raise RequestError(
            "not a finite number", "every number is finite", shown(raw), "give a finite number"
        )
    return number, unit


def _split(text: str) -> tuple[float, str]:
    if _NOT_FINITE.fullmatch(text):
        return math.nan, ""
    match = _NUMBER.fullmatch(text)
    if match is None:
        _junk(text)
    return float(match[1]), " ".join(match[2].split())


def _plain(raw: object) -> float:
    # bool is an int to Python; as a tilt it is a mistake.
    if isinstance(raw, bool | np.bool_) or not isinstance(raw, Real):
        _junk(raw)
    try:
        return float(raw)
    except OverflowError:
        return math.inf


def _read_count(text: str) -> int:
    if _COUNT.fullmatch(text):
        return int(text)
    raise RequestError(
        "not a count", "the count of a range is a whole number", text, "write a range as in 0.5:6:400"
    )


def _junk(raw: object) -> NoReturn:
    do = "write one of these, as in 0.01deg:20deg:300:log"
    if isinstance(raw, str) and any(sign in raw for sign in _MINUS):
        do = "write the minus sign as a hyphen, as in -1deg"
    raise RequestError("not a value", f"a value is {_VALUE}", shown(raw), do)
