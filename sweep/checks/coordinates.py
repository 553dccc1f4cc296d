"""The coordinates of an atlas against its spec: numbers beside wrong coordinates belong to other cells."""

from typing import TYPE_CHECKING, NoReturn

import numpy as np

from sweep.atlas.dataset import place_of
from sweep.atlas.slices import slices_of
from sweep.engine.grid import blocks, starts_of
from sweep.errors import RequestError
from sweep.model.quantity import Array, Input
from sweep.request.axes import Range, Values
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr

#: Rounding of a value of a range, as a share of its larger end.
_ROUNDING = 1e-15


def check_coordinates(dataset: "xr.Dataset", spec: SweepSpec) -> None:
    """Refuse an atlas whose axes or fixed parameters are not those of its spec.

    Parameters
    ----------
    dataset : xarray.Dataset
    spec : SweepSpec
        The spec that the atlas states.

    Raises
    ------
    RequestError
        If a coordinate is missing, has other units, or holds other values; a parameter that was added later may be
        missing where it has its default.
    """
    for name in (*spec.axes, *spec.fixed):
        quantity = spec.quantities[name]
        value = getattr(spec, name)
        size = len(value) if name in spec.axes else 1
        if name not in dataset.variables:
            if quantity.added_later and np.array_equal(values_of(spec, name), [quantity.default]):
                continue
            _refuse(dataset, name, "is missing")
        found = dataset[name]
        units = found.attrs.get("units")
        if units != quantity.units:
            _refuse(dataset, name, f"must have the units {quantity.units}; got {units}")
        if found.dtype.kind not in "fiu" or found.size != size:
            _refuse(dataset, name, f"must be {size} numbers; got {found.size} of type {found.dtype}")
        _check_values(dataset, quantity, spec)
    _check_starts(dataset, spec)


def _check_starts(dataset: "xr.Dataset", spec: SweepSpec) -> None:
    """Refuse a list whose starts are not those of its spec, up to the rounding that other coordinates may have."""
    for name in spec.listed:
        if name not in dataset.variables:
            _refuse(dataset, name, "is missing")
    for span in blocks(spec.size) if spec.listed else ():
        starts = starts_of(spec, span)
        for name in spec.listed:
            rule, expected = spec.model.parameters[name].tolerance, starts[name]
            stored = np.asarray(dataset[name][span.start : span.stop].values, np.float64)
            # written so that NaN is beyond
            beyond = ~(np.abs(stored - expected) <= rule.absolute + rule.relative * np.abs(expected))
            if beyond.any():
                place = int(np.argmax(beyond))
                _refuse(
                    dataset,
                    name,
                    f"must hold the values of the spec of its file; start {span.start + place} has "
                    f"{float(stored[place])!r} instead of {float(expected[place])!r}",
                )


def values_of(spec: SweepSpec, name: str) -> Array:
    """Return the values of a parameter that is not computed per cell, shape (n,): one, if it is fixed."""
    value = getattr(spec, name)
    return value.array() if isinstance(value, Range | Values) else np.array([float(value)])


def _check_values(dataset: "xr.Dataset", quantity: Input, spec: SweepSpec) -> None:
    name, rule = quantity.name, quantity.tolerance
    held, found = getattr(spec, name), dataset[name]
    ends = held.ends() if isinstance(held, Range | Values) else np.array([float(held)])
    # a value near 0 inside a range is known to the rounding of its ends
    rounding = _ROUNDING * float(np.abs(ends).max())
    wrong, first = 0, ""
    for span, places in slices_of(found.shape):
        expected = held.at(np.arange(span.start, span.stop)) if isinstance(held, Range | Values) else ends
        stored = np.asarray(found[places], np.float64).reshape(-1)
        allowed = rule.absolute + rule.relative * np.abs(expected) + rounding
        # written so that NaN is beyond
        beyond = np.flatnonzero(~(np.abs(stored - expected) <= allowed))
        wrong += beyond.size
        if beyond.size and not first:
            first = f"{float(stored[beyond[0]])!r} instead of {float(expected[beyond[0]])!r}"
    if wrong:
        _refuse(
            dataset,
            name,
            f"must hold the values of the spec of its file; {wrong} of {found.size} are others, the first {first}",
        )


def _refuse(dataset: "xr.Dataset", name: str, what: str) -> NoReturn:
    raise RequestError(
        f"The coordinate {name} {what}. The cells of this atlas cannot be told apart.",
        hint="Make the file again with eulerdisk run, or compare with an undamaged copy.",
        where=place_of(dataset),
    )
