"""The cell of an atlas that lies nearest to given values."""

from collections.abc import Mapping

import numpy as np

from sweep.errors import RequestError
from sweep.model.quantity import Array
from sweep.request.axes import Range, Values
from sweep.request.spec import SweepSpec
from sweep.request.values import read_number
from sweep.request.words import unknown_word

#: Relative tolerance of a value that is given for a parameter that does not vary.
_EQUAL = 1e-9


def nearest_cell(spec: SweepSpec, given: Mapping[str, object]) -> dict[str, int]:
    """Return the index of the nearest cell along each axis of a grid.

    Parameters
    ----------
    spec : SweepSpec
    given : mapping of str to number or text with a unit
        A value for every axis, in SI or with a unit; an axis of one value needs none. Along a logarithmic axis
        the nearest value is the one nearest in its logarithm.

    Returns
    -------
    dict of str to int
        Axis -> index, in the order of the axes.

    Raises
    ------
    RequestError
        If a name is none of the parameters, an axis has no value, or a value lies outside the atlas.
    """
    parameters = spec.model.parameters
    for name in given:
        if name not in parameters:
            unknown_word(name, tuple(parameters), spec.model)
    values = {name: read_number(raw, parameters[name]) for name, raw in given.items()}
    for name, value in values.items():
        _check_inside(spec, name, value)
    missing = [name for name in spec.axes if name not in values and len(getattr(spec, name)) > 1]
    if missing:
        raise RequestError(
            f"Which cell? A cell has a value for each of {', '.join(spec.axes)}; none was given for "
            f"{', '.join(missing)}.",
            hint="Add " + " ".join(f"{name}={_example(spec, name)}" for name in missing) + ".",
        )
    return {name: _place(getattr(spec, name), values.get(name)) for name in spec.axes}


def _check_inside(spec: SweepSpec, name: str, value: float) -> None:
    quantity, held = spec.model.parameters[name], getattr(spec, name)
    if isinstance(held, str):
        raise RequestError(
            f"{name} is computed in every cell: a cell of this atlas is named by {', '.join(spec.axes)}.",
            hint="Leave it out.",
            where=f"{name}={quantity.spell(value)}",
        )
    axis = held.array() if isinstance(held, Range | Values) else np.array([held])
    reach = _reach(axis)
    if axis[0] - reach[0] <= value <= axis[-1] + reach[1]:
        return
    holds = (
        f"{quantity.spell(axis[0])} to {quantity.spell(axis[-1])}"
        if axis.size > 1
        else quantity.spell(axis[0])
    )
    raise RequestError(
        f"This value is outside the atlas, whose {name} is {holds}.",
        hint="Give a value inside, or compute an atlas that holds it.",
        where=f"{name}={quantity.spell(value)}",
    )


def _reach(axis: Array) -> tuple[float, float]:
    """Return how far outside its ends a value still counts as inside: half a step at either end."""
    if axis.size == 1:
        slack = _EQUAL * abs(float(axis[0]))
        return slack, slack
    return 0.5 * float(axis[1] - axis[0]), 0.5 * float(axis[-1] - axis[-2])


def _place(axis: Range | Values, value: float | None) -> int:
    if value is None:
        return 0
    held = axis.array()
    if isinstance(axis, Range) and axis.spacing == "log" and value > 0.0:
        return int(np.argmin(np.abs(np.log(held / value))))
    return int(np.argmin(np.abs(held - value)))


def _example(spec: SweepSpec, name: str) -> str:
    axis = getattr(spec, name).array()
    number = spec.model.parameters[name].spell(axis[axis.size // 2], 3).split()[0]
    return number + ("deg" if spec.model.parameters[name].units == "rad" else "")
