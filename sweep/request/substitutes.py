"""Substitutes of parameters: rates in units of sqrt(gravity/radius), a speed, an angle from flat.

A request that gives a substitute becomes one that gives the parameter, before anything else is read: specs,
fingerprints and files know parameters only, in SI.
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

#: Characters of a word that are kept as they were given.
_LONGEST = 100

_NOTHING: Mapping[str, object] = MappingProxyType({})

#: Values of a list that stands for a logarithmic range at most.
_MOST_LISTED = 10_000


def parameter_of(name: str, model: Model) -> str:
    """Return the parameter that a word gives: that of a substitute, for any other word its own name."""
    return model.substitutes[name].parameter if name in model.substitutes else name


def _is_substitute(name: str, raw: object, model: Model) -> bool:
    """Whether a word gives a substitute: one that is called like its parameter is told by a unit."""
    return name in model.substitutes and (name not in model.parameters or has_unit(raw))


def substitutes_in(words: Mapping[str, Any], model: Model) -> dict[str, str]:
    """Return the words that stand for a parameter, as they were given; of many values only that there are some."""
    found = {name: raw for name, raw in words.items() if _is_substitute(name, raw, model)}
    texts = {
        name: ",".join(map(str, raw)) if isinstance(raw, list | tuple) else str(raw)
        for name, raw in found.items()
    }
    return {
        name: text if len(text) <= _LONGEST and text.isprintable() else "..." for name, text in texts.items()
    }


def changed(held: Mapping[str, Any], changes: Mapping[str, Any], model: Model) -> dict[str, Any]:
    """Return words with changes; a word that is changed keeps its place, new ones follow in the order given.

    A change of a parameter replaces its substitutes, and the reverse; a table of starts replaces what it has columns
    for, and the words of another list.

    Raises
    ------
    RequestError
        If the changes give a parameter in two ways.
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
    """Return words in which every substitute has become its parameter, in SI and in its place.

    The ends of a range become the ends of a range with as many values, spaced alike. Where the parameter is not a
    multiple of its substitute, a logarithmic range becomes a list.

    Parameters
    ----------
    words : mapping of str to anything
        Words of a request with their values, as given.
    model : Model
    fixed : mapping of str to anything, optional
        Values of parameters that `words` do not give, in SI, instead of the defaults of the model.
    read : callable, optional
        What reads a word; `sweep.request.values.read_number` where a list or a range is refused.

    Raises
    ------
    RequestError
        If a parameter is given in two ways, a value cannot be read, or a parameter varies that a substitute needs.
    """
    check_once(words, model)
    given = {name: model.substitutes[name] for name, raw in words.items() if _is_substitute(name, raw, model)}
    sources = {
        name: read_distribution(words[name], each) or read(words[name], each) for name, each in given.items()
    }
    # a substitute may need what another one gives, as a scaled rate needs the radius of a diameter
    direct = {
        each.parameter: _parameter(each, sources[name], {}, words[name], model)
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
            f"{each.parameter}={_for_all(each, sources[name], needed, words)}"
            for name, each in concerned.items()
        ]
        raise RequestError(
            f"{' and '.join(concerned)} {are(len(concerned), 'gives', 'give')} another {parameters} for each "
            f"{varying[0]}, and here {varying[0]} varies.",
            hint=f"Give {are(len(concerned), 'it', 'them')} in {units}, for example {' '.join(instead)}.",
            where=varying[0],
        )
    disk = {name: low for name, (low, _) in needed.items()}
    return {
        parameter_of(name, model): _parameter(given[name], sources[name], disk, raw, model)
        if name in given
        else raw
        for name, raw in words.items()
    }


def check_once(words: Mapping[str, Any], model: Model) -> None:
    """Refuse words of which two give the same parameter.

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
                f"{parameter} is given once: {first} and {name} both give it; got {first}={shown(words[first])} and "
                f"{name}={shown(value)}.",
                hint="Leave one of them out.",
                where=name,
            )
        seen[parameter] = name


def _check_no_column(given: Mapping[str, Substitute], words: Mapping[str, Any], table: StartTable) -> None:
    """Refuse a substitute of a parameter for which a table of starts has a column."""
    for name, each in given.items():
        if each.parameter in table.names:
            raise RequestError(
                f"{each.parameter} is given once: {name} and a column of the table both give it; got "
                f"{name}={shown(str(words[name]))} and {table}.",
                hint=f"Leave {name} out, or take the column out of the table.",
                where=name,
            )


def _ends(quantity: Input, raw: object, read: Callable[[object, Quantity], Value]) -> tuple[float, float]:
    """Return the smallest and the largest value of what was given for a parameter, of some distributions about."""
    held = raw if isinstance(raw, Column) else read_distribution(raw, quantity)
    source = held or read_input(quantity, raw, read)
    low, high = [float(source)] * 2 if isinstance(source, float | str) else source.ends().tolist()
    return low, high


def _for_all(
    substitute: Substitute,
    value: Source,
    needed: Mapping[str, tuple[float, float]],
    words: Mapping[str, Any],
) -> str:
    """Return what gives the parameter for all disks: a range or a distribution over theirs, or a number amid them."""
    disks = (
        dict(zip(substitute.needs, each, strict=True))
        for each in itertools.product(*(needed[name] for name in substitute.needs))
    )
    ends = [value] if isinstance(value, float) else value.ends().tolist()
    numbers = [_one(substitute, end, disk) for disk in disks for end in ends]
    low, high = min(numbers), max(numbers)
    if isinstance(value, Range) and not (words.get("samples") or isinstance(words.get("starts"), StartTable)):
        return f"{low:.4g}:{high:.4g}:{value.count}" + (":log" if value.spacing == "log" else "")
    if words.get("samples") and not isinstance(value, float):
        return f"uniform:{low:.4g}:{high:.4g}"
    return f"{math.copysign(math.sqrt(abs(low * high)), low):.4g}"


def _parameter(
    substitute: Substitute, value: Source, disk: Mapping[str, float], raw: object, model: Model
) -> Source:
    """Return the value of the parameter that a value of a substitute stands for; `raw` is what was given."""
    parameter = model.parameters[substitute.parameter]
    try:
        found = _converted(substitute, value, disk)
        if not substitute.offset:
            return allowed(found, parameter, raw)
    except RequestError as error:
        raise error.at(f"{substitute.name}={shown(raw)}") from None
    if (outside := not_allowed(found, parameter, raw)) is None:
        return found
    # the parameter is in the unit of the substitute
    text, rule = outside
    raise RequestError(
        f"That is a {parameter.name} of {text}, which is not possible: {rule}.",
        hint=f"Choose values with {rule}; a bare number is in {substitute.units}.",
        where=f"{substitute.name}={shown(raw)}",
    )


def _one(substitute: Substitute, number: float, disk: Mapping[str, float]) -> float:
    # a scale may be too small or too large for a float: what is not finite is refused as a value
    with np.errstate(all="ignore"):
        return float(np.divide(number, substitute.scale(disk))) + substitute.offset + 0.0


def _converted(substitute: Substitute, value: Source, disk: Mapping[str, float]) -> Source:
    one = partial(_one, substitute, disk=disk)
    if isinstance(value, float):
        return one(value)
    if isinstance(value, Distribution):
        first, second = one(value.first), one(value.second)
        if value.kind == NORMAL:
            return Distribution(NORMAL, first, abs(second - substitute.offset))
        if value.kind == UNIFORM or not substitute.offset:
            return Distribution(value.kind, *sorted((first, second)))
        raise RequestError(
            f"{substitute.parameter} is no multiple of {substitute.name}: {value.kind} makes no distribution of it.",
            hint=f"Write uniform, or give {substitute.parameter}.",
        )
    if isinstance(value, Values) or (value.spacing == "log" and substitute.offset):
        if isinstance(value, Range) and len(value) > _MOST_LISTED:
            raise RequestError(
                f"A logarithmic range of {substitute.name} becomes a list of {substitute.parameter}, of at most "
                f"{_MOST_LISTED} values; got {len(value)}.",
                hint="Give a smaller count, or leave out :log.",
            )
        return Values(tuple(sorted(map(one, value.array().tolist()))))
    start, stop = sorted((one(value.start), one(value.stop)))
    return replace(value, start=start, stop=stop)
