"""How two arrays of one variable differ: bit for bit, and at most over what is allowed."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from sweep.checks.alignment import Pair
from sweep.model.quantity import Array, Truths

if TYPE_CHECKING:
    import xarray as xr

Values = npt.NDArray[Any]


@dataclass(frozen=True)
class Cell:
    """The cell where two atlases differ most over what is allowed.

    Its coordinates [SI], its values, their difference and what is allowed, and its coordinates in words.
    """

    where: dict[str, float]
    new: float | None
    reference: float | None
    difference: float | None
    allowed: float
    place: str


def other_bits(new: Values, old: Values) -> Truths:
    """Return where two arrays of one shape differ in any bit; all missing values are alike."""
    if new.dtype != old.dtype or new.dtype.kind not in "biuf":
        return np.asarray(np.full(old.shape, new.dtype != old.dtype) | (new != old))
    words = f"u{new.dtype.itemsize}"
    differ: Truths = np.ascontiguousarray(new).view(words) != np.ascontiguousarray(old).view(words)
    if new.dtype.kind == "f":
        differ &= ~(np.isnan(new) & np.isnan(old))
    return differ.reshape(old.shape)


def bitwise(new: "xr.DataArray", old: "xr.DataArray") -> bool:
    """Return whether two variables have the same dimensions, the same type and the same bits."""
    alike = new.dims == old.dims and new.shape == old.shape and new.dtype == old.dtype
    return alike and not other_bits(new.values, old.values).any()


def share_of(distance: Array, allowed: Array) -> Array:
    """Return differences over what is allowed: infinite where nothing is, 0 where nothing differs or is known."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(distance > 0.0, distance / allowed, 0.0)


def worst(
    name: str, pair: Pair, beyond: Truths, gaps: Truths, distance: Array, allowed: Array
) -> Cell | None:
    """Return the cell with the largest difference over what is allowed, among those beyond if there are any.

    A value that is missing in one atlas counts as most.
    """
    excess = np.where(gaps, np.inf, share_of(distance, allowed))
    if not beyond.any() and not excess.any():
        return None
    candidates = beyond if beyond.any() else np.ones_like(beyond)
    place = np.unravel_index(int(np.argmax(np.where(candidates, excess, -1.0))), excess.shape)
    dims = [str(dim) for dim in pair.reference[name].dims]
    where = {
        dim: float(pair.reference[dim].values[i]) if dim in pair.reference.coords else float(i)
        for dim, i in zip(dims, place, strict=True)
    }
    new, reference, apart = (
        None if np.isnan(value) else value
        for value in (
            *(float(atlas[name].values[place]) for atlas in (pair.new, pair.reference)),
            float(distance[place]),
        )
    )
    return Cell(where, new, reference, apart, float(allowed[place]), _in_words(where, pair))


def _in_words(where: dict[str, float], pair: Pair) -> str:
    known = pair.spec.model.parameters
    words = (
        f"{dim} {known[dim].spell(value) if dim in known else int(value)}" for dim, value in where.items()
    )
    return ", ".join(words) or "the only one"
