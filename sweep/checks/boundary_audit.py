"""Checks of an atlas's boundary: a second search in the verdicts, and exact verdicts at the ends of brackets."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from sweep.atlas.boundary import judged, rows_along
from sweep.atlas.boundary_search import Group
from sweep.atlas.cf_metadata import EDGES, POINTS, Declaration, edge_names
from sweep.checks.statement import Checks, Statement, row_in_words
from sweep.checks.tally import difference
from sweep.engine.grid import completed, whole
from sweep.model.description import Starts
from sweep.model.quantity import UNDECIDED, Array
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr

#: Relative rounding error of axis values and their midpoints; and of lines of theory, whose sums are longer.
_ROUNDING, _THEORY_ROUNDING = 1e-12, 1e-9

#: The rounding error of axis values if this processor rounds like the one that made the atlas.
_LAST_BITS = 1e-15

#: Largest ratio between the width of a bracket from another machine and the width found here or set in the spec.
_WIDER = 4.0

#: Suffix of a half-width: its name is the name of the bracket's middle plus this suffix.
_HALF = "_halfwidth"

#: Variables of one shape by name.
_Columns = Mapping[str, Array]


def boundary_statements(
    spec: SweepSpec, dataset: "xr.Dataset", again: Iterable[Group], repeated: bool
) -> Iterator[tuple[Declaration, Statement | None]]:
    """Yield the variables of the boundary (edges, lines of theory, curves), each with its result.

    Parameters
    ----------
    spec : SweepSpec
    dataset : xarray.Dataset
        The atlas; variables that it lacks have no result.
    again : iterable of list of (Declaration, array)
        The boundary found in the stored verdicts (`sweep.atlas.boundary_search.boundary_groups`).
    repeated : bool
        Whether computations on this machine reproduce the bits of the atlas.

    Notes
    -----
    All variables follow from the stored verdicts. If the spec asks for a refined boundary, the exact reference must
    also give different verdicts at the two ends of every bracket.
    """
    for group in again:
        found = {declared.name: np.asarray(values, np.float64) for declared, values in group}
        shape = group[0][1].shape
        stored = {
            name: np.asarray(dataset[name], np.float64)
            for name in found
            if name in dataset and dataset[name].shape == shape
        }
        ends = {middle: _alike(spec, stored, axis, middle) for axis, middle in _brackets(spec, group, stored)}
        for declared, values in group:
            name = declared.name
            if name not in dataset:
                yield declared, None
            elif name not in stored:
                size = int(dataset[name].size)
                words = f"{_by(dataset[name].shape)} values instead of {_by(shape)}"
                yield declared, Statement(name, "the stored verdicts", size, size, named=[words])
            else:
                checks = Checks(name, str(declared.attributes.get("units", "1")))
                against, allowed = _allowed(spec, name, found, values.dtype.kind == "f", repeated)
                checks.add_whole(against, difference(stored[name], values), allowed)
                if (one_verdict := ends.get(name.removesuffix(_HALF))) is not None:
                    checks.add_whole(
                        "different exact verdicts at the ends of its bracket", one_verdict, np.zeros(shape)
                    )
                yield declared, checks.statement(_places_in_words(spec, declared, shape))


def _by(shape: tuple[int, ...]) -> str:
    return " x ".join(map(str, shape))


def _places_in_words(spec: SweepSpec, declared: Declaration, shape: tuple[int, ...]) -> Callable[[int], str]:
    def in_words(flat: int) -> str:
        places = dict(zip(declared.dims, np.unravel_index(flat, shape), strict=True))
        if not places:
            return "the only row"
        if places.keys() <= set(spec.axes):
            return row_in_words(spec, places)
        return ", ".join(f"{name} {number}" for name, number in places.items())

    return in_words


def _brackets(spec: SweepSpec, group: Group, stored: _Columns) -> Iterator[tuple[str, str]]:
    """Yield the axis and the name of the middle of each bracket whose ends have exact verdicts."""
    if spec.model.exact is None or spec.boundary_width is None:
        return
    # the reference gives no verdict if it does not know a variable that the criterion uses
    if not set(spec.criterion.needs(spec.model)).isdisjoint(spec.model.unknown_to.get("exact", ())):
        return
    if POINTS in group[0][0].dims and len(stored) < len(group):
        # the exact verdict at a point needs all of its coordinates
        return
    for axis in spec.axes:
        for middle in (f"curve_{axis}", *(edge_names(axis, edge)[0] for edge in EDGES)):
            if {middle, middle + _HALF} <= stored.keys():
                yield axis, middle


def _allowed(
    spec: SweepSpec, name: str, again: _Columns, is_float: bool, repeated: bool
) -> tuple[str, Array | float]:
    """Return the reference for a boundary variable, and the allowed difference of each value."""
    size = np.abs(np.nan_to_num(again[name]))
    if name.startswith(("predicted_", "critical_")):
        return "the line of theory, computed again", _THEORY_ROUNDING * size
    middle = name.removesuffix(_HALF)
    if middle + _HALF not in again:
        return "the stored verdicts", _THEORY_ROUNDING * size if is_float else 0.0
    place = np.abs(np.nan_to_num(again[middle]))
    if spec.boundary_width is None:
        return "the stored verdicts", _ROUNDING * place
    against = "the stored verdicts, bisected again"
    if repeated:
        return against, _LAST_BITS * place
    width = np.nan_to_num(again[middle + _HALF])
    wider = np.where(width > 0.0, _WIDER * np.maximum(width, spec.boundary_width), 0.0)
    return against, _ROUNDING * place + wider


def _alike(spec: SweepSpec, stored: _Columns, axis: str, middle: str) -> Array:
    """Return 1 where both ends of a bracket have the same exact verdict, otherwise 0; undecided ends give 0."""
    exact = spec.replace(method="exact")
    centre, width = stored[middle].reshape(-1), stored[middle + _HALF].reshape(-1)
    known = np.isfinite(centre) & np.isfinite(width)
    if middle.startswith("curve_"):
        # a point lies on the grid along all axes except the measured one
        known &= width > 0.0
        starts = _point_starts(exact, stored, centre.size)
    else:
        starts = whole(rows_along(spec, axis))
    verdicts = []
    for end in (centre - width, centre + width):
        chosen = {name: each[known] for name, each in starts.items()}
        chosen[axis] = _on_the_grid(exact, axis, end[known])
        verdicts.append(judged(exact, completed(exact, chosen)) if known.any() else np.zeros(0, np.int8))
    wrong = np.zeros(centre.size)
    wrong[known] = (verdicts[0] == verdicts[1]) & (verdicts[0] != UNDECIDED)
    return wrong.reshape(stored[middle].shape)


def _on_the_grid(spec: SweepSpec, axis: str, ends: Array) -> Array:
    """Return the ends of brackets; move an end within rounding of an axis value to that value.

    A criterion such as ``tilt == 1deg`` may hold at a single double, which middle plus half-width may miss.
    """
    held = getattr(spec, axis).array()
    after = np.clip(np.searchsorted(held, ends), 1, held.size - 1)
    near = np.where(ends - held[after - 1] < held[after] - ends, held[after - 1], held[after])
    return np.where(np.abs(near - ends) <= _LAST_BITS * np.abs(held).max(), near, ends)


def _point_starts(spec: SweepSpec, stored: _Columns, count: int) -> Starts:
    """Return the starts at the points of the curves."""
    others = dict.fromkeys(spec.computed, np.nan) | dict(spec.constants)
    others |= {name: getattr(spec, name) for name in spec.fixed}
    points = {name: np.full(count, value) for name, value in others.items()}
    points |= {name: stored[f"curve_{name}"] for name in spec.axes}
    return {name: points[name] for name in spec.model.parameters}
