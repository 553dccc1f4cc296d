"""The boundary of stability that a grid of verdicts has, found from its cells in C order, span by span."""

import itertools
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.atlas.boundary import AT_ONCE, Brackets, bisected, rows_along, theory_lines
from sweep.atlas.cf_metadata import EDGES, Declaration, curve_declarations, edge_declarations
from sweep.atlas.curves import Curves, curves
from sweep.atlas.neighbours import NeighbourSearch
from sweep.atlas.row_search import NOWHERE, Places, RowSearch, Verdicts
from sweep.engine.grid import blocks, starts_of
from sweep.model.description import Starts
from sweep.model.quantity import STABLE, UNSTABLE, Array
from sweep.request.axes import Range, Values
from sweep.request.spec import SweepSpec


class BoundarySearch:
    """The boundary of a grid, from the verdicts of its cells, which come in C order in spans of any size.

    Of the verdicts it keeps 7 to 22 bytes per row along each control parameter among the axes (`RowSearch`). Where the
    boundary is refined, it keeps the last line of cells and 9 bytes per point of the curves too (`NeighbourSearch`).

    Parameters
    ----------
    spec : SweepSpec
    """

    def __init__(self, spec: SweepSpec) -> None:
        self._spec, self._cells = spec, 0
        controls = spec.model.controls(spec.axes)
        self._rows = {axis: RowSearch(spec.shape, spec.axes.index(axis)) for axis in controls}
        has_curves = spec.boundary_width is not None and len(spec.axes) > 1
        self._neighbours = NeighbourSearch(spec.shape) if has_curves else None
        self._searches: list[RowSearch | NeighbourSearch] = [
            *self._rows.values(),
            *([self._neighbours] if self._neighbours else []),
        ]

    def add(self, start: int, stability: Verdicts) -> None:
        """Take the verdicts of the next cells.

        Parameters
        ----------
        start : int
            Flat index of the first of them: the number of cells that were given before.
        stability : array of int8, shape (n,)
            Verdicts (`sweep.model.quantity`).

        Raises
        ------
        ValueError
            If other cells come next, or there are not so many.
        """
        stop = start + stability.size
        if start != self._cells or stop > self._spec.size:
            raise ValueError(f"cells {self._cells} to {self._spec.size} come next, not {start} to {stop}")
        self._cells = stop
        for search in self._searches:
            search.add(start, stability)

    def variables(
        self, seen: Callable[[float], None] = lambda _: None
    ) -> Iterator[tuple[Declaration, npt.NDArray[Any]]]:
        """Yield the variables of the boundary with their values, once all cells are there.

        `seen` is called with the share of the rows that have been searched, from 0 to 1, now and then.

        One value per row of each control for the edges: the upper edge (stable above) along every such axis, and the
        lower edge (stable below) where theory or the cells have one. The measured value lies in the middle of the
        bracket between the last unstable and the first stable cell, the half-width is half that bracket; undecided
        cells between the two widen it, and NaN stands where there is none. Where the spec says
        ``boundary = "refined"`` the bracket is bisected.

        Where the boundary is refined and the grid has a plane, the curves follow (`sweep.atlas.curves.Curves`).

        At most 50 bytes per row along one axis, or 52 per point of the curves, are held at a time, if the caller lets
        go of each array before it takes the next.

        Raises
        ------
        ValueError
            If cells are missing.
        """
        if self._cells != self._spec.size:
            raise ValueError(f"only {self._cells} of {self._spec.size} cells were given")
        done, total = 0, len(EDGES) * sum(rows.rows for rows in self._rows.values())

        def count(rows: int) -> None:
            nonlocal done
            done += rows
            # the curves are bisected at once, and have as much to do as the edges
            seen(done / total / (2.0 if self._neighbours else 1.0))

        for axis, rows in self._rows.items():
            lines = theory_lines(self._spec, axis)
            for edge in EDGES:
                yield from _edge(self._spec, axis, rows, edge, lines.pop(edge, None), count)
        if self._spec.boundary_width is not None and self._neighbours is not None:
            yield from _with_points(curves(self._spec, self._neighbours.pairs(), self._spec.boundary_width))


def _edge(
    spec: SweepSpec,
    axis: str,
    rows: RowSearch,
    edge: str,
    line: tuple[Array, Array] | None,
    seen: Callable[[int], None],
) -> Iterator[tuple[Declaration, npt.NDArray[Any]]]:
    """Yield the variables of an edge along an axis, if there is one; `line` is that of theory."""
    measured, halfwidth = _measured(spec, axis, rows, edge, seen)
    if edge == "lower" and line is None and not np.isfinite(measured).any():
        return
    critical, predicted = line or np.full((2, *measured.shape), np.nan)
    values = (measured, halfwidth, predicted, critical, _status(rows, edge).reshape(measured.shape))
    yield from zip(edge_declarations(spec, axis, edge), values, strict=True)


def _measured(
    spec: SweepSpec, axis: str, rows: RowSearch, edge: str, seen: Callable[[int], None]
) -> tuple[Array, Array]:
    """Return the middles and the half-widths of the brackets of an edge along an axis, over the remaining axes."""
    middle, half, width = np.empty(rows.rows), np.empty(rows.rows), spec.boundary_width
    along = rows_along(spec, axis)
    for span in blocks(rows.rows, AT_ONCE):
        inside, outside = (_values(getattr(spec, axis), places) for places in rows.bracket(edge, span))
        if width is not None:
            starts = starts_of(along, span)
            inside, outside = _narrowed(spec, axis, starts, inside, outside, width)
        middle[span.start : span.stop] = 0.5 * (inside + outside)
        half[span.start : span.stop] = 0.5 * np.abs(outside - inside)
        seen(len(span))
    return middle.reshape(along.shape), half.reshape(along.shape)


def _values(axis: Range | Values, places: Places) -> Array:
    return np.where(places == NOWHERE, np.nan, axis.at(np.maximum(places, 0)))


def _narrowed(
    spec: SweepSpec, axis: str, starts: Starts, inside: Array, outside: Array, width: float
) -> tuple[Array, Array]:
    """Bisect the brackets of some rows, all at once."""
    found = np.flatnonzero(np.isfinite(inside))
    number = np.full(found.size, list(spec.model.parameters).index(axis))
    codes = [np.full(found.size, code, np.int8) for code in (UNSTABLE, STABLE)]
    held = {name: each[found] for name, each in starts.items()}
    fine = bisected(spec, Brackets(held, number, inside[found], outside[found], *codes), width)
    narrow = np.full((2, inside.size), np.nan)
    narrow[:, found] = fine.near, fine.far
    return narrow[0], narrow[1]


def _status(rows: RowSearch, edge: str) -> npt.NDArray[np.int8]:
    codes = np.empty(rows.rows, np.int8)
    for span in blocks(rows.rows, AT_ONCE):
        codes[span.start : span.stop] = rows.status(edge, span)
    return codes


def _with_points(lines: Curves) -> Iterator[tuple[Declaration, npt.NDArray[Any]]]:
    """Yield the variables of the curves."""
    # the classic model of netCDF allows no dimension of length 0, except an unlimited one
    if not lines.counts.size:
        return
    of_points = (part(axis) for axis in lines.spec.axes for part in (lines.places, lines.widths))
    values = itertools.chain((lines.counts.astype("i4"), lines.closed.astype("i1")), of_points)
    yield from zip(curve_declarations(lines.spec), values, strict=True)
