"""The stability boundary as curves, open or closed, in the planes of a grid."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from sweep.atlas.boundary import AT_ONCE, Brackets, Seen, bisected, unseen, verdicts
from sweep.atlas.cf_metadata import CURVES, POINTS
from sweep.atlas.row_edges import Verdicts
from sweep.engine.grid import blocks, starts_at
from sweep.model.quantity import STABLE, UNSTABLE, Array, Truths
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr

#: No point.
NOWHERE = -1

#: The two kinds of points: between neighbours along the last axis but one, and along the last.
_DOWN, _ACROSS = range(2)

Ints = npt.NDArray[np.int64]


class Curves:
    """The curves of a grid of verdicts as chains of points, one chain after the other.

    Each curve lies in a plane of the last two axes. Each point lies on a line of the grid, between two neighboring
    cells with different verdicts.

    Parameters
    ----------
    spec : SweepSpec
        A spec with two or more axes; the curves lie in the planes of the last two.
    stability : array of int8, shape of the grid
        The verdicts of its cells.

    Attributes
    ----------
    counts, closed : arrays, shape (curves,)
        The number of points of each curve, and whether the last point is joined to the first. The open curves come
        first. Open curves and loops are each sorted by their starting points: an open curve starts at the first of its
        ends, a loop at the first of its points.
    cells : array of int64, shape (points,)
        Flat index of the first of the two cells of each point, curve after curve.
    along_last : array of bool, shape (points,)
        Whether the two cells are neighbors along the last axis, not along the last but one.
    codes : array of int8, shape (points,)
        Verdict of the first cell.

    Notes
    -----
    Marching squares. In a square, the two sides whose ends have different verdicts are joined. If the corners
    alternate, the verdict at the middle, which is integrated like a cell, decides which sides are joined. A curve ends
    at the border of the grid and at undecided cells.
    """

    def __init__(self, spec: SweepSpec, stability: Verdicts) -> None:
        self._spec = spec
        planes = stability.reshape(-1, *spec.shape[-2:])
        cells, links = _all_joined(spec, planes)
        order, lengths, loops = _chains(links)
        self.counts, self.closed = np.array(lengths, np.int64), np.array(loops, bool)
        kind = np.array([number & 1 for number in order], np.int64)
        at = np.array([number >> 1 for number in order], np.int64)
        self.along_last: Truths = kind == _ACROSS
        self.cells = np.empty(at.size, np.int64)
        for each in (_DOWN, _ACROSS):
            self.cells[kind == each] = cells[each][at[kind == each]]
        self.codes = planes.reshape(-1)[self.cells].astype(np.int8)

    def measured(self, width: float, seen: Seen = unseen) -> "Points":
        """Return the points, each bisected between its two cells to a bracket of a given width [SI unit of its axis].

        `seen` is called with the completed share.
        """
        near, far = _bracket(self._spec, self.cells, self.along_last, self.codes, width, seen)
        return Points(self._spec, self.cells, self.along_last, 0.5 * (near + far), 0.5 * np.abs(far - near))


@dataclass(frozen=True)
class _Links:
    """The two points to which each point is joined, in the square before it and in the square after it.

    A link is twice the number of the other point, plus 1 if the link crosses a saddle; `NOWHERE` if there is no link.
    The number of a point is twice its number among the points of its kind, plus the kind.
    """

    before: Ints
    after: Ints


def _all_joined(spec: SweepSpec, planes: Verdicts) -> tuple[tuple[Ints, Ints], tuple[_Links, _Links]]:
    """Return the first cells and the links of both kinds of points, over all planes."""
    found, counts = list[tuple[tuple[Ints, Ints], tuple[_Links, _Links]]](), [0, 0]
    for number, plane in enumerate(planes):
        found.append(_joined(spec, plane, number * plane.size, (counts[_DOWN], counts[_ACROSS])))
        counts = [count + cells.size for count, cells in zip(counts, found[-1][0], strict=True)]
    cells = tuple(np.concatenate([part[0][kind] for part in found]) for kind in (_DOWN, _ACROSS))
    links = tuple(
        _Links(
            np.concatenate([part[1][kind].before for part in found]),
            np.concatenate([part[1][kind].after for part in found]),
        )
        for kind in (_DOWN, _ACROSS)
    )
    return (cells[_DOWN], cells[_ACROSS]), (links[_DOWN], links[_ACROSS])


def _joined(
    spec: SweepSpec, plane: Verdicts, first: int, numbers: tuple[int, int]
) -> tuple[tuple[Ints, Ints], tuple[_Links, _Links]]:
    """Return the points of one plane as `_all_joined` does, given its first cell and the first point numbers."""
    line = plane.shape[1]
    down, across = _unlike(plane[:-1], plane[1:]), _unlike(plane[:, :-1], plane[:, 1:])
    cells = tuple(row * line + column for row, column in (np.nonzero(down), np.nonzero(across)))
    row, column = np.nonzero(down[:, :-1] | down[:, 1:] | across[:-1] | across[1:])
    corner = row * line + column
    # the points on the sides of each square: left, low, right, high
    sides = np.stack(
        [
            _numbers(cells[kind], corner + beyond, kind, numbers[kind])
            for kind, beyond in ((_DOWN, 0), (_ACROSS, 0), (_DOWN, 1), (_ACROSS, line))
        ]
    )
    links = _links_of_sides(spec, sides, corner + first, plane[row, column])
    left, low, right, high = sides
    to_left, to_low, to_right, to_high = links
    joined = []
    for kind, (begin, to_begin, end, to_end) in enumerate(
        ((right, to_right, left, to_left), (high, to_high, low, to_low))
    ):
        before, after = (np.full(cells[kind].size, NOWHERE, np.int64) for _ in range(2))
        for into, side, link in ((before, begin, to_begin), (after, end, to_end)):
            has_point = side != NOWHERE
            into[(side[has_point] >> 2) - numbers[kind]] = link[has_point]
        joined.append(_Links(before, after))
    return (cells[_DOWN] + first, cells[_ACROSS] + first), (joined[_DOWN], joined[_ACROSS])


def _unlike(one: Verdicts, other: Verdicts) -> Truths:
    """Return where one of two verdicts is stable and the other unstable."""
    # the codes are bits: no other two differ in these
    return np.asarray((one ^ other) == STABLE ^ UNSTABLE)


def _numbers(cells: Ints, wanted: Ints, kind: int, first: int) -> Ints:
    """Return links to the points that begin at the wanted cells; `NOWHERE` if no point does."""
    at = np.searchsorted(cells, wanted)
    has_point = np.append(cells, NOWHERE)[at] == wanted
    return np.where(has_point, (at + first) << 2 | kind << 1, NOWHERE)


def _links_of_sides(spec: SweepSpec, sides: Ints, corners: Ints, codes: Verdicts) -> Ints:
    """Return the links of the sides of squares, shape (4, squares)."""
    is_there = sides != NOWHERE
    crossed = is_there.sum(0)
    # each of two sides is joined to the other one: their sum minus itself
    links = np.where(is_there & (crossed == 2), np.where(is_there, sides, 0).sum(0) - sides, NOWHERE)
    (saddle,) = np.nonzero(crossed == 4)
    if saddle.size:
        left, low, right, high = sides[:, saddle] | 1
        as_corner = _middle_verdicts(spec, corners[saddle]) == codes[saddle]
        # if the middle is like the first corner, the curve cuts off the two other corners
        links[:, saddle] = np.where(as_corner, (high, right, low, left), (low, left, high, right))
    return np.asarray(links)


def _chains(links: tuple[_Links, _Links]) -> tuple[list[int], list[int], list[bool]]:
    """Return the numbers of all points chain after chain, the lengths of the chains, and which are loops."""
    joined = tuple((each.before.tolist(), each.after.tolist()) for each in links)
    passed = tuple(bytearray(len(before)) for before, _ in joined)
    order, lengths, loops = list[int](), list[int](), list[bool]()

    def follow(start: int, came: int, is_loop: bool) -> None:
        """Follow the points from `start`, away from `came`, to an end or back to the start."""
        here, begin = start, len(order)
        while here not in (NOWHERE, start) or len(order) == begin:
            kind, at = here & 1, here >> 1
            passed[kind][at] = 1
            order.append(here)
            before, after = (each[at] >> 1 for each in joined[kind])
            here, came = after if before == came else before, here
        lengths.append(len(order) - begin)
        loops.append(is_loop)

    for number in _ends(links):
        if not passed[number & 1][number >> 1]:
            follow(number, NOWHERE, False)
    # the first point of a loop is of the first kind, because a loop turns at both ends of its first line
    before, after = joined[_DOWN]
    at = 0
    while (at := passed[_DOWN].find(0, at)) >= 0:
        # backward, but if possible not through a saddle
        forward = before[at] & 1 and not after[at] & 1
        follow(at << 1 | _DOWN, before[at] >> 1 if forward else NOWHERE, True)
    return order, lengths, loops


def _ends(links: tuple[_Links, _Links]) -> Iterator[int]:
    """Yield the numbers of the points that are joined to at most one other point."""
    for kind, each in enumerate(links):
        (at,) = np.nonzero((each.before == NOWHERE) | (each.after == NOWHERE))
        yield from (at << 1 | kind).tolist()


@dataclass(frozen=True)
class Points:
    """Points of curves. Their position along one axis is measured and has a half-width, the others are grid values.

    Parameters
    ----------
    spec : SweepSpec
    cells : array of int, shape (n,)
        Flat index of the first of the two cells of each point.
    along_last : array of bool, shape (n,)
        Whether the two cells are neighbors along the last axis, not along the last but one.
    middles, halfwidths : arrays, shape (n,)
        Middle and half-width of the bracket along the measured axis, in SI.
    """

    spec: SweepSpec
    cells: Ints
    along_last: Truths
    middles: Array
    halfwidths: Array

    def along(self, axis: str) -> tuple[Array, Array]:
        """Return the position of each point along an axis, and its half-width, 0 if it was not measured; in SI."""
        after = self.spec.shape[self.spec.axes.index(axis) + 1 :]
        values = getattr(self.spec, axis)
        places = values.at(self.cells // math.prod(after) % len(values))
        is_measured = self._is_measured(axis)
        return np.where(is_measured, self.middles, places), np.where(is_measured, self.halfwidths, 0.0)

    def _is_measured(self, axis: str) -> Truths:
        if axis not in self.spec.axes[-2:]:
            return np.zeros(self.cells.size, bool)
        return np.asarray(self.along_last == (axis == self.spec.axes[-1]))


def without_curves(dataset: "xr.Dataset") -> "xr.Dataset":
    """Return an atlas without its curves, so that all its dimensions are axes of its spec."""
    return dataset.drop_dims((CURVES, POINTS), errors="ignore")


def _bracket(
    spec: SweepSpec, cells: Ints, along_last: Truths, codes: npt.NDArray[np.int8], width: float, seen: Seen
) -> tuple[Array, Array]:
    """Return the ends of the bisected bracket between each cell, whose verdict is in `codes`, and the next cell."""
    one, other = spec.axes[-2:]
    along = np.where(along_last, *(list(spec.model.parameters).index(name) for name in (other, one)))
    starts = starts_at(spec, cells)
    beyond = starts_at(spec, cells + np.where(along_last, 1, spec.shape[-1]))
    near, far = (np.where(along_last, each[other], each[one]) for each in (starts, beyond))
    opposite = np.where(codes == STABLE, UNSTABLE, STABLE)
    fine = bisected(spec, Brackets(starts, along, near, far, codes, opposite), width, seen)
    return fine.near, fine.far


def _middle_verdicts(spec: SweepSpec, squares: Ints) -> npt.NDArray[np.int8]:
    """Return the verdicts at the middles of squares, given by their first corners."""
    line = spec.shape[-1]
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
