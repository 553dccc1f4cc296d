"""Warnings about the range of a control that does not contain the predicted boundary, with a range that does."""

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from sweep.atlas.boundary import theory_lines
from sweep.atlas.cf_metadata import EDGES, edge_names
from sweep.atlas.report_units import reported_as
from sweep.model.quantity import Array, with_unit
from sweep.request.sources import Range, Values
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr

#: Largest number of rows for which the prediction is computed, spread evenly: 200 rows of the presets take 0.06 s.
_MOST_ROWS = 2048

#: Margin of the suggested range beyond the predicted boundary, as a share of it.
_MARGIN = 0.2

#: Significant digits of the ends of the suggested range.
_DIGITS = 3


def one_sided(spec: SweepSpec, dataset: "xr.Dataset | None" = None) -> list[str]:
    """Return a warning if the whole range of a control lies on one side of the predicted boundary in every row.

    Parameters
    ----------
    spec : SweepSpec
    dataset : xarray.Dataset, optional
        Its atlas, which contains the prediction. If not given, the prediction is computed for up to 2048 rows.

    Returns
    -------
    list of str
        A sentence with a range to paste that contains the predicted boundary of the rows. Empty if theory predicts no
        boundary or only a bound of it, if rows differ, if the axis has one value, or if two controls are axes.
    """
    controls = spec.model.controls(spec.axes)
    if len(controls) != 1 or len(getattr(spec, controls[0])) < 2 or spec.model.line_words.bound:
        return []
    (axis,) = controls
    low, high = getattr(spec, axis).ends()
    if spec.computed and low < 0.0 < high:
        # for a steady motion with rates of both signs, theory gives only the outer edges
        return []
    lines = _predicted(spec, axis) if dataset is None else _stored(dataset, axis)
    side = _side(low, high, lines)
    if not side:
        return []
    known = np.concatenate([line[np.isfinite(line)] for line in lines.values()])
    if not known.any():
        # a margin relative to zero makes no range
        return []
    reported = reported_as(spec)[axis]
    name, found = reported.quantity.name, reported.value(known)
    ends = dict.fromkeys(f"{value:.4g}" for value in (found.min(), found.max()))
    at = with_unit(" to ".join(ends), reported.quantity.units)
    # converting a range to the parameter rounds its ends, so four digits are written
    given = (
        getattr(spec, axis)
        if name == axis
        else _range(getattr(spec, axis), *reported.value(np.array([low, high])))
    )
    return [
        f"{name}={given} lies on the {side} side of the predicted boundary, which is at {at}, in every row that has "
        f"one. Expect no boundary. A range that contains it: {name}={_around(spec, axis, found)}"
    ]


def _predicted(spec: SweepSpec, axis: str) -> dict[str, Array]:
    others = [name for name in spec.axes if name != axis]
    rows = spec.size // len(getattr(spec, axis))
    most = rows if rows <= _MOST_ROWS else max(2, int(_MOST_ROWS ** (1.0 / len(others))))
    few = {}
    for name in others:
        values = getattr(spec, name)
        places = np.unique(np.linspace(0, len(values) - 1, min(len(values), most)).round().astype(int))
        few[name] = values.at(places).tolist()
    return {edge: line[1] for edge, line in theory_lines(spec.replace(**few), axis).items()}


def _stored(dataset: "xr.Dataset", axis: str) -> dict[str, Array]:
    names = {edge: edge_names(axis, edge)[2] for edge in EDGES}
    return {edge: dataset[name].values for edge, name in names.items() if name in dataset}


def _side(low: float, high: float, lines: dict[str, Array]) -> str:
    """Return the side on which a range lies in all rows that have an edge, stable or unstable; empty if they differ."""
    if not lines:
        return ""
    edges = np.array([line.reshape(-1) for line in lines.values()]).reshape(len(lines), -1)
    edges = edges[:, np.isfinite(edges).any(axis=0)]
    if not edges.size or np.any((edges >= low) & (edges <= high)):
        return ""
    # NaN if a row lacks this edge: comparisons with NaN are false
    above, below = (np.array(lines.get(edge, np.nan)).reshape(-1) for edge in EDGES)
    stable = (low > above) | (high < below)
    has_edge = np.isfinite(above) | np.isfinite(below)
    sides = np.unique(stable[has_edge])
    return ("stable" if sides[0] else "unstable") if sides.size == 1 else ""


def _around(spec: SweepSpec, axis: str, known: Array) -> str:
    """Return a range around values, with the count and the spacing of an axis, in SI."""
    low, high = float(known.min()), float(known.max())
    start, stop = low - _MARGIN * abs(low), high + _MARGIN * abs(high)
    return _range(getattr(spec, axis), _rounded(start, math.floor), _rounded(stop, math.ceil))


def _range(given: Range | Values, start: float, stop: float) -> str:
    """Return a range with new ends, and with the count and the spacing of an axis."""
    log = isinstance(given, Range) and given.spacing == "log" and start > 0.0
    return f"{start:.{_DIGITS + 1}g}:{stop:.{_DIGITS + 1}g}:{len(given)}" + (":log" if log else "")


def _rounded(value: float, outward: Callable[[float], int]) -> float:
    """Round a number outward to a few digits."""
    if value == 0.0:
        return 0.0
    unit = 10.0 ** (math.floor(math.log10(abs(value))) + 1 - _DIGITS)
    return outward(value / unit) * unit
