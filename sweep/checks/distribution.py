"""The distribution of many values in constant memory."""

import numpy as np

from sweep.model.quantity import Array

#: Values that are kept at most.
_MOST_KEPT = 2**21


class Distribution:
    """The finite values among all that were added.

    Attributes
    ----------
    largest : float
        NaN if there is none.

    Notes
    -----
    Quantiles are those of `numpy.percentile`, of more than 2**21 values those of an even part of them: every second
    one, every fourth, and so on. The largest value is that of all.
    """

    def __init__(self) -> None:
        self._kept: list[Array] = []
        self._number, self._stride, self.largest = 0, 1, np.nan

    def add(self, values: Array) -> None:
        """Add an array of any shape; what is not finite is left out."""
        known = np.asarray(values, np.float64)
        known = known[np.isfinite(known)]
        if not known.size:
            return
        self.largest = float(np.fmax(self.largest, known.max()))
        # the place of a value among all decides whether it is kept, not the part that it came in
        self._kept.append(known[-self._number % self._stride :: self._stride].copy())
        self._number += known.size
        while self._number > self._stride * _MOST_KEPT:
            self._kept = [np.concatenate(self._kept)[::2]]
            self._stride *= 2

    def summary(self) -> tuple[float, float, float]:
        """Return median, 99 % and largest; NaN if there is none."""
        if not self._number:
            return (np.nan,) * 3
        median, high = np.percentile(np.concatenate(self._kept), [50.0, 99.0])
        return float(median), float(high), self.largest
