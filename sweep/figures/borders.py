"""Borders between the stable and the unstable cells of a map, and the places where they would hide it."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.model.quantity import STABLE, UNSTABLE, Array, Truths

#: Half the side of the square in which borders are counted [cells], and the number of borders per cell from which on
#: they are crowded. A straight border has 0.14, a diagonal one 0.27, cells of random verdicts have 1.
_REACH, _CROWDED = 3, 0.4

#: Least number of cells by which the count is divided: among only the sixteen cells in a corner, a diagonal would crowd
#: half.
_LEAST_COUNTED = 30

#: Least number of a cell's eight neighbours that share its verdict, for a line around it that does not just enclose a
#: dot: a corner of a large region has three.
_LEAST_ALIKE = 3


@dataclass(frozen=True)
class Borders:
    """Borders that can be drawn as lines, and the cells where they cannot.

    `upright` and `level` contain the rows and the columns of the cells to the left of a border and below it. `mixed`
    marks the cells whose verdicts alternate.
    """

    upright: tuple[npt.NDArray[np.intp], ...]
    level: tuple[npt.NDArray[np.intp], ...]
    mixed: Truths


def find_borders(stability: npt.NDArray[np.integer]) -> Borders:
    """Return the borders between stable and unstable cells of a map.

    Omits borders where the verdicts of single cells alternate, because the lines would cover the cells, and borders
    around a single cell.

    Parameters
    ----------
    stability : array of int, shape (rows, columns)
        Codes of verdicts.
    """
    pairs: Any = (np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])
    borders = [_are_unlike(stability[first], stability[second]) for first, second in pairs]
    count = np.zeros(stability.shape)
    for (first, _), border in zip(pairs, borders, strict=True):
        count[first] += border
    mixed = _mean_around(count) > _CROWDED
    is_clear = ~mixed & (_alike(stability) >= _LEAST_ALIKE)
    upright, level = (
        np.nonzero(border & is_clear[first] & is_clear[second])
        for (first, second), border in zip(pairs, borders, strict=True)
    )
    return Borders(upright, level, mixed)


def _are_unlike(first: npt.NDArray[np.integer], second: npt.NDArray[np.integer]) -> Truths:
    """Return where one of two cells is stable and the other unstable."""
    return np.asarray(((first == STABLE) & (second == UNSTABLE)) | ((first == UNSTABLE) & (second == STABLE)))


def _alike(stability: npt.NDArray[np.integer]) -> npt.NDArray[np.intp]:
    """Return how many of each cell's eight neighbours share its verdict; the map is extended by its outermost cells."""
    rows, columns = stability.shape
    padded = np.pad(stability, 1, mode="edge")
    shifted = [padded[i : i + rows, j : j + columns] == stability for i in range(3) for j in range(3)]
    return np.sum(shifted, axis=0) - 1


def _mean_around(values: Array) -> Array:
    """Return the mean of values over a square around each cell, cut off at the edge of the map."""
    count = _sums_around(np.ones(values.shape))
    return _sums_around(values) / np.maximum(count, _LEAST_COUNTED)


def _sums_around(values: Array) -> Array:
    side = 2 * _REACH + 1
    sums = np.pad(np.cumsum(np.cumsum(np.pad(values, _REACH), axis=0), axis=1), ((1, 0), (1, 0)))
    return np.asarray(sums[side:, side:] - sums[:-side, side:] - sums[side:, :-side] + sums[:-side, :-side])
