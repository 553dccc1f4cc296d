"""What was found of one variable, or of the attributes, of an atlas: a line of the table that `verify` prints."""

import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

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
    named: Sequence[str] = ()

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
        {name: None if _not_finite(value) else value for name, value in row.items()}
        for row in map(asdict, statements)
    ]
    return json.dumps(rows, separators=(",", ":"), allow_nan=False)


def from_text(text: str) -> tuple[Statement, ...]:
    """Return the statements that `to_text` wrote."""
    rows: list[dict[str, Any]] = json.loads(text)
    for row in rows:
        row |= {name: math.nan for name, value in row.items() if value is None}
    return tuple(Statement(**row) for row in rows)


def _not_finite(value: object) -> bool:
    return isinstance(value, float) and not math.isfinite(value)
