"""What may be given instead of a parameter: rates in units of sqrt(gravity/radius), a speed, an angle from flat.

A request that gives a substitute becomes one that gives the parameter, before anything else is read: specs,
fingerprints and files know parameters only, in SI.
"""

import itertools
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, NoReturn

import numpy as np

from sweep.errors import RequestError, shown
from sweep.model.description import Model
from sweep.model.quantity import Input, Quantity, Substitute
from sweep.request.as_given import as_given, rule_in
from sweep.request.axes import Range, Values
from sweep.request.distributions import (
    Distribution,
    is_distribution,
    parse_distribution,
    read_distribution,
)
from sweep.request.start_table import Column, StartTable
from sweep.request.values import Value, read_value
from sweep.request.words import allowed, read_input

_NOTHING: Mapping[str, object] = MappingProxyType({})

#: Values of a list that stands for a logarithmic range at most.
_MOST_LISTED = 10_000


def parameter_of(name: str, model: Model) -> str:
    """Return the parameter that a word gives: that of a substitute, for any other word its own name."""
    return model.substitutes[name].parameter if name in model.substitutes else name


def changed(held: Mapping[str, Any], changes: Mapping[str, Any], model: Model) -> dict[str, Any]:
    """Return words with changes; a word that is changed keeps its place, new ones follow in the order given.

    A change of a parameter replaces its substitutes, and the reverse.

    Raises
    ------
    RequestError
        If the changes give a parameter in two ways.
    """
    check_once(changes, model)
    change_of = {parameter_of(name, model): name for name in changes}
    merged: dict[str, Any] = {}
    for name, value in held.items():
        change = change_of.get(parameter_of(name, model))
        merged |= {name: value} if change is None else {change: changes[change]}
    return {**merged, **changes}


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
    given = {name: model.substitutes[name] for name in words if name in model.substitutes}
    values: dict[str, Value | Distribution] = {
        name: parse_distribution(words[name], each)
        if is_distribution(words[name])
        else read(words[name], each)
        for name, each in given.items()
    }
    known = {**{name: row.default for name, row in model.parameters.items()}, **fixed, **words}
    if isinstance(table := words.get("starts"), StartTable):
        known |= {name: Column(name, table) for name in table.names}
        _check_no_column(given, words, table)
    needed = {
        name: _ends(model.parameters[name], known[name], read if name in words else read_value)
        for each in given.values()
        for name in each.needs
    }
    if varying := [name for name, (low, high) in needed.items() if low != high]:
        told = {name: each for name, each in given.items() if not set(varying).isdisjoint(each.needs)}
        listing = next((word for word in ("starts", "samples") if str(words.get(word, "")).strip()), "")
        _refuse_varying(varying, told, values, needed, model, listing)
    disk = {name: low for name, (low, _) in needed.items()}
    found = {name: _parameter(each, values[name], disk, words[name], model) for name, each in given.items()}
    return {parameter_of(name, model): found.get(name, raw) for name, raw in words.items()}


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
    held = raw
    if not isinstance(raw, Column):
        held = read_distribution(raw, quantity) if is_distribution(raw) else read_input(quantity, raw, read)
    if isinstance(held, Range | Values | Distribution | Column):
        low, high = held.ends().tolist()
        return low, high
    return float(str(held)), float(str(held))


def _parameter(
    substitute: Substitute, value: Value | Distribution, disk: Mapping[str, float], raw: object, model: Model
) -> Value | Distribution:
    """Return the value of the parameter that a value of a substitute stands for; `raw` is what was given."""
    try:
        if isinstance(value, Distribution):
            found: Value | Distribution = _distribution(value, substitute, disk)
        elif isinstance(value, Range):
            found = _range(value, substitute, disk)
        elif isinstance(value, Values):
            found = _values(value, substitute, disk)
        else:
            found = _converted(value, substitute, disk)
        return _allowed(found, substitute, raw, model.parameters[substitute.parameter])
    except RequestError as error:
        raise error.at(f"{substitute.name}={shown(raw)}") from None


def _converted(value: float, substitute: Substitute, disk: Mapping[str, float]) -> float:
    # a scale may be too small or too large for a float: what is not finite is refused as a value
    with np.errstate(all="ignore"):
        return float(np.divide(value, substitute.scale(disk))) + substitute.offset + 0.0


def _allowed(
    value: Value | Distribution, substitute: Substitute, raw: object, parameter: Input
) -> Value | Distribution:
    """Return the value of a parameter that its rule allows; `raw` is what was given for the substitute."""
    if isinstance(value, Distribution):
        if not substitute.offset:
            return read_distribution(value, parameter, raw)
        ends = value.required()
    else:
        if not substitute.offset:
            return allowed(value, parameter, raw)
        ends = np.array([value]) if isinstance(value, float) else value.ends()
    if parameter.allows(ends).all():
        return value
    # the parameter is in the unit of the substitute
    outside = as_given(float(ends[~parameter.allows(ends)][0]), parameter, raw)
    rule = rule_in(parameter, outside.unit)
    raise RequestError(
        f"That is a {parameter.name} of {outside.text}, which is not possible: {rule}.",
        hint=f"Choose values with {rule}; a bare number is in {substitute.units}.",
    )


def _values(values: Values, substitute: Substitute, disk: Mapping[str, float]) -> Values:
    return Values(tuple(sorted(_converted(each, substitute, disk) for each in values.values)))


def _range(value: Range, substitute: Substitute, disk: Mapping[str, float]) -> Range | Values:
    if value.spacing == "log" and substitute.offset:
        if len(value) > _MOST_LISTED:
            raise RequestError(
                f"A logarithmic range of {substitute.name} becomes a list of {substitute.parameter}, of at most "
                f"{_MOST_LISTED} values; got {len(value)}.",
                hint="Give a smaller count, or leave out :log.",
            )
        return _values(Values(tuple(value.array().tolist())), substitute, disk)
    start, stop = sorted(_converted(end, substitute, disk) for end in (value.start, value.stop))
    return replace(value, start=start, stop=stop)


def _distribution(value: Distribution, substitute: Substitute, disk: Mapping[str, float]) -> Distribution:
    first, second = (_converted(each, substitute, disk) for each in (value.first, value.second))
    if value.kind == "normal":
        return Distribution(value.kind, first, abs(second - substitute.offset))
    if value.kind != "uniform" and substitute.offset:
        raise RequestError(
            f"{substitute.parameter} is no multiple of {substitute.name}: {value.kind} makes no distribution of it.",
            hint=f"Write uniform, or give {substitute.parameter}.",
        )
    return Distribution(value.kind, *sorted((first, second)))


def _refuse_varying(
    varying: list[str],
    told: Mapping[str, Substitute],
    values: Mapping[str, Value | Distribution],
    needed: Mapping[str, tuple[float, float]],
    model: Model,
    listing: str,
) -> NoReturn:
    """Refuse substitutes that would give the cells different values of their parameter, and say what to write.

    `listing` is the word that makes the cells a list of starts, "starts" or "samples"; empty for a grid.
    """
    several, of = len(told) > 1, " and ".join(varying)
    parameters = [each.parameter for each in told.values()]
    units = " and ".join(dict.fromkeys(model.parameters[name].units for name in parameters))
    instead = [_for_all(each, values[name], needed, listing) for name, each in told.items()]
    raise RequestError(
        f"{' and '.join(told)} {'give' if several else 'gives'} another {' and '.join(parameters)} for each {of}, and "
        f"here {of} {'vary' if len(varying) > 1 else 'varies'}.",
        hint=f"Give {'them' if several else 'it'} in {units}, for example {' '.join(instead)}.",
        where=varying[0],
    )


def _for_all(
    substitute: Substitute,
    value: Value | Distribution,
    needed: Mapping[str, tuple[float, float]],
    listing: str,
) -> str:
    """Return a word that gives the parameter: a range over the ranges of all disks, a number amid their numbers.

    Random starts have no ranges, but a distribution over them all; beside a table stands one number.
    """
    disks = [
        dict(zip(substitute.needs, each, strict=True))
        for each in itertools.product(*(needed[name] for name in substitute.needs))
    ]

    def among(number: float) -> tuple[float, float, float]:
        found = [_converted(number, substitute, disk) for disk in disks]
        low, high = min(found), max(found)
        return low, math.copysign(math.sqrt(low * high), low), high

    if listing == "starts" and not isinstance(value, float):
        text = f"{among(float(value.ends().mean()))[1]:.4g}"
    elif listing and isinstance(value, Range | Values):
        low, high = among(float(value.ends()[0]))[0], among(float(value.ends()[1]))[2]
        text = f"uniform:{low:.4g}:{high:.4g}"
    elif isinstance(value, Range):
        low, high = among(value.start)[0], among(value.stop)[2]
        text = f"{low:.4g}:{high:.4g}:{value.count}" + (":log" if value.spacing == "log" else "")
    elif isinstance(value, Distribution):
        text = f"{value.kind}:{among(value.first)[1]:.4g}:{among(value.second)[1]:.4g}"
    else:
        numbers = value.values if isinstance(value, Values) else (value,)
        text = ",".join(f"{among(number)[1]:.4g}" for number in numbers)
    return f"{substitute.parameter}={text}"
