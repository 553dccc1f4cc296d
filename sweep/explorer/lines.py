"""Lines on the map: the boundary of theory, the one predicted for the criterion, and the measured one."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from sweep.atlas.curves import Curves
from sweep.engine.compute import compute
from sweep.engine.grid import Span, whole
from sweep.explorer.stored import Stored
from sweep.explorer.theory_lines import theory
from sweep.explorer.turns import KERNELS
from sweep.explorer.view import Side, View
from sweep.request.axes import Values

#: Cells along both sides among which the measured boundary is looked for.
COARSE = 96, 72

#: Pixels of the largest screen: the measured boundary is bisected to one of them.
_FINE = 4096

#: No bracket is narrower, over the largest value of its side: there rounding decides.
_LEAST = 1e-14


def lines(view: View, stored: Stored | None) -> list[dict[str, Any]]:
    """Return the lines in a window; the measured one is that of the file where cells cannot be computed.

    Returns
    -------
    list of dict
        ``name`` (``analytic``, ``predicted`` or ``measured``), ``label``, and ``points``: polylines of pairs of the
        values of both parameters in SI. A line that the window does not meet is left out, and where a parameter cannot
        have its values there is none.

    Raises
    ------
    RequestError
        If the words of the view are not possible.
    """
    x, y = (side.within(view.spec.model.parameters[side.name].allows) for side in (view.x, view.y))
    if x is None or y is None:
        return []
    view = replace(view, x=x, y=y)
    found = theory(view)
    if view.is_live:
        found.append({"name": "measured", "label": "measured, exact cells", "points": measured(view)})
    elif stored is not None:
        found.append(
            {"name": "measured", "label": f"measured, {stored.label}", "points": stored.boundary(view)}
        )
    return [line for line in found if line["points"]]


def measured(view: View) -> list[list[list[float]]]:
    """Return the curves between stable and unstable cells, each point bisected to a pixel of a large screen.

    Each point lies between two neighbours of a coarse grid of exact cells; what is smaller than the grid is not found.
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
        points = curves.measured(Span(0, curves.cells.size), bracket_width(view))
        x, y = (points.along(side.name)[0] for side in (view.x, view.y))
    found = []
    for part, is_closed in zip(
        np.split(np.arange(x.size), np.cumsum(curves.counts)[:-1]), curves.closed, strict=True
    ):
        whole_curve = [*part, part[0]] if is_closed else part
        found.append(np.stack((x[whole_curve], y[whole_curve])).T.tolist())
    return found


def _coarse(side: Side, count: int) -> Values | None:
    """Return the values of a side of the coarse grid, border to border; None where they cannot be told apart."""
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
