"""The coordinates of an atlas against its spec: numbers beside wrong coordinates belong to other cells."""

from typing import TYPE_CHECKING, NoReturn

import numpy as np

from sweep.atlas.dataset import place_of
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
        quantity = spec.model.parameters[name]
        expected = values_of(spec, name)
        if name not in dataset.variables:
            if quantity.added_later and np.array_equal(expected, [quantity.default]):
                continue
            _refuse(dataset, name, "is missing")
        found = dataset[name]
        units = found.attrs.get("units")
        if units != quantity.units:
            _refuse(dataset, name, f"must have the units {quantity.units}; got {units}")
        if found.dtype.kind not in "fiu" or found.size != expected.size:
            _refuse(dataset, name, f"must be {expected.size} numbers; got {found.size} of type {found.dtype}")
        _check_values(dataset, quantity, np.asarray(found.values, np.float64).reshape(-1), expected)


def values_of(spec: SweepSpec, name: str) -> Array:
    """Return the values of a parameter that is not computed per cell, shape (n,): one, if it is fixed."""
    value = getattr(spec, name)
    return value.array() if isinstance(value, Range | Values) else np.array([float(value)])


def _check_values(dataset: "xr.Dataset", quantity: Input, found: Array, expected: Array) -> None:
    rule = quantity.tolerance
    # a value near 0 inside a range is known to the rounding of its ends
    allowed = rule.absolute + rule.relative * np.abs(expected) + _ROUNDING * np.abs(expected).max()
    # written so that NaN is beyond
    beyond = np.flatnonzero(~(np.abs(found - expected) <= allowed))
    if beyond.size:
        first = int(beyond[0])
        _refuse(
            dataset,
            quantity.name,
            f"must hold the values of the spec of its file; {beyond.size} of {found.size} are others, the first "
            f"{float(found[first])!r} instead of {float(expected[first])!r}",
        )


def _refuse(dataset: "xr.Dataset", name: str, what: str) -> NoReturn:
    raise RequestError(
        f"The coordinate {name} {what}. The cells of this atlas cannot be told apart.",
        hint="Make the file again with eulerdisk run, or compare with an undamaged copy.",
        where=place_of(dataset),
    )
