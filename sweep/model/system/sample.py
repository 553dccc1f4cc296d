"""A random sample of the cells of a system's atlas, followed by DOP853 to the times at which the atlas says they ended.

On lanes (`kernels.system.second`) also the greatest values on the way are found; a few cells are followed by SciPy too,
with NumPy's functions, which are the C library's. Each with two tolerances, whose difference says how far it is off.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.model.description import Columns, Starts
from sweep.model.kernel import Kernel
from sweep.model.quantity import Array, Truths
from sweep.model.system import tables
from sweep.model.system.cell_values import evaluated
from sweep.model.system.definition import TIME, Definition

#: Begin of the names of what each says; then of how far that may be off.
LANES, SCIPY, OFF = "lanes: ", "scipy: ", "off: "

#: Name of the greatest value of an expression until the end; they are numbered as the kernels do.
TOP = "top {}"

#: Cells of the sample, and how many of them SciPy follows too; the larger and the smaller tolerance of both.
_CELLS, _FEW, _TOLERANCES, _OF_SCIPY = 2000, 24, (1e-11, 1e-13), (1e-10, 1e-12)

#: How much longer than the shortest step on lanes one of SciPy may be; the least bound of a step, over the time.
_LONGER, _LEAST_STEP = 4.0, 1e-5

#: Evaluations of the rates by SciPy at most, about ten seconds: it would follow a stiff system without end.
_MOST_EVALUATIONS = 200_000


class Sample:
    """Cells of an atlas of a number of cells that are drawn at random.

    Parameters
    ----------
    definition : Definition
    second : Kernel
        Of `kernels.system.second`.
    tops : int
        How many greatest values that finds.
    size, seed : int

    Attributes
    ----------
    count, few : int
        How many cells are drawn, and how many of them SciPy follows too.
    """

    def __init__(self, definition: Definition, second: Kernel, tops: int, size: int, seed: int) -> None:
        self._definition, self._second = definition, second
        self._names = [each.name for each in definition.states]
        self._tops = [TOP.format(number) for number in range(tops)]
        drawn = np.random.default_rng(seed).choice(size, min(size, _CELLS), replace=False)
        self._drawn, self._by_scipy = drawn, drawn[:_FEW]
        self.count, self.few = self._drawn.size, self._by_scipy.size

    def of(self, starts: Starts, first: int, stored: Columns, known: Truths) -> Columns:
        """Return what both say of the cells from `first` on that are drawn and `known`; NaN of all others."""
        time = np.asarray(stored[tables.END_TIME], np.float64)
        found: dict[str, npt.NDArray[Any]] = {}
        for prefix, which, names, follow, tolerances in (
            (LANES, self._drawn, [*self._names, *self._tops], self._on_lanes, _TOLERANCES),
            (SCIPY, self._by_scipy, self._names, self._with_scipy, _OF_SCIPY),
        ):
            drawn = np.isin(first + np.arange(time.size), which) & known
            given = {name: np.asarray(each, np.float64)[drawn] for name, each in starts.items()}
            rows = np.full((2, len(names), time.size), np.nan)
            if drawn.any():
                rough, fine = (follow(given, time[drawn], each) for each in tolerances)
                rows[0][:, drawn], rows[1][:, drawn] = fine, 2.0 * np.abs(fine - rough)
            found |= {prefix + name: rows[0, row] for row, name in enumerate(names)}
            found |= {OFF + prefix + name: rows[1, row] for row, name in enumerate(names)}
        return found

    def _lanes(self, starts: Starts, times: Array, tolerance: float) -> Array:
        given = [*self._names, *(each.name for each in self._definition.parameters)]
        rows = np.array([*(starts[name] for name in given), times])
        measures = np.empty((len(self._names) + len(self._tops) + 1, times.size))
        self._second.load()(rows, np.array([tolerance]), measures, np.empty((1, times.size), np.int32))
        return measures

    def _on_lanes(self, starts: Starts, times: Array, tolerance: float) -> Array:
        return self._lanes(starts, times, tolerance)[:-1]

    def _with_scipy(self, starts: Starts, times: Array, tolerance: float) -> Array:
        # SciPy chooses its steps by the rates that it has seen, and would pass over a short push
        shortest = self._lanes(starts, times, tolerance)[-1] / times
        longest = max(_LONGER * float(np.min(shortest)), _LEAST_STEP)
        return followed(self._definition, starts, times, tolerance, longest)


def followed(
    definition: Definition, starts: Starts, times: Array, tolerance: float, longest: float = np.inf
) -> Array:
    """Return the states of some cells at a time of each, by SciPy's DOP853, shape (states, n); NaN where it gives up.

    Parameters
    ----------
    definition : Definition
    starts : mapping of str to array, shape (n,)
        States and parameters.
    times : array, shape (n,)
    tolerance : float
        Relative, of all states together.
    longest : float
        The longest step, over the time.
    """
    # this module is imported with the model, SciPy where an atlas is verified
    from scipy.integrate import solve_ivp

    names = [each.name for each in definition.states]
    first = np.array([starts[name] for name in names])
    shape = first.shape

    left = iter(range(_MOST_EVALUATIONS))

    def rate(share: float, flat: Array) -> Array:
        """Rates for a time that runs from 0 to 1 in every cell; not numbers once there were too many."""
        if next(left, None) is None:
            return np.full(flat.shape, np.nan)
        states = dict(zip(names, flat.reshape(shape), strict=True))
        found = evaluated(definition.rates, {**starts, **states, TIME: share * times})
        return np.ravel([np.broadcast_to(each, times.shape) * times for each in found])

    size = np.abs(first) + np.abs(rate(0.0, first.ravel())).reshape(shape)
    scale = np.broadcast_to(size.max(axis=1, keepdims=True), shape).ravel()
    with np.errstate(all="ignore"):
        found = solve_ivp(
            rate, (0.0, 1.0), first.ravel(), "DOP853", rtol=tolerance, atol=1e-4 * tolerance * scale + 1e-300,
            max_step=longest,
        )  # fmt: skip
    return found.y[:, -1].reshape(shape) if found.success else np.full(shape, np.nan)
