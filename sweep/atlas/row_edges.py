"""The edges of the unstable band in every row of a grid of verdicts, and why a row may have no edge."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.errors import counted
from sweep.model.quantity import STABLE, UNDECIDED, UNSTABLE, Truths

#: Index for no place in a row.
NOWHERE = -1

#: Codes for the status of an edge in a row of verdicts.
ROW_UNDECIDED, STABLE_THROUGHOUT, UNSTABLE_THROUGHOUT, FOUND, MORE_THAN_ONE, OTHER_EDGE_ONLY = range(6)

#: Names of the codes, as declared in the file.
ROW_STATUS: Mapping[int, str] = MappingProxyType(
    {
        ROW_UNDECIDED: "undecided",
        STABLE_THROUGHOUT: "stable_throughout",
        UNSTABLE_THROUGHOUT: "unstable_throughout",
        FOUND: "found",
        MORE_THAN_ONE: "more_than_one_edge",
        OTHER_EDGE_ONLY: "other_edge_only",
    }
)

#: Number of cells whose rows are processed together: their verdicts and truth values fit into a processor's cache.
_AT_ONCE = 2**18

Verdicts = npt.NDArray[np.integer]
Places = npt.NDArray[np.intp]


@dataclass(frozen=True)
class RowEdges:
    """The edges in rows of verdicts. A row is all cells along one axis, with the other axes fixed.

    Parameters
    ----------
    stable_before, first_unstable, last_unstable, stable_after : arrays of int, shape of the rows
        Indices in a row: the last stable cell before the first unstable one, the first and the last unstable cell, and
        the first stable cell after the last unstable one; `NOWHERE` if there is no such cell.
    is_split, has_undecided : arrays of bool, shape of the rows
        Whether stable cells lie between unstable ones, and whether a cell is undecided.
    """

    stable_before: Places
    first_unstable: Places
    last_unstable: Places
    stable_after: Places
    is_split: Truths
    has_undecided: Truths

    @classmethod
    def of(cls, verdicts: Verdicts, axis: int) -> "RowEdges":
        """Return the edges of the rows of a grid along one of its axes.

        Parameters
        ----------
        verdicts : array of int8
            Codes of `sweep.model.quantity`.
        axis : int
        """
        shape = verdicts.shape
        lines = np.moveaxis(verdicts.reshape(math.prod(shape[:axis]), shape[axis], -1), 1, 2)
        planes, inner, length = lines.shape
        places = [np.full((planes, inner), NOWHERE, np.intp) for _ in range(4)]
        truths = [np.zeros((planes, inner), bool) for _ in range(2)]
        columns = max(1, _AT_ONCE // length)
        step = max(1, columns // inner)
        for plane in range(0, planes, step):
            for column in range(0, inner, columns):
                part = np.s_[plane : plane + step, column : column + columns]
                found = _edges(np.ascontiguousarray(lines[part]))
                for into, values in zip((*places, *truths), found, strict=True):
                    into[part] = values
        rest = shape[:axis] + shape[axis + 1 :]
        return cls(*(each.reshape(rest) for each in (*places, *truths)))

    def bracket(self, edge: str) -> tuple[Places, Places]:
        """Return the indices of the two cells between which an edge lies.

        Parameters
        ----------
        edge : {"upper", "lower"}
            The edge with stable motion above it, or below it.

        Returns
        -------
        (unstable, stable) : arrays of int, shape of the rows
            The last unstable cell and the first stable one after it; for the lower edge, the first unstable cell and
            the last stable one before it. Both are `NOWHERE` if a row has no such pair.
        """
        if edge == "upper":
            unstable, stable = self.last_unstable, self.stable_after
        else:
            unstable, stable = self.first_unstable, self.stable_before
        return np.where(stable == NOWHERE, NOWHERE, unstable), stable

    def status(self, edge: str) -> npt.NDArray[np.int8]:
        """Return whether each row has an edge and, if not, why.

        Parameters
        ----------
        edge : {"upper", "lower"}

        Returns
        -------
        array of int8, shape of the rows
            A code of `ROW_STATUS`. Undecided cells are skipped in the sequence of verdicts.
            ``found``: the verdict changes once in the direction of this edge, and the row ends on its stable side.
            ``more_than_one_edge``: the verdict changes in this direction more than once, or changes back. The stored
            value is the outermost edge, and missing if the row ends on the unstable side. Rows without such a change
            are ``undecided`` if a cell is, otherwise ``stable_throughout``, ``unstable_throughout`` or
            ``other_edge_only``.
        """
        begins, ends = self.stable_before != NOWHERE, self.stable_after != NOWHERE
        has_edge = ends if edge == "upper" else begins
        stable_throughout = self.first_unstable == NOWHERE
        conditions = (self.is_split, has_edge, self.has_undecided, stable_throughout, ~(begins | ends))
        codes = (MORE_THAN_ONE, FOUND, ROW_UNDECIDED, STABLE_THROUGHOUT, UNSTABLE_THROUGHOUT)
        return np.asarray(np.select(conditions, codes, OTHER_EDGE_ONLY), np.int8)


def _edges(verdicts: Verdicts) -> tuple[Places, Places, Places, Places, Truths, Truths]:
    """Return the fields of `RowEdges` for rows along the last axis."""
    unstable, stable = verdicts == UNSTABLE, verdicts == STABLE
    first, last = _first(unstable), _last(unstable)
    place, any_unstable = np.arange(verdicts.shape[-1]), (first != NOWHERE)[..., None]
    before = stable & any_unstable & (place < first[..., None])
    after = stable & any_unstable & (place > last[..., None])
    between = (stable & any_unstable & ~before & ~after).any(-1)
    return _last(before), first, last, _first(after), between, ~(unstable | stable).all(-1)


def _first(truths: Truths) -> Places:
    """Return the first index along the last axis that is true; `NOWHERE` if none is."""
    return np.where(truths.any(-1), truths.argmax(-1), NOWHERE)


def _last(truths: Truths) -> Places:
    """Return the last index along the last axis that is true; `NOWHERE` if none is."""
    return np.where(truths.any(-1), truths.shape[-1] - 1 - truths[..., ::-1].argmax(-1), NOWHERE)


def legal(verdicts: npt.NDArray[Any]) -> npt.NDArray[np.int8]:
    """Return verdicts as codes; any other value than stable or unstable becomes undecided."""
    known = (verdicts == STABLE) | (verdicts == UNSTABLE)
    return np.where(known, verdicts, UNDECIDED).astype(np.int8, copy=False)


def in_words(status: npt.NDArray[np.integer], axis: str, edge: str = "", across: str = "") -> list[str]:
    """Explain in one or two lines why rows have no boundary, or more than one; no lines if each row has one.

    Parameters
    ----------
    status : array of int, any shape
        Codes of `ROW_STATUS`.
    axis : str
        The parameter along which the rows lie.
    edge : {"", "upper", "lower"}
        The edge of the codes, if the text should name it.
    across : str
        The parameter that has one value in each row, if the text should name rows by it.
    """

    def place(count: int) -> str:
        """Return the number of rows, in words."""
        if count == status.size:
            return ""
        if across:
            return f" at {count} of {status.size} values of {across.replace('_', ' ')}"
        return f" in {counted(count, 'row', status.size)} along {axis}"

    counts = {code: int((status == code).sum()) for code in ROW_STATUS}
    several, single = counts.pop(MORE_THAN_ONE), counts.pop(FOUND)
    missing = {name(code, edge): count for code, count in counts.items() if count}
    without, lines = status.size - several - single, []
    what = f"{edge} edge" if edge else "boundary"
    if without:
        reasons = (
            list(missing) if len(missing) == 1 else [f"{count} {word}" for word, count in missing.items()]
        )
        lines.append(f"no {what}{place(without)}: {', '.join(reasons)}")
    if several:
        lines.append(f"more than one {f'{edge} edge' if edge else 'edge'}{place(several)}")
    return lines


def name(code: int, edge: str = "") -> str:
    """Return the name of a code in words; if an edge is given, "other" becomes the opposite edge."""
    if code == OTHER_EDGE_ONLY and edge:
        return "lower edge only" if edge == "upper" else "upper edge only"
    return ROW_STATUS[code].replace("_", " ")
