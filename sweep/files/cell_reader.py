"""The cells of an atlas, read block by block as flat columns of consecutive cells.

A block consists of a few whole chunks, so every chunk of a file is inflated once and an atlas of any size can be read.
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

#: Largest number of times that a chunk of a file may be inflated, on average, while all blocks are read in turn.
_MOST_TIMES = 2.0

Values = npt.NDArray[Any]
Slices = tuple[slice, ...]


class UnreadableError(OSError):
    """The cells of a variable cannot be read.

    Attributes
    ----------
    name : str
        The variable.
    """

    def __init__(self, name: str, problem: Exception) -> None:
        super().__init__(str(problem))
        self.name = name


class CellReader:
    """A reader of variables with one value per cell.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas in memory, or a lazily opened one.
    names : sequence of str
        Variables with the shape of the grid.
    whole : bool
        Read each variable as a whole on first use. Use this if the dataset selects or reorders the cells of its file.
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

        `names` is read again for each block, so it may change in between.

        Raises
        ------
        UnreadableError
        """
        for span in self.spans():
            yield span, {name: self.read(name, span) for name in tuple(names)}

    def spans(self) -> Iterator[Span]:
        """Yield the spans of `blocks`, each at most a block of computation or one chunk."""
        start, stop = 0, 0
        for span, _ in self._places:
            if span.stop - start > BLOCK_CELLS and stop > start:
                yield Span(start, stop)
                start = stop
            stop = span.stop
        if stop > start:
            yield Span(start, stop)

    def read(self, name: str, span: Span) -> Values:
        """Return the values of a variable in any span of cells, shape (len(span),); do not modify them.

        Raises
        ------
        UnreadableError
        """
        first = bisect_right(self._begins, span.start) - 1
        places = self._places[first : bisect_left(self._begins, span.stop)]
        if len(places) == 1:
            # a view, if the array is in memory
            return self._cut(name, *places[0], span)
        return np.concatenate([self._cut(name, chunk, slices, span) for chunk, slices in places])

    def _cut(self, name: str, chunk: Span, slices: Slices, span: Span) -> Values:
        """Return the values of a chunk that lie in a span."""
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
    """Return whether reading the grid by its chunks would inflate the chunks of the file several times."""
    stored = encoding.get("chunksizes")
    if not stored or len(stored) != len(shape):
        return False
    times = 1.0
    for size, ours, theirs in zip(shape, chunk, stored, strict=True):
        starts = np.arange(0, size, ours)
        touched = (np.minimum(starts + ours, size) - 1) // theirs - starts // theirs + 1
        times *= float(touched.sum()) / math.ceil(size / theirs)
    return times > _MOST_TIMES
