"""The distribution of any number of values, in constant memory: median, 99 %, largest."""

import numpy as np
import numpy.typing as npt

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

Array = npt.NDArray[np.float64]


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
