"""Align two atlases on one grid, or refuse them with the reason why they cannot be compared."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from sweep.atlas.dataset import spec_of
from sweep.errors import RequestError
from sweep.model.quantity import Array, Quantity
from sweep.request.axes import Range, Values
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr

#: Settings that change the errors of the measures of a cell and not their meaning.
_STEPPING = ("step", "tolerance")

#: Options that change neither the measures of a cell nor their meaning.
_PRESENTATION = ("title", "boundary", "device")


@dataclass(frozen=True)
class Pair:
    """Two atlases with the same dimensions in the same order and the same cells.

    `cut` names the axes of which only a part is common, `other_steps` the settings of the integration that differ,
    `boundaries` holds the option ``boundary`` of both, `cell_variables` the table of what either has of every cell.
    `spec` is that of the reference, with its whole grid.
    """

    new: "xr.Dataset"
    reference: "xr.Dataset"
    spec: SweepSpec
    axes: tuple[str, ...]
    cut: frozenset[str]
    other_steps: tuple[str, ...]
    boundaries: tuple[str, str]
    cell_variables: Mapping[str, Quantity]
    notes: tuple[str, ...]


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
        If they are of different motions or criteria, or their grids differ.
    """
    specs = spec_of(new), spec_of(reference)
    _check_meaning(*specs)
    axes = tuple(dict.fromkeys((*specs[1].axes, *specs[0].axes)))
    values = {name: (_values(specs[0], name), _values(specs[1], name)) for name in axes}
    places = {name: _matches(*both, specs[0].model.parameters[name]) for name, both in values.items()}
    cut = frozenset(name for name in axes if any(places[name][0].size < each.size for each in values[name]))
    if not common:
        _check_same_grid(specs, axes, cut)
    empty = [name for name, (left, _) in places.items() if not left.size]
    if empty:
        raise RequestError(
            f"The two atlases have no cell in common: no value of {', '.join(empty)} is in both.",
            hint="Compare atlases of overlapping grids.",
        )
    parts = [
        _part(dataset, axes, {name: both[side] for name, both in places.items()})
        for side, dataset in enumerate((new, reference))
    ]
    return Pair(
        new=parts[0],
        reference=parts[1],
        spec=specs[1],
        axes=axes,
        cut=cut,
        other_steps=tuple(name for name in _STEPPING if getattr(specs[0], name) != getattr(specs[1], name)),
        boundaries=(specs[0].boundary, specs[1].boundary),
        cell_variables={
            name: quantity for each in specs for name, quantity in each.model.cell_variables(each).items()
        },
        notes=tuple(
            f"only a part of {name} is common: {places[name][0].size} values" for name in axes if name in cut
        ),
    )


def _check_meaning(new: SweepSpec, reference: SweepSpec) -> None:
    if new.model is not reference.model:
        raise RequestError(
            f"The two atlases are of different models: {new.model.name} and {reference.model.name}.",
            hint="Compare atlases of one model.",
        )
    additions = [name for name, word in new.model.options.items() if not word.decides]
    settled = (*_STEPPING, *_PRESENTATION, *new.model.parameters, *additions)
    fields = [
        name for name in new.words() if name not in settled and getattr(new, name) != getattr(reference, name)
    ]
    for name, quantity in new.model.parameters.items():
        values = getattr(new, name), getattr(reference, name)
        # a parameter that each cell computes for itself is a word
        words = any(isinstance(value, str) for value in values)
        fixed = name not in (*new.axes, *reference.axes)
        if (words and values[0] != values[1]) or (not words and fixed and not _same(*values, quantity)):
            fields.append(name)
    if fields:
        raise RequestError(
            "The two atlases cannot be compared: they must be of the same system, starts, criterion and method, and "
            f"they differ in {_in_words(fields, new, reference)}.",
            hint="Compare with an atlas of the same request (run --from makes one); against exact values, use "
            "eulerdisk verify.",
        )


def _check_same_grid(specs: tuple[SweepSpec, SweepSpec], axes: tuple[str, ...], cut: frozenset[str]) -> None:
    fields = [name for name in axes if name in cut or any(name not in spec.axes for spec in specs)]
    if not fields and specs[0].axes != specs[1].axes:
        fields = ["axes"]
    if fields:
        raise RequestError(
            "The two atlases are not on the same grid: they must have the same axes with the same values, in the same "
            f"order, and they differ in {_in_words(fields, *specs)}.",
            hint="Add --common to compare the cells that both have.",
        )


def _in_words(fields: list[str], new: SweepSpec, reference: SweepSpec) -> str:
    return ", ".join(f"{name} ({getattr(new, name)} and {getattr(reference, name)})" for name in fields)


def _values(spec: SweepSpec, name: str) -> Array:
    value = getattr(spec, name)
    return value.array() if isinstance(value, Range | Values) else np.array([float(value)])


def _same(left: Any, right: Any, quantity: Quantity) -> Any:
    return np.isclose(left, right, rtol=quantity.tolerance.relative, atol=quantity.tolerance.absolute)


def _matches(
    new: Array, reference: Array, quantity: Quantity
) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Return the indices, in each of two increasing arrays, of the values that both have."""
    after = np.searchsorted(new, reference)
    # the match, if there is one, is the neighbour on either side
    left, right = (np.clip(after + shift, 0, new.size - 1) for shift in (-1, 0))
    nearest = np.where(np.abs(new[left] - reference) <= np.abs(new[right] - reference), left, right)
    found = np.flatnonzero(_same(new[nearest], reference, quantity))
    return nearest[found], found


def _part(
    dataset: "xr.Dataset", axes: tuple[str, ...], places: dict[str, npt.NDArray[np.intp]]
) -> "xr.Dataset":
    """Select cells; a parameter that is fixed here and an axis there becomes an axis of one value."""
    cells = dataset.expand_dims([name for name in axes if name not in dataset.dims])
    # curves have dimensions of their own
    return cells.isel(places).transpose(*axes, ...)
