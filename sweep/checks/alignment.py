"""Alignment of two atlases: the cells that both have."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from sweep.atlas.cf_metadata import spec_attributes
from sweep.atlas.dataset import place_of, spec_of
from sweep.errors import RequestError, counted, shown
from sweep.model.quantity import Array, Quantity
from sweep.request.sources import Range, Values
from sweep.request.spec import SweepSpec
from sweep.request.start_list import START
from sweep.request.start_table import Column, StartTable
from sweep.request.values import both_written

if TYPE_CHECKING:
    import xarray as xr


#: Settings that change the errors of the measures, but not their meaning.
_STEPPING = ("step", "tolerance")

#: Positions of values on an axis: indices or a slice.
_Places = npt.NDArray[np.intp] | slice

#: Options that change neither the measures nor their meaning.
_PRESENTATION = ("title", "boundary", "device")

#: Attributes that `_check_attributes` skips: one in words, and those with the spec, which `_check_meaning` compares.
_SPELLED = ("criterion_meaning", "sweep_spec", "sweep_fingerprint")

#: Options that give the number of starts in a list: its axis already has their numbers.
_EXTENT = ("samples", "start")


class OtherGridError(RequestError):
    """Two atlases are not on the same grid."""


@dataclass(frozen=True)
class Pair:
    """Two atlases with the same dimensions in the same order and the same cells.

    `specs` are their specs, with the whole grids. `cut` names the axes that they share only in part. `cell_variables`
    is the table of the cell variables of either. `in_blocks` is true for an atlas whose cells can be read block by
    block.
    """

    new: "xr.Dataset"
    reference: "xr.Dataset"
    specs: tuple[SweepSpec, SweepSpec]
    axes: tuple[str, ...]
    cut: frozenset[str]
    cell_variables: Mapping[str, Quantity]
    notes: tuple[str, ...]
    in_blocks: tuple[bool, bool]

    @property
    def spec(self) -> SweepSpec:
        """The spec of the reference."""
        return self.specs[1]

    @property
    def boundaries(self) -> tuple[str, str]:
        """The option ``boundary`` of both atlases."""
        return self.specs[0].boundary, self.specs[1].boundary

    @property
    def other_errors(self) -> str:
        """The reason why integration errors and step counts may differ; empty if they must be equal."""
        differing = [
            name for name in _STEPPING if getattr(self.specs[0], name) != getattr(self.specs[1], name)
        ]
        if differing:
            return f"{', '.join(differing)} differ"
        same = self.new.attrs.get("kernel_hash") == self.reference.attrs.get("kernel_hash")
        return "" if same else "the kernels differ"


def align(new: "xr.Dataset", reference: "xr.Dataset", *, common: bool) -> Pair:
    """Select the cells that two atlases have in common.

    Parameters
    ----------
    new, reference : xarray.Dataset
    common : bool
        Whether the grids may differ.

    Raises
    ------
    RequestError
        If their motions or criteria differ, or if their grids differ without `common`.
    """
    specs = spec_of(new), spec_of(reference)
    _check_meaning(*specs)
    for dataset, spec in zip((new, reference), specs, strict=True):
        _check_attributes(dataset, spec)
    axes = tuple(dict.fromkeys((*specs[1].axes, *specs[0].axes)))
    places = {name: _places(specs, name) for name in axes}
    cut = frozenset(name for name, each in places.items() if each.cut)
    if not common:
        _check_same_grid(specs, axes, cut)
    empty = [name for name, each in places.items() if not each.count]
    if empty:
        raise RequestError(
            f"The two atlases have no cell in common: no value of {', '.join(empty)} is in both.",
            hint="Compare atlases of overlapping grids.",
        )
    parts = [
        _part(dataset, spec, axes, {name: each.of[side] for name, each in places.items()})
        for side, (dataset, spec) in enumerate(zip((new, reference), specs, strict=True))
    ]
    # netCDF reads scattered indices one by one; transposed axes need the whole variable
    in_blocks = [
        _is_in_order(dataset, axes) and all(isinstance(each.of[side], slice) for each in places.values())
        for side, dataset in enumerate((new, reference))
    ]
    return Pair(
        new=parts[0],
        reference=parts[1],
        specs=specs,
        axes=axes,
        cut=cut,
        cell_variables={**specs[0].model.cell_variables(specs[0]), **specs[1].model.cell_variables(specs[1])},
        notes=tuple(
            f"only part of {name} is common: {counted(places[name].count, 'value')}"
            for name in axes
            if name in cut
        ),
        in_blocks=(in_blocks[0], in_blocks[1]),
    )


def _check_meaning(new: SweepSpec, reference: SweepSpec) -> None:
    if new.model != reference.model:
        names = new.model.name, reference.model.name
        what = (
            f"models: {names[0]} and {names[1]}"
            if names[0] != names[1]
            else f"systems, both called {names[0]}"
        )
        raise RequestError(
            f"The two atlases are of different {what}.",
            hint="Compare atlases of one model, or of one system.",
        )
    if new.is_list != reference.is_list:
        raise RequestError(
            "A list of starts cannot be compared with a grid.",
            hint="Compare two lists, or two grids.",
        )
    additions = [name for name, word in new.model.options.items() if not word.decides]
    elsewhere = ("starts", *_STEPPING, *_PRESENTATION, *_EXTENT, *new.model.parameters, *additions)
    fields = [
        name
        for name in new.words()
        if name not in elsewhere and getattr(new, name) != getattr(reference, name)
    ]
    if not _same_tables(new, reference):
        fields.append("starts")
    for name, quantity in new.model.parameters.items():
        values = getattr(new, name), getattr(reference, name)
        # a parameter computed per cell is a word
        words = any(isinstance(value, str) for value in values)
        fixed = name not in (*new.axes, *reference.axes)
        if name in (*new.listed, *reference.listed):
            # columns were compared as part of their tables
            if values[0] != values[1] and not all(isinstance(value, Column) for value in values):
                fields.append(name)
        elif (words and values[0] != values[1]) or (not words and fixed and not _same(*values, quantity)):
            fields.append(name)
    if fields:
        raise RequestError(
            "The two atlases cannot be compared: they must have the same system, starts, criterion and method, but "
            f"they differ in {_in_words(fields, new, reference)}.",
            hint="Compare with an atlas of the same request (run --from makes one). To check against exact values, use "
            "eulerdisk verify.",
        )


def _check_attributes(dataset: "xr.Dataset", spec: SweepSpec) -> None:
    """Refuse an atlas whose attributes contradict the numbers, units, method or criterion of its spec."""
    for name, value in spec_attributes(spec).items():
        if name in dataset.attrs and name not in _SPELLED and str(dataset.attrs[name]) != str(value):
            raise RequestError(
                f"The attribute {name} of this atlas contradicts its spec: it is {shown(dataset.attrs[name])}, but the "
                f"cells were computed with {value}.",
                hint="Use an undamaged copy, or recompute it. eulerdisk verify reports other changes.",
                where=place_of(dataset),
            )


def _same_tables(new: SweepSpec, reference: SweepSpec) -> bool:
    """Return whether two specs have the same kind of table, with equal values in the starts that both have."""
    tables = new.starts, reference.starts
    if tables[0] == tables[1] or not all(isinstance(each, StartTable) for each in tables):
        return bool(tables[0] == tables[1])
    if tables[0].names != tables[1].names:
        return False
    places = _matches(_values_of(new, START.name), _values_of(reference, START.name), START)
    return all(
        np.array_equal(*(table.values(name)[each] for table, each in zip(tables, places, strict=True)))
        for name in tables[0].names
    )


def _check_same_grid(specs: tuple[SweepSpec, SweepSpec], axes: tuple[str, ...], cut: frozenset[str]) -> None:
    fields = [name for name in axes if name in cut or any(name not in spec.axes for spec in specs)]
    if not fields and specs[0].axes != specs[1].axes:
        fields = ["axes"]
    if fields:
        raise OtherGridError(
            "The two atlases are not on the same grid: they must have the same axes with the same values, in the same "
            f"order, but they differ in {_in_words(fields, *specs)}.",
            hint="Add --common (in Python common=True) to compare the cells that both have.",
        )


def _in_words(fields: list[str], new: SweepSpec, reference: SweepSpec) -> str:
    return ", ".join(f"{name} ({' and '.join(both_written((new, reference), name))})" for name in fields)


def _same(left: Any, right: Any, quantity: Quantity) -> Any:
    return np.isclose(left, right, rtol=quantity.tolerance.relative, atol=quantity.tolerance.absolute)


@dataclass(frozen=True)
class _Common:
    """The common values of a parameter in two atlases: their positions in each atlas, and their number.

    `cut` is true if either atlas has further values.
    """

    of: tuple[_Places, _Places]
    count: int
    cut: bool


def _places(specs: tuple[SweepSpec, SweepSpec], name: str) -> _Common:
    held = [getattr(spec, name) for spec in specs]
    if held[0] == held[1] and isinstance(held[0], Range | Values):
        # avoids making the arrays of long axes
        return _Common((slice(None), slice(None)), len(held[0]), False)
    values = _values_of(specs[0], name), _values_of(specs[1], name)
    found = _matches(*values, {**specs[0].quantities, **specs[1].quantities}[name])
    count = found[0].size
    return _Common(
        (_as_slice(found[0]), _as_slice(found[1])), count, any(count < each.size for each in values)
    )


def _values_of(spec: SweepSpec, name: str) -> Array:
    """Return the values of a parameter that is not computed per cell, shape (n,); n is 1 if it is fixed."""
    value = getattr(spec, name)
    return value.array() if isinstance(value, Range | Values) else np.array([float(value)])


def _as_slice(places: npt.NDArray[np.intp]) -> _Places:
    """Return increasing positions as a slice if evenly spaced: cells in a slice can be read in blocks."""
    steps = np.diff(places)
    if not places.size or (steps != steps[:1]).any():
        return places
    return slice(int(places[0]), int(places[-1]) + 1, int(steps[0]) if steps.size else 1)


def _matches(
    new: Array, reference: Array, quantity: Quantity
) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Return the indices of the common values in each of two increasing arrays."""
    after = np.searchsorted(new, reference)
    # a match can only be the neighbor on either side
    left, right = (np.clip(after + shift, 0, new.size - 1) for shift in (-1, 0))
    nearest = np.where(np.abs(new[left] - reference) <= np.abs(new[right] - reference), left, right)
    found = np.flatnonzero(_same(new[nearest], reference, quantity))
    return nearest[found], found


def _is_in_order(dataset: "xr.Dataset", axes: tuple[str, ...]) -> bool:
    """Return whether an atlas has all axes, and each of its variables has them in the order of `axes`."""
    in_order = all(
        tuple(name for name in each.dims if name in axes) == tuple(name for name in axes if name in each.dims)
        for each in dataset.variables.values()
    )
    return in_order and set(axes) <= set(dataset.dims)


def _part(
    dataset: "xr.Dataset", spec: SweepSpec, axes: tuple[str, ...], places: Mapping[str, _Places]
) -> "xr.Dataset":
    """Select cells; turn a parameter that is fixed here but an axis in the other atlas into an axis of one value."""
    # other tools drop the attribute that says which variables are coordinates
    dataset = dataset.set_coords([name for name in spec.fixed if name in dataset.data_vars])
    cells = dataset.expand_dims([name for name in axes if name not in dataset.dims])
    # the ellipsis stands for the dimensions of curves
    return cells.isel(places).transpose(*axes, ...)
