"""The boundary of stability that a grid of verdicts has: of its rows, and of its curves."""

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

#: Variables of one shape with their values: those of one edge, of the curves, or of their points.
Group = list[tuple[Declaration, npt.NDArray[Any]]]


def boundary_groups(spec: SweepSpec, stability: Verdicts, seen: Seen = unseen) -> list[Group]:
    """Return the boundary of a grid, from the verdicts of its cells.

    Parameters
    ----------
    spec : SweepSpec
    stability : array of int8, shape of the grid
        The verdicts of all cells (`sweep.model.quantity`).
    seen : callable, optional
        Called now and then with the share of the work that is done, from 0 to 1.

    Returns
    -------
    list of list of (Declaration, array)
        Variables of one shape together. One value per row of each control for the edges: the upper edge (stable above)
        along every such axis, and the lower edge (stable below) where theory or the cells have one. The measured value
        lies in the middle of the bracket between the last unstable and the first stable cell, the half-width is half
        that bracket; undecided cells between the two widen it, and NaN stands where there is none. Where the spec says
        ``boundary = "refined"`` the bracket is bisected.

        Where the boundary is refined and the grid has a plane, the curves follow (`sweep.atlas.curves.Curves`).
    """
    controls = spec.model.controls(spec.axes)
    has_curves = spec.boundary_width is not None and len(spec.axes) > 1
    # the curves have as much to bisect as the edges
    of_edges = 0.5 if has_curves else 1.0
    groups = list[Group]()
    for number, axis in enumerate(controls):
        share = of_edges / len(controls)
        groups += _edges(spec, axis, stability, _part(seen, number * share, share))
    return groups + _curves(spec, stability, _part(seen, of_edges, 0.5)) if has_curves else groups


def _part(seen: Seen, begin: float, share: float) -> Seen:
    return lambda done: seen(begin + share * done)


def _edges(spec: SweepSpec, axis: str, stability: Verdicts, seen: Seen) -> Iterator[Group]:
    """Yield the edges along one control; their rows are all cells along it, the other axes fixed."""
    rows, lines = RowEdges.of(stability, spec.axes.index(axis)), theory_lines(spec, axis)
    drawn = [line[0] for line in lines.values()]
    one_line = len(drawn) == len(EDGES) and np.array_equal(drawn[0], drawn[1], equal_nan=True)
    for number, edge in enumerate(EDGES):
        inside, outside = (_values(getattr(spec, axis), places) for places in rows.bracket(edge))
        # one line for both edges does not say that both are there
        expected = edge in lines and not one_line
        if edge == "lower" and not expected and not np.isfinite(inside).any():
            break
        if spec.boundary_width is not None:
            share = 1.0 / len(EDGES)
            inside, outside = _narrowed(
                spec, axis, inside, outside, spec.boundary_width, _part(seen, number * share, share)
            )
        # of rows for which theory has no edge it may have no line
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
    found = np.flatnonzero(np.isfinite(inside))
    number = np.full(found.size, list(spec.model.parameters).index(axis))
    codes = [np.full(found.size, code, np.int8) for code in (UNSTABLE, STABLE)]
    starts = starts_at(rows_along(spec, axis), found)
    near, far = (each.reshape(-1)[found] for each in (inside, outside))
    fine = bisected(spec, Brackets(starts, number, near, far, *codes), width, seen)
    narrow = np.full((2, inside.size), np.nan)
    narrow[:, found] = fine.near, fine.far
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
    return [(each, np.asarray(held, each.dtype)) for each, held in zip(declared, values, strict=True)]
