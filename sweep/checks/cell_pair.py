"""The cells of two aligned atlases, read block by block from both at once, and those of them that stand on an edge."""

from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from sweep.checks.alignment import Pair
from sweep.checks.difference import bitwise, other_bits
from sweep.checks.variables import Stated, allowed_of_cells
from sweep.engine.grid import Span
from sweep.files.cell_reader import CellReader
from sweep.model.description import Starts
from sweep.model.quantity import STABLE, UNSTABLE, Array, Truths
from sweep.runs.executor import prefetch

if TYPE_CHECKING:
    import xarray as xr


Values = npt.NDArray[Any]
Places = npt.NDArray[np.intp]


class Columns(dict[str, Values]):
    """Variables of some cells of an atlas; one that is not there yet is read when it is asked for."""

    def __init__(
        self, reader: CellReader, span: Span, which: Places | slice, held: dict[str, Values]
    ) -> None:
        super().__init__({name: each[which] for name, each in held.items()})
        self._reader, self._span, self._which = reader, span, which

    def at(self, which: Places) -> "Columns":
        """Return the same variables of some of all cells of the span."""
        return Columns(self._reader, self._span, which, self)

    def __missing__(self, name: str) -> Values:
        """Read a variable of the same cells."""
        self[name] = self._reader.read(name, self._span)[self._which]
        return self[name]


@dataclass(frozen=True)
class CellBlock:
    """Cells of a span: what both atlases hold of them, the new one first."""

    span: Span
    new: Columns
    reference: Columns

    def at(self, which: Places) -> "CellBlock":
        """Return the cells at some places of the block; the span stays that of the block."""
        return CellBlock(self.span, self.new.at(which), self.reference.at(which))


class CellPair:
    """Variables with one value per cell of two atlases.

    Parameters
    ----------
    pair : Pair
    seen : callable, optional
        Called with the number of cells of the present pass that are done.

    Attributes
    ----------
    shape : tuple of int
        That of the grid.
    names : set of str
        The variables with one number per cell that both have.
    """

    def __init__(self, pair: Pair, seen: Callable[[int], None] = lambda _: None) -> None:
        self.pair, self._seen = pair, seen
        self.shape: tuple[int, ...] = pair.reference["ending"].shape
        self._readers: list[CellReader] = []
        held = []
        sides = zip((pair.new, pair.reference), pair.as_given, pair.in_blocks, strict=True)
        for dataset, given, in_blocks in sides:
            names = _cell_shaped(dataset, pair.axes)
            self._readers.append(CellReader(dataset, names, whole=not (given or in_blocks)))
            held.append(set(names))
        self.names = held[0] & held[1]

    def blocks(self, names: Collection[str]) -> Iterator[CellBlock]:
        """Yield all cells in C order, with variables that both have; the names are looked at for each block anew."""
        with ExitStack() as stack:
            both = [stack.enter_context(prefetch(reader.blocks(names))) for reader in self._readers]
            for (span, new), (_, reference) in zip(*both, strict=True):
                every = slice(None)
                yield CellBlock(
                    span,
                    Columns(self._readers[0], span, every, new),
                    Columns(self._readers[1], span, every, reference),
                )
                self._seen(span.stop)

    def same(self, name: str, alike: Collection[str]) -> bool:
        """Return whether a variable that both have is the same to the bit, `alike` being those of the cells."""
        if name in self.names:
            return name in alike
        return bitwise(self.pair.new[name], self.pair.reference[name])

    def alike(self, names: Sequence[str]) -> set[str]:
        """Return which of the variables have the same bits in all cells."""
        left = set(names)
        for block in self.blocks(left) if left else ():
            for name in left & block.new.keys() & block.reference.keys():
                if other_bits(block.new[name], block.reference[name]).any():
                    left.discard(name)
            if not left:
                break
        return left

    def reference_at(self, name: str, places: Places) -> Values:
        """Return what the reference holds of cells at flat indices, which lie near each other."""
        span = Span(int(places.min()), int(places.max()) + 1)
        return self._readers[1].read(name, span)[places - span.start]

    def starts(self, places: Places) -> Starts:
        """Return the starts of cells at flat indices that the reference gives as coordinates, shape of `places`."""
        index = (
            dict(zip(self.pair.axes, np.unravel_index(places, self.shape), strict=True)) if self.shape else {}
        )
        return {
            str(name): _at(values, index, places.shape)
            for name, values in self.pair.reference.coords.items()
            if name in self.pair.spec.model.parameters
        }

    def stated(self, block: CellBlock) -> tuple[Stated, Stated]:
        """Return what the two atlases state of the cells of a block, the new one first."""
        name = self.pair.spec.model.error_name
        for dataset, columns in ((self.pair.new, block.new), (self.pair.reference, block.reference)):
            if name in dataset:
                # an atlas may lack it, so that it is only looked for among what has been read
                columns.setdefault(name, columns[name])
        return Stated(self.pair.specs[0], block.new), Stated(self.pair.specs[1], block.reference)


def _cell_shaped(dataset: "xr.Dataset", axes: tuple[str, ...]) -> list[str]:
    """Return the variables with one number per cell."""
    return [
        str(name)
        for name, each in dataset.variables.items()
        if each.dims == axes and each.dtype.kind in "biuf"
    ]


def _at(values: "xr.DataArray", index: dict[str, Any], shape: tuple[int, ...]) -> Array:
    if 0 in shape:
        return np.zeros(shape)
    places = [index[str(name)] for name in values.dims]
    # of a long axis no more than these cells need
    box = tuple(slice(int(each.min()), int(each.max()) + 1) for each in places)
    inside = tuple(each - part.start for each, part in zip(places, box, strict=True))
    return np.broadcast_to(np.asarray(values[box])[inside], shape)


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
