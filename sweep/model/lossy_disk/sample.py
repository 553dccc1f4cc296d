"""Cells of an atlas with losses, computed a second time: with half the step, and some by another integrator."""

import secrets
from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.model.description import Columns, Request, Starts
from sweep.model.lossy_disk import tables
from sweep.model.quantity import Array

#: Cells of an atlas that are integrated with half the step, and of these by another integrator; steps of such a cell at
#: most: some seconds of work in all.
CELLS, _FEW, _MOST_STEPS = 200, 8, 20_000

#: Half the step is this much less of the tolerance, for a method of the fourth order; and the least tolerance that long
#: motions meet in double precision.
_FINER, _LEAST_TOLERANCE = 16.0, 5e-13

#: What is compared, and the prefixes of the values of both second computations.
COMPARED = (
    "ending",
    "end_time",
    "end_tilt",
    "tilt_min",
    "tilt_max",
    *(each for _, each in tables.LOSSES.values()),
    "heading_turned",
    "path_length",
    "breach_time",
)
AGAIN, OTHER = "again_", "other_"

_OTHER = "sweep.model.lossy_disk.dop853:smooth_motion"


class Sample:
    """Cells that are drawn from an atlas, and what a second computation says of them.

    Parameters
    ----------
    size : int
        Number of cells of the atlas.
    seed : int, optional
        Which cells are drawn; a fresh one if not given.

    Attributes
    ----------
    seed : int
    count : int
        Number of cells that are drawn.
    others : int
        Cells so far that were integrated by SciPy.
    """

    def __init__(self, size: int, seed: int | None = None) -> None:
        self.seed = secrets.randbelow(10**9) if seed is None else seed
        rng = np.random.default_rng(self.seed)
        # of many cells the few that are drawn twice do not matter
        drawn = rng.permutation(size) if size <= 10 * CELLS else rng.integers(0, size, CELLS)
        self._places = np.unique(drawn[:CELLS])
        self.count, self.others = self._places.size, 0

    def of(self, spec: Request, starts: Starts, first: int) -> dict[str, npt.NDArray[Any]]:
        """Return what is known of the cells from `first` on with these starts, shape (n,); NaN of what is not drawn."""
        n = starts["tilt"].size
        there = self._places[(self._places >= first) & (self._places < first + n)] - first
        found = {f"{prefix}{name}": np.full(n, np.nan) for prefix in (AGAIN, OTHER) for name in COMPARED}
        if there.size:
            few = {name: values[there] for name, values in starts.items()}
            again = _again(spec, few)
            for name in COMPARED:
                found[AGAIN + name][there] = again[name]
            self._by_another(spec, few, again, there, found)
        return found

    def _by_another(
        self, spec: Request, starts: Starts, again: Columns, places: npt.NDArray[np.intp], found: Columns
    ) -> None:
        """Write what another integrator says of the first short motions in which friction neither held nor turned."""
        ends = np.isin(again["ending"], [tables.ENDINGS.code(name) for name in ("flat", "horizon")])
        smooth = ends & (again["switches"] == 0) & (again["steps"] <= _MOST_STEPS)
        smooth &= np.abs(starts["tilt"]) < spec.flat_tilt
        module, _, function = _OTHER.partition(":")
        for k in np.flatnonzero(smooth)[: _FEW - self.others]:
            follow: Callable[..., dict[str, float]] = getattr(import_module(module), function)
            for name, value in follow(spec, {name: float(each[k]) for name, each in starts.items()}).items():
                found[OTHER + name][places[k]] = value
            self.others += 1


def _again(spec: Request, starts: Starts) -> dict[str, Array]:
    """Return the measures and counts of cells, integrated with half the step."""
    model = spec.model
    rows = np.stack([starts[name] for name in model.parameters])
    settings = model.kernel_settings(spec)
    names = list(model.settings)
    settings[names.index("step")] *= 0.5
    settings[names.index("tolerance")] = max(spec.tolerance / _FINER, _LEAST_TOLERANCE)
    n = rows.shape[1]
    measures, counts = np.empty((len(model.measures), n)), np.zeros((len(model.counts), n), np.int32)
    model.integrator(spec).load()(rows, settings, measures, counts)
    return dict(zip((*model.measures, *model.counts), (*measures, *counts), strict=True))
