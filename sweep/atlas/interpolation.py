"""Values of an atlas between its cells: measures linearly, flags and counts from the nearest cell."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from sweep.atlas.dataset import spec_of
from sweep.atlas.selection import BETWEEN
from sweep.errors import RequestError, shown
from sweep.model.quantity import Array
from sweep.request.spec import SweepSpec
from sweep.request.suggestions import unknown_word
from sweep.request.values import Value, read_value

if TYPE_CHECKING:
    import xarray as xr


def interpolated(atlas: "xr.Dataset", given: Mapping[str, Any]) -> "xr.Dataset":
    """Return the variables of the cells at places between them.

    Parameters
    ----------
    atlas : xarray.Dataset
        A whole one, see `sweep.atlas.selection.settled`.
    given : mapping of str to number, text with a unit, or array
        Axis -> the places; along the other axes the values stay.

    Returns
    -------
    xarray.Dataset
        Measures linearly between their neighbours, missing where a neighbour is missing; variables of whole numbers
        (endings, verdicts, counts) of the nearest cell. It is no atlas.

    Raises
    ------
    RequestError
        If a name is no axis, or a value cannot be read or lies outside.
    """
    spec = spec_of(atlas)
    if spec.is_list:
        raise RequestError(
            "Between the starts of a list nothing is known: the next one may lie anywhere.",
            hint="Take cells with isel or sel, or compute a grid.",
        )
    places = {name: _places(spec, name, raw) for name, raw in given.items()}
    cells = atlas[[name for name in atlas.data_vars if atlas[name].dims == spec.axes]]
    whole = [name for name in cells.data_vars if cells[name].dtype.kind in "iu"]
    # one value along an axis has nothing to lie between
    lines = {name: values for name, values in places.items() if cells.sizes[name] > 1}
    points = {name: values for name, values in places.items() if name not in lines}
    measures = cells.drop_vars(whole).interp(lines) if lines else cells.drop_vars(whole)
    measures = measures.sel(points, method="nearest").assign_coords(places)
    found = measures.assign(cells[whole].sel(places, method="nearest").assign_coords(places).data_vars)
    found.attrs = {"title": f"{BETWEEN}{atlas.attrs['title']}"}
    return found[list(cells.data_vars)]


def _places(spec: SweepSpec, name: str, raw: Any) -> float | Array:
    if name not in spec.axes:
        unknown_word(name, spec.axes, spec.model)
    quantity, axis = spec.model.parameters[name], getattr(spec, name)
    value: Value = read_value(raw, quantity)
    ends = axis.ends()
    values = value if isinstance(value, float) else value.array()
    if np.min(values) < ends[0] or np.max(values) > ends[1]:
        raise RequestError(
            f"Outside of the cells nothing is known: {name} is {quantity.spell(ends[0])} to {quantity.spell(ends[1])}.",
            hint="Give values inside, or compute an atlas that holds them.",
            where=f"{name}={shown(raw)}",
        )
    return values
