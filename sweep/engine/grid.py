"""The grid of a spec: how it is cut into chunks of the file and blocks of computation, and the starts of its cells.

The chunks follow from the grid alone; blocks may have any size.
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

#: Cells of a chunk at most: half a megabyte per double-precision variable.
CHUNK_CELLS = 2**16

#: Cells of a block unless the caller says otherwise: some tenths of a second of work.
BLOCK_CELLS = 2**17

#: Cells of a block at most: 16 megabytes in the journal, and some tenths of a second at the fastest.
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
    """Return the shape of the chunks of a grid: every chunk is one contiguous run of cells in C order.

    Parameters
    ----------
    shape : tuple of int
        Number of values along each axis.
    cells : int
        Cells of a chunk at most.

    Returns
    -------
    tuple of int
        Whole trailing axes, a share of one axis, and 1 along the axes before it.
    """
    chunk: list[int] = []
    room = cells
    for n in reversed(shape):
        # as even as the axis allows, so that the last chunk is not a sliver
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
        Every parameter of the model, in its order and in SI. A parameter that the cell computes is not finite where it
        does not exist.
    """
    return starts_at(spec, np.arange(span.start, span.stop))


def starts_at(spec: SweepSpec, cells: npt.NDArray[np.intp]) -> Starts:
    """Return the starts of chosen cells, by their flat indices, shape (n,); as from `starts_of`."""
    places = dict(zip(spec.axes, np.unravel_index(cells, spec.shape), strict=True)) if spec.axes else {}
    values: dict[str, Array] = {}
    for name in spec.model.parameters:
        given = getattr(spec, name)
        if isinstance(given, Range | Values):
            values[name] = given.at(places[name])
        elif isinstance(given, Column):
            values[name] = given.at(places["start"])
        elif isinstance(given, Distribution):
            numbers = np.rint(spec.start.at(places["start"])).astype(np.int64)
            values[name] = given.at(numbers, f"{spec.seed}:{name}")
        elif not isinstance(given, str):
            values[name] = np.full(cells.size, given)
    return completed(spec, values)


def whole(spec: SweepSpec) -> Starts:
    """Return the starts of all cells of a spec, shape (spec.size,), in C order."""
    return starts_of(spec, Span(0, spec.size))


def completed(spec: SweepSpec, values: Starts) -> Starts:
    """Return starts with the parameters that each cell computes for itself, in the order of the model."""
    starts = spec.model.complete(spec, values)
    return {name: starts[name] for name in spec.model.parameters}
