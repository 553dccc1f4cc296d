"""Counts of values that differ by more than is allowed, with the first and the worst value."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.model.quantity import Array, Truths

#: Number of wrong values to name.
MOST_NAMED = 3

Values = npt.NDArray[Any]


@dataclass(frozen=True)
class Worst:
    """The worst value: its flat index, its difference, the allowed difference, and their ratio.

    `beyond` is true if the difference is too large. The ratio is infinite if a value is missing or no difference is
    allowed. `values` are the two differing values, if given.
    """

    beyond: bool
    ratio: float
    place: int
    difference: float
    allowed: float
    values: tuple[float, ...] = ()


class Tally:
    """Results of a comparison of values, added part by part.

    Parameters
    ----------
    share : float
        Share of the judged values that may exceed the allowed difference.

    Attributes
    ----------
    judged, beyond, excused : int
        Numbers of values compared, wrong, and excused. Wrong and excused values exceed the allowed difference.
    unknown : int
        Number of values without an expected value.
    first : list of int
        Flat indices of the first wrong values.
    largest, allowed, ratio : float
        If values were given: the largest difference between two values, none missing and not excused, the allowed
        difference there, and the largest ratio of difference to allowed difference.
    worst : Worst or None
        None until a value is judged.
    """

    def __init__(self, share: float = 0.0) -> None:
        self.share, self.judged, self.beyond, self.excused, self.unknown = share, 0, 0, 0, 0
        self.first: list[int] = []
        self.largest, self.allowed, self.ratio = -1.0, 0.0, 0.0
        self.worst: Worst | None = None

    @property
    def fails(self) -> bool:
        """Whether more values are wrong than the share allows.

        Chance may add five times the square root of the expected number, plus five.
        """
        expected = self.share * self.judged
        return self.beyond > (expected + 5.0 * np.sqrt(expected) + 5.0 if self.share else 0.0)

    def add(
        self,
        start: int,
        apart: Array,
        allowed: Array,
        judged: Truths | bool = True,
        *,
        step: int = 1,
        beyond: Truths | None = None,
        excused: Truths | bool = False,
        values: tuple[Values, ...] = (),
    ) -> Truths | None:
        """Add every `step`-th value from flat index `start` on; arrays of shape (n,).

        Parameters
        ----------
        start : int
        apart, allowed : array
            The difference at each value (see `difference`), and the allowed difference.
        judged : array of bool
            Which values were compared.
        step : int
        beyond : array of bool, optional
            Which values are wrong, if this does not follow from the difference.
        excused : array of bool
            Which values may exceed the allowed difference without being wrong.
        values : tuple of array
            The values that were compared.

        Returns
        -------
        array of bool or None
            Which values are wrong; None if all are right.
        """
        if not apart.size:
            return None
        self.judged += apart.size if judged is True else int(np.count_nonzero(judged))
        # shortcut for parts without differences, two passes in the cache; max and min of an array with NaN are NaN
        if self.worst and beyond is None and apart.max() == 0.0 and allowed.min() >= 0.0:
            return None
        # written so that NaN counts as beyond
        wrong: Truths = (~(apart <= allowed) if beyond is None else beyond) & judged
        self.excused += int(np.count_nonzero(wrong & excused))
        wrong = wrong & ~np.asarray(excused)
        counted = np.broadcast_to(judged & ~np.asarray(excused), apart.shape)
        ratio = np.zeros(apart.shape)
        with np.errstate(divide="ignore", invalid="ignore"):
            np.divide(apart, allowed, out=ratio, where=counted & (apart != 0.0))
        if values:
            self._keep_largest(np.where(counted, apart, 0.0), allowed, ratio)
        self._keep_worst(start, step, apart, allowed, ratio, wrong, counted, values)
        if not wrong.any():
            return None
        self.beyond += int(np.count_nonzero(wrong))
        self.first += (start + step * np.flatnonzero(wrong)[: MOST_NAMED - len(self.first)]).tolist()
        return wrong

    def _keep_largest(self, apart: Array, allowed: Array, ratio: Array) -> None:
        place = int(np.argmax(np.nan_to_num(apart, posinf=np.inf)))
        if apart[place] > self.largest:
            self.largest, self.allowed = float(apart[place]), float(allowed[place])
        self.ratio = max(self.ratio, float(np.nan_to_num(ratio, posinf=np.inf).max()))

    def _keep_worst(
        self,
        start: int,
        step: int,
        apart: Array,
        allowed: Array,
        ratio: Array,
        wrong: Truths,
        counted: Truths,
        values: tuple[Values, ...],
    ) -> None:
        """Keep the value with the largest ratio, the first of equal ones; values beyond the limit come first."""
        beyond = bool(wrong.any())
        rank = np.where(np.isnan(ratio), np.inf, ratio)
        rank[~(wrong if beyond else counted)] = -1.0
        place = int(np.argmax(rank))
        if rank[place] >= 0.0 and (
            self.worst is None or (beyond, rank[place]) > (self.worst.beyond, self.worst.ratio)
        ):
            self.worst = Worst(
                beyond,
                float(rank[place]),
                start + step * place,
                float(apart[place]),
                float(allowed[place]),
                tuple(float(each[place]) for each in values),
            )


def difference(stored: Values, right: Values) -> Array:
    """Return the absolute differences: 0 where both values are missing, NaN where only one is."""
    one, other = np.asarray(stored, np.float64), np.asarray(right, np.float64)
    found, unlike = np.zeros(one.shape), one != other
    # most values are equal
    if unlike.any():
        unlike &= ~(np.isnan(one) & np.isnan(other))
        with np.errstate(invalid="ignore"):
            np.subtract(one, other, out=found, where=unlike)
        np.abs(found, out=found)
    return found


def other_bits(new: Values, old: Values) -> Truths:
    """Return where two arrays of one shape differ in any bit; all NaNs count as equal."""
    if new.dtype != old.dtype or new.dtype.kind not in "biuf":
        return np.asarray(np.full(old.shape, new.dtype != old.dtype) | (new != old))
    words = f"u{new.dtype.itemsize}"
    differ: Truths = np.ascontiguousarray(new).view(words) != np.ascontiguousarray(old).view(words)
    differ = differ.reshape(old.shape)
    if new.dtype.kind == "f" and differ.any():
        differ &= ~(np.isnan(new) & np.isnan(old))
    return differ
