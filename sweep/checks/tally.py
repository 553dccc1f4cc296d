"""What was found of one variable, or of the attributes, of an atlas: a line of the table that `verify` prints."""

import json
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from sweep.errors import counted
from sweep.model.description import CellCheck
from sweep.model.quantity import Array, Truths
from sweep.request.spec import SweepSpec

#: Number of wrong cells, rows or attributes that are named.
MOST_NAMED = 3


@dataclass(frozen=True)
class Statement:
    """One variable or attribute of an atlas, and what it was held against.

    Parameters
    ----------
    name : str
        The variable, the attribute, or both joined by a colon.
    against : str
        What it was held against; where nothing was, the reason.
    judged, wrong : int
        Values that were held against something, and those of them that are wrong.
    difference, allowed : float
        Largest difference, as a multiple of what is allowed for it, and what is allowed there, in `units`; NaN where
        values are words, or missing.
    units : str
    named : sequence of str
        The first wrong values, in words.
    """

    name: str
    against: str
    judged: int
    wrong: int = 0
    difference: float = math.nan
    allowed: float = math.nan
    units: str = "1"
    named: list[str] | tuple[str, ...] = ()

    @property
    def checked(self) -> bool:
        """Whether it was held against anything."""
        return self.judged > 0


def unchecked(name: str, reason: str) -> Statement:
    """Return the statement of what cannot be checked."""
    return Statement(name, reason, 0)


def to_text(statements: Iterable[Statement]) -> str:
    """Return statements as ASCII JSON, for an attribute; numbers that are not finite are null."""
    rows = [
        {
            name: None if isinstance(value, float) and not math.isfinite(value) else value
            for name, value in row.items()
        }
        for row in map(asdict, statements)
    ]
    return json.dumps(rows, separators=(",", ":"), allow_nan=False)


def from_text(text: str) -> tuple[Statement, ...]:
    """Return the statements that `to_text` wrote."""
    rows: list[dict[str, Any]] = json.loads(text)
    for row in rows:
        row |= {name: math.nan for name, value in row.items() if value is None}
    return tuple(Statement(**row) for row in rows)


class _Places:
    """How many values, and the first of them by their flat indices."""

    def __init__(self) -> None:
        self.count = 0
        self.first: list[int] = []

    def add(self, start: int, step: int, values: Truths) -> None:
        """Add those of every k-th value from `start` on, k = `step`, for which the array of bool is true."""
        places = np.flatnonzero(values)[: MOST_NAMED - len(self.first)]
        self.first += (start + step * places).tolist()
        self.count += int(np.count_nonzero(values))


class _CheckTally:
    """What one check of a variable has found so far: counts, the worst value, the first that are wrong."""

    def __init__(self, check: CellCheck) -> None:
        self.against, self.share, self.promise = check.against, check.share, check.promise
        self.judged, self.unknown, self.beyond = 0, 0, _Places()
        self.difference, self.allowed, self.ratio = np.nan, np.nan, -1.0

    def add(self, start: int, step: int, check: CellCheck) -> Truths | None:
        """Add every k-th value from `start` on, k = `step`; return which are wrong, None if none is."""
        if not check.difference.size:
            return None
        self.judged += int(np.count_nonzero(check.judged))
        if check.unknown is not None:
            self.unknown += int(np.count_nonzero(check.unknown))
        elif step > 1:
            self.unknown += (step - 1) * check.difference.size
        if self.ratio >= 0.0 and _all_right(check):
            return None
        self._keep_worst(check)
        beyond = check.wrong
        if not beyond.any():
            return None
        self.beyond.add(start, step, beyond)
        return beyond

    def _keep_worst(self, check: CellCheck) -> None:
        """Keep the value with the largest difference over what is allowed, of two equal ones the first."""
        ratio = np.zeros(check.difference.shape)
        with np.errstate(divide="ignore", invalid="ignore"):
            np.divide(check.difference, check.allowed, out=ratio, where=check.difference != 0.0)
        if not check.judged.all():
            ratio[~check.judged] = -1.0
        worst = int(np.argmax(ratio))
        if np.isnan(ratio[worst]):
            # a value that is missing is as wrong as one for which nothing is allowed
            worst = int(np.argmax(np.isnan(ratio) | np.isposinf(ratio)))
            ratio[worst] = np.inf
        if ratio[worst] > self.ratio:
            self.ratio = float(ratio[worst])
            self.difference, self.allowed = float(check.difference[worst]), float(check.allowed[worst])

    @property
    def fails(self) -> bool:
        """Whether more values are further off than is allowed than the share lets pass.

        Of few values more than the share may be beyond it by chance: five times the square root of the expected number,
        and five.
        """
        expected = self.share * self.judged
        return self.beyond.count > (expected + 5.0 * np.sqrt(expected) + 5.0 if self.share else 0.0)

    @property
    def words(self) -> str:
        """What the variable was held against, with the share of cells that are beyond it where some may be."""
        if not self.share:
            return self.against
        found, allowed = 100.0 * self.beyond.count / self.judged, 100.0 * self.share
        return f"{self.against} ({found:.2g} % of cells beyond it, {allowed:g} % allowed)"


class Tally:
    """What all checks of one variable have found so far, slice by slice."""

    def __init__(self, name: str, units: str) -> None:
        self._name, self._units, self._checks, self._wrong = name, units, dict[str, _CheckTally](), _Places()

    @property
    def is_empty(self) -> bool:
        """Whether the variable was held against nothing."""
        return not self._checks

    def add(self, start: int, check: CellCheck, step: int = 1) -> Truths | None:
        """Add every k-th value from a flat index on, k = `step`; return which are wrong, None if none is."""
        return self._checks.setdefault(check.against, _CheckTally(check)).add(start, step, check)

    def add_wrong(self, start: int, values: Truths) -> None:
        """Add values from a flat index on of which it is known, from all checks together, whether they are wrong."""
        self._wrong.add(start, 1, values)

    def add_all(self, start: int, checks: Iterable[CellCheck]) -> None:
        """Add all checks of the same values."""
        wrong = [found for each in checks if (found := self.add(start, each)) is not None]
        if wrong:
            self.add_wrong(start, np.any(wrong, axis=0))

    def statement(self, in_words: Callable[[int], str], own: bool = True) -> Statement:
        """Return the statement: its numbers are those of the worst check, a wrong one before all others.

        Parameters
        ----------
        in_words : callable
            The flat index of a value -> where that is.
        own : bool
            Whether the code that made the atlas is this code; what only this code promises of another is left out.
        """
        checks = [each for each in self._checks.values() if each.judged and (own or not each.promise)]
        if not checks:
            return unchecked(self._name, "made by other code, which promised nothing of it")
        # of checks with and without a size of the difference the one with a size says more
        worst = max(
            checks, key=lambda each: (each.fails, not each.share, np.isfinite(each.ratio), each.ratio)
        )
        # a promise about a share of the cells is broken by them together
        wrong = worst.beyond if worst.fails and worst.share else self._wrong
        against = "; ".join(each.words for each in checks)
        if unknown := min(each.unknown for each in checks):
            against += f"; otherwise not checked: {counted(unknown, 'value')}"
        return Statement(
            self._name,
            against,
            judged=max(each.judged for each in checks),
            wrong=wrong.count,
            difference=worst.difference,
            allowed=worst.allowed,
            units=self._units,
            named=[in_words(place) for place in wrong.first],
        )


def difference_check(name: str, against: str, stored: Array, right: Array, allowed: Array) -> CellCheck:
    """Return the check of values of one shape against what they have to be, which may be that they are missing."""
    same = (stored == right) | (np.isnan(stored) & np.isnan(right))
    with np.errstate(invalid="ignore"):
        apart = np.where(same, 0.0, np.abs(stored - right)).reshape(-1)
    return CellCheck(name, against, apart, allowed.reshape(-1), np.ones(apart.shape, bool))


def cell_in_words(spec: SweepSpec, place: int) -> str:
    """Return the coordinates of a cell, given by its flat index."""
    return row_in_words(spec, dict(zip(spec.axes, np.unravel_index(place, spec.shape), strict=True)))


def row_in_words(spec: SweepSpec, places: Mapping[str, np.intp]) -> str:
    """Return the coordinates of a row or a cell, given by its places along some axes."""
    words = [
        f"{name} {spec.quantities[name].spell(getattr(spec, name).at(place))}"
        for name, place in places.items()
    ]
    return ", ".join(words) or "the one cell"


def _all_right(check: CellCheck) -> bool:
    """Return whether no value differs, and something is allowed in each; two passes over what is in the cache."""
    # the extremes of an array that holds NaN are NaN
    return bool(check.difference.max() == 0.0 and check.allowed.min() >= 0.0)
