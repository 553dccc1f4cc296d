"""Substitutes for parameters: rates in units of sqrt(gravity/radius), a speed, an angle from flat.

Substitutes are converted to their parameters before anything else is read: specs, fingerprints and files contain only
parameters, in SI.
"""

import itertools
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from types import MappingProxyType
from typing import Any

import numpy as np

from sweep.errors import RequestError, are, shown
from sweep.model.description import Model
from sweep.model.quantity import Input, Quantity, Substitute
from sweep.request.sources import NORMAL, UNIFORM, Distribution, Range, Values
from sweep.request.start_list import WORDS
from sweep.request.start_table import Column, GivenTable, StartTable, table_for
from sweep.request.values import (
    Source,
    Value,
    allowed,
    has_unit,
    not_allowed,
    read_distribution,
    read_value,
)
from sweep.request.words import read_input

#: Largest length of a word whose given text is kept.
_LONGEST = 100

_NOTHING: Mapping[str, object] = MappingProxyType({})

#: Largest number of values of a list that replaces a logarithmic range.
_MOST_LISTED = 10_000


def parameter_of(name: str, model: Model) -> str:
    """Return the parameter that a word gives: a substitute's parameter, or the word itself."""
    return model.substitutes[name].parameter if name in model.substitutes else name


def _is_substitute(name: str, raw: object, model: Model) -> bool:
    """Return whether a word gives a substitute; if it has the same name as its parameter, the value has a unit."""
    return name in model.substitutes and (name not in model.parameters or has_unit(raw))


def requested_in(words: Mapping[str, Any], model: Model) -> dict[str, str]:
    """Return the given text of words that a spec stores otherwise: substitutes and values with a unit.

    Long texts become ``...``.
    """
    quantities, found = {**model.parameters, **model.settings}, {}
    for name, raw in words.items():
        text = ",".join(map(str, raw)) if isinstance(raw, list | tuple) else str(raw)
        is_short = len(text) <= _LONGEST and text.isprintable()
        if _is_substitute(name, raw, model) or (name in quantities and is_short and has_unit(text)):
            found[name] = text if is_short else "..."
    return found


def changed(held: Mapping[str, Any], changes: Mapping[str, Any], model: Model) -> dict[str, Any]:
    """Return words with changes; changed words keep their places, new ones follow in the order given.

    A parameter replaces its substitutes, and the reverse. A table of starts replaces the parameters of its columns and
    the words of another list.

    Raises
    ------
    RequestError
        If the changes give a parameter twice.
    """
    check_once(changes, model)
    change_of = {parameter_of(name, model): name for name in changes}
    table = changes.get("starts")
    gone = (*table.names, *WORDS) if isinstance(table, StartTable | GivenTable) else ()
    found: dict[str, Any] = {}
    for name, value in held.items():
        parameter = parameter_of(name, model)
        if parameter in change_of:
            found[change_of[parameter]] = changes[change_of[parameter]]
        elif parameter not in gone:
            found[name] = value
    return {**found, **changes}


def resolved(
    words: Mapping[str, Any],
    model: Model,
    fixed: Mapping[str, object] = _NOTHING,
    read: Callable[[object, Quantity], Value] = read_value,
) -> dict[str, Any]:
    """Return words with every substitute converted to its parameter, in SI and in the same place.

    The conversion of a range keeps the count and the spacing. If the parameter is not proportional to its substitute, a
    logarithmic range becomes a list.

    Parameters
    ----------
    words : mapping of str to anything
        Words of a request with their values, as given.
    model : Model
    fixed : mapping of str to anything, optional
        Values in SI of parameters that are not in `words`, instead of the defaults of the model.
    read : callable, optional
        The reader of a word's value; `sweep.request.values.read_number` refuses lists and ranges.

    Raises
    ------
    RequestError
        If a parameter is given twice, a value cannot be read, or a substitute needs a parameter that varies.
    """
    check_once(words, model)
    given = {name: model.substitutes[name] for name, raw in words.items() if _is_substitute(name, raw, model)}
    sources = {
        name: read_distribution(words[name], each) or read(words[name], each) for name, each in given.items()
    }
    # a substitute may need the parameter of another one: a scaled rate needs the radius that a diameter gives
    direct = {
        each.parameter: _convert_substitute(each, sources[name], {}, words[name], model)
        for name, each in given.items()
        if not each.needs
    }
    known = {**{name: row.default for name, row in model.parameters.items()}, **fixed, **words, **direct}
    words = table_for(words, model)
    if isinstance(table := words.get("starts"), StartTable):
        known |= {name: Column(name, table) for name in table.names}
        _check_no_column(given, words, table)
    needed = {
        name: _ends(model.parameters[name], known[name], read if name in words else read_value)
        for each in given.values()
        for name in each.needs
    }
    if varying := [name for name, (low, high) in needed.items() if low != high]:
        concerned = {name: each for name, each in given.items() if not set(varying).isdisjoint(each.needs)}
        parameters = " and ".join(each.parameter for each in concerned.values())
        units = " and ".join(
            dict.fromkeys(model.parameters[each.parameter].units for each in concerned.values())
        )
        instead = [
            f"{each.parameter}={_value_for_all_disks(each, sources[name], needed, words)}"
            for name, each in concerned.items()
        ]
        raise RequestError(
            f"{' and '.join(concerned)} {are(len(concerned), 'gives', 'give')} a different {parameters} for each "
            f"{varying[0]}, and {varying[0]} varies here.",
            hint=f"Give {are(len(concerned), 'it', 'them')} in {units}, for example {' '.join(instead)}.",
            where=varying[0],
        )
    disk = {name: low for name, (low, _) in needed.items()}
    return {
        parameter_of(name, model): _convert_substitute(given[name], sources[name], disk, raw, model)
        if name in given
        else raw
        for name, raw in words.items()
    }


def check_once(words: Mapping[str, Any], model: Model) -> None:
    """Refuse words if two of them give the same parameter.

    Raises
    ------
    RequestError
    """
    seen: dict[str, str] = {}
    for name, value in words.items():
        parameter = parameter_of(name, model)
        if parameter in seen:
            first = seen[parameter]
            raise RequestError(
                f"{parameter} is given twice, by {first} and {name}; got {first}={shown(words[first])} and "
                f"{name}={shown(value)}.",
                hint="Leave one of them out.",
                where=name,
            )
        seen[parameter] = name


def _check_no_column(given: Mapping[str, Substitute], words: Mapping[str, Any], table: StartTable) -> None:
    """Refuse a substitute if a table of starts has a column for its parameter."""
    for name, each in given.items():
        if each.parameter in table.names:
            raise RequestError(
                f"{each.parameter} is given twice, by {name} and by a column of the table; got "
                f"{name}={shown(str(words[name]))} and {table}.",
                hint=f"Leave {name} out, or remove the column from the table.",
                where=name,
            )


def _ends(quantity: Input, raw: object, read: Callable[[object, Quantity], Value]) -> tuple[float, float]:
    """Return the smallest and the largest value given for a parameter; for a normal distribution approximate ones."""
    held = raw if isinstance(raw, Column) else read_distribution(raw, quantity)
    source = held or read_input(quantity, raw, read)
    low, high = [float(source)] * 2 if isinstance(source, float | str) else source.ends().tolist()
    return low, high


def _value_for_all_disks(
    substitute: Substitute,
    value: Source,
    needed: Mapping[str, tuple[float, float]],
    words: Mapping[str, Any],
) -> str:
    """Return a value of the parameter for all disks: a range or a distribution, or a number between the extremes."""
    disks = (
        dict(zip(substitute.needs, each, strict=True))
        for each in itertools.product(*(needed[name] for name in substitute.needs))
    )
    ends = [value] if isinstance(value, float) else value.ends().tolist()
    numbers = [_convert_number(substitute, end, disk) for disk in disks for end in ends]
    low, high = min(numbers), max(numbers)
    if isinstance(value, Range) and not (words.get("samples") or isinstance(words.get("starts"), StartTable)):
        return f"{low:.4g}:{high:.4g}:{value.count}" + (":log" if value.spacing == "log" else "")
    if words.get("samples") and not isinstance(value, float):
        return f"uniform:{low:.4g}:{high:.4g}"
    return f"{math.copysign(math.sqrt(abs(low * high)), low):.4g}"


def _convert_substitute(
    substitute: Substitute, value: Source, disk: Mapping[str, float], raw: object, model: Model
) -> Source:
    """Return the parameter's value for a value of its substitute; `raw` is the value as given."""
    parameter = model.parameters[substitute.parameter]
    try:
        found = _convert_value(substitute, value, disk)
        if not substitute.offset:
            return allowed(found, parameter, raw)
    except RequestError as error:
        raise error.at(f"{substitute.name}={shown(raw)}") from None
    if (outside := not_allowed(found, parameter, raw)) is None:
        return found
    # show the parameter in the unit of the substitute
    text, rule = outside
    raise RequestError(
        f"This gives a {parameter.name} of {text}, which is not allowed: {rule}.",
        hint=f"Choose values with {rule}; a bare number is in {substitute.units}.",
        where=f"{substitute.name}={shown(raw)}",
    )


def _convert_number(substitute: Substitute, number: float, disk: Mapping[str, float]) -> float:
    # the scale may underflow or overflow: values that are not finite are refused later
    with np.errstate(all="ignore"):
        return float(np.divide(number, substitute.scale(disk))) + substitute.offset + 0.0


def _convert_value(substitute: Substitute, value: Source, disk: Mapping[str, float]) -> Source:
    one = partial(_convert_number, substitute, disk=disk)
    if isinstance(value, float):
        return one(value)
    if isinstance(value, Distribution):
        first, second = one(value.first), one(value.second)
        if value.kind == NORMAL:
            return Distribution(NORMAL, first, abs(second - substitute.offset))
        if value.kind == UNIFORM or not substitute.offset:
            return Distribution(value.kind, *sorted((first, second)))
        raise RequestError(
            f"{substitute.parameter} is not proportional to {substitute.name}, so {substitute.name} cannot have a "
            f"{value.kind} distribution.",
            hint=f"Use a uniform distribution, or give {substitute.parameter}.",
        )
    if isinstance(value, Values) or (value.spacing == "log" and substitute.offset):
        if isinstance(value, Range) and len(value) > _MOST_LISTED:
            raise RequestError(
                f"A logarithmic range of {substitute.name} becomes a list of {substitute.parameter}, which has at most "
                f"{_MOST_LISTED} values; got {len(value)}.",
                hint="Give a smaller count, or leave out :log.",
            )
        return Values(tuple(sorted(map(one, value.array().tolist()))))
    start, stop = sorted((one(value.start), one(value.stop)))
    return replace(value, start=start, stop=stop)
