"""Lines on the map: the boundary from theory, the boundary predicted for the criterion, and the measured one."""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from sweep.atlas.curves import Curves
from sweep.engine.compute import compute
from sweep.engine.grid import whole
from sweep.explorer.stored import Stored
from sweep.explorer.view import Side, View
from sweep.explorer.waiting import KERNELS
from sweep.model.quantity import Array
from sweep.request.sources import Values

#: Cells along both sides of the grid on which the measured boundary is sought.
COARSE = 96, 72

#: Pixels of the largest screen: the measured boundary is bisected to one of these.
_FINE = 4096

#: Least width of a bracket, relative to the largest value of its side: below, rounding decides.
_LEAST = 1e-14

#: Raster on which lines of theory are sought, in window coordinates from -1 to 1: centres of rows, and columns from
#: beyond one border to beyond the other.
_ROWS, _COLUMNS = (2.0 * np.arange(256) + 1.0) / 256 - 1.0, np.linspace(-1.25, 1.25, 161)


def lines(view: View, stored: Stored | None) -> list[dict[str, Any]]:
    """Return the lines in a window; the measured line is the file's boundary if cells cannot be computed.

    Returns
    -------
    list of dict
        ``name`` (``analytic``, ``predicted`` or ``measured``), ``label``, and ``points``: polylines of pairs of the
        values of both parameters in SI. A line outside the window is omitted, and a line does not extend to values that
        a parameter cannot have.

    Raises
    ------
    RequestError
        If the words of the view are invalid.
    """
    x, y = (side.within(view.spec.model.parameters[side.name].allows) for side in (view.x, view.y))
    if x is None or y is None:
        return []
    view = replace(view, x=x, y=y)
    found = theory(view)
    if view.spec.model.exact is not None and view.is_live:
        found.append({"name": "measured", "label": "measured, exact cells", "points": measured(view)})
    elif stored is not None:
        found.append(
            {"name": "measured", "label": f"measured, {stored.label}", "points": stored.boundary(view)}
        )
    return [line for line in found if line["points"]]


def measured(view: View) -> list[list[list[float]]]:
    """Return the curves between stable and unstable cells, each point bisected to a pixel of a large screen.

    Each point is between two neighbours on a coarse grid of exact cells; features smaller than the grid are not found.
    """
    names = view.y.name, view.x.name
    axes = {side.name: _coarse(side, count) for side, count in ((view.x, COARSE[0]), (view.y, COARSE[1]))}
    if any(axis is None for axis in axes.values()):
        return []
    spec = view.live.replace(**axes, axes=names)
    with KERNELS:
        verdicts = compute(spec, whole(spec), verdicts_only=True)["stability"]
        curves = Curves(spec, verdicts.reshape(spec.shape))
        if not curves.counts.size:
            return []
        points = curves.measured(bracket_width(view))
        x, y = (points.along(side.name)[0] for side in (view.x, view.y))
    found = []
    for part, is_closed in zip(
        np.split(np.arange(x.size), np.cumsum(curves.counts)[:-1]), curves.closed, strict=True
    ):
        whole_curve = [*part, part[0]] if is_closed else part
        found.append(np.stack((x[whole_curve], y[whole_curve])).T.tolist())
    return found


def _coarse(side: Side, count: int) -> Values | None:
    """Return the values of a side of the coarse grid, from border to border; None if they cannot be distinguished."""
    values = side.at(np.linspace(-1.0, 1.0, count))
    return Values(tuple(values.tolist())) if (np.diff(values) > 0.0).all() else None


def bracket_width(view: View) -> float:
    """Return the width of a bracket [SI unit of its axis] that is less than a pixel along both sides."""
    widths, largest = [], []
    for side in (view.x, view.y):
        low, high = side.ends()
        pixel = 2.0 * side.half / _FINE
        widths.append(low * math.expm1(pixel) if side.scale == "log" else pixel)
        largest.append(max(abs(low), abs(high)))
    return max(min(widths), _LEAST * min(largest))


def theory(view: View) -> list[dict[str, Any]]:
    """Return the lines of theory in a window, as `lines` does; empty if neither axis is a control.

    Theory gives the edges of the unstable band as rates for each row. A line is the zero contour of a function of both
    parameters that changes sign there: the distance from the edge, or, if the band has two edges, the product of both
    distances, which continues smoothly past the row where they meet.
    """
    model = view.spec.model
    controls = model.controls([view.x.name, view.y.name])
    if not controls:
        return []
    labels = {
        "analytic": "analytic, vanishing perturbation",
        "predicted": model.line_words.label.format(view.spec.criterion.label(model)),
    }
    names = labels if view.spec.criterion.predictable else ("analytic",)
    for control in controls:
        along = view.x if view.x.name == control else view.y
        parts = [(part, _edges(view, part, along)) for part in _split_by_sign(along)]
        # the theory of a system may cover only one of its parameters
        if any(edges for _, edges in parts):
            break
    return [
        {
            "name": name,
            "label": labels[name],
            "points": [
                points
                for part, edges in parts
                for points in _contours(view, part, along, [edge[number] for edge in edges])
            ],
        }
        for number, name in enumerate(names)
    ]


def _split_by_sign(side: Side) -> list[Side]:
    """Return a side, or its negative and positive parts: theory has different edges for negative rates."""
    low, high = side.ends()
    if not low < 0.0 < high:
        return [side]
    return [replace(side, centre=0.5 * end, half=0.5 * abs(end)) for end in (low, high)]


def _edges(view: View, part: Side, along: Side) -> list[tuple[Array, Array]]:
    """Return the edges (analytic, predicted) in all rows, as window coordinates on a side."""
    across = view.y if along is view.x else view.x
    rows = across.at(_ROWS)
    starts = view.starts(*(rows if side is across else np.ones_like(rows) for side in (view.x, view.y)))
    with np.errstate(all="ignore"):
        found = view.spec.model.lines(view.spec_along(part), along.name, starts)
        return [(part.place(analytic), part.place(predicted)) for analytic, predicted in found.values()]


def _contours(view: View, part: Side, along: Side, edges: list[Array]) -> Iterator[list[list[float]]]:
    """Yield the polylines of pairs of values on which a row meets one of its edges."""
    from contourpy import contour_generator

    # the theory of a system does not say to which of the two edges its line belongs
    if len(edges) == 2 and not np.array_equal(edges[0], edges[1], equal_nan=True):
        middle, squared = 0.5 * (edges[0] + edges[1]), 0.25 * (edges[1] - edges[0]) ** 2
        middle, squared = _extrapolate(middle), _extrapolate(squared)
        field = (_COLUMNS - middle[:, None]) ** 2 - squared[:, None]
    elif edges:
        field = _COLUMNS - edges[0][:, None]
    else:
        return
    across = view.y if along is view.x else view.x
    for line in contour_generator(_COLUMNS, _ROWS, np.ma.masked_invalid(field)).lines(0.0):
        at_columns, at_rows = np.asarray(line).T
        sides = part.at(at_columns), across.at(at_rows)
        yield np.stack(sides if along is view.x else sides[::-1], axis=1).tolist()


def _extrapolate(values: Array) -> Array:
    """Return the values of the rows, extrapolated linearly by two rows where they are missing."""
    found = values.copy()
    for rows, known in ((found, values), (found[::-1], values[::-1])):
        for i in range(2, known.size):
            if np.isnan(known[i]) and np.isfinite(known[i - 2 : i]).all():
                after = rows[i : i + 2]
                after[:] = known[i - 1] + np.arange(1, after.size + 1) * (known[i - 1] - known[i - 2])
    return found
