"""The cell of an atlas that is nearest to given values."""

import math
from collections.abc import Mapping

import numpy as np

from sweep.errors import RequestError, shown
from sweep.model.quantity import Input
from sweep.request.as_given import as_given, in_unit
from sweep.request.axes import Range, Values
from sweep.request.spec import SweepSpec
from sweep.request.start_list import START
from sweep.request.substitutes import parameter_of
from sweep.request.suggestions import unknown_word
from sweep.request.values import read_number
from sweep.request.words import degrees_meant

#: A value that differs by less, relative to the ends of its axis, is the one that was asked for.
SAME = 1e-9


def nearest_cell(spec: SweepSpec, given: Mapping[str, object]) -> dict[str, int]:
    """Return the index of the nearest cell along each axis of a grid.

    Parameters
    ----------
    spec : SweepSpec
    given : mapping of str to number or text with a unit
        A value for every axis, in SI or with a unit; an axis of one value needs none. Along a logarithmic axis
        the nearest value is the one nearest in its logarithm. A rate may be given scaled, or as a speed. The
        number of a start has to be one of the list.

    Returns
    -------
    dict of str to int
        Axis -> index, in the order of the axes.

    Raises
    ------
    RequestError
        If a name is none of the parameters, an axis has no value, a value lies outside the atlas, or there is no
        such start.
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
            f"A value is needed for each of {', '.join(spec.axes)}; none was given for {', '.join(missing)}.",
            hint="Add " + " ".join(f"{name}={_example(spec, name)}" for name in missing) + ".",
        )
    return {
        name: nearest(getattr(spec, name), values[name], parameters[name]) if name in values else 0
        for name in spec.axes
    }


def other_values(spec: SweepSpec, place: Mapping[str, int], given: Mapping[str, object]) -> str:
    """Return where a cell is, along the axes for which another value was given; nothing if it has the values given.

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
    """Refuse a value of a parameter that no cell has; `word` and `raw` are what was given for it."""
    quantity, held = spec.quantities[name], getattr(spec, name)
    if isinstance(held, str) or name in spec.listed:
        how = "computed in every cell" if isinstance(held, str) else "another number in every start"
        raise RequestError(
            f"{name} is {how}: a cell of this atlas is named by {', '.join(spec.axes)}.",
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
        or "Give a value inside, or compute an atlas that holds it.",
        where=f"{word}={shown(raw)}",
    )


def is_inside(axis: Range | Values | float, value: float) -> bool:
    """Return whether a value lies within an axis, or no further outside than half a step, in logs if they are even."""
    held = axis.array() if isinstance(axis, Range | Values) else np.array([axis])
    steps = np.diff(held)[[0, -1]] if held.size > 1 else 2.0 * SAME * np.abs(held[[0, 0]])
    if isinstance(axis, Range) and axis.spacing == "log" and held.size > 1:
        if value <= 0.0:
            return False
        held, value = np.log(held), math.log(value)
        steps = np.diff(held)[[0, -1]]
    return bool(held[0] - 0.5 * steps[0] <= value <= held[-1] + 0.5 * steps[1])


def nearest(axis: Range | Values, value: float, quantity: Input) -> int:
    """Return the place of the value that is nearest; along a logarithmic axis, nearest in its logarithm.

    Raises
    ------
    RequestError
        If the axis has the numbers of starts, and this is none of them: a start has no nearest one.
    """
    held = axis.array()
    if isinstance(axis, Range) and axis.spacing == "log" and value > 0.0:
        return int(np.argmin(np.abs(np.log(held / value))))
    place = int(np.argmin(np.abs(held - value)))
    if quantity is START and held[place] != value:
        raise RequestError(
            f"There is no start {value:.12g}: this list has {held.size}, numbered from {held[0]:.0f} to "
            f"{held[-1]:.0f}.",
            hint="Give one of its numbers: a start has no nearest one.",
            where=f"{START.name}={value:.12g}",
        )
    return place


def is_other(axis: Range | Values, place: int, value: float) -> bool:
    """Return whether the value at a place of an axis is another one than a given one, beyond rounding."""
    return bool(abs(float(axis.at([place])[0]) - value) > SAME * np.abs(axis.ends()).max())


def _example(spec: SweepSpec, name: str) -> str:
    axis = getattr(spec, name).array()
    # the number of a start has to be whole
    number = spec.quantities[name].spell(axis[axis.size // 2], 10 if spec.is_list else 3).split()[0]
    return number + ("deg" if spec.quantities[name].units == "rad" else "")
