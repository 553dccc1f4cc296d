"""Lists of starts, instead of a grid: one dimension, and in every cell different values of the parameters.

The dimension is called `start`, and its coordinate is the number of the start. A part of a list keeps the numbers of
its starts, and so their values.
"""

import math
import re
from collections.abc import Mapping
from typing import Any, NoReturn

import numpy as np

from sweep.errors import RequestError, shown
from sweep.model.description import Model
from sweep.model.quantity import DECISION, Array, Input, Truths, Word, table
from sweep.request.sources import KINDS, Distribution, Range, Values
from sweep.request.start_table import Column, GivenTable, StartTable, read_table
from sweep.request.units import plain_number
from sweep.request.values import NoCountError, read_value

#: Largest number of starts of a list: their numbers are 32-bit integers in the file.
_MOST_STARTS = 2**31 - 1

_MOST_SEED = 2**64 - 1

#: A range of start numbers, with both ends.
_PART = re.compile(r"\s*(\d{1,10})\s*:\s*(\d{1,10})\s*", re.ASCII)


def _counts(values: Array) -> Truths:
    whole: Truths = (values >= 0.0) & (values == np.rint(values))
    return whole


#: The dimension of a list, and the words of a request that makes one.
START = Input(
    "start", "", "1", "number of the start", DECISION,
    "cells are a list of starts, not a grid; each has its own values of the parameters that are listed", "i4",
    default="", rule="a whole number, at least 0", allows=_counts,
)  # fmt: skip
WORDS: Mapping[str, Word | Input] = {
    **table(
        Word("samples", "number of random starts", ""),
        Word("seed", "seed of the random starts", "0"),
        Word("starts", "table of given starts", ""),
    ),
    START.name: START,
}


def read_list_word(name: str, raw: object, model: Model) -> int | str | Range | Values | StartTable:
    """Return the value of one of `WORDS`; empty text if it is not given.

    Raises
    ------
    RequestError
        If the value cannot be read.
    """
    if isinstance(raw, str) and not raw.strip():
        return ""
    if name == "starts":
        table = read_table(raw)
        assert table is not None
        return table.of(model) if isinstance(table, GivenTable) else table
    if name == START.name:
        return _read_start_numbers(raw)
    low, most = (1, _MOST_STARTS) if name == "samples" else (0, _MOST_SEED)
    found = _read_whole_number(raw)
    if found is None or not low <= found <= most:
        raise RequestError(
            f"{name} is a whole number from {low} to {most}; got {shown(raw)}.",
            hint=f"Write {name}={'1e6' if name == 'samples' else '7'}.",
            where=name,
        )
    return found


def _read_whole_number(raw: object) -> int | None:
    """Return a value as a whole number, for text also in the form 1e6; None if it is not a whole number."""
    if isinstance(raw, int | np.integer) and not isinstance(raw, bool):
        return int(raw)
    if isinstance(raw, str) and raw.strip().isascii() and raw.strip().isdigit():
        # read all digits: a float keeps only 16 of them
        return int(raw) if len(raw.strip()) <= 20 else None
    number = plain_number(raw) if isinstance(raw, str) else raw if isinstance(raw, float) else math.nan
    return int(number) if math.isfinite(number) and number == math.floor(number) else None


def _read_start_numbers(raw: object) -> Range | Values:
    if isinstance(raw, str) and (part := _PART.fullmatch(raw)):
        first, last = int(part[1]), int(part[2])
        return Range(float(first), float(last), last - first + 1) if first < last else _refuse_numbers(raw)
    try:
        found = read_value(raw, START)
    except NoCountError:
        _refuse_numbers(raw)
    # a single number selects one start
    axis = Values((found,)) if isinstance(found, float) else found
    # for a range check its step instead of computing all of its values
    steps = (axis.stop - axis.start) % max(1, axis.count - 1) if isinstance(axis, Range) else 0.0
    ends_or_values = axis.ends() if isinstance(axis, Range) else axis.array()
    if steps or getattr(axis, "spacing", "") == "log" or not _counts(ends_or_values).all():
        _refuse_numbers(raw)
    return axis


def _refuse_numbers(raw: object) -> NoReturn:
    raise RequestError(
        f"start takes the numbers of starts, which are whole numbers from 0; got {shown(raw)}.",
        hint="Write start=0:99, or leave it out for all starts.",
        where="start",
    )


def with_list(
    model: Model, values: Mapping[str, Any], axes: tuple[str, ...], given: Mapping[str, Any]
) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Return the values and axes of a request, after adding the list of starts if it has one.

    Parameters
    ----------
    model : Model
    values : mapping of str to value
        The value of every word.
    axes : tuple of str
        The words with a list or a range, in the order given.
    given : mapping of str to anything
        The words of the request, as given; all other words have their defaults.

    Returns
    -------
    values : dict
        The values, with the numbers of the starts as ``start``.
    axes : tuple of str
        For a list of starts ``("start",)``.

    Raises
    ------
    RequestError
        If words of lists and of grids are given together, or samples without a distribution.
    """
    if not values["starts"] and not values["samples"]:
        _check_no_list(values, given)
        return dict(values), axes
    own = (
        _use_table(model, values, axes, given)
        if values["starts"]
        else _draw_starts(model, values, axes, given)
    )
    if values["boundary"] != "grid":
        raise RequestError(
            "A boundary can be refined only on a grid, not in a list of starts; got "
            f"boundary={values['boundary']} for a list.",
            hint="Leave boundary out, or give axes.",
            where="boundary",
        )
    return {**values, **own}, (START.name,)


def _draw_starts(
    model: Model, values: Mapping[str, Any], axes: tuple[str, ...], given: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the numbers of random starts."""
    count = int(values["samples"])
    if not any(isinstance(values[name], Distribution) for name in model.parameters):
        control = next(iter(model.controls(model.parameters)), next(iter(model.parameters)))
        raise RequestError(
            f"samples is the number of random starts, but no parameter has a distribution; got samples={count}.",
            hint=f"Give a distribution, as in {control}=uniform:2:4, or leave samples out.",
            where="samples",
        )
    if crossed := [name for name in axes if name != START.name]:
        raise RequestError(
            f"samples and axes cannot be combined: every start has one value of each parameter; got samples={count} "
            f"and {_word_as_given(crossed[0], given, values)}.",
            hint=f"Give {' and '.join(crossed)} one number or a distribution ({', '.join(KINDS.values())}), or leave "
            "samples out.",
            where=crossed[0],
        )
    numbers = values["start"] or every_start(count)
    if numbers.ends()[1] >= count:
        raise RequestError(
            f"The starts have the numbers 0 to {count - 1}; got {_word_as_given(START.name, given, values)}.",
            hint="Choose numbers in this range, or leave start out for all starts.",
            where="start",
        )
    return {START.name: numbers}


def _use_table(
    model: Model, values: Mapping[str, Any], axes: tuple[str, ...], given: Mapping[str, Any]
) -> dict[str, Any]:
    """Return a table, its columns, which replace the defaults, and the numbers of its starts."""
    table: StartTable = values["starts"]
    if foreign := [name for name in table.names if name not in model.parameters]:
        raise ValueError(f"{foreign[0]} is not a parameter of the model {model.name}")
    other = [
        name
        for name in (*model.parameters, "samples", "seed")
        if (name in table.names and name in given and not isinstance(values[name], Column))
        or (name not in table.names and (name in axes or isinstance(values[name], Distribution | Column)))
        or (name not in model.parameters and values[name])
    ]
    if other:
        raise RequestError(
            f"With a table of starts every other parameter must have one number; got {table} and "
            f"{_word_as_given(other[0], given, values)}.",
            hint=f"Leave {other[0]} out."
            if other[0] in (*table.names, "samples", "seed")
            else f"Give {other[0]} one number, or a column of the table.",
            where=other[0],
        )
    if values["start"] and values["start"] != table.numbers:
        table = table.part(values["start"])
    columns = {name: Column(name, table) for name in table.names}
    return {**columns, "starts": table, START.name: table.numbers}


def _check_no_list(values: Mapping[str, Any], given: Mapping[str, Any]) -> None:
    """Refuse the words of a list in a request without one."""
    for name, value in values.items():
        if isinstance(value, Column):
            raise RequestError(
                f"{name} is a column of a table, but the request has no table.",
                hint=f"Give the table as starts, or give {name} a number.",
                where=name,
            )
        if isinstance(value, Distribution):
            raise RequestError(
                f"{_word_as_given(name, given, values)} is a distribution, which needs a number of starts.",
                hint="Add samples=1e6, for instance.",
                where=name,
            )
        if name in ("seed", START.name) and value:
            raise RequestError(
                f"{name} applies only to random starts, which need samples; got "
                f"{_word_as_given(name, given, values)} without samples.",
                hint=f"Leave {name} out, or add samples=1e6 and a distribution.",
                where=name,
            )


def _word_as_given(name: str, given: Mapping[str, Any], values: Mapping[str, Any]) -> str:
    """Return a word with its value: as given if it was given as text, otherwise in SI."""
    raw = given.get(name)
    return f"{name}={shown(raw if isinstance(raw, str) else str(values[name]))}"


def every_start(count: int) -> Range:
    """Return the indices of all starts in a list."""
    return Range(0.0, count - 1.0, count)


def implied(name: str, values: Mapping[str, Any]) -> bool:
    """Return whether a word can be omitted: it is a word of lists and this is a grid, or it selects all starts."""
    if name not in WORDS:
        return False
    if name == "starts":
        return not values[name]
    if name != START.name:
        return not values["samples"]
    # a table contains the numbers of its starts
    return bool(not values[name] or values["starts"] or values[name] == every_start(int(values["samples"])))
