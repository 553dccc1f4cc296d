"""The cells of an atlas block by block: its variables as flat columns of consecutive cells.

A block is a few whole chunks, so that of a file every chunk is inflated once and an atlas of any size can be read.
"""

import math
from bisect import bisect_left, bisect_right
from collections.abc import Collection, Generator, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from sweep.engine.grid import BLOCK_CELLS, Span, chunk_shape, chunks

if TYPE_CHECKING:
    import xarray as xr

#: How often a chunk of a file may be inflated while all blocks are read one after the other.
_MOST_TIMES = 2.0

Values = npt.NDArray[Any]
Slices = tuple[slice, ...]


class UnreadableError(OSError):
    """Cells of a variable cannot be read.

    Attributes
    ----------
    name : str
        The variable.
    """

    def __init__(self, name: str, problem: Exception) -> None:
        super().__init__(str(problem))
        self.name = name


class CellReader:
    """Reads variables with one value per cell.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas in memory, or opened from a file and not read yet.
    names : sequence of str
        Variables of one shape, that of the grid.
    whole : bool
        Read each variable as a whole when cells of it are asked for: of a dataset whose cells are others, or in another
        order, than those of its file.
    """

    def __init__(self, dataset: "xr.Dataset", names: Sequence[str], whole: bool = False) -> None:
        self._variables = {name: dataset[name].variable for name in names}
        shape = next(iter(self._variables.values())).shape
        self._places = list(chunks(shape))
        self._begins = [span.start for span, _ in self._places]
        self._at_once = {
            name
            for name, each in self._variables.items()
            if whole or _is_read_often(each.encoding, shape, chunk_shape(shape))
        }
        self._whole: dict[str, Values] = {}

    def blocks(self, names: Collection[str]) -> Generator[tuple[Span, dict[str, Values]]]:
        """Yield all cells in C order: spans of whole chunks, and the columns of some variables, shape (len(span),).

        The names are looked at for each block anew.

        Raises
        ------
        UnreadableError
        """
        for span in self.spans():
            yield span, {name: self.read(name, span) for name in tuple(names)}

    def spans(self) -> Iterator[Span]:
        """Yield the spans of `blocks`: no more than a block of computation each, or one chunk."""
        start, stop = 0, 0
        for span, _ in self._places:
            if span.stop - start > BLOCK_CELLS and stop > start:
                yield Span(start, stop)
                start = stop
            stop = span.stop
        if stop > start:
            yield Span(start, stop)

    def read(self, name: str, span: Span) -> Values:
        """Return the values of a variable in any span of cells, shape (len(span),); not to be changed.

        Raises
        ------
        UnreadableError
        """
        first = bisect_right(self._begins, span.start) - 1
        places = self._places[first : bisect_left(self._begins, span.stop)]
        if len(places) == 1:
            # of an array in memory this is a view
            return self._cut(name, *places[0], span)
        return np.concatenate([self._cut(name, chunk, slices, span) for chunk, slices in places])

    def _cut(self, name: str, chunk: Span, slices: Slices, span: Span) -> Values:
        """Return the cells of a chunk that lie in a span."""
        try:
            return self._chunk_of(name, slices)[max(0, span.start - chunk.start) : span.stop - chunk.start]
        except (OSError, RuntimeError) as problem:
            raise UnreadableError(name, problem) from problem

    def _chunk_of(self, name: str, slices: Slices) -> Values:
        if name in self._at_once and name not in self._whole:
            self._whole[name] = self._variables[name].values
        if name in self._whole:
            return self._whole[name][slices].reshape(-1)
        return np.asarray(self._variables[name][slices].values).reshape(-1)


def _is_read_often(encoding: Mapping[Any, Any], shape: tuple[int, ...], chunk: tuple[int, ...]) -> bool:
    """Return whether the chunks of a file lie so across those of the grid that each is inflated several times."""
    stored = encoding.get("chunksizes")
    if not stored or len(stored) != len(shape):
        return False
    times = 1.0
    for size, ours, theirs in zip(shape, chunk, stored, strict=True):
        starts = np.arange(0, size, ours)
        touched = (np.minimum(starts + ours, size) - 1) // theirs - starts // theirs + 1
        times *= float(touched.sum()) / math.ceil(size / theirs)
    return times > _MOST_TIMES
