"""Interpolation between the cells of an atlas: measures linearly, flags and counts from the nearest cell."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from sweep.atlas.dataset import spec_of
from sweep.atlas.selection import INTERPOLATED
from sweep.errors import RequestError, shown
from sweep.model.quantity import Array
from sweep.request.spec import SweepSpec
from sweep.request.substitutes import parameter_of
from sweep.request.suggestions import unknown_word
from sweep.request.values import Value, as_given, degrees_meant, limit_in, read_value

if TYPE_CHECKING:
    import xarray as xr


def interpolated(atlas: "xr.Dataset", given: Mapping[str, Any]) -> "xr.Dataset":
    """Interpolate the variables of the cells.

    Parameters
    ----------
    atlas : xarray.Dataset
        A whole atlas, see `sweep.atlas.selection.as_atlas`.
    given : mapping of str to number, text with a unit, array, or xarray.DataArray
        Axis -> positions; other axes keep their values. A rate may be given scaled, or as a speed. Arrays span a grid;
        an xarray.DataArray [SI] gives points along its own dimensions, as in xarray.

    Returns
    -------
    xarray.Dataset
        Measures are interpolated linearly, and missing where a neighbor is missing; whole-number variables (endings,
        verdicts, counts) come from the nearest cell. The result is not an atlas.

    Raises
    ------
    RequestError
        If a name is not an axis, or a value cannot be read or lies outside.
    """
    spec = spec_of(atlas)
    if spec.is_list:
        raise RequestError(
            "A list of starts cannot be interpolated: neighbors in the list may lie anywhere.",
            hint="Select cells with isel or sel, or compute a grid.",
        )
    for name, raw in given.items():
        _check_name(spec, name, raw)
    words = {parameter_of(name, spec.model): name for name in given}
    places = {
        name: _places(spec, name, raw, words[name], given[words[name]])
        for name, raw in spec.resolve(given).items()
    }
    cells = atlas[[name for name in atlas.data_vars if atlas[name].dims == spec.axes]]
    whole = [name for name in cells.data_vars if cells[name].dtype.kind in "iu"]
    # an axis with one value cannot be interpolated
    lines = {name: values for name, values in places.items() if cells.sizes[name] > 1}
    points = {name: values for name, values in places.items() if name not in lines}
    measures = cells.drop_vars(whole).interp(lines) if lines else cells.drop_vars(whole)
    measures = measures.sel(points, method="nearest").assign_coords(places)
    found = measures.assign(cells[whole].sel(places, method="nearest").assign_coords(places).data_vars)
    found.attrs = {
        "title": f"Between the cells of: {atlas.attrs['title']}",
        INTERPOLATED: spec.fingerprint(),
    }
    return found[list(cells.data_vars)]


def _is_pointwise(raw: Any) -> bool:
    """Return whether positions are an xarray.DataArray: points with their own dimensions, not a grid."""
    return hasattr(raw, "dims") and hasattr(raw, "values")


def _check_name(spec: SweepSpec, name: str, raw: Any) -> None:
    parameter = parameter_of(name, spec.model)
    if name != parameter and _is_pointwise(raw):
        raise RequestError(
            f"{name} must be a number, a list or an array; points in an xarray.DataArray are given as {parameter}.",
            hint=f"Give {parameter} [{spec.model.parameters[parameter].units}].",
            where=name,
        )
    if parameter not in spec.axes:
        instead = [each.name for each in spec.model.substitutes.values() if each.parameter in spec.axes]
        unknown_word(name, (*spec.axes, *instead), spec.model)


def _places(spec: SweepSpec, name: str, raw: Any, word: str, given: Any) -> "float | Array | xr.DataArray":
    """Return the positions along an axis; `word` and `given` are the name and the value in the request."""
    quantity, axis = spec.model.parameters[name], getattr(spec, name)
    pointwise = _is_pointwise(raw)
    given = raw.values if pointwise else given
    value: Value = read_value(np.unique(given) if pointwise else raw, quantity)
    ends = axis.ends()
    values = value if isinstance(value, float) else value.array()
    if np.min(values) < ends[0] or np.max(values) > ends[1]:
        unit = as_given(float(np.max(values)), quantity, given).unit
        raise RequestError(
            f"Values outside the atlas cannot be interpolated: its {name} is "
            f"{limit_in(ends[0], quantity, unit, upper=False)} to {limit_in(ends[1], quantity, unit, upper=True)}.",
            hint=degrees_meant(quantity, word, given, np.atleast_1d(values))
            or "Give values inside, or compute an atlas that contains them.",
            where=f"{word}={shown(given)}",
        )
    return raw.astype(np.float64) if pointwise else values
