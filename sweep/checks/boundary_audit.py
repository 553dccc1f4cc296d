"""The boundary of an atlas found again from its verdicts, and its brackets held against the exact reference."""

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from sweep.atlas.boundary import judged, rows_along
from sweep.atlas.boundary_search import Group
from sweep.atlas.cf_metadata import CURVES, EDGES, POINTS, Declaration, edge_names
from sweep.checks.tally import Statement, Tally, difference_check, row_in_words
from sweep.engine.grid import completed, whole
from sweep.model.description import CellCheck, Starts
from sweep.model.quantity import UNDECIDED, Array, Truths
from sweep.request.axes import Range
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr

#: Relative rounding of an axis and of a middle between two of its values, and of a line of theory: its sums are longer.
_ROUNDING, _THEORY_ROUNDING = 1e-12, 1e-9

#: The same where the processor rounds like the one that made the atlas.
_LAST_BITS = 1e-15

#: A bracket that was bisected elsewhere may be so many times as wide as it comes out here, or as the spec asks for.
_WIDER = 4.0

#: Variables of one shape by their names.
_Columns = Mapping[str, Array]


def boundary_statements(
    spec: SweepSpec, dataset: "xr.Dataset", again: Iterable[Group], repeated: bool
) -> Iterator[tuple[Declaration, Statement | None]]:
    """Yield the variables of the boundary, edges, lines of theory and curves, and what is found of each.

    Parameters
    ----------
    spec : SweepSpec
    dataset : xarray.Dataset
        The atlas, which may lack some of them: of those nothing is found.
    again : iterable of list of (Declaration, array)
        The boundary (`sweep.atlas.boundary_search.boundary_groups`) that the stored verdicts have.
    repeated : bool
        Whether a computation here comes out the same, to the bit, as where the atlas was made.

    Notes
    -----
    All of them follow from the stored verdicts: they are found again. Where the spec asks for a refined boundary, the
    exact reference must besides have unlike verdicts at the two ends of every bracket.
    """
    for group in again:
        audit = _GroupAudit(spec, dataset, group, repeated)
        for declared, _ in group:
            yield declared, audit.statement(declared)


class _GroupAudit:
    """What is found of the variables of one edge, of the curves, or of their points."""

    def __init__(self, spec: SweepSpec, dataset: "xr.Dataset", group: Group, repeated: bool) -> None:
        self._spec, self._dataset, self._shape = spec, dataset, group[0][1].shape
        self._repeated, self._halves = repeated, _halfwidths(spec)
        named, dims = {each.name: each for each, _ in group}, group[0][0].dims
        self._tallies = {
            name: Tally(name, str(declared.attributes.get("units", "1")))
            for name, declared in named.items()
            if name in dataset and dataset[name].shape == self._shape
        }
        # where the reference does not know what the criterion judges by, it has no verdict of an end
        unknown = spec.model.unknown_to.get("exact", ())
        judged_by = spec.criterion.needs(spec.model)
        has_exact = spec.boundary_width is not None and set(judged_by).isdisjoint(unknown)
        held = self._halves if has_exact else {}
        self._brackets = {
            middle: half for half, middle in held.items() if {half, middle} <= self._tallies.keys()
        }
        if CURVES in dims or (POINTS in dims and not named.keys() <= self._tallies.keys()):
            # the coordinates of a point are needed to have its exact verdict
            self._brackets = {}
        self._add({declared.name: values for declared, values in group})

    def _add(self, again: _Columns) -> None:
        stored = {name: np.asarray(self._dataset[name], np.float64) for name in self._tallies}
        wrong = {middle: self._alike(stored, middle, half) for middle, half in self._brackets.items()}
        for name, tally in self._tallies.items():
            checks = [_found_again(self._spec, name, stored[name], again, self._halves, self._repeated)]
            ends = wrong.get(self._halves.get(name, name))
            if ends is not None:
                against = "unlike exact verdicts at the ends of its bracket"
                checks.append(
                    difference_check(name, against, ends, np.zeros(ends.shape), np.zeros(ends.shape))
                )
            tally.add_all(0, checks)

    def _alike(self, stored: _Columns, middle: str, half: str) -> Array:
        """Return 1 where both ends of a bracket have one exact verdict, else 0; an end on the edge is undecided."""
        spec, axis = self._spec.replace(method="exact"), _axis_of(self._spec, middle)
        centre, width = stored[middle].reshape(-1), stored[half].reshape(-1)
        known = np.isfinite(centre) & np.isfinite(width)
        if middle.startswith("curve_"):
            # a point lies on the grid along all axes but the measured one
            known &= width > 0.0
            starts = _point_starts(spec, stored, centre.size)
        else:
            starts = whole(rows_along(self._spec, axis))
        wrong = np.zeros(centre.size)
        wrong[known] = _same_verdicts(spec, axis, starts, known, centre[known], width[known])
        return wrong.reshape(stored[middle].shape)

    def statement(self, declared: Declaration) -> Statement | None:
        """Return what was found of a variable; None if the atlas lacks it."""
        if declared.name in self._tallies:
            return self._tallies[declared.name].statement(
                lambda place: _place_in_words(self._spec, declared, np.unravel_index(place, self._shape))
            )
        if declared.name not in self._dataset:
            return None
        stored = self._dataset[declared.name]
        words = f"{_by(stored.shape)} values instead of {_by(self._shape)}"
        size = int(stored.size)
        return Statement(declared.name, "the stored verdicts", judged=size, wrong=size, named=[words])


def _by(shape: tuple[int, ...]) -> str:
    return " x ".join(map(str, shape))


def _halfwidths(spec: SweepSpec) -> dict[str, str]:
    """Return the name of each half-width with that of the middle of its bracket."""
    edges = [edge_names(axis, edge) for axis in spec.axes for edge in EDGES]
    return {names[1]: names[0] for names in edges} | {
        f"curve_{axis}_halfwidth": f"curve_{axis}" for axis in spec.axes
    }


def _found_again(
    spec: SweepSpec, name: str, stored: Array, again: _Columns, halves: Mapping[str, str], repeated: bool
) -> CellCheck:
    """Return what the values of a variable were held against, the difference, and what is allowed."""
    wanted = np.asarray(again[name], np.float64)
    size = np.abs(np.nan_to_num(wanted))
    middles = {middle: half for half, middle in halves.items()}
    against, allowed = "the stored verdicts", np.zeros(wanted.shape)
    if name.startswith(("predicted_", "critical_")):
        against, allowed = "the line of theory, computed again", _THEORY_ROUNDING * size
    elif name in halves or name in middles:
        middle = halves.get(name, name)
        place = np.abs(np.nan_to_num(again[middle]))
        allowed = _ROUNDING * place
        if spec.boundary_width is not None:
            against = "the stored verdicts, bisected again"
            if repeated:
                allowed = _LAST_BITS * place
            else:
                width = np.nan_to_num(again[middles[middle]])
                allowed = allowed + np.where(
                    width > 0.0, _WIDER * np.maximum(width, spec.boundary_width), 0.0
                )
    elif again[name].dtype.kind == "f":
        allowed = _THEORY_ROUNDING * size
    return difference_check(name, against, stored, wanted, allowed)


def _same_verdicts(
    spec: SweepSpec, axis: str, starts: Starts, which: Truths, places: Array, width: Array
) -> Truths:
    """Return where both ends of a bracket have one exact verdict; an end on the edge itself is undecided."""
    ends = []
    for end in (_on_the_grid(spec, axis, places - width), _on_the_grid(spec, axis, places + width)):
        chosen = {name: end if name == axis else each[which] for name, each in starts.items()}
        ends.append(judged(spec, completed(spec, chosen)) if end.size else np.zeros(0, np.int8))
    return np.asarray((ends[0] == ends[1]) & (ends[0] != UNDECIDED))


def _on_the_grid(spec: SweepSpec, axis: str, ends: Array) -> Array:
    """Return the ends of brackets, those that are a value of the axis but for their rounding as that value.

    A criterion may hold at one double alone, as ``tilt == 1deg`` does, and middle plus half-width may miss it.
    """
    values = getattr(spec, axis)
    if isinstance(values, Range):
        first, last = values.ends()
        share = (
            np.log(ends / first) / np.log(last / first)
            if values.spacing == "log"
            else (ends - first) / (last - first)
        )
        places = np.clip(np.rint(share * (len(values) - 1)), 0, len(values) - 1).astype(np.intp)
    else:
        held = values.array()
        after = np.clip(np.searchsorted(held, ends), 1, max(held.size - 1, 1))
        places = np.where(
            ends - held[after - 1] < held[after % held.size] - ends, after - 1, after % held.size
        )
    near = values.at(places)
    return np.where(np.abs(near - ends) <= _LAST_BITS * np.abs(values.ends()).max(), near, ends)


def _axis_of(spec: SweepSpec, middle: str) -> str:
    if middle.startswith("curve_"):
        return middle.removeprefix("curve_")
    return next(axis for axis in spec.axes for edge in EDGES if edge_names(axis, edge)[0] == middle)


def _point_starts(spec: SweepSpec, stored: _Columns, count: int) -> Starts:
    """Return the starts at some points of the curves."""
    points = {name: stored[f"curve_{name}"] for name in spec.axes}
    fixed = {name: np.full(count, getattr(spec, name)) for name in spec.fixed}
    fixed |= {name: np.full(count, value) for name, value in spec.constants.items()}
    computed = {name: np.full(count, np.nan) for name in spec.computed}
    return {name: {**points, **fixed, **computed}[name] for name in spec.model.parameters}


def _place_in_words(spec: SweepSpec, declared: Declaration, place: tuple[np.intp, ...]) -> str:
    if set(declared.dims) <= set(spec.axes):
        return (
            row_in_words(spec, dict(zip(declared.dims, place, strict=True)))
            if declared.dims
            else "the one row"
        )
    return ", ".join(f"{name} {number}" for name, number in zip(declared.dims, place, strict=True))
