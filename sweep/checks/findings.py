"""Counts and distributions of an audit over all cells, and the cells to look at."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sweep.checks.distribution import Distribution
from sweep.checks.statement import Statement
from sweep.model.audit import Audit
from sweep.model.quantity import Array
from sweep.request.spec import SweepSpec

#: Number of disagreeing cells that are named.
_MOST_NAMED = 5


@dataclass(frozen=True)
class Findings:
    """Counts and statistics of an audit.

    Parameters
    ----------
    counts : mapping of str to int
        Flag of the audit -> number of cells.
    agreeing, disagreeing, missing : int
        Numbers of cells that agree within time and tolerance, disagree, and have not been computed. The other cells
        are unresolved or invalid, in the atlas or in the reference.
    compared : int
        Number of cells with a value in the reference or in a second computation.
    coordinate, units : str
        The coordinate whose extremes were compared, and its unit.
    extremes : (median, 99 %, largest)
        Distribution of the errors of the extremes [SI], for the cells that have one and did not end by time; NaN
        without such cells. For more than 2**21 cells, median and 99 % come from a regular subset.
    period : (median, 99 %, largest)
        Distribution of the relative error of the period.
    period_share : float
        Largest ratio of the error of a period to the allowed error.
    named : sequence of (str, mapping of str to float)
        Flag and coordinates of the first disagreeing cells, or of the cell with the largest difference if all agree.
    tolerance : float
        Tolerance of the atlas, in the same unit.
    method : str
        Method of the atlas.
    statements : sequence of Statement
        Results for each variable and attribute.
    sampled : str
        Description of the sample if only a sample was computed by another method; otherwise empty.
    told, has_period : str, bool
        A description of `extremes`, and whether the audit has periods.
    """

    counts: Mapping[str, int]
    agreeing: int
    disagreeing: int
    missing: int
    compared: int
    coordinate: str
    units: str
    extremes: tuple[float, float, float]
    period: tuple[float, float, float]
    period_share: float
    named: Sequence[tuple[str, Mapping[str, float]]]
    tolerance: float
    method: str
    statements: Sequence[Statement]
    sampled: str = ""
    told: str = ""
    has_period: bool = True

    @property
    def cells(self) -> int:
        """Number of cells."""
        return sum(self.counts.values())

    @property
    def wrong(self) -> Sequence[Statement]:
        """The statements that the audit found wrong."""
        return [each for each in self.statements if each.wrong]

    @property
    def passed(self) -> bool:
        """Whether cells were compared, none disagrees, none is missing, and no statement is wrong."""
        return self.compared > 0 and not self.disagreeing and not self.missing and not self.wrong


class AuditSummary:
    """Counts and distributions of the variables of an audit over all cells.

    Parameters
    ----------
    audit : Audit
        The audit of the model.

    Attributes
    ----------
    counts : dict of str to int
        Flag -> number of cells.
    compared : int
        Number of cells with a value in the reference.
    extremes, period : Distribution
        Errors of the extremes, for the cells that have one and did not end by time; relative errors of periods.
    period_share : float
        Largest finite ratio of the error of a period to the allowed error; NaN without periods.
    """

    def __init__(self, audit: Audit) -> None:
        self._audit = audit
        self._flags = audit.variables["audit"].flags or {}
        self.counts = dict.fromkeys(self._flags.values(), 0)
        self.extremes, self.period, self.period_share = Distribution(), Distribution(), np.nan
        self.compared = 0
        self._disagreeing: list[tuple[str, int]] = []
        self._worst: tuple[str, int] | None = None
        self._most = -np.inf

    def add(self, start: int, variables: Mapping[str, npt.NDArray[np.generic]]) -> None:
        """Add the audit variables of the cells that begin at flat index `start`, arrays of shape (n,)."""
        audit, codes = self._audit, variables["audit"]
        for code, name in self._flags.items():
            self.counts[name] += int(np.count_nonzero(codes == code))
        difference = np.asarray(variables[audit.difference], np.float64)
        self.compared += int(np.count_nonzero(np.isfinite(difference)))
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

    def findings(self, spec: SweepSpec, statements: Sequence[Statement], sampled: str) -> Findings:
        """Return the findings of the audit, including its statements; `sampled` as in `Findings`."""
        audit, named = self._audit, self._disagreeing
        if not named and self._worst is not None and np.isfinite(self.extremes.largest):
            named = [self._worst]
        return Findings(
            counts=self.counts,
            agreeing=self._sum_of(audit.agreeing),
            disagreeing=self._sum_of(audit.disagreeing),
            missing=self._sum_of((audit.missing,)),
            compared=self.compared,
            coordinate=spec.model.coordinate,
            units=audit.units,
            extremes=self.extremes.summary(),
            period=self.period.summary(),
            period_share=self.period_share,
            named=[(flag, _where(spec, place)) for flag, place in named],
            tolerance=spec.tolerance,
            method=spec.method,
            statements=statements,
            sampled=sampled,
            told=audit.told,
            has_period=audit.period is not None,
        )

    def _sum_of(self, codes: tuple[int, ...]) -> int:
        """Return the number of cells with any of these codes."""
        return sum(self.counts[self._flags[code]] for code in codes)

    def _keep_places(
        self, start: int, codes: npt.NDArray[np.generic], difference: npt.NDArray[np.float64]
    ) -> None:
        if self._sum_of(self._audit.disagreeing):
            room = _MOST_NAMED - len(self._disagreeing)
            places = np.flatnonzero(np.isin(codes, self._audit.disagreeing))[:room] if room else ()
            self._disagreeing += [(self._flags[int(codes[place])], start + int(place)) for place in places]
            return
        most = np.fmax.reduce(difference, initial=-np.inf)
        if most > self._most:
            place = int(np.flatnonzero(difference == most)[0])
            self._most, self._worst = float(most), (self._flags[int(codes[place])], start + place)


def _where(spec: SweepSpec, place: int) -> dict[str, float]:
    """Return the coordinates of the cell at a flat index."""
    places = zip(spec.axes, np.unravel_index(place, spec.shape), strict=True)
    return {name: float(getattr(spec, name).at(each)) for name, each in places}
