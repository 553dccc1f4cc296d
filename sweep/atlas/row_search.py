"""The edges of the unstable band in every row of a grid, found from its cells in C order, one span after the other."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.atlas.row_status import (
    FOUND,
    MORE_THAN_ONE,
    OTHER_EDGE_ONLY,
    ROW_UNDECIDED,
    STABLE_THROUGHOUT,
    UNSTABLE_THROUGHOUT,
)
from sweep.engine.grid import Span, blocks
from sweep.model.quantity import STABLE, UNDECIDED, UNSTABLE

#: Cells that are searched at a time: their verdicts and what is made of them fit the cache of a processor.
_AT_ONCE = 2**18

#: No place in a row.
NOWHERE = -1

Verdicts = npt.NDArray[np.integer]
Places = npt.NDArray[np.integer]


class RowSearch:
    """What the verdicts of every row say of its edges; a row is all cells along one axis, the other axes fixed.

    Cells come in C order, in spans of any size. Of each row seven numbers are kept, whatever its length: 7 bytes where
    rows have up to 128 cells, 12 up to 32768, else 22.

    Parameters
    ----------
    shape : tuple of int
        Shape of the grid.
    axis : int
        Which of its axes the rows lie along. Rows are counted in C order of the other axes.

    Notes
    -----
    Between neighbours of one row with the same verdict nothing changes, so that only the other places are looked at,
    which are few. All that holds of an edge follows from the places where a run of equal verdicts begins or ends.
    """

    def __init__(self, shape: tuple[int, ...], axis: int) -> None:
        self._count, self._inner = shape[axis], math.prod(shape[axis + 1 :])
        self.rows = math.prod(shape[:axis]) * self._inner
        # the smallest type that holds every place and NOWHERE
        place = np.min_scalar_type(-self._count)
        (
            self._first_unstable,
            self._stable_before,
            self._stable_since,
            self._last_unstable,
            self._stable_after,
        ) = (np.full(self.rows, NOWHERE, place) for _ in range(5))
        self._now = np.zeros(self.rows, np.int8)
        self._has_undecided = np.zeros(self.rows, bool)

    def add(self, start: int, verdicts: Verdicts) -> None:
        """Take the verdicts of the cells that follow on those before.

        Parameters
        ----------
        start : int
            Flat index of the first cell.
        verdicts : array of int8, shape (n,)
        """
        for span in blocks(verdicts.size, _AT_ONCE):
            for row, place, box in self._boxes(start + span.start, verdicts[span.start : span.stop]):
                self._take(row, place, box)

    def bracket(self, edge: str, rows: Span) -> tuple[Places, Places]:
        """Return the places of the two cells between which an edge lies, once all cells are there.

        Parameters
        ----------
        edge : {"upper", "lower"}
            Stable above it, or below.
        rows : Span

        Returns
        -------
        (unstable, stable) : arrays of int, shape (len(rows),)
            The last unstable cell and the first stable one after it, for the lower edge the first unstable cell and the
            last stable one before it; `NOWHERE` in both where a row has no such pair.
        """
        part = slice(rows.start, rows.stop)
        if edge == "upper":
            found, unstable, stable = self._ends_stable(part), self._last_unstable, self._stable_after
        else:
            found, unstable, stable = self._begins_stable(part), self._first_unstable, self._stable_before
        found &= self._first_unstable[part] != NOWHERE
        return np.where(found, unstable[part], NOWHERE), np.where(found, stable[part], NOWHERE)

    def status(self, edge: str, rows: Span) -> npt.NDArray[np.int8]:
        """Return for each row whether it has an edge, and if not, why, once all cells are there.

        Parameters
        ----------
        edge : {"upper", "lower"}
        rows : Span

        Returns
        -------
        array of int8, shape (len(rows),)
            A code of `sweep.atlas.row_status.ROW_STATUS`. Undecided cells are left out of the sequence of verdicts.
            ``found``: the verdict changes once in the direction of this edge, and the row ends on its stable side.
            ``more_than_one_edge``: it changes so more than once, or changes back: the value stored is that of the
            outermost edge, and there is none where the row ends on the unstable side. Rows without such a change are
            ``undecided`` if a cell is, ``stable_throughout``, ``unstable_throughout``, or have the ``other_edge_only``.
        """
        part = slice(rows.start, rows.stop)
        any_unstable = self._first_unstable[part] != NOWHERE
        begins, ends = self._begins_stable(part) & any_unstable, self._ends_stable(part) & any_unstable
        here = ends if edge == "upper" else begins
        split = self._is_split(part)
        conditions = (split, here, self._has_undecided[part], ~any_unstable, ~(begins | ends))
        codes = (MORE_THAN_ONE, FOUND, ROW_UNDECIDED, STABLE_THROUGHOUT, UNSTABLE_THROUGHOUT)
        found: npt.NDArray[np.int8] = np.select(conditions, codes, OTHER_EDGE_ONLY).astype(np.int8)
        return found

    def _begins_stable(self, part: slice) -> npt.NDArray[np.bool_]:
        """Return where the first decided verdict of a row with unstable cells is stable."""
        return np.asarray(self._stable_before[part] != NOWHERE)

    def _ends_stable(self, part: slice) -> npt.NDArray[np.bool_]:
        """Return where the last decided verdict of a row is stable."""
        after = self._stable_after[part] > self._last_unstable[part]
        return np.asarray(after & (self._now[part] != UNSTABLE))

    def _is_split(self, part: slice) -> npt.NDArray[np.bool_]:
        """Return where stable cells lie between unstable ones."""
        since = self._stable_since[part]
        still = (self._now[part] == UNSTABLE) | (since < self._last_unstable[part])
        return np.asarray((since != NOWHERE) & still)

    def _boxes(self, start: int, verdicts: Verdicts) -> Iterator[tuple[int, int, Verdicts]]:
        """Cut a span of cells into at most five boxes.

        Yields the first row and the first place of a box, and its verdicts, shape (outer, places, inner): a part of one
        line of neighbouring rows, several lines, or all places of several planes. Its rows are neighbours too.
        """
        at = 0
        while at < verdicts.size:
            outer, rest = divmod(start + at, self._count * self._inner)
            place, column = divmod(rest, self._inner)
            left = verdicts.size - at
            if column or left < self._inner:
                shape = (1, 1, min(self._inner - column, left))
            elif place or left < self._count * self._inner:
                shape = (1, min(self._count - place, left // self._inner), self._inner)
            else:
                shape = (left // (self._count * self._inner), self._count, self._inner)
            size = math.prod(shape)
            yield outer * self._inner + column, place, verdicts[at : at + size].reshape(shape)
            at += size

    def _take(self, row: int, place: int, box: Verdicts) -> None:
        outer, places, inner = box.shape
        rows = slice(row, row + outer * inner)
        if place == 0:
            self._begin(rows, box[:, 0].reshape(-1))
        # each line of cells with the one before it, which of the first line is what the rows had until now
        lines = np.concatenate((self._now[row : row + inner], box.reshape(-1)))
        changed = lines[inner:] != lines[:-inner]
        if outer > 1:
            # here the line before belongs to other rows, and the first cells of these have been taken
            changed.reshape(box.shape)[:, 0] = False
        self._now[rows] = box[:, -1].reshape(-1)
        at = np.flatnonzero(changed)
        if at.size:
            plane, rest = np.divmod(at, places * inner)
            along, column = np.divmod(rest, inner)
            self._change(row + plane * inner + column, place + along, lines[at], lines[at + inner])

    def _begin(self, rows: slice, verdicts: Verdicts) -> None:
        self._now[rows] = verdicts
        self._first_unstable[rows] = np.where(verdicts == UNSTABLE, 0, NOWHERE)
        self._stable_after[rows] = np.where(verdicts == STABLE, 0, NOWHERE)
        self._has_undecided[rows] = verdicts == UNDECIDED

    def _change(self, rows: Places, places: Places, before: Verdicts, after: Verdicts) -> None:
        """Note where the verdict is another one than at the place before; of each row the places increase."""
        self._has_undecided[rows[after == UNDECIDED]] = True
        new = (after == UNSTABLE) & (self._first_unstable[rows] == NOWHERE)
        _keep_first(self._first_unstable, rows[new], places[new])
        first = self._first_unstable[rows]
        ended = (before == STABLE) & ((first == NOWHERE) | (places <= first))
        _keep_last(self._stable_before, rows[ended], places[ended] - 1)
        begun = (after == STABLE) & (first != NOWHERE) & (places > first)
        begun &= self._stable_since[rows] == NOWHERE
        _keep_first(self._stable_since, rows[begun], places[begun])
        ended = before == UNSTABLE
        _keep_last(self._last_unstable, rows[ended], places[ended] - 1)
        last = self._last_unstable[rows]
        begun = (after == STABLE) & (places > last) & (self._stable_after[rows] <= last)
        _keep_first(self._stable_after, rows[begun], places[begun])


def _keep_first(held: Places, rows: Places, places: Places) -> None:
    # of a row that is named more than once numpy keeps the value that was given last
    held[rows[::-1]] = places[::-1]


def _keep_last(held: Places, rows: Places, places: Places) -> None:
    held[rows] = places


def row_status(verdicts: npt.NDArray[Any], edge: str = "upper") -> npt.NDArray[np.int8]:
    """Return for each row of a grid in memory whether it has an edge of the unstable band, and if not, why.

    Parameters
    ----------
    verdicts : array, shape (..., n)
        Along a control parameter, increasing along the last axis. What is neither stable nor unstable is undecided.
    edge : {"upper", "lower"}
        The edge above which, or below which, the motion is stable.

    Returns
    -------
    array of int8, shape (...)
        As from `RowSearch.status`.
    """
    search = RowSearch(verdicts.shape, verdicts.ndim - 1)
    search.add(0, legal(verdicts).reshape(-1))
    return search.status(edge, Span(0, search.rows)).reshape(verdicts.shape[:-1])


def legal(verdicts: npt.NDArray[Any]) -> npt.NDArray[np.int8]:
    """Return verdicts as codes: what is neither stable nor unstable is undecided."""
    known = (verdicts == STABLE) | (verdicts == UNSTABLE)
    return np.where(known, verdicts, UNDECIDED).astype(np.int8, copy=False)
