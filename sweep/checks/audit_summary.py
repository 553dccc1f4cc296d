"""Counts and statistics of an audit, gathered block by block."""

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from sweep.checks.distribution import Distribution
from sweep.model.description import Audit
from sweep.model.quantity import Array

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
