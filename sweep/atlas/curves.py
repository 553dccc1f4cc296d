"""The boundary of stability as curves: several, closed or not, through the planes of a grid."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from sweep.atlas.boundary import AT_ONCE, Brackets, Seen, bisected, unseen, verdicts
from sweep.atlas.cf_metadata import CURVES, POINTS
from sweep.atlas.chains import chains
from sweep.atlas.neighbours import Ints, Read, joined_pairs, parts_of
from sweep.atlas.scratch import Scratch
from sweep.engine.grid import Span, blocks, starts_at
from sweep.model.quantity import STABLE, UNSTABLE, Array, Truths
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr


class Curves:
    """The curves of a grid of verdicts as chains of points, one chain after the other.

    Each curve lies in a plane of the last two axes. Each point lies on a line of the grid between two neighbouring
    cells of unlike verdicts.

    Parameters
    ----------
    spec : SweepSpec
        Of two axes or more; the curves lie in the planes of the last two.
    read : callable
        Gives the verdicts of any span of the cells.
    scratch : Scratch
        Where the points are kept.
    seen : callable, optional
        Called now and then while they are joined.

    Notes
    -----
    Marching squares. Of a square whose corners alternate, the verdict at its middle says which corners belong together;
    it is integrated like a cell. A curve ends at the border of the grid and at undecided cells.

    In memory is what `sweep.atlas.neighbours.joined_pairs` and `sweep.atlas.chains.Chains` hold of the points, whatever
    the grid. All of them are in the scratch: 33 bytes each.
    """

    def __init__(
        self, spec: SweepSpec, read: Read, scratch: Scratch, seen: Callable[[], None] = lambda: None
    ) -> None:
        self._spec = spec
        chained = chains(scratch, joined_pairs(spec.shape, read, partial(_middle_verdicts, spec)), seen)
        self._places, self._counts, self._closed = chained.places, chained.counts, chained.closed
        #: Number of curves, and of the points of all.
        self.count, self.points = len(self._counts), len(self._places)

    def lengths(self, span: Span) -> tuple[npt.NDArray[np.int64], Truths]:
        """Return how many points some curves have, and whether the last of them leads back to the first.

        The open curves come first.
        """
        return self._counts.read(span.start, span.stop), self._closed.read(span.start, span.stop) != 0

    def measured(self, span: Span, width: float, seen: Seen = unseen) -> "Points":
        """Return some points, each bisected between its two cells to a bracket of some width [SI unit of its axis].

        `seen` is called with the share that is done.
        """
        cells, codes, along_last = parts_of(self._places.read(span.start, span.stop))
        near, far = _bracket(self._spec, cells, along_last, codes, width, seen)
        return Points(self._spec, cells, along_last, 0.5 * (near + far), 0.5 * np.abs(far - near))


@dataclass(frozen=True)
class Points:
    """Points of curves: the place along one axis was measured and has a half-width, the others are the grid's.

    Parameters
    ----------
    spec : SweepSpec
    cells : array of int, shape (n,)
        Flat index of the first of the two cells of each point.
    along_last : array of bool, shape (n,)
        Whether they are neighbours along the last axis, not along the last but one.
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
