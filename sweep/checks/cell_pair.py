"""The cells of two aligned atlases, read block by block from both, and the cells that lie on an edge."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.checks.alignment import Pair
from sweep.checks.variables import Stated, allowed_of_cells
from sweep.engine.grid import Span
from sweep.files.cell_reader import CellReader
from sweep.model.description import Columns, Starts
from sweep.model.quantity import Array, Truths
from sweep.runs.executor import prefetch

Values = npt.NDArray[Any]
Places = npt.NDArray[np.intp]


@dataclass(frozen=True)
class CellBlock:
    """Cells of two atlases: their increasing flat indices, and their columns in each atlas."""

    pair: Pair
    places: Places
    new: Columns
    reference: Columns

    def at(self, which: Places) -> "CellBlock":
        """Return the cells at some positions in the block."""
        new, reference = (
            {name: held[which] for name, held in each.items()} for each in (self.new, self.reference)
        )
        return CellBlock(self.pair, self.places[which], new, reference)

    @cached_property
    def starts(self) -> Starts:
        """The starts of the cells in the reference."""
        dataset = self.pair.reference
        along = np.unravel_index(self.places, dataset["ending"].shape) if self.pair.axes else ()
        index = dict(zip(self.pair.axes, along, strict=True))
        return {
            str(name): self.reference[str(name)]
            if name in self.reference
            else _at(values.values, [index[str(dim)] for dim in values.dims], self.places.shape)
            for name, values in dataset.coords.items()
            if name in self.pair.spec.model.parameters
        }

    @property
    def stated(self) -> tuple[Stated, Stated]:
        """The specs and columns of both atlases, the new one first."""
        return Stated(self.pair.specs[0], self.new), Stated(self.pair.specs[1], self.reference)


def _at(values: Values, index: list[Places], shape: tuple[int, ...]) -> Array:
    return np.broadcast_to(values[tuple(index)], shape)


class CellPair:
    """Variables with one value per cell of two atlases.

    Parameters
    ----------
    pair : Pair
    seen : callable, optional
        Called with the number of finished cells.

    Attributes
    ----------
    names : set of str
        The variables with one number per cell that both atlases have.
    """

    def __init__(self, pair: Pair, seen: Callable[[int], None] = lambda _: None) -> None:
        self.pair, self._seen = pair, seen
        self._held = [
            [
                str(name)
                for name, each in dataset.variables.items()
                if each.dims == pair.axes and each.dtype.kind in "biuf"
            ]
            for dataset in (pair.new, pair.reference)
        ]
        self._readers = [
            CellReader(dataset, names, whole=not in_blocks)
            for dataset, names, in_blocks in zip(
                (pair.new, pair.reference), self._held, pair.in_blocks, strict=True
            )
        ]
        self.names = {*self._held[0]} & {*self._held[1]}

    def blocks(self) -> Iterator[CellBlock]:
        """Yield all cells in C order."""
        with ExitStack() as stack:
            both = [
                stack.enter_context(prefetch(reader.blocks(names)))
                for reader, names in zip(self._readers, self._held, strict=True)
            ]
            for (span, new), (_, reference) in zip(*both, strict=True):
                yield CellBlock(self.pair, np.arange(span.start, span.stop), new, reference)
                self._seen(span.stop)

    def flips(self, block: CellBlock) -> Mapping[str, Truths]:
        """Return which cells of a block lie on an edge, so that their ending or their verdict may flip.

        The ending of a cell may flip if a neighbor in the reference has the ending that the cell has in the new atlas:
        an ending changes where time, error or coordinate reaches its limit, and that edge runs between cells. With the
        same ending, the verdict of a cell may flip if the limit of the criterion lies between the departures in the two
        atlases, or within the tolerance of the extremes from either. For a user's criterion, the same holds for its
        comparisons and the variables in them. Where the ending flips, the verdict that depends on it may flip too.
        """
        new, old = block.new, block.reference
        endings, verdicts = (new[name] != old[name] for name in ("ending", "stability"))
        same_ending = ~endings
        endings[endings] = self._match_neighbors(block.at(np.flatnonzero(endings)))
        close = verdicts & same_ending
        close[close] = _at_limit(block.at(np.flatnonzero(close)))
        return {"ending": endings, "stability": verdicts & (endings | close)}

    def _match_neighbors(self, block: CellBlock) -> Truths:
        """Return which cells have a neighbour, along any axis, whose ending in the reference is their new ending."""
        found, shape = np.zeros(block.places.shape, bool), self.pair.reference["ending"].shape
        if self.pair.spec.is_list or not shape:
            # consecutive starts of a list are not neighbors
            return found
        stride = 1
        for count, at in zip(reversed(shape), reversed(np.unravel_index(block.places, shape)), strict=True):
            for step, there in ((-1, at > 0), (1, at < count - 1)):
                if there.any():
                    beside = self._reference_ending(block.places[there] + step * stride)
                    found[there] |= block.new["ending"][there] == beside
            stride *= count
        return found

    def _reference_ending(self, places: Places) -> Values:
        """Return the endings of some cells in the reference; the cells should lie near each other."""
        span = Span(int(places.min()), int(places.max()) + 1)
        return self._readers[1].read("ending", span)[places - span.start]


def _at_limit(block: CellBlock) -> Truths:
    """Return which cells have the limit of the criterion between their values in the two atlases."""
    if not block.places.size:
        return np.zeros(0, bool)
    spec, stated = block.pair.spec, block.stated
    quantities = spec.model.cell_variables(spec)
    return spec.criterion.on_edge(
        spec,
        block.starts,
        (block.new, block.reference),
        lambda name: allowed_of_cells(quantities[name], *stated, block.starts),
    )
