"""A check of the structure of an atlas file, made once so that readers can rely on it.

The variables must have the dimensions, types, units and flags of the spec. Values are not checked, except those of
coordinates. A selection from an atlas also passes: an axis may be shorter, or a scalar.
"""

import itertools
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from sweep.atlas.cf_metadata import (
    CURVES,
    EDGES,
    POINTS,
    Declaration,
    cell_declarations,
    curve_declarations,
    edge_declarations,
)
from sweep.errors import RequestError, counted, printable, shown
from sweep.model.quantity import Array, Quantity
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr

#: Global attributes that must be text, if present.
_TEXTS = (
    "title",
    "summary",
    "history",
    "requested_as",
    "source",
    "criterion",
    "method",
    "sweep_fingerprint",
    "kernel_hash",
    "versions",
)

#: Attributes that xarray moves to the encoding of packed variables; an atlas has no packed variables.
_PACKED = ("scale_factor", "add_offset")

#: Kinds of coordinate types, in words.
_KINDS = {"f": "floating-point numbers", "i": "whole numbers"}

#: Largest number of problems that a message names.
_MOST_NAMED = 3


def check_structure(dataset: "xr.Dataset", spec: SweepSpec, place: str) -> None:
    """Refuse a dataset that does not have the structure of the atlas of a spec, or of a selection from it.

    Parameters
    ----------
    dataset : xarray.Dataset
        With the variables ``ending`` and ``stability``, and without variables that no atlas has.
    spec : SweepSpec
        The spec that the dataset states.
    place : str
        The name of the dataset in messages.

    Raises
    ------
    RequestError
        With the problems.
    """
    problems = list(_grid_problems(dataset, spec))
    # the other checks rely on the grid
    problems = problems or [*_variable_problems(dataset, spec), *_attribute_problems(dataset)]
    if problems:
        more = f"; and {len(problems) - _MOST_NAMED} more" if len(problems) > _MOST_NAMED else ""
        raise RequestError(
            "The file does not have the structure of the atlas in its sweep_spec: "
            f"{'; '.join(problems[:_MOST_NAMED])}{more}.",
            hint="Compute it again with eulerdisk run, or use a copy that no other program has changed.",
            where=place,
        )


def _grid_problems(dataset: "xr.Dataset", spec: SweepSpec) -> Iterator[str]:
    dims = dataset["ending"].dims
    if len(set(dims)) < len(dims) or not set(dims) <= set(spec.axes):
        yield f"the dimensions of ending must be axes, of {_listed(spec.axes)}; got {_listed(dims)}"
        return
    for name in spec.axes:
        if name not in dataset.variables:
            yield f"the coordinate {name} is missing"
        elif problem := _coordinate_problem(
            dataset[name], (name,) if name in dims else (), spec.quantities[name]
        ):
            yield f"the coordinate {name} {problem}"
    for name in spec.fixed:
        if name in dataset.variables and (
            problem := _coordinate_problem(dataset[name], (), spec.quantities[name])
        ):
            yield f"the coordinate {name} {problem}"


def _coordinate_problem(
    found: "xr.DataArray | xr.Variable", dims: tuple[str, ...], quantity: Quantity
) -> str:
    if found.dims != dims:
        return f"must have the dimensions {_listed(dims)}; got {_listed(found.dims)}"
    kind = np.dtype(quantity.dtype).kind
    if found.dtype.kind != kind:
        return f"must be {_KINDS[kind]}; got {found.dtype}"
    values: Array = np.atleast_1d(np.asarray(found[...], np.float64))
    with np.errstate(invalid="ignore"):
        steps = np.diff(values)
    if not values.size or not np.isfinite(values).all():
        return "must be finite and increasing"
    if steps.size and (steps < 0.0).all():
        return f"decreases and must increase: use dataset.sortby({dims[0]!r}) in Python"
    return "" if (steps > 0.0).all() else "must be finite and increasing"


def known_names(spec: SweepSpec) -> set[str]:
    """Return the names of all variables that an atlas of a spec may have."""
    groups = [cell_declarations(spec), *_groups(spec)]
    return {each.name for group in groups for each in group} | {*spec.quantities}


def strangers(dataset: "xr.Dataset", spec: SweepSpec) -> dict[str, str]:
    """Return the variables that no atlas has and that do not fit its cells: name -> problem.

    Parameters
    ----------
    dataset : xarray.Dataset
        With the variable ``ending``.
    spec : SweepSpec
        The spec that the dataset states.
    """
    known, grid = known_names(spec), dataset["ending"].dims
    problems = {
        str(name): _stray(found, grid) for name, found in dataset.variables.items() if name not in known
    }
    return {name: problem for name, problem in problems.items() if problem}


def _groups(spec: SweepSpec) -> list[Sequence[Declaration]]:
    """Return the declarations of the boundaries in groups; an atlas has all variables of a group or none."""
    if spec.is_list:
        return []
    edges = [edge_declarations(spec, axis, edge) for axis in spec.model.controls(spec.axes) for edge in EDGES]
    return [*edges, [*itertools.chain(*curve_declarations(spec))]]


def _variable_problems(dataset: "xr.Dataset", spec: SweepSpec) -> Iterator[str]:
    grid = dataset["ending"].dims
    declared = {each.name: each for each in cell_declarations(spec)}
    for group in _groups(spec):
        declared |= {each.name: each for each in group}
        names = [each.name for each in group]
        present = [name in dataset for name in names]
        if any(present) and not all(present):
            yield f"{names[present.index(False)]} is missing, but {names[present.index(True)]} is present"
    for name, found in dataset.variables.items():
        # all other variables are parameters, which are coordinates
        if name in declared and (problem := _unlike(found, declared[name], grid, spec)):
            yield f"{name} {problem}"
    if "curve_point_count" in dataset:
        yield from _curve_problems(dataset)


def _unlike(
    found: "xr.DataArray | xr.Variable", declared: Declaration, grid: tuple[Any, ...], spec: SweepSpec
) -> str:
    """Return how a variable differs from its declaration; empty if it does not."""
    # a selection lacks the dimensions of axes with one selected value
    dims = {name for name in declared.dims if name in grid or name not in spec.axes}
    if set(found.dims) != dims or len(found.dims) != len(dims):
        return f"must have the dimensions {_listed(dims)}; got {_listed(found.dims)}"
    if found.dtype.kind not in ("f" if declared.dtype.startswith("f") else "iu"):
        return f"must be of type {declared.dtype}; got {found.dtype}"
    if packed := [name for name in _PACKED if name in found.encoding]:
        return f"must not be packed; got {_listed(packed)}"
    if _has_two_fills(found):
        return "must have no missing_value other than its _FillValue"
    units = declared.attributes.get("units")
    if units is not None and found.attrs.get("units") != units:
        return f"must be in {units}; got {shown(found.attrs.get('units', 'no units'))}"
    return _flag_problem(found, "flag_values" in declared.attributes)


def _has_two_fills(found: "xr.DataArray | xr.Variable") -> bool:
    """Return whether a variable has a missing_value that differs from its _FillValue; CDO adds an equal one."""
    encoding = found.encoding
    if "missing_value" not in encoding:
        return False
    return "_FillValue" not in encoding or not np.array_equal(
        encoding["_FillValue"], encoding["missing_value"]
    )


def _stray(found: "xr.DataArray | xr.Variable", grid: tuple[Any, ...]) -> str:
    """Return why a variable that no atlas has does not fit the cells; empty if it does."""
    if len(set(found.dims)) < len(found.dims) or not set(found.dims) <= {*grid, CURVES, POINTS}:
        return f"has dimensions that are not axes of the cells: {_listed(found.dims)}"
    if found.dtype.kind not in "iufb":
        return f"must be numbers; got {found.dtype}"
    return _flag_problem(found, False)


def _flag_problem(found: "xr.DataArray | xr.Variable", needed: bool) -> str:
    meanings, values = found.attrs.get("flag_meanings"), found.attrs.get("flag_values")
    if meanings is None and values is None and not needed:
        return ""
    codes = np.atleast_1d(np.asarray(values))
    words = meanings.split() if isinstance(meanings, str) else []
    if codes.dtype.kind in "iu" and codes.ndim == 1 and codes.size == len(words) == len(set(codes.tolist())):
        return ""
    return "must have whole numbers as flag_values, and as many words in flag_meanings"


def _curve_problems(dataset: "xr.Dataset") -> Iterator[str]:
    counts = dataset["curve_point_count"]
    points = dataset.sizes.get(POINTS, 0)
    if counts.dims == (CURVES,) and counts.dtype.kind in "iu":
        numbers = np.asarray(counts[...])
        # summed as floats, because 64-bit integers could overflow
        if not (numbers > 0).all() or numbers.sum(dtype=np.float64) != points:
            yield f"curve_point_count must add up to the {counted(points, 'point')} of the curves"


def _attribute_problems(dataset: "xr.Dataset") -> Iterator[str]:
    for name in _TEXTS:
        found = dataset.attrs.get(name, "")
        if not isinstance(found, str):
            yield f"the attribute {name} must be text; got {shown(found)}"


def _listed(names: Any) -> str:
    return shown(printable(", ".join(sorted(map(str, names))))) or "none"
