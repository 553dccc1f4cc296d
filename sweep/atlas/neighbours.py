"""Neighbouring cells with unlike verdicts in the planes of a grid, and the squares that join them, span by span."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sweep.engine.grid import Span
from sweep.model.quantity import STABLE, UNDECIDED, UNSTABLE, Truths

#: Squares that are looked at a time: their verdicts and what is made of them fit the cache of a processor.
_AT_ONCE = 2**17

#: No point.
NOWHERE = -1

#: The two kinds of pairs: of neighbours along the last axis but one, and along the last.
DOWN, ACROSS = range(2)

Ints = npt.NDArray[np.int64]
Verdicts = npt.NDArray[np.integer]

#: Returns the verdicts of any span of the cells in C order.
Read = Callable[[Span], Verdicts]

#: Returns the verdicts at the middles of squares, given by their first corners.
Middles = Callable[[Ints], Verdicts]


@dataclass(frozen=True)
class Joined:
    """Some pairs of decided and unlike neighbours of one kind, and to which other pairs they are joined.

    Parameters
    ----------
    places : array of int64, shape (n,)
        What the pairs are (`place_of`), in C order of their first cells.
    before, after : arrays of int64
        The link (`link_of`) of a pair in the square before it, and in that after it, or `NOWHERE`. These are lists of
        their own: each has all pairs in the same order, but a part may hold more of one than of the other.
    """

    places: Ints
    before: Ints
    after: Ints


def place_of(cells: Ints, verdicts: Verdicts, kind: int) -> Ints:
    """Return what pairs of a kind are as one number each: first cell, and its verdict."""
    return (cells << 3) | (verdicts.astype(np.int64) << 1) | kind


def parts_of(places: Ints) -> tuple[Ints, npt.NDArray[np.int8], Truths]:
    """Return first cells of pairs, their verdicts, and whether the pairs lie along the last axis."""
    return places >> 3, (places >> 1 & 3).astype(np.int8), (places & 1) == ACROSS


def link_of(numbers: Ints, kind: int) -> Ints:
    """Return a link to pairs by their numbers among those of their kind; the last bit is for one across a saddle."""
    return (numbers << 2) | (kind << 1)


def joined_pairs(shape: tuple[int, ...], read: Read, middles: Middles) -> Iterator[tuple[Joined, Joined]]:
    """Yield all pairs of unlike neighbours, along the last axis but one and along the last, and what joins them.

    Parameters
    ----------
    shape : tuple of int
        Shape of a grid of two axes or more. Neighbours lie in one plane of the last two.
    read : callable
        Asked for every cell once or twice; no more than some spans of cells are held, however long a line is.
    middles : callable

    Notes
    -----
    Marching squares. Two sides of a square with unlike ends are joined, of four the verdict at the middle says which
    belong together. A pair has a square before it, of which it is the right or the high side, and one after it, of
    which it is the left or the low side. Squares come in C order of their first corners, and so do the sides of each
    kind: what is said of them is appended. Squares in front of the first cell, and those at the end of a line or of a
    plane, join nothing.
    """
    line = shape[-1]
    squares = _Squares(shape, read, middles)
    for start in range(-line, squares.size, _AT_ONCE):
        yield squares.joined(start, min(start + _AT_ONCE, squares.size))


class _Squares:
    """The squares of a grid by their first corners, and how many pairs those before have begun with."""

    def __init__(self, shape: tuple[int, ...], read: Read, middles: Middles) -> None:
        self._plane = shape[-2:]
        self.size = int(np.prod(shape, dtype=np.int64))
        self._read, self._middles = read, middles
        # numbers of the next left or low side, and of the next high one
        self._next = [0, 0]
        self._next_high = 0

    def joined(self, start: int, stop: int) -> tuple[Joined, Joined]:
        """Return the pairs that begin at some cells, and what joins the sides of the squares there."""
        cells, verdicts, sides = self._sides(start, stop)
        is_left, is_low, is_right, is_high = sides
        first = self._next[DOWN]
        left = _numbered(is_left, first, DOWN)
        low = _numbered(is_low, self._next[ACROSS], ACROSS)
        # a side is the right one of the square before that of which it is the left one
        begins_left = bool(cells.size and cells[0] == start and is_left[0])
        right = _numbered(is_right, first + begins_left, DOWN)
        high = _numbered(is_high, self._next_high, ACROSS)
        self._next[DOWN] += int(is_left.sum())
        self._next[ACROSS] += int(is_low.sum())
        self._next_high += int(is_high.sum())
        to_left, to_low, to_right, to_high = self._links(cells, verdicts, np.stack((left, low, right, high)))
        return (
            Joined(place_of(cells[is_left], verdicts[is_left], DOWN), to_right[is_right], to_left[is_left]),
            Joined(place_of(cells[is_low], verdicts[is_low], ACROSS), to_high[is_high], to_low[is_low]),
        )

    def _sides(self, start: int, stop: int) -> tuple[Ints, Verdicts, Truths]:
        """Return squares with sides of unlike ends, their first verdicts, and which sides: left, low, right, high."""
        lines, line = self._plane
        here, beyond = self._lines(start, stop + 1)
        down = _unlike(here, beyond)
        low, high = _unlike(here[:-1], here[1:]), _unlike(beyond[:-1], beyond[1:])
        at = np.flatnonzero(down[:-1] | down[1:] | low | high)
        cells = start + at
        column, row = cells % line, cells // line % lines
        # what follows on the last line of a plane, or on the end of a line, is no neighbour
        in_line = column < line - 1
        is_above = row < lines - 1
        next_is_above = np.where(in_line, is_above, (row + 1) % lines < lines - 1)
        sides = (down[at] & is_above, low[at] & in_line, down[at + 1] & next_is_above, high[at] & in_line)
        return cells, here[at], np.stack(sides)

    def _lines(self, start: int, stop: int) -> tuple[Verdicts, Verdicts]:
        """Return the verdicts of a span of cells and of those one line after them, undecided where there are none."""
        line = self._plane[1]
        if line < stop - start:
            found = self._padded(start, stop + line)
            return found[: stop - start], found[line:]
        return self._padded(start, stop), self._padded(start + line, stop + line)

    def _padded(self, start: int, stop: int) -> Verdicts:
        found = np.full(stop - start, UNDECIDED, np.int8)
        begin, end = min(max(start, 0), self.size), min(max(stop, 0), self.size)
        if begin < end:
            found[begin - start : end - start] = self._read(Span(begin, end))
        return found

    def _links(self, cells: Ints, verdicts: Verdicts, sides: Ints) -> Ints:
        """Return what the sides of squares are joined to, shape (4, squares)."""
        lines, line = self._plane
        within = (cells >= 0) & (cells % line < line - 1) & (cells // line % lines < lines - 1)
        is_there = sides != NOWHERE
        crossed = np.where(within, is_there.sum(0), 0)
        # of two sides each is joined to what is left of their sum
        links = np.where(is_there & (crossed == 2), np.where(is_there, sides, 0).sum(0) - sides, NOWHERE)
        (saddle,) = np.nonzero(crossed == 4)
        if saddle.size:
            left, low, right, high = sides[:, saddle] | 1
            as_corner = self._middles(cells[saddle]) == verdicts[saddle]
            # joined to the middle, the first corner and the one opposite leave the two others cut off
            links[:, saddle] = np.where(as_corner, (high, right, low, left), (low, left, high, right))
        return links


def _unlike(one: Verdicts, other: Verdicts) -> Truths:
    """Return where of two verdicts one is stable and the other unstable."""
    # the codes are bits: no two others differ so
    return np.asarray((one ^ other) == STABLE ^ UNSTABLE)


def _numbered(which: Truths, first: int, kind: int) -> Ints:
    """Return links to sides, those that there are counted from `first`; `NOWHERE` for the others."""
    return np.where(which, link_of(first + np.cumsum(which) - 1, kind), NOWHERE)
