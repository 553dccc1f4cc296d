"""How two arrays of one variable differ: bit for bit, and at most over what is allowed."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from sweep.checks.alignment import Pair
from sweep.engine.grid import chunks
from sweep.model.quantity import Array, Truths

if TYPE_CHECKING:
    import xarray as xr

Values = npt.NDArray[Any]


@dataclass(frozen=True)
class Cell:
    """The cell where two atlases differ most over what is allowed.

    Its coordinates [SI], its values, their difference and what is allowed; in words its coordinates, and for flags its
    values.
    """

    where: dict[str, float]
    new: float | None
    reference: float | None
    difference: float | None
    allowed: float
    place: str
    flags: str = ""


def other_bits(new: Values, old: Values) -> Truths:
    """Return where two arrays of one shape differ in any bit; all missing values are alike."""
    if new.dtype != old.dtype or new.dtype.kind not in "biuf":
        return np.asarray(np.full(old.shape, new.dtype != old.dtype) | (new != old))
    words = f"u{new.dtype.itemsize}"
    differ: Truths = np.ascontiguousarray(new).view(words) != np.ascontiguousarray(old).view(words)
    differ = differ.reshape(old.shape)
    if new.dtype.kind == "f" and differ.any():
        differ &= ~(np.isnan(new) & np.isnan(old))
    return differ


def bitwise(new: "xr.DataArray", old: "xr.DataArray") -> bool:
    """Return whether two variables have the same dimensions, the same type and the same bits."""
    alike = new.dims == old.dims and new.shape == old.shape and new.dtype == old.dtype
    return alike and not any(
        other_bits(np.asarray(new[places]), np.asarray(old[places])).any() for _, places in chunks(old.shape)
    )


def share_of(distance: Array, allowed: Array) -> Array:
    """Return differences over what is allowed: infinite where nothing is, 0 where nothing differs or is known."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(distance > 0.0, distance / allowed, 0.0)


@dataclass(frozen=True)
class Judged:
    """Values of one variable of some cells, arrays of shape (n,), in C order from some flat index on.

    `beyond` says which of them differ by more than is allowed, `excused` which of these may, because a borderline cell
    flips, `gaps` which are missing in one atlas alone; `distance` is their absolute difference.
    """

    new: Values
    reference: Values
    beyond: Truths
    excused: Truths
    gaps: Truths
    distance: Array
    allowed: Array


@dataclass(frozen=True)
class _Value:
    """A value that differs: its flat index, both values, their difference, and what is allowed there."""

    place: int
    new: float
    reference: float
    difference: float
    allowed: float


class Differences:
    """What the differences of one variable come to, gathered block by block; blocks without any may be left out.

    Attributes
    ----------
    different, on_edge : int
        Values beyond what is allowed: those that may not be, and those that may because a borderline cell flips.
    largest, allowed : float
        The largest of the other differences, and what is allowed there.
    share : float
        The largest difference over what is allowed.
    """

    def __init__(self) -> None:
        self.different, self.on_edge = 0, 0
        self.largest, self.allowed, self.share = -1.0, 0.0, 0.0
        #: the excess over what is allowed, and the value, of all and of those beyond
        self._most: list[tuple[float, _Value | None]] = [(-1.0, None), (-1.0, None)]

    def add(self, start: int, judged: Judged) -> None:
        """Add the values from a flat index on."""
        beyond = judged.beyond & ~judged.excused
        self.different += int(beyond.sum())
        self.on_edge += int((judged.beyond & judged.excused).sum())
        if not beyond.size:
            return
        distance = np.where(judged.excused | np.isnan(judged.distance), 0.0, judged.distance)
        place = int(np.argmax(distance))
        if distance[place] > self.largest:
            self.largest, self.allowed = float(distance[place]), float(judged.allowed[place])
        share = share_of(distance, judged.allowed)
        self.share = max(self.share, float(share.max()))
        # a value that is missing in one atlas counts as most
        excess = np.where(judged.gaps & ~judged.excused, np.inf, share)
        for number, candidates in enumerate((np.ones_like(beyond), beyond)):
            place = int(np.argmax(np.where(candidates, excess, -1.0)))
            if candidates[place] and excess[place] > self._most[number][0]:
                value = _Value(
                    start + place,
                    float(judged.new[place]),
                    float(judged.reference[place]),
                    float(distance[place]),
                    float(judged.allowed[place]),
                )
                self._most[number] = float(excess[place]), value

    def worst(self, name: str, pair: Pair, flags: Mapping[int, str] | None = None) -> Cell | None:
        """Return the cell with the largest difference over what is allowed, among those beyond if there are any.

        `flags` are the names of the values, if they are codes.
        """
        (excess, anywhere), (_, beyond) = self._most
        found = beyond or (anywhere if excess > 0.0 else None)
        if found is None:
            return None
        values = pair.reference[name]
        places = np.unravel_index(found.place, values.shape) if values.ndim else ()
        where = {
            str(dim): float(pair.reference[dim].values[i]) if dim in pair.reference.coords else float(i)
            for dim, i in zip(values.dims, places, strict=True)
        }
        new, reference, apart = (
            None if np.isnan(value) else value for value in (found.new, found.reference, found.difference)
        )
        named = "" if flags is None else " and ".join(_flag(value, flags) for value in (new, reference))
        return Cell(where, new, reference, apart, found.allowed, _in_words(where, pair), named)


def _flag(value: float | None, flags: Mapping[int, str]) -> str:
    return "missing" if value is None else flags.get(int(value), f"code {value:g}")


def _in_words(where: dict[str, float], pair: Pair) -> str:
    known = pair.spec.model.parameters
    words = (
        f"{dim} {known[dim].spell(value) if dim in known else int(value)}" for dim, value in where.items()
    )
    return ", ".join(words) or "the only one"
