"""The distribution of many values in constant memory."""

import numpy as np

from sweep.model.quantity import Array

#: Largest number of values kept.
_MOST_KEPT = 2**21


class Distribution:
    """The distribution of the finite values that were added.

    Attributes
    ----------
    largest : float
        NaN without values.

    Notes
    -----
    Quantiles come from `numpy.percentile`. For more than 2**21 values they come from a regular subset: every second
    value, every fourth, and so on. The largest value is exact.
    """

    def __init__(self) -> None:
        self._kept: list[Array] = []
        self._number, self._stride, self.largest = 0, 1, np.nan

    def add(self, values: Array) -> None:
        """Add an array of any shape, except for its values that are not finite."""
        known = np.asarray(values, np.float64)
        known = known[np.isfinite(known)]
        if not known.size:
            return
        self.largest = float(np.fmax(self.largest, known.max()))
        # whether a value is kept depends on its place among all values, not on how they were split
        self._kept.append(known[-self._number % self._stride :: self._stride].copy())
        self._number += known.size
        while self._number > self._stride * _MOST_KEPT:
            self._kept = [np.concatenate(self._kept)[::2]]
            self._stride *= 2

    def summary(self) -> tuple[float, float, float]:
        """Return the median, the 99 % quantile and the largest value; NaN without values."""
        if not self._number:
            return (np.nan,) * 3
        median, high = np.percentile(np.concatenate(self._kept), [50.0, 99.0])
        return float(median), float(high), self.largest
