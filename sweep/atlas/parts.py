"""Selection of a part or a cell of an atlas by words: ``alpha=0.5``, ``tilt=1deg,2deg``, ``roll_rate=2:3``."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple, NoReturn

import numpy as np

from sweep.atlas.selection import as_atlas, selected_spec
from sweep.errors import RequestError, shown
from sweep.model.quantity import Array, Input
from sweep.request.sources import Range, Values
from sweep.request.spec import SweepSpec
from sweep.request.start_list import START
from sweep.request.substitutes import check_once, parameter_of
from sweep.request.suggestions import unknown_word
from sweep.request.values import as_given, degrees_meant, in_unit, read_number, read_value

if TYPE_CHECKING:
    import xarray as xr


#: Relative difference, compared with the ends of the axis, below which two values count as the same.
SAME = 1e-9


def nearest_cell(spec: SweepSpec, given: Mapping[str, object]) -> dict[str, int]:
    """Return the index of the nearest cell along each axis of a grid.

    Parameters
    ----------
    spec : SweepSpec
    given : mapping of str to number or text with a unit
        A value for every axis, in SI or with a unit; optional for an axis with one value. Along a logarithmic axis,
        logarithms are compared. A rate may be given scaled, or as a speed. The number of a start must be in the list.

    Returns
    -------
    dict of str to int
        Axis -> index, in the order of the axes.

    Raises
    ------
    RequestError
        If a name is not a parameter, an axis has no value, a value lies outside the atlas, or there is no such start.
    """
    parameters = spec.quantities
    for name in given:
        if name not in parameters and name not in spec.model.substitutes:
            unknown_word(name, (*parameters, *spec.model.substitutes), spec.model)
    words = {parameter_of(name, spec.model): name for name in given}
    resolved = spec.resolve(given, read_number)
    values = {name: read_number(raw, parameters[name]) for name, raw in resolved.items()}
    for name, value in values.items():
        _check_inside(spec, name, value, words[name], given[words[name]])
    missing = [name for name in spec.axes if name not in values and len(getattr(spec, name)) > 1]
    if missing:
        raise RequestError(
            f"A cell needs a value for each of {', '.join(spec.axes)}; missing {', '.join(missing)}.",
            hint="Add " + " ".join(f"{name}={_example(spec, name)}" for name in missing) + ".",
        )
    return {
        name: nearest(getattr(spec, name), values[name], parameters[name]) if name in values else 0
        for name in spec.axes
    }


def other_values(spec: SweepSpec, place: Mapping[str, int], given: Mapping[str, object]) -> str:
    """Return the values of a cell that differ from the given ones, in words; empty if none do.

    Parameters
    ----------
    spec : SweepSpec
    place : mapping of str to int
        The cell: axis -> index.
    given : mapping of str to number or text with a unit
        Values for axes.
    """
    others = []
    for name, raw in spec.resolve(given, read_number).items():
        quantity, axis = spec.quantities[name], getattr(spec, name)
        if is_other(axis, place[name], read_number(raw, quantity)):
            others.append(f"{name} {quantity.spell(float(axis.at([place[name]])[0]), 6)}")
    return ", ".join(others)


def _check_inside(spec: SweepSpec, name: str, value: float, word: str, raw: object) -> None:
    """Refuse a value of a parameter that no cell has; `word` and `raw` are the name and the value in the request."""
    quantity, held = spec.quantities[name], getattr(spec, name)
    if isinstance(held, str) or name in spec.listed:
        how = "computed in every cell" if isinstance(held, str) else "different for every start"
        raise RequestError(
            f"{name} is {how}: a cell of this atlas is selected by {', '.join(spec.axes)}.",
            hint="Leave it out.",
            where=f"{word}={shown(raw)}",
        )
    if is_inside(held, value):
        return
    axis = held.array() if isinstance(held, Range | Values) else np.array([held])
    asked = as_given(value, quantity, raw)
    holds = " to ".join(in_unit(end, quantity, asked.unit) for end in axis[[0, -1]][: axis.size])
    raise RequestError(
        f"{asked.text} is outside the atlas, whose {name} is {holds}.",
        hint=degrees_meant(quantity, word, raw, np.array([value]))
        or "Give a value inside, or compute an atlas that contains it.",
        where=f"{word}={shown(raw)}",
    )


def is_inside(axis: Range | Values | float, value: float) -> bool:
    """Return whether a value lies within an axis extended by half a step, in logarithms if the axis is logarithmic."""
    held = axis.array() if isinstance(axis, Range | Values) else np.array([axis])
    steps = np.diff(held)[[0, -1]] if held.size > 1 else 2.0 * SAME * np.abs(held[[0, 0]])
    if isinstance(axis, Range) and axis.spacing == "log" and held.size > 1:
        if value <= 0.0:
            return False
        held, value = np.log(held), math.log(value)
        steps = np.diff(held)[[0, -1]]
    return bool(held[0] - 0.5 * steps[0] <= value <= held[-1] + 0.5 * steps[1])


def nearest(axis: Range | Values, value: float, quantity: Input) -> int:
    """Return the index of the nearest value; along a logarithmic axis, logarithms are compared.

    Raises
    ------
    RequestError
        If the axis consists of the numbers of starts and lacks this one: starts are not rounded to the nearest.
    """
    held = axis.array()
    if isinstance(axis, Range) and axis.spacing == "log" and value > 0.0:
        return int(np.argmin(np.abs(np.log(held / value))))
    place = int(np.argmin(np.abs(held - value)))
    if quantity is START and held[place] != value:
        raise RequestError(
            f"There is no start {value:.12g}: this list has {held.size}, numbered from {held[0]:.0f} to "
            f"{held[-1]:.0f}.",
            hint="Give one of these numbers.",
            where=f"{START.name}={value:.12g}",
        )
    return place


def is_other(axis: Range | Values, place: int, value: float) -> bool:
    """Return whether the value at an index of an axis differs from a given one by more than rounding."""
    return bool(abs(float(axis.at([place])[0]) - value) > SAME * np.abs(axis.ends()).max())


def _example(spec: SweepSpec, name: str) -> str:
    axis = getattr(spec, name).array()
    # the number of a start must be whole
    quantity, digits = spec.quantities[name], 10 if spec.is_list else 3
    number = f"{axis[axis.size // 2] * quantity.plot_scale:.{digits}g}"
    return number + ("deg" if quantity.units == "rad" else "")


class _Given(NamedTuple):
    """A word of a request and its text, which may be a speed although the axis is a rate."""

    word: str
    text: str


def part_of(dataset: "xr.Dataset", words: Mapping[str, str]) -> tuple["xr.Dataset", list[str]]:
    """Return the part of an atlas that words select, as an atlas.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas.
    words : mapping of str to str
        Axis -> a number, which selects the nearest value and removes the axis; a list ``a,b``, which selects the
        nearest value to each; or ``start:stop``, which selects all values between the two. Numbers are in SI or have a
        unit. A rate may be given scaled, or as a speed.

    Returns
    -------
    part : xarray.Dataset
        The atlas from `as_atlas`.
    notes : list of str
        Notes on values that were replaced by the nearest value of the atlas.

    Raises
    ------
    RequestError
        If a name is not an axis, or a value cannot be read or lies outside.
    """
    spec = selected_spec(dataset)
    places: dict[str, int | list[int] | slice] = {}
    notes: list[str] = []
    check_once(words, spec.model)
    for word, given in words.items():
        name, text = _parameter(spec, word, given)
        if name not in spec.axes:
            _no_axis(spec, name)
        quantity = spec.quantities[name]
        try:
            places[name] = _places(getattr(spec, name), text, quantity, notes, _Given(word, given))
        except RequestError as error:
            raise error.at(error.where if error.where and word == name else f"{word}={given}") from None
    return as_atlas(dataset.isel(places)), notes


def _parameter(spec: SweepSpec, name: str, text: str) -> tuple[str, str]:
    """Return a parameter and its text; a scaled rate or a speed is converted to the rate for the atlas's disk."""
    if name not in spec.model.substitutes:
        return name, text
    parameter = parameter_of(name, spec.model)
    if text.count(":") != 1:
        return parameter, str(spec.resolve({name: text})[parameter])
    ends = [spec.resolve({name: part}, read_number)[parameter] for part in text.split(":")]
    # an inclination decreases as the tilt increases
    return parameter, ":".join(map(str, sorted(ends)))


def _no_axis(spec: SweepSpec, name: str) -> NoReturn:
    if name not in spec.model.parameters:
        instead = [each.name for each in spec.model.substitutes.values() if each.parameter in spec.axes]
        unknown_word(name, (*spec.axes, *instead), spec.model)
    raise RequestError(
        f"{name} is not an axis of this atlas; its axes are {', '.join(spec.axes) or 'none'}.",
        hint="Leave it out.",
        where=name,
    )


def _places(
    axis: Range | Values, text: str, quantity: Input, notes: list[str], given: _Given
) -> int | list[int] | slice:
    """Return the indices along an axis that a text selects; `given` is the word of the request."""
    if text.count(":") == 1:
        low, high = (read_number(part, quantity) for part in text.split(":"))
        return _between(axis.array(), low, high, quantity, given)
    value = read_value(text, quantity)
    if isinstance(value, Range):
        raise RequestError(
            f"A part of an axis is START:STOP, which selects all values between the two; got {given.text}.",
            hint=f"Write {given.word}={':'.join(given.text.split(':')[:2])}.",
        )
    if isinstance(value, Values):
        return sorted({_nearest(axis, each, quantity, given, notes) for each in value.values})
    return _nearest(axis, value, quantity, given, notes)


def _between(axis: Array, low: float, high: float, quantity: Input, given: _Given) -> slice:
    margin = SAME * np.abs(axis[[0, -1]]).max()
    inside = np.flatnonzero((axis >= low - margin) & (axis <= high + margin))
    if inside.size:
        return slice(int(inside[0]), int(inside[-1]) + 1)
    first, last = (as_given(each, quantity, given.text) for each in (low, high))
    raise RequestError(
        f"No value of {quantity.name} lies from {first.text} to {last.text}; the axis is "
        f"{_extent(axis, quantity, first.unit)}.",
        hint=degrees_meant(quantity, *given, np.array([low, high]))
        or "Give two values with values of the axis between them, the smaller one first.",
    )


def _nearest(axis: Range | Values, value: float, quantity: Input, given: _Given, notes: list[str]) -> int:
    """Return the index of the nearest value, and add a note if it differs from the given value."""
    held = axis.array()
    if not is_inside(axis, value):
        asked = as_given(value, quantity, given.text)
        raise RequestError(
            f"{asked.text} is outside this atlas, whose {quantity.name} is {_extent(held, quantity, asked.unit)}.",
            hint=degrees_meant(quantity, *given, np.array([value])) or "Give a value inside.",
        )
    place = nearest(axis, value, quantity)
    if is_other(axis, place, value):
        asked = as_given(value, quantity, given.text)
        taken = in_unit(float(held[place]), quantity, asked.unit, 6)
        notes.append(f"{quantity.name} {taken} is the value of the atlas nearest to {asked.text}")
    return place


def _extent(axis: Array, quantity: Input, unit: str) -> str:
    return " to ".join(in_unit(float(end), quantity, unit, 6) for end in axis[[0, -1]][: axis.size])
