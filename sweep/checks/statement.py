"""The result for a variable or attribute of an atlas: a line of the table that `verify` prints."""

import json
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from sweep.checks.tally import Tally
from sweep.errors import counted
from sweep.model.audit import CellCheck
from sweep.model.quantity import Array, Truths
from sweep.request.spec import SweepSpec


@dataclass(frozen=True)
class Statement:
    """The result for one variable or attribute of an atlas.

    Parameters
    ----------
    name : str
        The variable or the attribute, or both joined by a colon.
    against : str
        The reference of the comparison, or the reason for not comparing.
    judged, wrong : int
        Number of values compared, and number of wrong values in the check that finds most.
    difference, allowed : float
        The difference with the largest ratio to the allowed difference, and the allowed difference there, in `units`;
        NaN if values are words or missing.
    units : str
    named : sequence of str
        The first wrong values, in words.
    """

    name: str
    against: str
    judged: int = 0
    wrong: int = 0
    difference: float = math.nan
    allowed: float = math.nan
    units: str = "1"
    named: list[str] | tuple[str, ...] = ()

    @property
    def checked(self) -> bool:
        """Whether any value was compared."""
        return self.judged > 0


def to_text(statements: Iterable[Statement]) -> str:
    """Return statements as ASCII JSON for an attribute; numbers that are not finite become null."""
    rows = [
        {
            name: None if isinstance(value, float) and not math.isfinite(value) else value
            for name, value in asdict(each).items()
        }
        for each in statements
    ]
    return json.dumps(rows, separators=(",", ":"), allow_nan=False)


def from_text(text: str) -> tuple[Statement, ...]:
    """Return the statements that `to_text` wrote."""
    rows: list[dict[str, Any]] = json.loads(text)
    for row in rows:
        row |= {name: math.nan for name, value in row.items() if value is None}
    return tuple(Statement(**row) for row in rows)


class Checks:
    """All checks of one variable.

    Parameters
    ----------
    name, units : str

    Attributes
    ----------
    tallies : dict of str to Tally
        Reference of a comparison -> its result.
    """

    def __init__(self, name: str, units: str) -> None:
        self._name, self._units, self.tallies = name, units, dict[str, Tally]()

    def add(self, start: int, check: CellCheck, step: int = 1) -> Truths | None:
        """Add a check of every `step`-th value from flat index `start` on; return which are wrong, None if none is."""
        tally = self.tallies.setdefault(check.against, Tally(check.share))
        if check.unknown is None:
            tally.unknown += (step - 1) * check.difference.size
        else:
            tally.unknown += int(np.count_nonzero(check.unknown))
        return tally.add(start, check.difference, check.allowed, check.judged, step=step)

    def add_whole(self, against: str, apart: Array, allowed: Array | float) -> None:
        """Add a check of all values of the variable, arrays of any shape."""
        tally = self.tallies[against] = Tally()
        tally.add(0, apart.reshape(-1), np.broadcast_to(allowed, apart.shape).reshape(-1))

    def statement(self, in_words: Callable[[int], str]) -> Statement:
        """Return the statement, with the numbers of the worst check; failed checks come first.

        Parameters
        ----------
        in_words : callable
            Flat index of a value -> its place in words.
        """
        checks = {against: each for against, each in self.tallies.items() if each.judged}
        if not checks:
            return Statement(self._name, "made by other code, which promises nothing about it")
        worst = max(checks.values(), key=_severity)
        wrong = max(
            (each for each in checks.values() if each.fails), key=lambda each: each.beyond, default=None
        )
        against = "; ".join(_with_share(words, each) for words, each in checks.items())
        if unknown := min(each.unknown for each in checks.values()):
            against += f"; otherwise not checked: {counted(unknown, 'value')}"
        return Statement(
            self._name,
            against,
            judged=max(each.judged for each in checks.values()),
            wrong=wrong.beyond if wrong else 0,
            difference=worst.worst.difference if worst.worst else math.nan,
            allowed=worst.worst.allowed if worst.worst else math.nan,
            units=self._units,
            named=[in_words(place) for place in wrong.first] if wrong else [],
        )


def _severity(tally: Tally) -> tuple[bool, bool, bool, float]:
    """Return the key that orders checks by severity; a check with a finite ratio ranks above one without."""
    ratio = tally.worst.ratio if tally.worst else -1.0
    return tally.fails, not tally.share, math.isfinite(ratio), ratio


def _with_share(against: str, tally: Tally) -> str:
    """Return the reference of a comparison, with the share of wrong cells if some are allowed."""
    if not tally.share:
        return against
    found, allowed = 100.0 * tally.beyond / tally.judged, 100.0 * tally.share
    return f"{against} ({found:.2g} % of cells outside, {allowed:g} % allowed)"


def cell_in_words(spec: SweepSpec, place: int) -> str:
    """Return the coordinates of the cell at a flat index, in words."""
    return row_in_words(spec, dict(zip(spec.axes, np.unravel_index(place, spec.shape), strict=True)))


def row_in_words(spec: SweepSpec, places: Mapping[str, np.intp]) -> str:
    """Return the coordinates of a row or a cell in words, from its indices along some axes."""
    words = [
        f"{name} {spec.quantities[name].spell(getattr(spec, name).at(place))}"
        for name, place in places.items()
    ]
    return ", ".join(words) or "the only cell"
