"""The boundary of stability as curves: several, closed or not, through the planes of a grid."""

import itertools
import math
from array import array
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from sweep.atlas.boundary import AT_ONCE, Brackets, Seen, bisected, unseen, verdicts
from sweep.atlas.cf_metadata import CURVES, POINTS
from sweep.atlas.neighbours import Pairs
from sweep.engine.grid import Span, blocks, starts_at
from sweep.model.quantity import STABLE, UNSTABLE, Array, Truths
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr

Ints = npt.NDArray[np.intp]


@dataclass(frozen=True)
class Curves:
    """Curves as chains of points, one chain after the other.

    Each curve lies in a plane of the last two axes. Each point lies on a line of the grid between two neighbouring
    cells of unlike verdicts.

    Parameters
    ----------
    spec : SweepSpec
    counts, closed : arrays, shape (curves,)
        The points of each curve, and whether its last point leads back to its first.
    cells : array of int, shape (points,)
        Flat index of the first of the two cells of each point.
    along_last : array of bool, shape (points,)
        Whether they are neighbours along the last axis, not along the last but one.
    verdicts : array of int8, shape (points,)
        Verdict of the first of the two cells.
    """

    spec: SweepSpec
    counts: Ints
    closed: Truths
    cells: Ints
    along_last: Truths
    verdicts: npt.NDArray[np.int8]

    def measured(self, span: Span, width: float, seen: Seen = unseen) -> "Points":
        """Return some points, each bisected between its two cells to a bracket of some width [SI unit of its axis].

        `seen` is called with the share that is done.
        """
        part = slice(span.start, span.stop)
        cells, along_last = self.cells[part], self.along_last[part]
        near, far = _bracket(self.spec, cells, along_last, self.verdicts[part], width, seen)
        return Points(self.spec, cells, along_last, 0.5 * (near + far), 0.5 * np.abs(far - near))


@dataclass(frozen=True)
class Points:
    """Points of curves: the place along one axis was measured and has a half-width, the others are the grid's.

    Parameters
    ----------
    spec : SweepSpec
    cells, along_last : arrays, shape (n,)
        As in `Curves`.
    middles, halfwidths : arrays, shape (n,)
        Of the bracket along the measured axis, in SI.
    """

    spec: SweepSpec
    cells: Ints
    along_last: Truths
    middles: Array
    halfwidths: Array

    def along(self, axis: str) -> tuple[Array, Array]:
        """Return where each point lies along an axis, and its half-width there, 0 where it was not measured; in SI."""
        after = self.spec.shape[self.spec.axes.index(axis) + 1 :]
        values = getattr(self.spec, axis)
        places = values.at(self.cells // math.prod(after) % len(values))
        is_measured = self._is_measured(axis)
        return np.where(is_measured, self.middles, places), np.where(is_measured, self.halfwidths, 0.0)

    def _is_measured(self, axis: str) -> Truths:
        if axis not in self.spec.axes[-2:]:
            return np.zeros(self.cells.size, bool)
        return np.asarray(self.along_last == (axis == self.spec.axes[-1]))


def curves(spec: SweepSpec, pairs: Pairs) -> Curves:
    """Join all places where neighbouring cells have unlike verdicts to curves.

    Parameters
    ----------
    spec : SweepSpec
        Of two axes or more; the curves lie in the planes of the last two.
    pairs : Pairs
        These neighbours.

    Returns
    -------
    Curves
        The open ones first. They hold 10 bytes per point; 60 per point, and 260 per point of one plane, are needed
        while they are joined.

    Notes
    -----
    Marching squares. Of a square whose corners alternate, the verdict at its middle says which corners belong together;
    it is integrated like a cell. A curve ends at the border of the grid and at undecided cells.
    """
    order, counts, closed = _joined(spec, pairs)
    return Curves(spec, counts, closed, pairs.cells[order], order >= pairs.down, pairs.verdicts[order])


def without_curves(dataset: "xr.Dataset") -> "xr.Dataset":
    """Return what an atlas holds on its grid: its dimensions are axes of its spec, and no others."""
    return dataset.drop_dims((CURVES, POINTS), errors="ignore")


def _bracket(
    spec: SweepSpec, cells: Ints, along_last: Truths, codes: npt.NDArray[np.int8], width: float, seen: Seen
) -> tuple[Array, Array]:
    """Return the ends of the bisected bracket between each cell, with its code, and the next."""
    one, other = spec.axes[-2:]
    along = np.where(along_last, *(list(spec.model.parameters).index(name) for name in (other, one)))
    starts = starts_at(spec, cells)
    beyond = starts_at(spec, cells + np.where(along_last, 1, spec.shape[-1]))
    near, far = (np.where(along_last, each[other], each[one]) for each in (starts, beyond))
    opposite = np.where(codes == STABLE, UNSTABLE, STABLE)
    fine = bisected(spec, Brackets(starts, along, near, far, codes, opposite), width, seen)
    return fine.near, fine.far


def _joined(spec: SweepSpec, pairs: Pairs) -> tuple[Ints, Ints, Truths]:
    """Return the numbers of the pairs in the order of the curves, how many each curve has, and which are closed.

    Open curves come first. Among themselves both kinds are ordered by the pair that they begin with.
    """
    order, counts, closed = [np.zeros(0, np.intp)], [np.zeros(0, np.intp)], [np.zeros(0, bool)]
    for numbers, part in pairs.of_planes(AT_ONCE):
        chains, loops = _chains(_links(spec, part))
        order.append(numbers[np.concatenate([*chains, np.zeros(0, np.intp)])])
        counts.append(np.array([len(chain) for chain in chains], np.intp))
        closed.append(np.array(loops, bool))
    every, lengths, loop = np.concatenate(order), np.concatenate(counts), np.concatenate(closed)
    begins = np.cumsum(lengths) - lengths
    by = np.lexsort((every[begins], loop))
    lengths = lengths[by]
    shift = begins[by] - (np.cumsum(lengths) - lengths)
    return every[np.repeat(shift, lengths) + np.arange(every.size)], lengths, loop[by]


def _links(spec: SweepSpec, pairs: Pairs) -> Ints:
    """Return the two points that each point is joined to, -1 for none, shape (points, 2)."""
    squares = _squares(pairs)
    line = pairs.plane[1]
    down, across = pairs.cells[: pairs.down], pairs.cells[pairs.down :]
    # the four sides of each square: left and right run along the first of the two axes, low and high along the last
    left, right = (_numbers(down, squares + by, 0) for by in (0, 1))
    low, high = (_numbers(across, squares + by, pairs.down) for by in (0, line))
    sides = np.stack((left, low, right, high))
    crossed = (sides >= 0).sum(0)
    joined = np.sort(sides[:, crossed == 2].T, axis=1)[:, 2:]
    saddle = crossed == 4
    if saddle.any():
        a, b, c, d = sides[:, saddle]
        as_corner = _middle_verdicts(spec, squares[saddle], line) == pairs.verdicts[a]
        # joined to the middle, the first corner and the one opposite leave the two others cut off
        cut = np.where(as_corner, (a, d, b, c), (a, b, c, d)).T
        joined = np.concatenate((joined, cut.reshape(-1, 2)))
    return _linked(joined, pairs.cells.size)


def _squares(pairs: Pairs) -> Ints:
    """Return the first corners of all squares with a crossed side, in C order."""
    lines, line = pairs.plane
    down, across = pairs.cells[: pairs.down], pairs.cells[pairs.down :]
    column, row = down % line, across // line % lines
    beside = (down[column < line - 1], down[column > 0] - 1, across[row < lines - 1], across[row > 0] - line)
    return np.unique(np.concatenate(beside))


def _numbers(cells: Ints, wanted: Ints, first: int) -> Ints:
    """Return where increasing `cells` hold the wanted ones, counted from `first`; -1 where they do not."""
    at = np.searchsorted(cells, wanted)
    held = np.append(cells, -1)[at] == wanted
    return np.where(held, at + first, -1)


def _middle_verdicts(spec: SweepSpec, squares: Ints, line: int) -> npt.NDArray[np.int8]:
    """Return the verdicts at the middles of squares, given by their first corners."""
    found = np.empty(squares.size, np.int8)
    number = list(spec.model.parameters).index(spec.axes[-1])
    for span in blocks(squares.size, AT_ONCE):
        corners = squares[span.start : span.stop]
        opposite = starts_at(spec, corners + line + 1)
        starts = {name: 0.5 * (each + opposite[name]) for name, each in starts_at(spec, corners).items()}
        place, nothing = starts[spec.axes[-1]], np.zeros(len(span), np.int8)
        at = Brackets(starts, np.full(len(span), number), place, place, nothing, nothing)
        found[span.start : span.stop] = verdicts(spec, at, np.arange(len(span)), place)
    return found


def _linked(joined: Ints, points: int) -> Ints:
    """Return what each point is joined to, from pairs of points, shape (n, 2): what is named first comes first."""
    here, there = np.concatenate((joined, joined[:, ::-1])).T
    order = np.argsort(here, kind="stable")
    here, there = here[order], there[order]
    again = np.append(False, here[1:] == here[:-1])[: here.size]
    links = np.full((points, 2), -1)
    links[here[~again], 0], links[here[again], 1] = there[~again], there[again]
    return links


def _chains(links: Ints) -> tuple[list[Ints], list[bool]]:
    """Follow the links: open curves from their ends first, then closed ones; returns the points of each."""
    # lists of integers took 50 bytes more per point, and half as much time again
    joined, seen = links.reshape(-1).data, bytearray(len(links))
    chains: list[Ints] = []
    closed: list[bool] = []
    for start in itertools.chain(np.flatnonzero(links[:, 1] < 0).tolist(), range(len(links))):
        if seen[start]:
            continue
        chain, here = array("q"), start
        while here >= 0:
            seen[here] = True
            chain.append(here)
            ahead = joined[2 * here : 2 * here + 2]
            here = next((each for each in ahead if each >= 0 and not seen[each]), -1)
        chains.append(np.array(chain, np.intp))
        closed.append(start in links[chain[-1]] and len(chain) > 2)
    return chains, closed
