"""How a message says a value of a request: as it was given, beside what is allowed in the same unit."""

import contextlib
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from typing import Any, NamedTuple

from sweep.errors import RequestError, shown
from sweep.model.quantity import Input, Quantity
from sweep.request.values import factor_to_si, number_and_unit

#: A number of a rule, and the unit of an angle after it.
_IN_A_RULE = re.compile(r"(?<![\w.])([0-9][0-9.]*(?:e[+-]?[0-9]+)?)( deg| rad)?(?![\w.])")


#: What stands before the largest value that a rule allows.
_BEFORE_THE_LARGEST = re.compile("<=? *$")


class Wording(NamedTuple):
    """A value as a request gave it: its text, with its unit, and the unit alone; that is empty for a bare number."""

    text: str
    unit: str


def as_given(value: float, quantity: Quantity, raw: object) -> Wording:
    """Return how a request gave one of its values.

    Parameters
    ----------
    value : float
        In SI.
    quantity : Quantity
        What it is a value of.
    raw : object
        What was given: text with numbers and units, or anything without text, which is in SI.

    Returns
    -------
    Wording
        The number as it stands in the text. One that stands there nowhere, such as the tilt of an inclination, is in
        the first unit of the text.
    """
    found = [(text, unit) for text, unit in numbers_in(raw) if _factor(unit, quantity) is not None]
    for text, unit in found:
        if (unit or float(text)) and float(text) * (_factor(unit, quantity) or 1.0) == value:
            return Wording(f"{text} {unit or _si(quantity)}".rstrip(), unit)
    unit = next((unit for _, unit in found if unit), "")
    # zero is zero in every unit: then that of its rule
    if found and not any(unit or float(text) for text, unit in found):
        unit = "deg" if " deg" in getattr(quantity, "rule", "") else ""
    return Wording(in_unit(value, quantity, unit), unit)


def in_unit(value: float, quantity: Quantity, unit: str, digits: int = 10) -> str:
    """Return a value [SI] in a unit that fits its quantity; in SI if that is empty."""
    return f"{value / (_factor(unit, quantity) or 1.0):.{digits}g} {unit or _si(quantity)}".rstrip()


def limit_in(value: float, quantity: Quantity, unit: str, *, upper: bool) -> str:
    """Return a limit [SI] in a unit as `in_unit` does, rounded to the side of what is allowed."""
    # 14 digits: the last ones are those of the division
    exact = Decimal(f"{value / (_factor(unit, quantity) or 1.0):.14g}")
    rounded = Context(prec=10, rounding=ROUND_FLOOR if upper else ROUND_CEILING).plus(exact)
    return f"{float(rounded):.10g} {unit or _si(quantity)}".rstrip()


def rule_in(quantity: Input, unit: str) -> str:
    """Return the rule of a quantity with its limits in a unit that fits it; in SI if that is empty."""

    def converted(found: re.Match[str]) -> str:
        number = math.radians(float(found[1])) if found[2] == " deg" else float(found[1])
        upper = _BEFORE_THE_LARGEST.search(quantity.rule[: found.start()]) is not None
        return limit_in(number, quantity, unit, upper=upper) if number or found[2] else "0"

    return _IN_A_RULE.sub(converted, quantity.rule)


def words_given(
    quantities: Sequence[Quantity], words: Mapping[str, Any], values: Mapping[str, float | str]
) -> str:
    """Return words of a request as they were given, with ``NAME=VALUE`` for each.

    Parameters
    ----------
    quantities : sequence of Quantity
        What the words give; all have one SI unit.
    words : mapping of str to anything
        The words of the request, as given.
    values : mapping of str to number or word
        In SI. A word that was not given, or given as a number without text, has its value in the first unit given;
        in SI if none was.
    """
    units = [as_given(math.nan, each, words[each.name]).unit for each in quantities if each.name in words]
    unit = next(filter(None, units), "")

    def text(each: Quantity) -> str:
        raw, value = words.get(each.name), values[each.name]
        if isinstance(raw, str):
            return shown(raw).strip()
        if isinstance(value, str):
            return value
        return (in_unit(value, each, unit) if units else each.spell(value)).replace(" ", "", 1)

    return " ".join(f"{each.name}={text(each)}" for each in quantities)


def at_word(error: RequestError, words: Mapping[str, Any], values: Mapping[str, Any]) -> RequestError:
    """Return the error of a check that knows values in SI alone, with the words that a request gave with a unit."""
    message, where = error.message, error.where
    for name, raw in words.items():
        # what stands for a parameter is in no check
        if name in values and any(unit for _, unit in numbers_in(raw)):
            given = f"{name}={shown(raw)}"
            message = message.replace(f" {name}={values[name]}", f" {given}")
            where = given if where == name else where
    return type(error)(message, error.hint, where)


def numbers_in(raw: object) -> Iterator[tuple[str, str]]:
    """Yield the text of every number in what was given, and that of its unit."""
    texts = map(str, raw) if isinstance(raw, list | tuple) else [str(raw)]
    for part in (part for text in texts for part in re.split("[:,]", text)):
        if found := number_and_unit(part):
            yield found


def _factor(unit: str, quantity: Quantity) -> float | None:
    with contextlib.suppress(RequestError):
        return factor_to_si(unit, quantity)
    return None


def _si(quantity: Quantity) -> str:
    return "" if quantity.units == "1" else quantity.units
