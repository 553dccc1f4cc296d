"""The part of an atlas that words name: ``alpha=0.5``, ``tilt=1deg,2deg``, ``roll_rate=2:3``."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple, NoReturn

import numpy as np

from sweep.atlas.nearest import SAME, is_inside, is_other, nearest
from sweep.atlas.selection import selected_spec, settled
from sweep.errors import RequestError
from sweep.model.quantity import Array, Input
from sweep.request.as_given import as_given, in_unit
from sweep.request.axes import Range, Values
from sweep.request.spec import SweepSpec
from sweep.request.substitutes import check_once, parameter_of
from sweep.request.suggestions import unknown_word
from sweep.request.values import read_number, read_value
from sweep.request.words import degrees_meant

if TYPE_CHECKING:
    import xarray as xr


class _Given(NamedTuple):
    """A word of a request, and its text: perhaps a speed, where the axis is a rate."""

    word: str
    text: str


def picked(dataset: "xr.Dataset", words: Mapping[str, str]) -> tuple["xr.Dataset", list[str]]:
    """Return the part of an atlas that words name, as an atlas.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas.
    words : mapping of str to str
        Axis -> a number, which takes the nearest value and leaves the axis out; a list ``a,b``, which takes the
        nearest of each; or ``start:stop``, all values between the two. Each number in SI or with a unit. A rate may
        be given scaled, or as a speed.

    Returns
    -------
    part : xarray.Dataset
        As from `settled`.
    notes : list of str
        Which values stand for others that the atlas does not have.

    Raises
    ------
    RequestError
        If a name is no axis, a value cannot be read, or lies outside.
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
    return settled(dataset.isel(places)), notes


def _parameter(spec: SweepSpec, name: str, text: str) -> tuple[str, str]:
    """Return a word that gives a parameter; of a scaled rate or a speed, the rate for the disk of an atlas."""
    if name not in spec.model.substitutes:
        return name, text
    parameter = parameter_of(name, spec.model)
    if text.count(":") != 1:
        return parameter, str(spec.resolve({name: text})[parameter])
    ends = [spec.resolve({name: part}, read_number)[parameter] for part in text.split(":")]
    # an inclination falls where the tilt rises
    return parameter, ":".join(map(str, sorted(ends)))


def _no_axis(spec: SweepSpec, name: str) -> NoReturn:
    if name not in spec.model.parameters:
        instead = [each.name for each in spec.model.substitutes.values() if each.parameter in spec.axes]
        unknown_word(name, (*spec.axes, *instead), spec.model)
    raise RequestError(
        f"{name} is no axis of this atlas, whose axes are {', '.join(spec.axes) or 'none'}: there is nothing to pick.",
        hint="Leave it out.",
        where=name,
    )


def _places(
    axis: Range | Values, text: str, quantity: Input, notes: list[str], given: _Given
) -> int | list[int] | slice:
    """Return the places along an axis that a text names; `given` is what the request says."""
    if text.count(":") == 1:
        low, high = (read_number(part, quantity) for part in text.split(":"))
        return _between(axis.array(), low, high, quantity, given)
    value = read_value(text, quantity)
    if isinstance(value, Range):
        raise RequestError(
            f"A part of an axis is START:STOP, all values between the two; got {given.text}.",
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
        or "Give two values with some of the axis between them, the smaller one first.",
    )


def _nearest(axis: Range | Values, value: float, quantity: Input, given: _Given, notes: list[str]) -> int:
    """Return the place of the nearest value, and note which one it is where it is another one."""
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
        notes.append(f"{quantity.name} {taken} is the nearest of the atlas to {asked.text}")
    return place


def _extent(axis: Array, quantity: Input, unit: str) -> str:
    return " to ".join(in_unit(float(end), quantity, unit, 6) for end in axis[[0, -1]][: axis.size])
