"""The cells of an atlas block by block: its variables as flat columns of consecutive cells.

A block is a few whole chunks, so that of a file every chunk is inflated once and an atlas of any size can be read.
"""

import contextlib
import math
from bisect import bisect_left, bisect_right
from collections.abc import Collection, Generator, Iterator, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import numpy.typing as npt

from sweep.engine.grid import BLOCK_CELLS, Span, chunk_shape, chunks
from sweep.files.inflated_chunks import InflatedChunks

if TYPE_CHECKING:
    import xarray as xr

#: Smaller atlases are read before h5py would be imported.
RAW_CELLS = 2**17

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
    """Reads variables with one value per cell; a context manager.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas in memory, or opened from a file and not read yet.
    names : sequence of str
        Variables of one shape, that of the grid.
    file : Path, optional
        The file that the dataset has just been opened from, if nothing has been changed in it since: chunks that this
        program has written can then be read without netCDF (`sweep.files.inflated_chunks`).
    whole : bool
        Read each variable as a whole when cells of it are asked for: of a dataset whose cells are others, or in another
        order, than those of its file.
    """

    def __init__(
        self, dataset: "xr.Dataset", names: Sequence[str], file: Path | None = None, whole: bool = False
    ) -> None:
        self._variables = {name: dataset[name].variable for name in names}
        self._shape = next(iter(self._variables.values())).shape
        self._chunk = chunk_shape(self._shape)
        self._places = list(chunks(self._shape))
        self._begins = [span.start for span, _ in self._places]
        self._at_once = {
            name
            for name, each in self._variables.items()
            if whole or _is_read_often(each.encoding, self._shape, self._chunk)
        }
        self._whole: dict[str, Values] = {}
        self._stack = contextlib.ExitStack()
        self._raw: InflatedChunks | None = None
        if file is not None and not whole and math.prod(self._shape) > RAW_CELLS:
            # a system that lets a file be open only once leaves it to netCDF
            with contextlib.suppress(OSError):
                self._raw = self._stack.enter_context(InflatedChunks(file.absolute()))
        self._is_raw = {
            name: self._raw is not None and self._raw.fits(name, self._chunk, each.dtype)
            for name, each in self._variables.items()
        }

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, problem: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stack.close()

    def blocks(self, names: Collection[str]) -> Generator[tuple[Span, dict[str, Values]], None, None]:
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
        places = self._over(span)
        if len(places) == 1 and not self._is_raw[name]:
            # of an array in memory this is a view
            return self._cut(name, *places[0], span)
        found = np.empty(len(span), self._variables[name].dtype)
        for each, slices in places:
            part = Span(max(each.start, span.start), min(each.stop, span.stop))
            into = found[part.start - span.start : part.stop - span.start]
            if not (self._is_raw[name] and self._read_raw(name, each, slices, part, into)):
                into[...] = self._cut(name, each, slices, span)
        return found

    def _over(self, span: Span) -> list[tuple[Span, Slices]]:
        """Return the chunks that hold cells of a span."""
        first = bisect_right(self._begins, span.start) - 1
        return self._places[first : bisect_left(self._begins, span.stop)]

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

    def _read_raw(self, name: str, chunk: Span, slices: Slices, part: Span, out: Values) -> bool:
        """Read a part of a chunk without netCDF, NaN where it holds the value that stands for "missing"."""
        if self._raw is None:
            return False
        place = tuple(each.start for each in slices)
        sizes = tuple(each.stop - each.start for each in slices)
        if part == chunk and sizes == self._chunk:
            if not self._raw.read(name, place, out):
                return False
        else:
            # a chunk at the end of an axis is stored in full too
            stored = np.empty(math.prod(self._chunk), out.dtype)
            if not self._raw.read(name, place, stored):
                return False
            inside = stored.reshape(self._chunk)[tuple(map(slice, sizes))].reshape(-1)
            out[...] = inside[part.start - chunk.start : part.stop - chunk.start]
        fill = self._variables[name].encoding.get("_FillValue")
        if fill is not None and out.dtype.kind == "f":
            missing = out == out.dtype.type(fill)
            if missing.any():
                out[missing] = np.nan
        return True


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
