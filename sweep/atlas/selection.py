"""Selections from an atlas as atlases, with a new spec, new attributes and a new boundary.

``atlas.isel(alpha=0)`` selects cells and leaves everything else unchanged: the spec still has all values of alpha, and
the boundary may lie outside the selected cells.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from sweep.atlas.cf_metadata import (
    Declaration,
    cell_declarations,
    created,
    spec_attributes,
)
from sweep.atlas.completion import completed, is_complete, without_boundary
from sweep.atlas.dataset import as_variable, coordinates, edge_variables, encoding_of, place_of, spec_named
from sweep.atlas.structure import known_names
from sweep.engine.grid import blocks, starts_of
from sweep.errors import RequestError, printable, shown
from sweep.model.quantity import Array, Input
from sweep.request.sources import Range, Values
from sweep.request.spec import SweepSpec
from sweep.request.start_list import START, WORDS
from sweep.request.start_table import StartTable

if TYPE_CHECKING:
    import xarray as xr

#: Largest number of values of a selected axis that is not a range: each value is written in the spec.
_MOST_LISTED = 50_000

#: Allowed rounding of a value of a range, relative to it and to the larger end: logarithms differ between processors.
_ROUNDING = 1e-12


#: Attribute of a dataset that was interpolated between the cells of an atlas: the fingerprint of its spec.
INTERPOLATED = "interpolated_from"


def is_atlas(dataset: "xr.Dataset") -> bool:
    """Return whether a dataset has the attributes of an atlas, and cells."""
    stated = {"eulerdisk_format", "sweep_spec", "criterion", "title"} <= dataset.attrs.keys()
    return stated and "ending" in dataset and "stability" in dataset


def attributes_of(given: object) -> Mapping[str, Any]:
    """Return the attributes of a dataset; empty for anything else, even for the class of datasets."""
    attributes = getattr(given, "attrs", None)
    return attributes if isinstance(attributes, Mapping) else {}


def require_atlas(dataset: Any) -> None:
    """Refuse an object that is not an atlas, and report why.

    Raises
    ------
    RequestError
    """
    names = getattr(dataset, "data_vars", None)
    # the class has this attribute too
    if names is None or isinstance(dataset, type):
        raise RequestError(
            f"An atlas is an xarray.Dataset; got a {type(dataset).__name__}.",
            hint="Give a dataset from sweep.run or sweep.open_atlas.",
        )
    if INTERPOLATED in dataset.attrs:
        raise RequestError(
            "This is not a stability atlas: eulerdisk.interp interpolated it between the cells of one.",
            hint="Use the atlas itself, or compute one there; dataset.to_netcdf saves interpolated values.",
        )
    if "sweep_spec" not in dataset.attrs:
        given = printable(", ".join(map(str, names))) or "no variables"
        raise RequestError(
            "This is not a stability atlas from sweep.run or eulerdisk run, or its attributes were lost: the attribute "
            f"sweep_spec is missing; got a dataset of {given}.",
            hint="Give an atlas, and keep its attributes (xarray.set_options(keep_attrs=True)).",
            where=place_of(dataset),
        )
    if lost := [name for name in _always_held(dataset) if name not in dataset]:
        raise RequestError(
            f"This is no longer a stability atlas: it lacks {', '.join(lost)}.",
            hint="Use the atlas with all its variables; dataset.to_netcdf saves some of them.",
            where=place_of(dataset),
        )


def _always_held(dataset: "xr.Dataset") -> tuple[str, ...]:
    """Return the variables that every atlas must have."""
    return "ending", "stability", *spec_named(dataset).model.extremes


def check_numbers(dataset: "xr.Dataset") -> None:
    """Refuse an atlas with values that are not numbers, or with fractional flags, as from xarray's ``interp``.

    Raises
    ------
    RequestError
    """
    for name in sorted(known_names(spec_named(dataset)) & {*map(str, dataset.variables)}):
        if (kind := dataset[name].dtype).kind not in "fiu":
            what = "coordinate" if name in dataset.coords else "variable"
            raise RequestError(
                f"The {what} {name} of an atlas must contain floating-point or whole numbers; got the type {kind}.",
                hint=f"Use the original atlas, or convert it with dataset[{name!r}].astype.",
                where=place_of(dataset),
            )
    for name in ("ending", "stability"):
        if not _is_whole_numbers(dataset, name) and (np.nan_to_num(dataset[name].values) % 1.0).any():
            _no_flags(name)


def _is_whole_numbers(dataset: "xr.Dataset", name: str) -> bool:
    return dataset[name].dtype.kind in "iu"


def _no_flags(name: str) -> NoReturn:
    raise RequestError(
        f"This is no longer an atlas: the codes in {name} must be whole numbers and have become floats, as after "
        "where, mean or interp of xarray.",
        hint="Select cells with isel or sel; atlas.eulerdisk.interp takes flags from the nearest cell.",
        where=name,
    )


def selected_spec(dataset: "xr.Dataset") -> SweepSpec:
    """Return the spec of the cells of a dataset: the stated spec of an atlas, or a new spec for a selection.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas, or a selection whose axes kept their order and their coordinates. An axis with one selected value is
        a scalar.

    Raises
    ------
    RequestError
        If the spec cannot be read, a coordinate is missing, or values of an axis do not increase.
    """
    stated = spec_named(dataset)
    cells = dataset["ending"]
    sizes = dict(zip(cells.dims, cells.shape, strict=True))
    if strange := [str(name) for name in sizes if name not in stated.axes]:
        raise RequestError(
            f"The dimensions must be axes of the spec, {', '.join(stated.axes)}; got {', '.join(map(str, sizes))}.",
            hint=f"Select one value of {strange[0]}: dataset.isel({strange[0]}=0, drop=True) in Python.",
            where=place_of(dataset),
        )
    if list(sizes) != [name for name in stated.axes if name in sizes]:
        present = ", ".join(repr(name) for name in stated.axes if name in sizes)
        raise RequestError(
            f"The dimensions must be in the order of the axes of the spec, {', '.join(stated.axes)}; got "
            f"{', '.join(map(str, sizes))}.",
            hint=f"Use dataset.transpose({present}, ...) in Python.",
            where=place_of(dataset),
        )
    cut = [name for name in stated.axes if sizes.get(name) != len(getattr(stated, name))]
    if not cut:
        return stated
    kept: dict[str, Any] = {name: _kept(dataset, name, name in sizes) for name in cut}
    try:
        if stated.is_list and not sizes:
            return _one_start(stated, dataset)
        if stated.starts:
            columns = {name: np.asarray(dataset[name].values, np.float64) for name in stated.listed}
            kept = {"starts": StartTable.of(columns, kept[START.name])}
        return stated.replace(**kept)
    except RequestError as error:
        raise error.at(place_of(dataset)) from None


def _one_start(stated: SweepSpec, dataset: "xr.Dataset") -> SweepSpec:
    """Return the spec of one start of a list: a single cell, whose parameters are all numbers."""
    words = {name: value for name, value in stated.words().items() if name not in WORDS}
    numbers = {name: float(dataset[name].values) for name in stated.listed}
    return SweepSpec(**{"model": stated.model, **words, **numbers})


def _kept(dataset: "xr.Dataset", axis: str, dimension: bool) -> float | Range | Values:
    """Return the selected part of an axis: one number, or some of its values."""
    if axis not in dataset.variables:
        raise RequestError(
            f"This selection has lost the coordinate {axis}, so its cells cannot be identified.",
            hint="Select without drop=True, or use the whole atlas.",
            where=place_of(dataset),
        )
    found: Array = np.asarray(dataset[axis].values, np.float64)
    if found.ndim != dimension:
        raise RequestError(
            f"The coordinate {axis} of this selection does not belong to its cells: it has the shape {found.shape}.",
            hint="Select from the whole atlas with isel or sel.",
            where=place_of(dataset),
        )
    if not dimension:
        return float(found)
    if not found.size:
        raise RequestError(
            f"This selection has no cells: no value of {axis} is left.",
            hint="Select at least one value.",
            where=place_of(dataset),
        )
    if even := _as_range(found):
        return even
    if found.size > _MOST_LISTED:
        raise RequestError(
            f"A selection may have at most {_MOST_LISTED} values of an axis that are not evenly spaced; got "
            f"{found.size} of {axis}.",
            hint="Select fewer, or the whole axis.",
            where=place_of(dataset),
        )
    try:
        return Values(tuple(found.tolist()))
    except RequestError as error:
        raise error.at(f"{place_of(dataset)}: {axis}") from None


def _as_range(values: Array) -> Range | None:
    """Return the range with exactly these values, if there is one."""
    for spacing in ("linear", "log"):
        try:
            found = Range(float(values[0]), float(values[-1]), values.size, spacing)
        except (RequestError, IndexError):
            continue
        if np.array_equal(found.array(), values):
            return found
    return None


def _check_coordinates(dataset: "xr.Dataset", stated: SweepSpec) -> None:
    """Refuse a dataset whose coordinates contradict its spec.

    Uncut axes must have the values of the spec in their order, and fixed parameters, if present, its values.
    """
    sizes = dict(zip(dataset["ending"].dims, dataset["ending"].shape, strict=True))
    for declared, expected in coordinates(stated):
        name = declared.name
        if declared.dims and sizes.get(name) != expected.size:
            continue
        if name in dataset.variables:
            _check_values(dataset, name, dataset[name], expected, stated.quantities[name])
        elif declared.dims:
            _other_cells(dataset, name, "is missing")


def _check_starts(dataset: "xr.Dataset", spec: SweepSpec) -> None:
    """Refuse a list of starts whose parameters differ from those that its spec draws."""
    for span in blocks(spec.size) if spec.listed and not spec.starts else ():
        starts = starts_of(spec, span)
        for name in spec.listed:
            part = dataset[name][span.start : span.stop]
            _check_values(dataset, name, part, starts[name], spec.quantities[name])


def _check_values(
    dataset: "xr.Dataset", name: str, found: "xr.DataArray", expected: Array, quantity: Input
) -> None:
    # xarray drops attributes in computations
    units = found.attrs.get("units", quantity.units)
    if units != quantity.units:
        _other_cells(dataset, name, f"must have the units {quantity.units}; got {units}")
    if found.dtype.kind not in "fiu" or found.shape != expected.shape:
        _other_cells(
            dataset, name, f"must be {expected.size} numbers; got {found.size} of type {found.dtype}"
        )
    stored = np.asarray(found, np.float64)
    # NaN counts as different; near 0, a value inside a range has the rounding of its ends
    apart = ~(np.abs(stored - expected) <= _ROUNDING * (np.abs(expected) + np.abs(expected).max()))
    if apart.any():
        first = np.flatnonzero(apart)[0]
        values = f"one of them {stored.flat[first]!r} instead of {expected.flat[first]!r}"
        _other_cells(
            dataset,
            name,
            f"has other values than its spec, or another order: {np.count_nonzero(apart)} of {expected.size} differ, "
            f"{values}",
        )


def _other_cells(dataset: "xr.Dataset", name: str, what: str) -> NoReturn:
    raise RequestError(
        f"The coordinate {name} {what}. The cells cannot be identified.",
        hint=f"Select with isel or sel, and keep the order of the axes, as with dataset.sortby({name!r}). If the file "
        "is damaged, compute it again with eulerdisk run.",
        where=place_of(dataset),
    )


def as_atlas(dataset: "xr.Dataset", trusting: bool = False) -> "xr.Dataset":
    """Return a dataset as an atlas: an atlas unchanged, a selection with a spec for only its cells.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas or a selection from one, see `selected_spec`.
    trusting : bool
        Whether the caller checks the coordinates of a whole atlas. The coordinates of a selection decide which cells
        it has, and are always checked.

    Returns
    -------
    xarray.Dataset
        The same cells, with the dimensions in the order of the spec; a dataset that is not an atlas is returned
        unchanged. For a selection, the boundary is searched again among its cells (and bisected again if it was
        refined), the attributes state its own spec, and `history` what was selected. Parts that another program has
        dropped are restored (`sweep.atlas.completion.completed`).

    Raises
    ------
    RequestError
        As from `selected_spec`, or if a coordinate contradicts the spec.
    """
    import xarray as xr

    if not is_atlas(dataset):
        return dataset
    check_numbers(dataset)
    stated, dims = spec_named(dataset), dataset["ending"].dims
    order = [name for name in stated.axes if name in dims]
    if len(order) == len(dims) and tuple(order) != dims:
        dataset = dataset.transpose(*order, ...)
    spec = selected_spec(dataset)
    if spec != stated or not trusting:
        _check_coordinates(dataset, stated)
        _check_starts(dataset, spec)
    if spec == stated and is_complete(dataset, spec):
        return dataset
    for name in ("ending", "stability"):
        if not _is_whole_numbers(dataset, name):
            _no_flags(name)
    if spec == stated:
        return completed(dataset, spec)
    if stated.is_list and not spec.is_list:
        dataset = dataset.drop_vars(START.name)
    cells = without_boundary(dataset)
    values = {
        each.name: _on_grid(cells[each.name].variable, each, spec)
        for each in cell_declarations(spec)
        if each.name in cells
    }
    listed = {name: values.pop(name) for name in spec.listed}
    edges = edge_variables(spec, np.asarray(dataset["stability"].values))
    held: dict[str, xr.Variable] = listed | {
        each.name: as_variable(each, found, spec) for each, found in coordinates(spec)
    }
    title = dataset.attrs.get("title")
    changed = (name for name in stated.axes if name not in spec.axes or _differ(stated, spec, name))
    taken = (f"{name}={_in_history(getattr(spec, name), spec)}" for name in changed)
    found = cells.assign(values | edges).assign_coords(held)
    found.attrs |= {
        "title": spec.headline if title == stated.headline else title,
        **spec_attributes(spec),
        "history": f"{dataset.attrs.get('history', '')}\n{created()} selected {', '.join(taken)}".lstrip(
            "\n"
        ),
    }
    return found


def _in_history(kept: object, spec: SweepSpec) -> str:
    """Return the selected part of an axis for the history, shortened for a list; one start has no numbers."""
    return shown(str(kept)) if spec.is_list else str(kept) or "one"


def _differ(one: SweepSpec, other: SweepSpec, name: str) -> bool:
    return bool(getattr(one, name) != getattr(other, name))


def _on_grid(variable: "xr.Variable", declared: Declaration, spec: SweepSpec) -> "xr.Variable":
    """Return a variable of the cells with the encoding and the `cell_methods` attribute of its grid."""
    found = variable.copy(deep=False)
    found.encoding = encoding_of(declared, spec)
    found.attrs.pop("cell_methods", None)
    found.attrs |= {name: text for name, text in declared.attributes.items() if name == "cell_methods"}
    return found
