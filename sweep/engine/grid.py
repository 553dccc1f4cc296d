"""The grid of a spec: its chunks in the file, its blocks of computation, and the starts of its cells.

The chunks depend only on the grid; blocks may have any size.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sweep.model.description import Starts
from sweep.model.quantity import Array
from sweep.request.sources import Distribution, Range, Values
from sweep.request.spec import SweepSpec
from sweep.request.start_table import Column

#: Most cells of a chunk: half a megabyte per double-precision variable.
CHUNK_CELLS = 2**16

#: Default number of cells of a block: some tenths of a second of work.
BLOCK_CELLS = 2**17

#: Most cells of a block: 16 megabytes in the journal, and at least some tenths of a second of work.
MOST_BLOCK_CELLS = 2**18


@dataclass(frozen=True)
class Span:
    """Cells `start` to `stop` (exclusive) of a grid in C order."""

    start: int
    stop: int

    def __len__(self) -> int:
        """Return the number of cells."""
        return self.stop - self.start


def chunk_shape(shape: tuple[int, ...], cells: int = CHUNK_CELLS) -> tuple[int, ...]:
    """Return the shape of the chunks of a grid, so that every chunk is contiguous in C order.

    Parameters
    ----------
    shape : tuple of int
        Number of values along each axis.
    cells : int
        Most cells of a chunk.

    Returns
    -------
    tuple of int
        1 along the leading axes, a part of one axis, and whole trailing axes.
    """
    chunk: list[int] = []
    room = cells
    for n in reversed(shape):
        # parts as equal as possible, so that the last chunk is not much smaller
        share = math.ceil(n / math.ceil(n / room)) if room > 1 else 1
        chunk.insert(0, share)
        room = room // share if share == n else 1
    return tuple(chunk)


def chunks(shape: tuple[int, ...], cells: int = CHUNK_CELLS) -> Iterator[tuple[Span, tuple[slice, ...]]]:
    """Yield the chunks of a grid in C order: the span of cells and the slice along each axis."""
    shares = chunk_shape(shape, cells)
    counts = [math.ceil(n / share) for n, share in zip(shape, shares, strict=True)]
    start = 0
    for number in range(math.prod(counts)):
        slices = []
        for n, share, count in zip(reversed(shape), reversed(shares), reversed(counts), strict=True):
            number, place = divmod(number, count)
            slices.append(slice(place * share, min(n, (place + 1) * share)))
        stop = start + math.prod(part.stop - part.start for part in slices)
        yield Span(start, stop), tuple(reversed(slices))
        start = stop


def blocks(size: int, cells: int = BLOCK_CELLS) -> Iterator[Span]:
    """Yield the blocks in which the `size` cells of a grid are computed, `cells` at a time."""
    for start in range(0, size, cells):
        yield Span(start, min(size, start + cells))


def starts_of(spec: SweepSpec, span: Span) -> Starts:
    """Return the starts of the cells of a span.

    Parameters
    ----------
    spec : SweepSpec
    span : Span
        Cells in C order.

    Returns
    -------
    mapping of str to float64 array, shape (len(span),)
        Every parameter of the model, in its order and in SI. A computed parameter is not finite where no such value
        exists.
    """
    return starts_at(spec, np.arange(span.start, span.stop))


def starts_at(spec: SweepSpec, cells: npt.NDArray[np.intp]) -> Starts:
    """Return the starts of the cells with these flat indices, shape (n,); see `starts_of`."""
    places = dict(zip(spec.axes, np.unravel_index(cells, spec.shape), strict=True)) if spec.axes else {}
    values: dict[str, Array] = {}
    for name in spec.model.parameters:
        source = getattr(spec, name)
        if isinstance(source, Range | Values):
            values[name] = source.at(places[name])
        elif isinstance(source, Column):
            values[name] = source.at(places["start"])
        elif isinstance(source, Distribution):
            numbers = np.rint(spec.start.at(places["start"])).astype(np.int64)
            values[name] = source.at(numbers, f"{spec.seed}:{name}")
        elif not isinstance(source, str):
            values[name] = np.full(cells.size, source)
    return completed(spec, values)


def whole(spec: SweepSpec) -> Starts:
    """Return the starts of all cells of a spec, shape (spec.size,), in C order."""
    return starts_of(spec, Span(0, spec.size))


def completed(spec: SweepSpec, values: Starts) -> Starts:
    """Return starts with the parameters that each cell computes, in the order of the model."""
    starts = spec.model.complete(spec, values)
    return {name: starts[name] for name in spec.model.parameters}
