"""The boundary of an atlas found again from its verdicts, and its brackets held against the exact reference."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from sweep.atlas.boundary import judged
from sweep.atlas.boundary_search import BoundarySearch
from sweep.atlas.cf_metadata import EDGES, Declaration, edge_names
from sweep.checks.cell_audit import row_in_words
from sweep.checks.statement import MOST_NAMED, Statement
from sweep.engine.grid import completed, whole
from sweep.model.description import Starts
from sweep.model.quantity import UNDECIDED, Array, Truths
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr

#: Relative rounding of an axis and of a middle between two of its values, and of a line of theory: its sums are longer.
_ROUNDING, _THEORY_ROUNDING = 1e-12, 1e-9

#: The same where the processor rounds like the one that made the atlas.
_LAST_BITS = 1e-15

#: A bracket that was bisected elsewhere may be so many times as wide as it comes out here, or as the spec asks for.
_WIDER = 4.0

Values = npt.NDArray[np.generic]
_Check = tuple[str, Array, Array]


#: The variables of the boundary by their names.
Boundaries = Mapping[str, tuple[Declaration, Values]]


def found_again(search: BoundarySearch) -> Boundaries:
    """Return the variables of the boundary that the stored verdicts of an atlas have."""
    return {each.name: (each, np.asarray(values)) for each, values in search.variables()}


def boundary_statements(
    spec: SweepSpec, dataset: "xr.Dataset", again: Boundaries, repeated: bool
) -> list[Statement]:
    """Return what is found of the variables of the boundary: edges, lines of theory, curves.

    Parameters
    ----------
    spec : SweepSpec
    dataset : xarray.Dataset
        The atlas.
    again : Boundaries
        As from `found_again`.
    repeated : bool
        Whether a computation here comes out the same, to the bit, as where the atlas was made.

    Notes
    -----
    All of them follow from the stored verdicts: they are found again. Where the spec asks for a refined boundary, the
    exact reference must besides have unlike verdicts at the two ends of every bracket.
    """
    halves = _halfwidths(spec)
    brackets = dict(_brackets(spec, dataset, halves)) if spec.boundary_width is not None else {}
    statements = []
    for name, (declared, expected) in again.items():
        if name not in dataset:
            continue
        stored = dataset[name].values
        if stored.shape != expected.shape:
            statements.append(_other_shape(name, stored, expected))
            continue
        checks = [_found_again(spec, name, dataset, again, halves, repeated)]
        measured = halves.get(name, name)
        if measured in brackets:
            wrong = brackets[measured].astype(np.float64)
            checks.append(("unlike exact verdicts at the ends of its bracket", wrong, np.zeros(wrong.shape)))
        statements.append(_statement(spec, declared, checks))
    return statements


def _halfwidths(spec: SweepSpec) -> dict[str, str]:
    """Return the name of each half-width with that of the middle of its bracket."""
    edges = [edge_names(axis, edge) for axis in spec.axes for edge in EDGES]
    return {names[1]: names[0] for names in edges} | {
        f"curve_{axis}_halfwidth": f"curve_{axis}" for axis in spec.axes
    }


def _found_again(
    spec: SweepSpec,
    name: str,
    dataset: "xr.Dataset",
    again: Boundaries,
    halves: Mapping[str, str],
    repeated: bool,
) -> _Check:
    """Return what a variable was held against, the difference, and what is allowed."""
    declared, expected = again[name]
    stored = np.asarray(dataset[name].values, np.float64)
    wanted = np.asarray(expected, np.float64)
    size = np.abs(np.nan_to_num(wanted))
    middles = {middle: half for half, middle in halves.items()}
    against, allowed = "the stored verdicts", np.zeros(wanted.shape)
    if name.startswith(("predicted_", "critical_")):
        against, allowed = "the line of theory, computed again", _THEORY_ROUNDING * size
    elif name in halves or name in middles:
        middle = halves.get(name, name)
        place = np.abs(np.nan_to_num(np.asarray(again[middle][1], np.float64)))
        allowed = _ROUNDING * place
        if spec.boundary_width is not None:
            against = "the stored verdicts, bisected again"
            if repeated:
                allowed = _LAST_BITS * place
            else:
                width = np.nan_to_num(np.asarray(again[middles[middle]][1], np.float64))
                allowed = allowed + np.where(
                    width > 0.0, _WIDER * np.maximum(width, spec.boundary_width), 0.0
                )
    elif declared.dtype.startswith("f"):
        allowed = _THEORY_ROUNDING * size
    same = (stored == wanted) | (np.isnan(stored) & np.isnan(wanted))
    with np.errstate(invalid="ignore"):
        return against, np.where(same, 0.0, np.abs(stored - wanted)), allowed


def _other_shape(name: str, stored: Values, expected: Values) -> Statement:
    words = f"{' x '.join(map(str, stored.shape))} values instead of {' x '.join(map(str, expected.shape))}"
    return Statement(
        name, "the stored verdicts", judged=int(stored.size), wrong=int(stored.size), named=[words]
    )


def _brackets(
    spec: SweepSpec, dataset: "xr.Dataset", halves: Mapping[str, str]
) -> Iterator[tuple[str, npt.NDArray[np.bool_]]]:
    """Yield the name of each measured place with where the ends of its brackets have the wrong exact verdicts."""
    exact = spec.replace(method="exact")
    for half, middle in halves.items():
        if half not in dataset or middle not in dataset:
            continue
        if dataset[half].values.shape != dataset[middle].values.shape:
            continue
        axis = _axis_of(spec, middle)
        places, width = (np.asarray(dataset[name].values, np.float64) for name in (middle, half))
        starts = _curve_starts(spec, dataset) if middle.startswith("curve_") else _row_starts(spec, axis)
        if starts is None or any(each.size != places.size for each in starts.values()):
            continue
        known = (np.isfinite(places) & np.isfinite(width)).ravel()
        if middle.startswith("curve_"):
            # a point lies on the grid along all axes but the measured one
            known &= width.ravel() > 0.0
        wrong = np.zeros(places.size, bool)
        wrong[known] = _alike(exact, axis, starts, known, places.ravel()[known], width.ravel()[known])
        yield middle, wrong.reshape(places.shape)


def _alike(spec: SweepSpec, axis: str, starts: Starts, which: Truths, places: Array, width: Array) -> Truths:
    """Return where both ends of a bracket have one exact verdict; an end on the edge itself is undecided."""
    ends = []
    for end in (places - width, places + width):
        chosen = {name: end if name == axis else each.ravel()[which] for name, each in starts.items()}
        ends.append(judged(spec, completed(spec, chosen)) if end.size else np.zeros(0, np.int8))
    return np.asarray((ends[0] == ends[1]) & (ends[0] != UNDECIDED))


def _axis_of(spec: SweepSpec, middle: str) -> str:
    if middle.startswith("curve_"):
        return middle.removeprefix("curve_")
    return next(axis for axis in spec.axes for edge in EDGES if edge_names(axis, edge)[0] == middle)


def _row_starts(spec: SweepSpec, axis: str) -> Starts:
    """Return the starts of the rows along an axis; what they hold for the axis does not matter."""
    return whole(spec.replace(**{axis: next((float(end) for end in getattr(spec, axis).ends() if end), 1.0)}))


def _curve_starts(spec: SweepSpec, dataset: "xr.Dataset") -> Starts | None:
    """Return the starts at the points of the curves; None if a coordinate of theirs is missing."""
    names = {name: f"curve_{name}" for name in spec.axes}
    if any(name not in dataset for name in names.values()):
        return None
    points = {name: np.asarray(dataset[stored].values, np.float64) for name, stored in names.items()}
    count = points[spec.axes[0]].size
    fixed = {name: np.full(count, getattr(spec, name)) for name in spec.fixed}
    computed = {name: np.full(count, np.nan) for name in spec.computed}
    return {name: {**points, **fixed, **computed}[name] for name in spec.model.parameters}


def _statement(spec: SweepSpec, declared: Declaration, checks: list[_Check]) -> Statement:
    """Return the statement of a variable, with the difference that the first wrong check found, or the first of all."""
    wrongs = [~(difference <= allowed) for _, difference, allowed in checks]
    worst = int(np.argmax([wrong.any() for wrong in wrongs]))
    _, difference, allowed = checks[worst]
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.nan_to_num(np.where(difference == 0.0, 0.0, difference / allowed), nan=np.inf)
    place = np.unravel_index(int(np.argmax(ratio)), ratio.shape) if ratio.size else None
    some = np.any(wrongs, axis=0)
    return Statement(
        declared.name,
        "; ".join(against for against, _, _ in checks),
        judged=max(1, int(ratio.size)),
        wrong=int(np.count_nonzero(some)),
        difference=float(difference[place]) if place is not None else 0.0,
        allowed=float(allowed[place]) if place is not None else 0.0,
        units=str(declared.attributes.get("units", "1")),
        named=[_place_in_words(spec, declared, each) for each in np.argwhere(some)[:MOST_NAMED]],
    )


def _place_in_words(spec: SweepSpec, declared: Declaration, place: npt.NDArray[np.intp]) -> str:
    if set(declared.dims) <= set(spec.axes):
        return (
            row_in_words(spec, dict(zip(declared.dims, place, strict=True)))
            if declared.dims
            else "the one row"
        )
    return ", ".join(f"{name} {number}" for name, number in zip(declared.dims, place.tolist(), strict=True))
