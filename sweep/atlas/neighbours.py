"""Neighbouring cells with unlike verdicts in the planes of a grid, found from its cells in C order, span by span."""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sweep.engine.grid import blocks
from sweep.model.quantity import UNDECIDED

#: Cells that are compared at a time: their verdicts and what is made of them fit the cache of a processor.
_AT_ONCE = 2**18

Ints = npt.NDArray[np.intp]
Verdicts = npt.NDArray[np.integer]


@dataclass(frozen=True)
class Pairs:
    """Pairs of neighbours that are decided and unlike: first those along the last axis but one, then along the last.

    Either kind is in C order.

    Parameters
    ----------
    plane : tuple of int
        Number of values along the last axis but one, and along the last.
    cells : array of int, shape (n,)
        Flat index of the first cell of each pair.
    verdicts : array of int8, shape (n,)
        Its verdict, stable or unstable; the second cell has the other one.
    down : int
        How many pairs lie along the last axis but one.
    """

    plane: tuple[int, int]
    cells: Ints
    verdicts: npt.NDArray[np.int8]
    down: int

    @property
    def along_last(self) -> npt.NDArray[np.bool_]:
        """Which pairs lie along the last axis, shape (n,)."""
        return np.arange(self.cells.size) >= self.down

    def of_planes(self, about: int) -> Iterator[tuple[Ints, "Pairs"]]:
        """Yield the pairs of several whole planes at a time, about so many, and their numbers among all of them."""
        area = self.plane[0] * self.plane[1]
        ends = np.unique(np.sort(self.cells // area)[about::about]) * area
        cuts = [
            itertools.pairwise([0, *np.searchsorted(kind, ends).tolist(), kind.size])
            for kind in (self.cells[: self.down], self.cells[self.down :])
        ]
        for down, across in zip(*cuts, strict=True):
            numbers = np.concatenate((np.arange(*down), self.down + np.arange(*across)))
            yield numbers, Pairs(self.plane, self.cells[numbers], self.verdicts[numbers], down[1] - down[0])


class NeighbourSearch:
    """Compares cells with their neighbours; they come in C order, in spans of any size.

    Of the verdicts it keeps those of the last line of cells, and the pairs that it found: 9 bytes each.

    Parameters
    ----------
    shape : tuple of int
        Shape of a grid of two axes or more. Neighbours lie in one plane of the last two.
    """

    def __init__(self, shape: tuple[int, ...]) -> None:
        self._plane = (shape[-2], shape[-1])
        line = shape[-1]
        # the verdicts up to `_end` are those of the last cells: undecided before the first one
        self._recent = np.full(line + max(line, _AT_ONCE), UNDECIDED, np.int8)
        self._end = line
        # along the last axis but one, and along the last: cells and verdicts
        self._found: tuple[list[tuple[Ints, Verdicts]], ...] = ([], [])

    def add(self, start: int, verdicts: Verdicts) -> None:
        """Take the verdicts of the cells that follow on those before.

        Parameters
        ----------
        start : int
            Flat index of the first cell.
        verdicts : array of int8, shape (n,)
        """
        for span in blocks(verdicts.size, _AT_ONCE):
            self._take(start + span.start, verdicts[span.start : span.stop])

    def pairs(self) -> Pairs:
        """Return all pairs, once all cells are there."""
        down, across = (
            [
                np.concatenate(each)
                for each in zip((np.zeros(0, np.intp), np.zeros(0, np.int8)), *kind, strict=True)
            ]
            for kind in self._found
        )
        cells, verdicts = (np.concatenate(each) for each in zip(down, across, strict=True))
        return Pairs(self._plane, cells, verdicts, len(down[0]))

    def _take(self, start: int, verdicts: Verdicts) -> None:
        line = self._plane[1]
        if self._end + verdicts.size > self._recent.size:
            self._recent[:line] = self._recent[self._end - line : self._end]
            self._end = line
        begin, self._end = self._end, self._end + verdicts.size
        self._recent[begin : self._end] = verdicts
        after = self._recent[begin : self._end]
        for back, count, found in zip((line, 1), self._plane, self._found, strict=True):
            here = self._recent[begin - back : self._end - back]
            at = np.flatnonzero((here != after) & (here != UNDECIDED) & (after != UNDECIDED))
            cells = start - back + at
            # what follows on the last line of a plane, or on the end of a line, is no neighbour
            near = cells // back % count != count - 1
            if near.any():
                found.append((cells[near], here[at[near]]))
