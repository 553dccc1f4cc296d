"""The part of an atlas that words name: ``alpha=0.5``, ``tilt=1deg,2deg``, ``roll_rate=2:3``."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, NoReturn

import numpy as np

from sweep.atlas.nearest import SAME, is_inside, is_other, nearest
from sweep.atlas.selection import selected_spec, settled
from sweep.errors import RequestError
from sweep.model.quantity import Array, Input
from sweep.request.axes import Range, Values
from sweep.request.spec import SweepSpec
from sweep.request.substitutes import check_once, parameter_of
from sweep.request.suggestions import unknown_word
from sweep.request.values import read_number, read_value
from sweep.request.words import degrees_meant

if TYPE_CHECKING:
    import xarray as xr


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
    for name, text in (_parameter(spec, *word) for word in words.items()):
        if name not in spec.axes:
            _no_axis(spec, name)
        quantity = spec.quantities[name]
        try:
            places[name] = _places(getattr(spec, name), text, quantity, notes)
        except RequestError as error:
            raise error.at(error.where or f"{name}={text}") from None
    return settled(dataset.isel(places)), notes


def _parameter(spec: SweepSpec, name: str, text: str) -> tuple[str, str]:
    """Return a word that gives a parameter; of a scaled rate or a speed, the rate for the disk of an atlas."""
    if name not in spec.model.substitutes:
        return name, text
    parts = text.split(":") if text.count(":") == 1 else [text]
    parameter = parameter_of(name, spec.model)
    return parameter, ":".join(str(spec.resolve({name: part})[parameter]) for part in parts)


def _no_axis(spec: SweepSpec, name: str) -> NoReturn:
    if name not in spec.model.parameters:
        instead = [each.name for each in spec.model.substitutes.values() if each.parameter in spec.axes]
        unknown_word(name, (*spec.axes, *instead), spec.model)
    raise RequestError(
        f"{name} is no axis of this atlas, whose axes are {', '.join(spec.axes) or 'none'}: there is nothing to pick.",
        hint="Leave it out.",
        where=name,
    )


def _places(axis: Range | Values, text: str, quantity: Input, notes: list[str]) -> int | list[int] | slice:
    """Return the places along an axis that a text names."""
    if text.count(":") == 1:
        low, high = (read_number(part, quantity) for part in text.split(":"))
        return _between(axis.array(), low, high, quantity, text)
    value = read_value(text, quantity)
    if isinstance(value, Range):
        raise RequestError(
            f"A part of an axis is START:STOP, all values between the two; got {text}.",
            hint=f"Write {quantity.name}={':'.join(text.split(':')[:2])}.",
        )
    if isinstance(value, Values):
        return sorted({_nearest(axis, each, quantity, text, notes) for each in value.values})
    return _nearest(axis, value, quantity, text, notes)


def _between(axis: Array, low: float, high: float, quantity: Input, text: str) -> slice:
    margin = SAME * np.abs(axis[[0, -1]]).max()
    inside = np.flatnonzero((axis >= low - margin) & (axis <= high + margin))
    if inside.size:
        return slice(int(inside[0]), int(inside[-1]) + 1)
    raise RequestError(
        f"No value of {quantity.name} lies from {quantity.spell(low)} to {quantity.spell(high)}; the axis is "
        f"{_extent(axis, quantity)}.",
        hint=degrees_meant(quantity, text, np.array([low, high]))
        or "Give two values with some of the axis between them, the smaller one first.",
    )


def _nearest(axis: Range | Values, value: float, quantity: Input, text: str, notes: list[str]) -> int:
    """Return the place of the nearest value, and note which one it is where it is another one; `text` was given."""
    held = axis.array()
    if not is_inside(axis, value):
        raise RequestError(
            f"{quantity.spell(value)} is outside this atlas, whose {quantity.name} is {_extent(held, quantity)}.",
            hint=degrees_meant(quantity, text, np.array([value])) or "Give a value inside.",
        )
    place = nearest(axis, value, quantity)
    if is_other(axis, place, value):
        taken, asked = quantity.spell(float(held[place]), 6), quantity.spell(value, 6)
        notes.append(f"{quantity.name} {taken} is the nearest of the atlas to {asked}")
    return place


def _extent(axis: Array, quantity: Input) -> str:
    return " to ".join(quantity.spell(float(end), 6) for end in axis[[0, -1]][: axis.size])
