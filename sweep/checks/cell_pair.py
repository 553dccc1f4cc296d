"""The cells of two aligned atlases, read block by block from both at once."""

from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import numpy.typing as npt

from sweep.checks.alignment import Pair
from sweep.checks.allowed import Stated
from sweep.checks.difference import bitwise, other_bits
from sweep.engine.grid import Span
from sweep.files.cell_reader import CellReader
from sweep.model.description import Starts
from sweep.model.quantity import Array
from sweep.runs.executor import prefetch

if TYPE_CHECKING:
    import xarray as xr

Values = npt.NDArray[Any]
Places = npt.NDArray[np.intp]

#: The files that two atlases have just been opened from; None for one that has no file, or was changed since.
Files = tuple[Path | None, Path | None]


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
    """Variables with one value per cell of two atlases; a context manager.

    Parameters
    ----------
    pair : Pair
    files : Files
    seen : callable, optional
        Called with the number of cells of the present pass that are done.

    Attributes
    ----------
    shape : tuple of int
        That of the grid.
    names : set of str
        The variables with one number per cell that both have.
    """

    def __init__(self, pair: Pair, files: Files, seen: Callable[[int], None] = lambda _: None) -> None:
        self.pair, self._seen, self._stack = pair, seen, ExitStack()
        self.shape: tuple[int, ...] = pair.reference["ending"].shape
        self._readers: list[CellReader] = []
        held = []
        sides = zip((pair.new, pair.reference), files, pair.as_given, pair.in_blocks, strict=True)
        for dataset, file, given, in_blocks in sides:
            names = _cell_shaped(dataset, pair.axes)
            reader = CellReader(dataset, names, file if given else None, whole=not (given or in_blocks))
            self._readers.append(self._stack.enter_context(reader))
            held.append(set(names))
        self.names = held[0] & held[1]

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, problem: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stack.close()

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
