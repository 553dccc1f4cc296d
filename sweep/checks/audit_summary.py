"""What an audit comes to over all cells, gathered block by block: counts, and distributions in constant memory."""

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from sweep.model.description import Audit
from sweep.model.quantity import Array

#: Values of which quantiles are exact: more are counted in bins.
_MOST_KEPT = 2**20

#: A bin holds the values with the same exponent and the same first bits of the mantissa: its middle is within a part in
#: 2**11 of each of them.
_MANTISSA_BITS = 10
_SHIFT = 52 - _MANTISSA_BITS

#: Exponents of two that have bins of their own. Smaller values count as the smallest, larger ones as the largest.
_LEAST, _GREATEST = -120, 64
_FIRST_BIN = (1023 + _LEAST) << _MANTISSA_BITS
_BINS = (_GREATEST - _LEAST) << _MANTISSA_BITS

_QUANTILES = (0.5, 0.99)


class Distribution:
    """The finite values among all that were added, which must not be negative.

    Attributes
    ----------
    largest : float
        NaN if there is none.

    Notes
    -----
    Quantiles are those of `numpy.percentile`. Of more than 2**20 values they come from a histogram: the middle of the
    bin, at most 0.05 % from the value. The largest value is always exact.
    """

    def __init__(self) -> None:
        self._kept: list[Array] = []
        self._counts: npt.NDArray[np.int64] | None = None
        self._number, self.largest = 0, np.nan

    def add(self, values: Array) -> None:
        """Add an array of any shape; what is not finite is left out."""
        known = np.asarray(values, np.float64)
        finite = np.isfinite(known)
        known = known.reshape(-1) if finite.all() else known[finite]
        if not known.size:
            return
        self._number += known.size
        self.largest = float(np.fmax(self.largest, known.max()))
        if self._counts is not None:
            self._count(known)
        else:
            # a copy: what was given may be changed later
            self._kept.append(known.copy())
        if self._counts is None and self._number > _MOST_KEPT:
            self._counts = np.zeros(_BINS, np.int64)
            for each in self._kept:
                self._count(each)
            self._kept.clear()

    def summary(self) -> tuple[float, float, float]:
        """Return median, 99 % and largest; NaN if there is none."""
        if not self._number:
            return (np.nan,) * 3
        if self._counts is None:
            median, high = np.percentile(np.concatenate(self._kept), [100.0 * each for each in _QUANTILES])
            return float(median), float(high), self.largest
        upto = np.cumsum(self._counts)
        places = [
            int(np.searchsorted(upto, share * (self._number - 1), side="right")) for share in _QUANTILES
        ]
        median, high = (min(_middle(place), self.largest) for place in places)
        return median, high, self.largest

    def _count(self, values: Array) -> None:
        assert self._counts is not None
        bins = (values.view(np.int64) >> _SHIFT) - _FIRST_BIN
        low, high = int(bins.min()), int(bins.max())
        if low < 0 or high >= _BINS:
            bins = np.clip(bins, 0, _BINS - 1)
            low, high = int(bins.min()), int(bins.max())
        self._counts[low : high + 1] += np.bincount(bins - low, minlength=high - low + 1)


def _middle(place: int) -> float:
    """Return the middle of a bin; 0 of the first, which holds 0 too."""
    if place == 0:
        return 0.0
    edges = (np.arange(place, place + 2, dtype=np.int64) + _FIRST_BIN) << _SHIFT
    return float(edges.view(np.float64).mean())


#: Number of disagreeing cells that are named.
_MOST_NAMED = 5


class AuditSummary:
    """What the variables of an audit come to over all cells.

    Parameters
    ----------
    audit : Audit
        That of the model.

    Attributes
    ----------
    counts : dict of str to int
        Each flag to its number of cells.
    extremes, period : Distribution
        The error of the extremes over the cells that have one and were not ended by time; that of the period over the
        exact period.
    period_share : float
        Largest finite error of a period over what the tolerance allows; NaN if there is none.
    """

    def __init__(self, audit: Audit) -> None:
        self._audit = audit
        self._flags = audit.variables["audit"].flags or {}
        self.counts = dict.fromkeys(self._flags.values(), 0)
        self.extremes, self.period, self.period_share = Distribution(), Distribution(), np.nan
        self._disagreeing: list[tuple[str, int]] = []
        self._worst: tuple[str, int] | None = None
        self._most = -np.inf

    def add(self, start: int, variables: Mapping[str, npt.NDArray[np.generic]]) -> None:
        """Add cells from `start` on: the variables of the audit, arrays of shape (n,)."""
        audit, codes = self._audit, variables["audit"]
        for code, name in self._flags.items():
            self.counts[name] += int(np.count_nonzero(codes == code))
        difference = np.asarray(variables[audit.difference], np.float64)
        if audit.ended_by_time is not None and (by_time := codes == audit.ended_by_time).any():
            difference = np.where(by_time, np.nan, difference)
        self.extremes.add(difference)
        if audit.period is not None:
            self._add_periods(*(np.asarray(variables[name], np.float64) for name in audit.period))
        self._keep_places(start, codes, difference)

    def _add_periods(self, error: Array, exact: Array, share: Array) -> None:
        with np.errstate(divide="ignore", invalid="ignore"):
            self.period.add(np.abs(error) / exact)
        finite = np.isfinite(share)
        if finite.any():
            self.period_share = float(
                np.fmax(self.period_share, np.max(share, initial=-np.inf, where=finite))
            )

    def named(self) -> list[tuple[str, int]]:
        """Return cells by their flat indices, each with its flag.

        Of those that disagree the first few, or else the one with the largest difference, if one has any.
        """
        if self._disagreeing or self._worst is None or not np.isfinite(self.extremes.largest):
            return self._disagreeing
        return [self._worst]

    def sum_of(self, codes: tuple[int, ...]) -> int:
        """Return how many cells have one of some codes."""
        return sum(self.counts[self._flags[code]] for code in codes)

    def _keep_places(
        self, start: int, codes: npt.NDArray[np.generic], difference: npt.NDArray[np.float64]
    ) -> None:
        if self.sum_of(self._audit.disagreeing):
            room = _MOST_NAMED - len(self._disagreeing)
            places = np.flatnonzero(np.isin(codes, self._audit.disagreeing))[:room] if room else ()
            self._disagreeing += [(self._flags[int(codes[place])], start + int(place)) for place in places]
            return
        most = np.fmax.reduce(difference, initial=-np.inf)
        if most > self._most:
            place = int(np.flatnonzero(difference == most)[0])
            self._most, self._worst = float(most), (self._flags[int(codes[place])], start + place)
