"""The boundary of stability that a grid of verdicts has: of its rows, and of its curves."""

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.atlas.boundary import Brackets, Seen, bisected, rows_along, unseen
from sweep.atlas.cf_metadata import EDGES, curve_declarations, edge_declarations
from sweep.atlas.curves import Curves
from sweep.atlas.row_edges import NOWHERE, Places, RowEdges, Verdicts
from sweep.atlas.slices import SlicedVariables, slices_of
from sweep.engine.grid import Span, starts_of
from sweep.model.description import Starts
from sweep.model.quantity import STABLE, UNSTABLE, Array
from sweep.request.axes import Range, Values
from sweep.request.spec import SweepSpec

_Parts = Iterator[list[npt.NDArray[Any]]]


class BoundarySearch:
    """The boundary of a grid, from the verdicts of its cells.

    Parameters
    ----------
    spec : SweepSpec
    stability : array of int8, shape of the grid
        The verdicts of all cells (`sweep.model.quantity`).
    seen : callable, optional
        Called now and then with the share of the work that is done, from 0 to 1.
    """

    def __init__(self, spec: SweepSpec, stability: Verdicts, seen: Seen = unseen) -> None:
        self._spec, self._stability, self._seen = spec, stability, seen
        self._rows = [_Rows(spec, axis, stability) for axis in spec.model.controls(spec.axes)]
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
        lines = Curves(self._spec, self._stability)
        self._seen(0.5)
        # the classic model of netCDF allows no dimension of length 0, except an unlimited one
        if lines.counts.size:
            of_curves, of_points = curve_declarations(self._spec)
            count, points = lines.counts.size, lines.cells.size
            lengths = ([lines.counts[part], lines.closed[part]] for _, (part,) in slices_of((count,)))
            yield SlicedVariables(of_curves, (count,), lengths)
            yield SlicedVariables(of_points, (points,), self._points(lines))

    def _points(self, lines: Curves) -> _Parts:
        assert self._spec.boundary_width is not None
        count = lines.cells.size
        for span, _ in slices_of((count,)):

            def seen(share: float, span: Span = span) -> None:
                self._seen(0.5 + 0.5 * (span.start + share * len(span)) / count)

            points = lines.measured(span, self._spec.boundary_width, seen)
            yield [part for axis in self._spec.axes for part in points.along(axis)]


class _Rows:
    """The rows along one control: all cells along it, the other axes fixed; counted in C order of the other axes."""

    def __init__(self, spec: SweepSpec, axis: str, stability: Verdicts) -> None:
        self._spec, self.axis = spec, axis
        self._along = rows_along(spec, axis)
        self.shape, self.count = self._along.shape, self._along.size
        self._edges = RowEdges.of(stability, spec.axes.index(axis))
        #: Whether theory has a lower edge in the rows of which values were made, or the cells have one anywhere.
        self.have_lower = bool((self._edges.bracket("lower")[0] != NOWHERE).any())

    def values(self, edge: str, span: Span, seen: Seen) -> list[npt.NDArray[Any]]:
        """Return measured place, half-width, line of prediction, critical line and status of an edge in some rows."""
        starts, part = starts_of(self._along, span), slice(span.start, span.stop)
        lines = self._spec.model.lines(self._spec, self.axis, starts)
        self.have_lower |= "lower" in lines
        inside, outside = (
            _values(getattr(self._spec, self.axis), places.reshape(-1)[part])
            for places in self._edges.bracket(edge)
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
            self._edges.status(edge).reshape(-1)[part],
        ]


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
