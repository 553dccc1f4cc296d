"""The distribution of many values in constant memory."""

import numpy as np
import numpy.typing as npt

from sweep.model.quantity import Array

#: Values of which quantiles are exact: more are counted in bins.
_MOST_KEPT = 2**20

#: A bin holds the single-precision values with the same exponent and the same first 11 bits of the mantissa: its middle
#: is within a part in 2**12 of each of them. Larger values than those count as the largest of them.
_SHIFT, _GREATEST = 23 - 11, float(np.finfo(np.float32).max)
_BINS = 2**31 >> _SHIFT

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
        self._counts = np.zeros(_BINS, np.int64)
        self._number, self.largest = 0, np.nan

    def add(self, values: Array) -> None:
        """Add an array of any shape; what is not finite is left out."""
        known = np.asarray(values, np.float64)
        # a copy: what was given may be changed later
        known = known[np.isfinite(known)]
        if not known.size:
            return
        self._number += known.size
        self.largest = float(np.fmax(self.largest, known.max()))
        self._kept.append(known)
        if self._number > _MOST_KEPT:
            for each in self._kept:
                self._counts += _histogram(each)
            self._kept.clear()

    def summary(self) -> tuple[float, float, float]:
        """Return median, 99 % and largest; NaN if there is none."""
        if not self._number:
            return (np.nan,) * 3
        if self._kept:
            median, high = np.percentile(np.concatenate(self._kept), [100.0 * each for each in _QUANTILES])
        else:
            ranks = [share * (self._number - 1) for share in _QUANTILES]
            places = np.searchsorted(np.cumsum(self._counts), ranks, side="right")
            median, high = (min(_middle(int(place)), self.largest) for place in places)
        return float(median), float(high), self.largest


def _histogram(values: Array) -> npt.NDArray[np.int64]:
    single = np.minimum(values, _GREATEST).astype(np.float32)
    return np.bincount(single.view(np.int32) >> _SHIFT, minlength=_BINS)


def _middle(place: int) -> float:
    """Return the middle of a bin; 0 of the first, which holds 0 too."""
    edges = (np.arange(place, place + 2) << _SHIFT).astype(np.int32).view(np.float32)
    return float(edges.astype(np.float64).mean()) if place else 0.0
