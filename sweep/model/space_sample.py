"""A sample of cells from the reduction, computed again in space with SciPy (`sweep.model.rigid_body`)."""

import math
import secrets
import time
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.model.audit import CellCheck
from sweep.model.description import Columns, Starts
from sweep.model.quantity import Array
from sweep.model.rigid_body import RigidBody

#: Largest number of cells drawn. After SECONDS no further cell is computed, once there are FEW.
_CELLS, SECONDS, FEW = 200, 2.0, 8

#: Longest scaled period in the sample; smallest energy between a motion and a maximum of the potential, over m g R:
#: closer to the separatrix the solution in space loses its digits.
_LONGEST, _LEAST_SEPARATRIX = 60.0, 1e-3

#: Relative tolerance of the solution in space, and of a second one that gives its error: a period loses digits near an
#: unstable pole.
_ACCURACIES = (1e-12, 3e-11)

#: Least error of the solution in space: tilts [rad], and periods, relative. In 1,000 random motions it was 2e-11.
_TILT_ERROR, _PERIOD_ERROR = 1e-9, 1e-9

#: Measures compared; `SpaceSample.follow` returns them and their errors under names with these prefixes.
COMPARED, PREFIX, ERROR = ("tilt_min", "tilt_max", "nutation_period"), "space_", "space_error_"

_AGAINST = "DOP853 in space, of a sample"


class SpaceSample:
    """Random cells of an atlas, and their motions in space.

    Parameters
    ----------
    size : int
        Number of cells of the atlas.
    seed : int, optional
        Seed of the random cells; a new one if not given.

    Attributes
    ----------
    seed : int
    followed : int
        Number of cells computed so far.
    """

    def __init__(self, size: int, seed: int | None) -> None:
        self.seed = secrets.randbelow(10**9) if seed is None else seed
        rng = np.random.default_rng(self.seed)
        # in a large atlas a few cells drawn twice do not matter
        drawn = rng.permutation(size) if size <= 10 * _CELLS else rng.integers(0, size, _CELLS)
        self._places, self._size = np.unique(drawn[:_CELLS]), size
        self.followed, self._spent = 0, 0.0

    def follow(
        self,
        starts: Starts,
        bodies: Mapping[str, Array],
        exact: Columns,
        bounded: npt.NDArray[np.bool_],
        first: int,
    ) -> dict[str, Array]:
        """Compute the motions of the drawn cells among the n cells from `first` on.

        Parameters
        ----------
        starts : mapping of str to array, shape (n,)
            Tilt, rates, radius and gravity [SI].
        bodies : mapping of str to array, shape (n,)
            The fields of `RigidBody`.
        exact : mapping of str to array, shape (n,)
            The results of the reduction.
        bounded : array of bool, shape (n,)
            Which cells have both turning points.
        first : int

        Returns
        -------
        dict of str to array, shape (n,)
            `COMPARED` with `PREFIX`, and its error with `ERROR`; NaN for cells that were not computed.
        """
        n = bounded.size
        columns = {prefix + name: np.full(n, np.nan) for prefix in (PREFIX, ERROR) for name in COMPARED}
        with np.errstate(divide="ignore", invalid="ignore"):
            unit = np.sqrt(starts["radius"] / starts["gravity"])
            short = bounded & (exact["nutation_period"] / unit < _LONGEST)
            short &= ~(np.abs(exact["separatrix"]) < _LEAST_SEPARATRIX)
        here = self._places[(self._places >= first) & (self._places < first + n)] - first
        # each block of cells gets its share of the time
        until = SECONDS * min(1.0, (first + n) / self._size)
        for cell in here[short[here]]:
            if self._spent > until and self.followed >= FEW:
                break
            begin = time.monotonic()
            values, rough = (_follow_cell(starts, bodies, int(cell), accuracy) for accuracy in _ACCURACIES)
            self._spent += time.monotonic() - begin
            for name, value, other in zip(COMPARED, values, rough, strict=True):
                columns[PREFIX + name][cell], columns[ERROR + name][cell] = value, abs(value - other)
            self.followed += 1
        return columns


def _follow_cell(
    starts: Starts, bodies: Mapping[str, Array], cell: int, accuracy: float
) -> tuple[float, float, float]:
    """Return the extreme tilts [rad] and the period [s] of a cell."""
    unit = math.sqrt(starts["radius"][cell] / starts["gravity"][cell])
    body = RigidBody(**{name: float(values[cell]) for name, values in bodies.items()})
    tilt, turn = float(starts["tilt"][cell]), float(starts["precession_rate"][cell]) * unit
    s = float(starts["roll_rate"][cell]) * unit + turn * math.sin(tilt)
    w, o = float(starts["tilt_rate"][cell]) * unit, turn * math.cos(tilt)
    least, greatest, period = body.extremes(tilt, w, o, s, end=3.0 * _LONGEST, accuracy=accuracy)
    return least, greatest, unit * period


def is_sampled(truth: Columns) -> bool:
    """Return whether columns include the columns of `SpaceSample.follow`."""
    return PREFIX + COMPARED[0] in truth


def compare_with_space(stored: Columns, truth: Columns, tilt_allowed: Array) -> list[CellCheck]:
    """Return the checks of cells against their motions in space.

    Parameters
    ----------
    stored : mapping of str to array, shape (n,)
        The variables of the atlas.
    truth : mapping of str to array, shape (n,)
        Includes the columns of `SpaceSample.follow`.
    tilt_allowed : array, shape (n,)
        Allowed error [rad] of an extreme tilt.
    """
    checks: list[CellCheck] = []
    for name in COMPARED:
        values: npt.NDArray[Any] = truth[PREFIX + name]
        # a value that the reduction cannot find is missing in the atlas too
        judged = np.isfinite(values) & np.isfinite(truth[name])
        with np.errstate(invalid="ignore"):
            difference = np.abs(stored[name] - values)
        least = _PERIOD_ERROR * values if name == "nutation_period" else tilt_allowed + _TILT_ERROR
        allowed = least + np.nan_to_num(truth[ERROR + name])
        checks.append(CellCheck(name, _AGAINST, difference, allowed, judged))
    return checks
