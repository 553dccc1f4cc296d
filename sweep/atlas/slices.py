"""Variables whose values are made slice by slice: of a long axis, or of a long boundary, no more is in memory."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.atlas.cf_metadata import Declaration, coordinate_declarations
from sweep.engine.grid import Span, chunks
from sweep.request.axes import Range, Values
from sweep.request.spec import SweepSpec

#: Values of a slice at most: half a megabyte of doubles.
SLICE_VALUES = 2**16

Slices = tuple[slice, ...]


@dataclass(frozen=True)
class SlicedVariables:
    """Variables of one shape, whose values come in slices.

    Parameters
    ----------
    declared : sequence of Declaration
    shape : tuple of int
        Shape of each of them.
    parts : iterable of sequence of array
        For each slice (`slices`) in turn the values of each variable there, in C order, of any shape. They can be taken
        once.
    """

    declared: Sequence[Declaration]
    shape: tuple[int, ...]
    parts: Iterable[Sequence[npt.NDArray[Any]]]

    def slices(self) -> Iterator[tuple[Span, Slices]]:
        """Yield the slices: a run of values in C order each, and its places along every dimension."""
        return slices_of(self.shape)

    def each(self) -> Iterator[tuple[Span, Slices, list[npt.NDArray[Any]]]]:
        """Yield every slice with the values of each variable, of the shape of the slice and of the declared type."""
        for (span, places), values in zip(self.slices(), self.parts, strict=True):
            shape = [part.stop - part.start for part in places]
            named = zip(self.declared, values, strict=True)
            yield span, places, [np.asarray(each, declared.dtype).reshape(shape) for declared, each in named]

    def whole(self) -> list[tuple[Declaration, npt.NDArray[Any]]]:
        """Return each variable with all its values."""
        found = [np.empty(math.prod(self.shape), each.dtype) for each in self.declared]
        for span, _, values in self.each():
            for into, part in zip(found, values, strict=True):
                into[span.start : span.stop] = part.reshape(-1)
        return [(each, held.reshape(self.shape)) for each, held in zip(self.declared, found, strict=True)]


def slices_of(shape: tuple[int, ...]) -> Iterator[tuple[Span, Slices]]:
    """Yield the slices of a grid in C order: each is one run of values, and covers whole trailing axes, or one in part.

    Slices of the rows along an axis cover the same cells along the other axes as the chunks of the cells do.
    """
    return chunks(shape, SLICE_VALUES)


def coordinates(spec: SweepSpec) -> Iterator[SlicedVariables]:
    """Yield the axes with their values, and the fixed parameters as scalars."""
    for declared in coordinate_declarations(spec):
        held = getattr(spec, declared.name)
        shape = (len(held),) if declared.dims else ()
        yield SlicedVariables([declared], shape, ([_values(held, span)] for span, _ in slices_of(shape)))


def _values(held: Range | Values | float, span: Span) -> npt.NDArray[np.float64]:
    if isinstance(held, Range | Values):
        return held.at(np.arange(span.start, span.stop))
    return np.array([held])


def whole(variables: Iterable[SlicedVariables]) -> list[tuple[Declaration, npt.NDArray[Any]]]:
    """Return all variables with all their values."""
    return [pair for each in variables for pair in each.whole()]
