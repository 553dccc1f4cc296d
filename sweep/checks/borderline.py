"""Cells on an edge: where the last bit decides an ending or a verdict, both of two atlases may be right."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sweep.checks.allowed import allowed_of_cells
from sweep.checks.cell_pair import CellBlock, CellPair, Places
from sweep.engine.grid import Span
from sweep.model.quantity import STABLE, UNSTABLE, Truths

_NONE = np.zeros(0, np.intp)


@dataclass(frozen=True)
class Flips:
    """The cells whose ending, and those whose verdict, may be another one in the new atlas: increasing flat indices."""

    endings: Places
    verdicts: Places

    def of(self, name: str, span: Span) -> Truths:
        """Return which cells of a span may differ in a variable: in the verdict, or else as the ending allows."""
        places = self.verdicts if name == "stability" else self.endings
        begin, end = np.searchsorted(places, [span.start, span.stop])
        found = np.zeros(len(span), bool)
        found[places[begin:end] - span.start] = True
        return found

    @property
    def both(self) -> Places:
        """All of these cells."""
        return np.union1d(self.endings, self.verdicts)


def no_flips() -> Flips:
    """Return that no cell is on an edge."""
    return Flips(_NONE, _NONE)


def flips(cells: CellPair) -> Flips:
    """Return the cells of two atlases that stand on an edge.

    The ending of a cell does where a neighbour of it, in the reference, ended as the new atlas says: an ending changes
    where time, error or coordinate reaches its limit, and that edge runs between cells. With the same ending, a cell
    may be stable in one and unstable in the other where the limit of the criterion lies between the departures of the
    two, or within the tolerance of the extremes from either; a criterion of one's own where its comparisons are so for
    the variables that they name. Where the ending flips, the verdict that follows from it may flip too.
    """
    found = [_of_block(cells, block) for block in cells.blocks(("ending", "stability"))]
    return Flips(*(np.concatenate([_NONE, *each]) for each in zip(*found, strict=True)))


def _of_block(cells: CellPair, block: CellBlock) -> tuple[Places, Places]:
    endings, verdicts = _NONE, _NONE
    new, old = block.new, block.reference
    other = np.flatnonzero(new["ending"] != old["ending"])
    if other.size:
        other = other[_beside(cells, block.span.start + other, new["ending"][other])]
        endings = block.span.start + other
    differ = np.flatnonzero(new["stability"] != old["stability"])
    if differ.size:
        may = np.isin(differ, other)
        decided = np.all(
            [np.isin(each["stability"][differ], (STABLE, UNSTABLE)) for each in (new, old)], axis=0
        )
        close = decided & (new["ending"][differ] == old["ending"][differ])
        may[close] |= _at_limit(cells, block, differ[close])
        verdicts = block.span.start + differ[may]
    return endings, verdicts


def _beside(cells: CellPair, places: Places, codes: npt.NDArray[np.integer]) -> Truths:
    """Return which cells have a neighbour along any axis that has, in the reference, the code that they have."""
    found = np.zeros(places.shape, bool)
    if cells.pair.spec.is_list:
        # the next start of a list may lie anywhere
        return found
    index = np.unravel_index(places, cells.shape) if cells.shape else ()
    stride = 1
    for count, at in zip(reversed(cells.shape), reversed(index), strict=True):
        for step, there in ((-1, at > 0), (1, at < count - 1)):
            if there.any():
                found[there] |= codes[there] == cells.reference_at("ending", places[there] + step * stride)
        stride *= count
    return found


def _at_limit(cells: CellPair, block: CellBlock, which: Places) -> Truths:
    """Return which cells of a block, at some places of it, have the edge of the criterion between the two atlases."""
    if not which.size:
        return np.zeros(0, bool)
    spec, part, starts = cells.pair.spec, block.at(which), cells.starts(block.span.start + which)
    quantities, stated = spec.model.cell_variables(spec), cells.stated(part)
    return spec.criterion.on_edge(
        spec,
        starts,
        (part.new, part.reference),
        lambda name: allowed_of_cells(quantities[name], *stated, starts),
    )
