"""The boundary of stability that a grid of verdicts has: of its rows, and of its curves, one slice after the other."""

import math
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.atlas.boundary import Brackets, Seen, bisected, rows_along, unseen
from sweep.atlas.cf_metadata import EDGES, curve_declarations, edge_declarations
from sweep.atlas.curves import Curves
from sweep.atlas.row_search import NOWHERE, Places, RowSearch, Verdicts
from sweep.atlas.scratch import Scratch
from sweep.atlas.slices import SlicedVariables, slices_of
from sweep.engine.grid import Span, blocks, starts_of
from sweep.model.description import Starts
from sweep.model.quantity import STABLE, UNSTABLE, Array
from sweep.request.axes import Range, Values
from sweep.request.spec import SweepSpec

#: Cells that are read at a time: verdicts of a megabyte. Chunks at the ends of such a span may be inflated twice.
READ_CELLS = 2**20

#: Returns the verdicts (`sweep.model.quantity`) of any span of the cells in C order, as int8, shape (len(span),).
Read = Callable[[Span], Verdicts]

_Parts = Iterator[list[npt.NDArray[Any]]]


class BoundarySearch:
    """The boundary of a grid, from the verdicts of its cells, of which it holds those of a slice of the rows.

    Parameters
    ----------
    spec : SweepSpec
    read : callable
        Gives the verdicts. Those of a cell are asked for once for each control among the axes, a second time for each
        that has a lower edge, and once or twice more for the curves.
    seen : callable, optional
        Called now and then with the share of the work that is done, from 0 to 1.
    folder : Path, optional
        Where the points of long curves are kept while they are joined, 33 bytes each; the system's folder for temporary
        files if not given. A process that is killed leaves nothing there.
    """

    def __init__(self, spec: SweepSpec, read: Read, seen: Seen = unseen, folder: Path | None = None) -> None:
        self._spec, self._read, self._seen, self._folder = spec, read, seen, folder
        controls = spec.model.controls(spec.axes)
        self._rows = [_Rows(spec, axis, read) for axis in controls]
        self._has_curves = spec.boundary_width is not None and len(spec.axes) > 1
        self._done, self._total = 0, len(EDGES) * sum(rows.count for rows in self._rows)

    def variables(self) -> Iterator[SlicedVariables]:
        """Yield the variables of the boundary; the values of each have to be taken before the next are asked for.

        One value per row of each control for the edges: the upper edge (stable above) along every such axis, and the
        lower edge (stable below) where theory or the cells have one. The measured value lies in the middle of the
        bracket between the last unstable and the first stable cell, the half-width is half that bracket; undecided
        cells between the two widen it, and NaN stands where there is none. Where the spec says
        ``boundary = "refined"`` the bracket is bisected.

        Where the boundary is refined and the grid has a plane, the curves follow (`sweep.atlas.curves.Curves`).
        """
        for rows in self._rows:
            for edge in EDGES:
                if edge == "lower" and not rows.have_lower:
                    self._count(rows.count, 0.0)
                    continue
                yield SlicedVariables(
                    edge_declarations(self._spec, rows.axis, edge), rows.shape, self._edge(rows, edge)
                )
        if self._has_curves:
            yield from self._curves()

    def _edge(self, rows: "_Rows", edge: str) -> _Parts:
        for span, _ in slices_of(rows.shape):
            yield rows.values(edge, span, partial(self._count, len(span)))
            self._done += len(span)

    def _count(self, rows: int, share: float) -> None:
        """Say how much is done when a share of some rows is."""
        # the curves have as much to bisect as the edges
        self._seen((self._done + share * rows) / self._total / (2.0 if self._has_curves else 1.0))

    def _curves(self) -> Iterator[SlicedVariables]:
        with Scratch(self._folder) as scratch:
            lines = Curves(self._spec, self._read, scratch, lambda: self._seen(0.5))
            # the classic model of netCDF allows no dimension of length 0, except an unlimited one
            if lines.count:
                of_curves, of_points = curve_declarations(self._spec)
                yield SlicedVariables(of_curves, (lines.count,), self._lengths(lines))
                yield SlicedVariables(of_points, (lines.points,), self._points(lines))

    def _lengths(self, lines: Curves) -> _Parts:
        for span, _ in slices_of((lines.count,)):
            yield list(lines.lengths(span))

    def _points(self, lines: Curves) -> _Parts:
        assert self._spec.boundary_width is not None
        for span, _ in slices_of((lines.points,)):

            def seen(share: float, span: Span = span) -> None:
                self._seen(0.5 + 0.5 * (span.start + share * len(span)) / lines.points)

            points = lines.measured(span, self._spec.boundary_width, seen)
            yield [part for axis in self._spec.axes for part in points.along(axis)]


class _Rows:
    """The rows along one control: all cells along it, the other axes fixed; counted in C order of the other axes."""

    def __init__(self, spec: SweepSpec, axis: str, read: Read) -> None:
        self._spec, self._read, self.axis = spec, read, axis
        self._along = rows_along(spec, axis)
        self.shape, self.count = self._along.shape, self._along.size
        #: Whether theory or the cells have a lower edge in the rows of which values were made.
        self.have_lower = False
        self._last: tuple[Span, RowSearch] | None = None

    def values(self, edge: str, span: Span, seen: Seen) -> list[npt.NDArray[Any]]:
        """Return measured place, half-width, line of prediction, critical line and status of an edge in some rows."""
        rows, starts = self._searched(span), starts_of(self._along, span)
        lines = self._spec.model.lines(self._spec, self.axis, starts)
        every = Span(0, rows.rows)
        self.have_lower |= "lower" in lines or bool((rows.bracket("lower", every)[0] != NOWHERE).any())
        inside, outside = (
            _values(getattr(self._spec, self.axis), places) for places in rows.bracket(edge, every)
        )
        if (width := self._spec.boundary_width) is not None:
            inside, outside = _narrowed(self._spec, self.axis, starts, inside, outside, width, seen)
        seen(1.0)
        # of rows for which theory has no edge it may have no line
        critical, predicted = lines.get(edge) or np.full((2, len(span)), np.nan)
        return [
            0.5 * (inside + outside),
            0.5 * np.abs(outside - inside),
            predicted,
            critical,
            rows.status(edge, every),
        ]

    def _searched(self, span: Span) -> RowSearch:
        """Return what the cells of some rows say of their edges; kept until other rows are asked for."""
        if self._last is None or self._last[0] != span:
            self._last = (span, self._search(span))
        return self._last[1]

    def _search(self, span: Span) -> RowSearch:
        shape, number = self._spec.shape, self._spec.axes.index(self.axis)
        count, inner = shape[number], math.prod(shape[number + 1 :])
        plane, column = divmod(span.start, inner)
        if len(span) < inner:
            # the rows begin on one line of cells and go through all lines of its plane
            search = RowSearch((1, count, len(span)), 1)
            begins = range(plane * count * inner + column, (plane + 1) * count * inner, inner)
            cells = (Span(begin, begin + len(span)) for begin in begins)
        else:
            search = RowSearch((len(span) // inner, count, inner), 1)
            begin = span.start * count
            cells = (
                Span(begin + each.start, begin + each.stop) for each in blocks(len(span) * count, READ_CELLS)
            )
        at = 0
        for each in cells:
            search.add(at, self._read(each))
            at += len(each)
        return search


def in_memory(stability: Verdicts) -> Read:
    """Return a function that gives the verdicts of a grid in memory."""
    flat = stability.reshape(-1)
    return lambda span: flat[span.start : span.stop]


def _values(axis: Range | Values, places: Places) -> Array:
    return np.where(places == NOWHERE, np.nan, axis.at(np.maximum(places, 0)))


def _narrowed(
    spec: SweepSpec, axis: str, starts: Starts, inside: Array, outside: Array, width: float, seen: Seen
) -> tuple[Array, Array]:
    """Bisect the brackets of some rows, all at once."""
    found = np.flatnonzero(np.isfinite(inside))
    number = np.full(found.size, list(spec.model.parameters).index(axis))
    codes = [np.full(found.size, code, np.int8) for code in (UNSTABLE, STABLE)]
    held = {name: each[found] for name, each in starts.items()}
    fine = bisected(spec, Brackets(held, number, inside[found], outside[found], *codes), width, seen)
    narrow = np.full((2, inside.size), np.nan)
    narrow[:, found] = fine.near, fine.far
    return narrow[0], narrow[1]
