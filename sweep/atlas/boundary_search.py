"""The stability boundary of a grid of verdicts, row by row and as curves."""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.atlas.boundary import Brackets, Seen, bisected, rows_along, theory_lines, unseen
from sweep.atlas.cf_metadata import EDGES, Declaration, curve_declarations, edge_declarations
from sweep.atlas.curves import Curves
from sweep.atlas.row_edges import NOWHERE, Places, RowEdges, Verdicts
from sweep.engine.grid import starts_at
from sweep.model.quantity import STABLE, UNSTABLE, Array
from sweep.request.sources import Range, Values
from sweep.request.spec import SweepSpec

#: Variables of the same shape with their values: the variables of one edge, of the curves, or of their points.
Group = list[tuple[Declaration, npt.NDArray[Any]]]


def boundary_groups(spec: SweepSpec, stability: Verdicts, seen: Seen = unseen) -> list[Group]:
    """Find the boundary of a grid from the verdicts of its cells.

    Parameters
    ----------
    spec : SweepSpec
    stability : array of int8, shape of the grid
        The verdicts of all cells (`sweep.model.quantity`).
    seen : callable, optional
        Called now and then with the completed share of the work, from 0 to 1.

    Returns
    -------
    list of list of (Declaration, array)
        Groups of variables of the same shape. Edges have one value per row along each control: the upper edge (stable
        above) for every such axis, and the lower edge (stable below) where theory or the cells have one. The measured
        value is the middle of the bracket between the last unstable and the first stable cell, the half-width is half
        of that bracket. Undecided cells between the two widen it; both are NaN where a row has no edge. With
        ``boundary = "refined"`` in the spec, the bracket is bisected.

        If the boundary is refined and the grid has a plane, the curves follow (`sweep.atlas.curves.Curves`).
    """
    controls = spec.model.controls(spec.axes)
    has_curves = spec.boundary_width is not None and len(spec.axes) > 1
    # the curves take as many bisections as the edges
    of_edges = 0.5 if has_curves else 1.0
    groups = list[Group]()
    for number, axis in enumerate(controls):
        share = of_edges / len(controls)
        groups += _edges(spec, axis, stability, _part(seen, number * share, share))
    return groups + _curves(spec, stability, _part(seen, of_edges, 0.5)) if has_curves else groups


def _part(seen: Seen, begin: float, share: float) -> Seen:
    return lambda done: seen(begin + share * done)


def _edges(spec: SweepSpec, axis: str, stability: Verdicts, seen: Seen) -> Iterator[Group]:
    """Yield the edges along one control. A row is all cells along it, with the other axes fixed."""
    rows, lines = RowEdges.of(stability, spec.axes.index(axis)), theory_lines(spec, axis)
    drawn = [line[0] for line in lines.values()]
    one_line = len(drawn) == len(EDGES) and np.array_equal(drawn[0], drawn[1], equal_nan=True)
    for number, edge in enumerate(EDGES):
        inside, outside = (_values(getattr(spec, axis), places) for places in rows.bracket(edge))
        # the same line for both edges does not mean that both exist
        expected = edge in lines and not one_line
        if edge == "lower" and not expected and not np.isfinite(inside).any():
            break
        if spec.boundary_width is not None:
            share = 1.0 / len(EDGES)
            inside, outside = _narrowed(
                spec, axis, inside, outside, spec.boundary_width, _part(seen, number * share, share)
            )
        # theory may give no line for rows without an edge
        critical, predicted = lines.get(edge) or np.full((2, *inside.shape), np.nan)
        middle, half = 0.5 * (inside + outside), 0.5 * np.abs(outside - inside)
        values = (middle, half, predicted, critical, rows.status(edge))
        yield _group(edge_declarations(spec, axis, edge), values)
    seen(1.0)


def _values(axis: Range | Values, places: Places) -> Array:
    return np.where(places == NOWHERE, np.nan, axis.at(np.maximum(places, 0)))


def _narrowed(
    spec: SweepSpec, axis: str, inside: Array, outside: Array, width: float, seen: Seen
) -> tuple[Array, Array]:
    """Bisect the brackets of the rows along an axis, all at once."""
    rows = np.flatnonzero(np.isfinite(inside))
    number = np.full(rows.size, list(spec.model.parameters).index(axis))
    codes = [np.full(rows.size, code, np.int8) for code in (UNSTABLE, STABLE)]
    starts = starts_at(rows_along(spec, axis), rows)
    near, far = (ends.reshape(-1)[rows] for ends in (inside, outside))
    fine = bisected(spec, Brackets(starts, number, near, far, *codes), width, seen)
    narrow = np.full((2, inside.size), np.nan)
    narrow[:, rows] = fine.near, fine.far
    return narrow[0].reshape(inside.shape), narrow[1].reshape(inside.shape)


def _curves(spec: SweepSpec, stability: Verdicts, seen: Seen) -> list[Group]:
    assert spec.boundary_width is not None
    lines = Curves(spec, stability)
    # the classic model of netCDF allows no dimension of length 0, except an unlimited one
    if not lines.counts.size:
        return []
    of_curves, of_points = curve_declarations(spec)
    points = lines.measured(spec.boundary_width, seen)
    places = [part for axis in spec.axes for part in points.along(axis)]
    return [_group(of_curves, (lines.counts, lines.closed)), _group(of_points, places)]


def _group(declared: Iterable[Declaration], values: Iterable[npt.NDArray[Any]]) -> Group:
    return [
        (declaration, np.asarray(array, declaration.dtype))
        for declaration, array in zip(declared, values, strict=True)
    ]
