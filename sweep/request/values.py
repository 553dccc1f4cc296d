"""Parsing and writing values: ``0.5``, ``10deg``, ``0.5,1``, ``0.01deg:20deg:300:log``, ``normal:1deg:0.2deg``.

A value is a number, a list or a range (with both ends). Each number has its own unit or is in SI. A list or a range is
an axis of the grid even if it has only one value; a number is not. Messages show values as given, and limits in the
same unit.
"""

import contextlib
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from numbers import Real
from typing import Any, NamedTuple, NoReturn

import numpy as np
import numpy.typing as npt

from sweep.errors import RequestError, shown
from sweep.model.description import Request
from sweep.model.quantity import Array, Input, Quantity
from sweep.request.sources import KINDS, Distribution, Range, SourceError, Values
from sweep.request.units import factor_to_si, number_and_unit

Value = float | Range | Values
Source = float | Range | Values | Distribution

_VALUE = (
    "a number, a list a,b,c or a range start:stop:count[:log], each number finite and with an optional unit"
)
NOT_FINITE = re.compile(r"[+-]?(inf|infinity|nan)", re.IGNORECASE)
#: Typographic minus signs: the hyphens and dashes of Unicode, and its minus.
_MINUS = "\u2010\u2011\u2012\u2013\u2014\u2212"
_COUNT = re.compile(r"[+-]?\d{1,18}", re.ASCII)

#: A number in a rule with its unit if it is an angle; the text of a rule before an upper limit.
_IN_A_RULE = re.compile(r"(?<![\w.])([0-9][0-9.]*(?:e[+-]?[0-9]+)?)( deg| rad)?(?![\w.])")
_BEFORE_THE_LARGEST = re.compile("<=? *$")


class NoCountError(RequestError):
    """A range without a count."""


def read_value(raw: object, quantity: Quantity) -> Value:
    """Return the number, range or list that was given for a quantity, in its SI units.

    Parameters
    ----------
    raw : str, number, sequence, 1-d array, Range or Values
        Text has the notation of the module docstring; bare numbers are in SI.
    quantity : Quantity
        Determines the allowed units.

    Returns
    -------
    float, Range or Values

    Raises
    ------
    RequestError
        If it is anything else, or a unit does not fit the quantity.
    """
    with _locate_errors(raw, quantity):
        if isinstance(raw, Range | Values):
            return raw
        if isinstance(raw, np.ndarray):
            return _read_array(raw, quantity)
        if isinstance(raw, Sequence) and not isinstance(raw, str | bytes | bytearray):
            return Values(_read_numbers(raw, quantity))
        if not isinstance(raw, str) or not (":" in raw or "," in raw):
            return _read_numbers([raw], quantity)[0]
        if ":" not in raw:
            return Values(_read_numbers(raw.removesuffix(",").split(","), quantity))
        return _read_range(raw, quantity)


def read_number(raw: object, quantity: Quantity) -> float:
    """Return the single number that was given for a quantity, in its SI units; refuse lists and ranges.

    Raises
    ------
    RequestError
        If it is not a single number, or a unit does not fit the quantity.
    """
    # start:stop without a count gets the message below, like any other range
    with contextlib.suppress(NoCountError):
        value = read_value(raw, quantity)
        if isinstance(value, float):
            return value
    raise RequestError(
        f"{quantity.name} must be one number here; it cannot be an axis.",
        hint="Give one number, and use a separate run for each value.",
        where=f"{quantity.name}={shown(raw)}",
    )


def read_distribution(raw: object, quantity: Quantity) -> Distribution | None:
    """Return the distribution that was given for a quantity, in its SI units; None if it is another kind of value.

    Raises
    ------
    RequestError
        If a text begins like a distribution and is not one.
    """
    if not isinstance(raw, str):
        return raw if isinstance(raw, Distribution) else None
    kind, *numbers = (part.strip() for part in raw.split(":"))
    if not numbers or not kind.replace("-", "").isalpha() or NOT_FINITE.fullmatch(kind):
        return None
    with _locate_errors(raw, quantity):
        if kind in KINDS and len(numbers) == 2:
            return Distribution(kind, *_read_numbers(numbers, quantity))
        raise RequestError(
            f"{shown(raw)} is not a distribution. A distribution is {', '.join(KINDS.values())}.",
            hint="Write one of these forms, as in normal:1deg:0.2deg.",
        )


@contextlib.contextmanager
def _locate_errors(raw: object, quantity: Quantity) -> Iterator[None]:
    """Add the word to errors, and show the value as given: a refused range has its ends in SI."""
    try:
        yield
    except SourceError as error:
        texts = raw if isinstance(raw, list | tuple) else [raw]
        said = raw.strip() if isinstance(raw, str) else raw
        found = error.with_given(said) if any(isinstance(each, str) for each in texts) else error
        raise found.at(f"{quantity.name}={shown(raw)}") from None
    except RequestError as error:
        raise error.at(f"{quantity.name}={shown(raw)}") from None


def _read_range(text: str, quantity: Quantity) -> Range:
    parts = [part.strip() for part in text.split(":")]
    if "," in text or len(parts) > 4:
        _refuse(text)
    if len(parts) == 2 and all(map(number_and_unit, parts)):
        raise NoCountError(
            f"A range is start:stop:count with a number of values; got {shown(text)}.",
            hint=f"Write {shown(text.strip())}:100, for instance.",
        )
    if len(parts) == 2:
        _refuse(text)
    start, stop = _read_numbers(parts[:2], quantity)
    if not _COUNT.fullmatch(parts[2]):
        raise RequestError(
            f"The count of a range must be a whole number; got {shown(parts[2])}.",
            hint="Write a range as in 0.5:6:400.",
        )
    return Range(start, stop, int(parts[2]), parts[3] if len(parts) == 4 else "linear")


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
    # Zero is zero in every unit. Any other bare number next to 20deg probably means degrees, not radians.
    if any(unit for _, unit in pairs) and any(number and not unit for number, unit in pairs):
        raise RequestError(
            "Some numbers have a unit and some do not. Each number needs its own unit; a number without one is in SI.",
            hint="Write the unit after every number, as in 1deg:20deg:300.",
        )
    return tuple(number for number, _ in pairs)


def _read_number(raw: object, quantity: Quantity) -> tuple[float, str]:
    number, unit = math.nan, ""
    if isinstance(raw, str):
        found = number_and_unit(raw)
        if found is not None:
            number, unit = float(found[0]) * factor_to_si(found[1], quantity) + 0.0, found[1]
        elif not NOT_FINITE.fullmatch(raw.strip()):
            _refuse(raw.strip())
    # a bool is an int in Python, but as a value it is a mistake
    elif isinstance(raw, bool | np.bool_) or not isinstance(raw, Real):
        _refuse(raw)
    else:
        with contextlib.suppress(OverflowError):
            number = float(raw) + 0.0
    if not math.isfinite(number):
        raise RequestError(f"Every number must be finite; got {shown(raw)}.", hint="Give a finite number.")
    return number, unit


def _refuse(raw: object) -> NoReturn:
    hint = "Write one of these forms, as in 0.01deg:20deg:300:log."
    if isinstance(raw, str) and any(sign in raw for sign in _MINUS):
        hint = "Write the minus sign as a hyphen, as in -1deg."
    raise RequestError(f"{shown(raw)} is not a value. A value is {_VALUE}.", hint=hint)


# -- allowed values


def allowed[Given: (float, Value, Source)](value: Given, quantity: Input, raw: object) -> Given:
    """Return a value if its quantity's rule allows it; for a normal distribution the rule must allow the mean.

    Raises
    ------
    RequestError
        If the rule does not allow the value; the message shows `raw`, the value as given.
    """
    if (outside := not_allowed(value, quantity, raw)) is None:
        return value
    text, rule = outside
    raise RequestError(
        f"{text} is not allowed: {rule}.",
        hint=degrees_meant(quantity, quantity.name, raw, _required_values(value))
        or f"Choose values with {rule}.",
        where=f"{quantity.name}={shown(raw)}",
    )


def not_allowed(value: Source, quantity: Input, raw: object) -> tuple[str, str] | None:
    """Return the first number that the quantity's rule does not allow, and the rule, both in the unit of `raw`."""
    required = _required_values(value)
    if quantity.allows(required).all():
        return None
    outside = as_given(float(required[~quantity.allows(required)][0]), quantity, raw)
    return outside.text, rule_in(quantity, outside.unit)


def _required_values(value: Source) -> Array:
    return np.array([value]) if isinstance(value, float) else value.required()


def degrees_meant(quantity: Input, word: str, raw: object, ends: Array) -> str:
    """Return the hint that a bare number is in radians if it would be allowed in degrees; otherwise empty text.

    `word` and `raw` are the given word and value. If the word is a substitute for the angle, there is no hint.
    """
    if word != quantity.name or not quantity.allows(np.radians(ends)).all():
        return ""
    if quantity.units != "rad" or any(unit for _, unit in _numbers_in(raw)):
        return ""
    example = "1deg:5deg:200"
    if isinstance(raw, str | int | float) and str(raw).count(":") < 2:
        example = f"{quantity.name}={re.sub('[^,:]+', lambda each: f'{each[0].strip()}deg', str(raw))}"
    return f"A bare number is in radians; for degrees write the unit, as in {example}."


# -- values as given


class Wording(NamedTuple):
    """A value as a request gave it: the text with its unit, and only the unit; a bare number has an empty unit."""

    text: str
    unit: str


def as_given(value: float, quantity: Quantity, raw: object) -> Wording:
    """Return a value in the wording of a request.

    Parameters
    ----------
    value : float
        The value, in SI.
    quantity : Quantity
        The quantity of the value.
    raw : object
        The value as given: text with numbers and units, or anything else in SI.

    Returns
    -------
    Wording
        The number as it is written in the text. If the text does not contain it, as for the tilt of an inclination,
        the value is converted to the first unit in the text.
    """
    found = [(text, unit) for text, unit in _numbers_in(raw) if _fits(unit, quantity)]
    for text, unit in found:
        if (unit or float(text)) and float(text) * factor_to_si(unit, quantity) == value:
            return Wording(f"{text} {unit or _si_unit(quantity)}".rstrip(), unit)
    unit = next((unit for _, unit in found if unit), "")
    # zero is zero in every unit: use the unit of the rule
    if found and not any(unit or float(text) for text, unit in found):
        unit = "deg" if " deg" in getattr(quantity, "rule", "") else ""
    return Wording(in_unit(value, quantity, unit), unit)


def in_unit(value: float, quantity: Quantity, unit: str, digits: int = 10, space: str = " ") -> str:
    """Return a value [SI] as text in a unit that fits its quantity; in SI if the unit is empty."""
    return f"{value / factor_to_si(unit, quantity):.{digits}g}{space}{unit or _si_unit(quantity)}".rstrip()


def limit_in(value: float, quantity: Quantity, unit: str, *, upper: bool) -> str:
    """Return a limit [SI] in a unit, like `in_unit`, rounded toward the allowed values."""
    # 14 digits: further ones are rounding errors of the division
    exact = Decimal(f"{value / factor_to_si(unit, quantity):.14g}")
    rounded = Context(prec=10, rounding=ROUND_FLOOR if upper else ROUND_CEILING).plus(exact)
    return f"{float(rounded):.10g} {unit or _si_unit(quantity)}".rstrip()


def rule_in(quantity: Input, unit: str) -> str:
    """Return the rule of a quantity with its limits in a unit that fits it; in SI if the unit is empty."""

    def converted(found: re.Match[str]) -> str:
        number = math.radians(float(found[1])) if found[2] == " deg" else float(found[1])
        upper = _BEFORE_THE_LARGEST.search(quantity.rule[: found.start()]) is not None
        return limit_in(number, quantity, unit, upper=upper) if number or found[2] else "0"

    return _IN_A_RULE.sub(converted, quantity.rule)


def words_given(
    quantities: Sequence[Quantity], words: Mapping[str, Any], values: Mapping[str, float | str]
) -> str:
    """Return words of a request as given, in the form ``NAME=VALUE``.

    Parameters
    ----------
    quantities : sequence of Quantity
        The quantities of the words; all have the same SI unit.
    words : mapping of str to anything
        The words of the request, as given.
    values : mapping of str to number or word
        The values in SI. Words that were not given as text are shown in the first unit given, or in SI without one.
    """
    units = [as_given(math.nan, each, words[each.name]).unit for each in quantities if each.name in words]
    unit = next(filter(None, units), "")

    def text(each: Quantity) -> str:
        raw, value = words.get(each.name), values[each.name]
        if isinstance(raw, str) or isinstance(value, str):
            return shown(raw).strip() if isinstance(raw, str) else str(value)
        return in_unit(value, each, unit if units else each.shown_units, space="")

    return " ".join(f"{each.name}={text(each)}" for each in quantities)


def at_word(error: RequestError, words: Mapping[str, Any], values: Mapping[str, Any]) -> RequestError:
    """Return the error of a check, which shows values in SI, with the values that had a unit shown as given."""
    message, where = error.message, error.where
    for name, raw in words.items():
        # no check mentions substitutes
        if name in values and has_unit(raw):
            given = f"{name}={shown(raw)}"
            message = message.replace(f" {name}={values[name]}", f" {given}")
            where = given if where == name else where
    return type(error)(message, error.hint, where)


def as_written(value: object, quantity: Quantity) -> str:
    """Return a value of a spec as a person would write it: angles in degrees instead of SI."""
    unit = "deg" if quantity.units == "rad" else ""

    def one(number: float) -> str:
        return f"{number * quantity.plot_scale:.10g}{unit}"

    if isinstance(value, float):
        return one(value)
    if isinstance(value, Range):
        return f"{one(value.start)}:{one(value.stop)}:{value.count}" + ":log" * (value.spacing == "log")
    return ",".join(map(one, value.values)) if isinstance(value, Values) else str(value)


def both_written(specs: tuple[Request, Request], name: str) -> tuple[str, str]:
    """Return a word of two specs as people write it; with all digits in SI if these texts would be equal."""
    values = [spec.model.name if name == "model" else getattr(spec, name) for spec in specs]
    quantities = [{**spec.quantities, **spec.model.settings}.get(name) for spec in specs]
    exact = [",".join(value) if isinstance(value, tuple) else str(value) for value in values]
    written = [
        text if quantity is None else as_written(value, quantity)
        for value, quantity, text in zip(values, quantities, exact, strict=True)
    ]
    first, second = map(shown, exact if written[0] == written[1] else written)
    return first, second


def has_unit(raw: object) -> bool:
    """Return whether any number in a given value has a unit."""
    return any(unit for _, unit in _numbers_in(raw))


def _numbers_in(raw: object) -> Iterator[tuple[str, str]]:
    """Yield the texts of each number in a given value and of its unit."""
    texts = map(str, raw) if isinstance(raw, list | tuple) else [str(raw)]
    for part in (part for text in texts for part in re.split("[:,]", text)):
        if found := number_and_unit(part):
            yield found


def _fits(unit: str, quantity: Quantity) -> bool:
    with contextlib.suppress(RequestError):
        return factor_to_si(unit, quantity) > 0.0
    return False


def _si_unit(quantity: Quantity) -> str:
    return "" if quantity.units == "1" else quantity.units
