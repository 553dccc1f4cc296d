"""A random sample of the cells of a system's atlas, followed by SciPy's DOP853 to the times at which they ended.

A budget of time sets its size. Each cell is followed with two tolerances, and their difference estimates the error.
"""

import math
import time
from collections.abc import Iterator

import numpy as np

from sweep.model.description import Columns, Starts
from sweep.model.quantity import Array, Truths
from sweep.model.system import tables
from sweep.model.system.definition import Definition, Node, Operation
from sweep.model.system.second_method import Places, follow

#: Prefixes of the names of values and of their errors.
FOUND, OFF = "found: ", "off: "

#: Name of the greatest value of an expression until the end; they are numbered as in `tops_of`.
TOP = "top {}"

#: Cells of the sample at most; seconds after which no more are begun, and the cells that are followed in any case.
MOST_CELLS, SECONDS, LEAST_CELLS = 2000, 5.0, 24

#: The larger and the smaller tolerance.
_TOLERANCES = (1e-10, 1e-12)

#: Parts in which the first cells are followed; cells that are taken up together after them, and their parts.
_FIRST_PARTS, _NEXT_CELLS, _NEXT_PARTS = 2, 400, 4


def tops_of(definition: Definition) -> list[Node]:
    """Return the expressions whose greatest values are sought: of all measures, then of all events."""
    tops = [
        node if measure.kind == "max" else Operation("neg", (node,))
        for measure in definition.measures
        if measure.tops
        for node in measure.expressions
    ]
    return [*tops, *(node for event in definition.ends for node in event.any_positive)]


class Sample:
    """Cells of an atlas of a number of cells, drawn at random.

    Parameters
    ----------
    definition : Definition
    size, seed : int

    Attributes
    ----------
    count, followed : int
        How many cells are drawn, and how many of them were followed to their ends so far.
    """

    def __init__(self, definition: Definition, size: int, seed: int) -> None:
        self._definition, self._tops = definition, tops_of(definition)
        self._names = [each.name for each in definition.states]
        self._names += [TOP.format(number) for number in range(len(self._tops))]
        self._drawn = np.random.default_rng(seed).choice(size, min(size, MOST_CELLS), replace=False)
        self._left, self._seconds = self._drawn.size, 0.0
        self.count, self.followed = self._drawn.size, 0

    def of(self, starts: Starts, first: int, stored: Columns, known: Truths) -> Columns:
        """Return what is found of the cells from `first` on that are drawn and `known`; NaN of all others.

        Parameters
        ----------
        starts, stored : mapping of str to array, shape (n,)
        first : int
            Number of the first cell; calls come in the order of the cells.
        known : array of bool, shape (n,)
        """
        rows = np.full((2, len(self._names), known.size), np.nan)
        ranks = np.flatnonzero((self._drawn >= first) & (self._drawn < first + known.size))
        # cells come in blocks: each gets its share of the time that is left
        began, allowed = time.monotonic(), (SECONDS - self._seconds) * ranks.size / max(1, self._left)
        self._left -= ranks.size
        ranks = ranks[known[self._drawn[ranks] - first]]
        sure = int(np.count_nonzero(ranks < LEAST_CELLS))
        for cells, in_any_case in _parts(self._drawn[ranks] - first, sure, np.asarray(stored["steps"])):
            deadline = math.inf if in_any_case else began + allowed
            if time.monotonic() > deadline:
                break
            rows[:, :, cells] = self._follow(cells, starts, stored, deadline)
        self._seconds += time.monotonic() - began
        places = rows[:, : len(self._definition.states)]
        self.followed += int(np.count_nonzero(np.isfinite(places).all(axis=(0, 1))))
        found = {FOUND + name: rows[0, row] for row, name in enumerate(self._names)}
        return found | {OFF + name: rows[1, row] for row, name in enumerate(self._names)}

    def _follow(self, cells: Places, starts: Starts, stored: Columns, deadline: float) -> Array:
        """Return the values of some cells and their errors, shape (2, names, cells)."""
        given = {name: np.asarray(each, np.float64)[cells] for name, each in starts.items()}
        times = np.asarray(stored[tables.END_TIME], np.float64)[cells]
        ends = np.array([stored[each.name + tables.AT_END][cells] for each in self._definition.states])
        found = np.full((2, len(self._names), cells.size), np.nan)
        for row, tolerance in enumerate(_TOLERANCES):
            found[row] = follow(
                self._definition, self._tops, given, times, tolerance, sizes=np.abs(ends), deadline=deadline
            )
            if np.isnan(found[row, 0]).any():
                break
        rough, fine = found
        with np.errstate(invalid="ignore"):
            return np.array([fine, 2.0 * np.abs(fine - rough)])


def _parts(cells: Places, sure: int, steps: Array) -> Iterator[tuple[Places, bool]]:
    """Yield cells to follow together, and whether they are among the first ones, which are followed in any case.

    Those of a part share the steps of SciPy, so they are those whose motions take about as many.
    """
    rest = [cells[start : start + _NEXT_CELLS] for start in range(sure, cells.size, _NEXT_CELLS)]
    for number, some in enumerate([cells[:sure], *rest]):
        by_steps = some[np.argsort(steps[some], kind="stable")]
        for part in np.array_split(by_steps, _NEXT_PARTS if number else _FIRST_PARTS):
            if part.size:
                yield part, number == 0
