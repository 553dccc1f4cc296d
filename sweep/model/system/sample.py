"""A random sample of the cells of a system's atlas, integrated by SciPy's DOP853 to their end times.

A time budget limits its size. Each cell is integrated with two tolerances, and their difference estimates the error.
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

#: Name of the integral that a measure follows from, and of the count, the time and the value of its moment.
INTEGRAL, OF_MOMENT = "{} integral", ("{} count", "{} time", "{} value")

#: Name of the greatest value of an expression until the end; they are numbered as in `tops_of`.
TOP = "top {}"

#: Most cells of the sample; seconds after which no further cells are started; cells that are integrated in any case.
MOST_CELLS, SECONDS, LEAST_CELLS = 2000, 5.0, 24

#: The larger and the smaller tolerance.
_TOLERANCES = (1e-10, 1e-12)

#: Number of parts of the first cells; size of each later group of cells, and its number of parts.
_FIRST_PARTS, _NEXT_CELLS, _NEXT_PARTS = 2, 400, 4


def tops_of(definition: Definition) -> list[Node]:
    """Return the expressions whose greatest values are needed: of all measures, then of all events."""
    tops = [
        node if measure.kind == "max" else Operation("neg", (node,))
        for measure in definition.measures
        if measure.tops
        for node in measure.expressions
    ]
    return [*tops, *(node for event in definition.ends for node in event.any_positive)]


class Sample:
    """Random cells of an atlas of `size` cells.

    Parameters
    ----------
    definition : Definition
    size, seed : int

    Attributes
    ----------
    count, followed : int
        Number of cells drawn, and number of them integrated to their ends so far.
    """

    def __init__(self, definition: Definition, size: int, seed: int) -> None:
        self._definition, self._tops = definition, tops_of(definition)
        self._names = [state.name for state in definition.states]
        measures = definition.measures
        self._names += [INTEGRAL.format(measure.name) for measure in measures if measure.is_integral]
        self._names += [TOP.format(number) for number in range(len(self._tops))]
        self._names += [
            each.format(measure.name) for measure in measures if measure.moment for each in OF_MOMENT
        ]
        self._drawn = np.random.default_rng(seed).choice(size, min(size, MOST_CELLS), replace=False)
        self._left, self._seconds = self._drawn.size, 0.0
        self.count, self.followed = self._drawn.size, 0

    def of(self, starts: Starts, first: int, stored: Columns, known: Truths) -> Columns:
        """Integrate the cells from `first` on that are drawn and `known`; NaN for other cells.

        Parameters
        ----------
        starts, stored : mapping of str to array, shape (n,)
        first : int
            Index of the first cell; calls come in the order of the cells.
        known : array of bool, shape (n,)
        """
        rows = np.full((2, len(self._names), known.size), np.nan)
        ranks = np.flatnonzero((self._drawn >= first) & (self._drawn < first + known.size))
        # cells come in blocks: each gets its share of the remaining time
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
        values = {FOUND + name: rows[0, row] for row, name in enumerate(self._names)}
        return values | {OFF + name: rows[1, row] for row, name in enumerate(self._names)}

    def _follow(self, cells: Places, starts: Starts, stored: Columns, deadline: float) -> Array:
        """Return the values of some cells and their errors, shape (2, names, cells)."""
        chosen = {name: np.asarray(values, np.float64)[cells] for name, values in starts.items()}
        times = np.asarray(stored[tables.END_TIME], np.float64)[cells]
        ends = [stored[state.name + tables.AT_END][cells] for state in self._definition.states]
        for measure in self._definition.measures:
            if measure.is_integral:
                ends.append(stored[measure.name][cells] * (times if measure.kind == "mean" else 1.0))
        results = np.full((2, len(self._names), cells.size), np.nan)
        for row, tolerance in enumerate(_TOLERANCES):
            results[row] = follow(
                self._definition, self._tops, chosen, times, tolerance, sizes=np.abs(ends), deadline=deadline
            )
            if np.isnan(results[row, 0]).any():
                break
        rough, fine = results
        with np.errstate(invalid="ignore"):
            return np.array([fine, 2.0 * np.abs(fine - rough)])


def _parts(cells: Places, sure: int, steps: Array) -> Iterator[tuple[Places, bool]]:
    """Yield cells to integrate together, and whether they are among the first cells, which are integrated in any case.

    The cells of a part share the steps of SciPy, so they are cells with similar numbers of steps.
    """
    rest = [cells[start : start + _NEXT_CELLS] for start in range(sure, cells.size, _NEXT_CELLS)]
    for number, some in enumerate([cells[:sure], *rest]):
        by_steps = some[np.argsort(steps[some], kind="stable")]
        for part in np.array_split(by_steps, _NEXT_PARTS if number else _FIRST_PARTS):
            if part.size:
                yield part, number == 0
