"""A selection from an atlas is an atlas: its spec, its attributes and its boundary are made to say so.

``atlas.isel(alpha=0)`` takes cells, and leaves everything else as it was: the spec still asks for all values of alpha,
and the boundary may lie outside the cells that are left.
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

#: Values of a selected axis at most, where they are no range: each is written in the spec.
_MOST_LISTED = 50_000

#: Rounding of a value of a range, as a share of it and of its larger end: the logarithm differs between processors.
_ROUNDING = 1e-12


#: How the title of a dataset begins whose values lie between the cells of an atlas.
BETWEEN = "Between the cells of: "


def is_atlas(dataset: "xr.Dataset") -> bool:
    """Return whether a dataset says that it is an atlas, and has cells."""
    stated = {"eulerdisk_format", "sweep_spec", "criterion", "title"} <= dataset.attrs.keys()
    return stated and "ending" in dataset and "stability" in dataset


def attributes_of(given: object) -> Mapping[str, Any]:
    """Return the attributes of a dataset; none of anything else, the class of datasets among it."""
    found = getattr(given, "attrs", None)
    return found if isinstance(found, Mapping) else {}


def require_atlas(dataset: Any) -> None:
    """Refuse what is no atlas, and say why it is none.

    Raises
    ------
    RequestError
    """
    names = getattr(dataset, "data_vars", None)
    # the class has this name too
    if names is None or isinstance(dataset, type):
        raise RequestError(
            f"An atlas is an xarray.Dataset; got a {type(dataset).__name__}.",
            hint="Give a dataset as sweep.run or sweep.open_atlas returns it.",
        )
    if str(dataset.attrs.get("title", "")).startswith(BETWEEN):
        raise RequestError(
            "This is no stability atlas: it lies between the cells of one, as eulerdisk.interp returns it, and its "
            "values belong to no start.",
            hint="Take the atlas itself, or compute one there; dataset.to_netcdf writes such values.",
        )
    if "sweep_spec" not in dataset.attrs:
        given = printable(", ".join(map(str, names))) or "no variables"
        raise RequestError(
            "This is no stability atlas, which sweep.run and eulerdisk run make, or its attributes are gone: it lacks "
            f"the attribute sweep_spec; got a dataset of {given}.",
            hint="Give an atlas, and keep its attributes (xarray.set_options(keep_attrs=True)).",
            where=place_of(dataset),
        )
    if lost := [name for name in _always_held(dataset) if name not in dataset]:
        raise RequestError(
            f"This is no stability atlas any more: it lacks {', '.join(lost)}, without which it cannot be read.",
            hint="Take the atlas with all its variables; dataset.to_netcdf writes some of them.",
            where=place_of(dataset),
        )


def _always_held(dataset: "xr.Dataset") -> tuple[str, ...]:
    """Return the variables without which no file is read as an atlas."""
    return "ending", "stability", *spec_named(dataset).model.extremes


def check_numbers(dataset: "xr.Dataset") -> None:
    """Refuse an atlas of other things than numbers, or with fractions as flags, as ``interp`` of xarray makes them.

    Raises
    ------
    RequestError
    """
    for name in sorted(known_names(spec_named(dataset)) & {*map(str, dataset.variables)}):
        if (kind := dataset[name].dtype).kind not in "fiu":
            what = "coordinate" if name in dataset.coords else "variable"
            raise RequestError(
                f"The {what} {name} of an atlas must be of numbers, floating point or whole; got the type {kind}.",
                hint=f"Take the atlas as it was, or change it with dataset[{name!r}].astype.",
                where=place_of(dataset),
            )
    for name in ("ending", "stability"):
        if not _is_whole_numbers(dataset, name) and (np.nan_to_num(dataset[name].values) % 1.0).any():
            _no_flags(name)


def _is_whole_numbers(dataset: "xr.Dataset", name: str) -> bool:
    return dataset[name].dtype.kind in "iu"


def _no_flags(name: str) -> NoReturn:
    raise RequestError(
        f"This is no atlas any more: {name} holds codes of flags, whole numbers, and here they have become floats, as "
        "where, mean and interp of xarray make them.",
        hint="Select cells with isel or sel; atlas.eulerdisk.interp takes flags from the nearest cell.",
        where=name,
    )


def selected_spec(dataset: "xr.Dataset") -> SweepSpec:
    """Return the spec of the cells that a dataset holds: that which it states, or of a selection one of its own.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas, or a selection whose axes kept their order and their coordinates; an axis of which one value was
        taken is a scalar.

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
            hint=f"Choose one value of {strange[0]}: dataset.isel({strange[0]}=0, drop=True) in Python.",
            where=place_of(dataset),
        )
    if list(sizes) != [name for name in stated.axes if name in sizes]:
        present = ", ".join(repr(name) for name in stated.axes if name in sizes)
        raise RequestError(
            f"The dimensions must stand in the order of the axes of the spec, {', '.join(stated.axes)}; got "
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
    """Return what a selection has kept of an axis: one number, or some of its values."""
    if axis not in dataset.variables:
        raise RequestError(
            f"This selection has lost the coordinate {axis}, so that it cannot be told which cells it holds.",
            hint="Select without drop=True, or take the whole atlas.",
            where=place_of(dataset),
        )
    found: Array = np.asarray(dataset[axis].values, np.float64)
    if found.ndim != dimension:
        raise RequestError(
            f"The coordinate {axis} of this selection does not belong to its cells: it has the shape {found.shape}.",
            hint="Take the whole atlas, and select from it with isel or sel.",
            where=place_of(dataset),
        )
    if not dimension:
        return float(found)
    if not found.size:
        raise RequestError(
            f"This selection holds no cells: it has no value of {axis} left.",
            hint="Select at least one.",
            where=place_of(dataset),
        )
    if even := _as_range(found):
        return even
    if found.size > _MOST_LISTED:
        raise RequestError(
            f"A selection may hold at most {_MOST_LISTED} values of an axis that are not evenly spaced; got "
            f"{found.size} of {axis}.",
            hint="Take fewer, or the whole axis.",
            where=place_of(dataset),
        )
    try:
        return Values(tuple(found.tolist()))
    except RequestError as error:
        raise error.at(f"{place_of(dataset)}: {axis}") from None


def _as_range(values: Array) -> Range | None:
    """Return the range that has exactly these values, if there is one."""
    for spacing in ("linear", "log"):
        try:
            found = Range(float(values[0]), float(values[-1]), values.size, spacing)
        except (RequestError, IndexError):
            continue
        if np.array_equal(found.array(), values):
            return found
    return None


def _check_coordinates(dataset: "xr.Dataset", stated: SweepSpec) -> None:
    """Refuse a dataset whose cells are not those that its coordinates and its spec say.

    An axis that was not cut has the values of the spec in their order; so has every fixed parameter that is there.
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
    """Refuse a list of starts whose parameters are not those that its spec draws."""
    for span in blocks(spec.size) if spec.listed and not spec.starts else ():
        starts = starts_of(spec, span)
        for name in spec.listed:
            part = dataset[name][span.start : span.stop]
            _check_values(dataset, name, part, starts[name], spec.quantities[name])


def _check_values(
    dataset: "xr.Dataset", name: str, found: "xr.DataArray", expected: Array, quantity: Input
) -> None:
    # computing with xarray drops attributes
    units = found.attrs.get("units", quantity.units)
    if units != quantity.units:
        _other_cells(dataset, name, f"must have the units {quantity.units}; got {units}")
    if found.dtype.kind not in "fiu" or found.shape != expected.shape:
        _other_cells(
            dataset, name, f"must be {expected.size} numbers; got {found.size} of type {found.dtype}"
        )
    stored = np.asarray(found, np.float64)
    # written so that NaN is beyond; a value near 0 inside a range is known to the rounding of its ends
    apart = ~(np.abs(stored - expected) <= _ROUNDING * (np.abs(expected) + np.abs(expected).max()))
    if apart.any():
        first = np.flatnonzero(apart)[0]
        values = f"one of them {stored.flat[first]!r} instead of {expected.flat[first]!r}"
        _other_cells(
            dataset,
            name,
            f"has other values than its spec, or another order of them: {np.count_nonzero(apart)} of {expected.size} "
            f"are others, {values}",
        )


def _other_cells(dataset: "xr.Dataset", name: str, what: str) -> NoReturn:
    raise RequestError(
        f"The coordinate {name} {what}. It cannot be told which cells these are.",
        hint=f"Select with isel or sel, and keep the order of the axes, as by dataset.sortby({name!r}); a damaged file "
        "is made again with eulerdisk run.",
        where=place_of(dataset),
    )


def as_atlas(dataset: "xr.Dataset", trusting: bool = False) -> "xr.Dataset":
    """Return the atlas that a dataset is: itself, or, of a selection, one whose spec asks for its cells alone.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas or a selection from one, see `selected_spec`.
    trusting : bool
        Whether the coordinates of a whole atlas are left to the caller, who checks them. Those of a selection decide
        which cells it holds, and are always checked.

    Returns
    -------
    xarray.Dataset
        The same cells, with the dimensions in the order of the spec; what is no atlas is returned as it is. In a
        selection the boundary is sought again among them (a refined one is bisected again), the attributes state its
        own spec, and `history` what was taken. What another program has left out is made again
        (`sweep.atlas.completion.completed`).

    Raises
    ------
    RequestError
        As from `selected_spec`, or if a coordinate is not that of the spec.
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
    """Return what was kept of an axis; numbers of starts may be many, and one start has none."""
    return shown(str(kept)) if spec.is_list else str(kept) or "one"


def _differ(one: SweepSpec, other: SweepSpec, name: str) -> bool:
    return bool(getattr(one, name) != getattr(other, name))


def _on_grid(variable: "xr.Variable", declared: Declaration, spec: SweepSpec) -> "xr.Variable":
    """Return a variable of the cells with the encoding of its grid, and the attribute that names its axes."""
    found = variable.copy(deep=False)
    found.encoding = encoding_of(declared, spec)
    found.attrs.pop("cell_methods", None)
    found.attrs |= {name: text for name, text in declared.attributes.items() if name == "cell_methods"}
    return found
