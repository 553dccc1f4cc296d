"""The regression check: compare an atlas with a reference.

Decisions (endings, verdicts) must be equal, measures must agree within the tolerances of the tables, and a value that
is missing in one must be missing in the other. In a borderline cell the last bit decides: such flips are counted apart.
What a reference holds of its cells, the new atlas must hold; what only the new one holds is named, and no difference.
"""

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from sweep.atlas.cf_metadata import EDGES, curve_quantities, edge_quantities, point_quantities
from sweep.checks.alignment import Pair, align
from sweep.engine.compute import reach_and_scale
from sweep.model.quantity import ERROR_GAUGE, STABLE, STEP_COUNT, UNSTABLE, Array, Quantity, Tolerance, Truths

if TYPE_CHECKING:
    import xarray as xr

#: Attributes of a variable that give its numbers their meaning.
_MEANING = ("units", "flag_values", "flag_meanings")

#: Prefixes of the variables that follow from the verdicts; curves have dimensions of their own.
_CURVE = "curve_"
_MEASURED = ("boundary_", _CURVE)

#: Attributes of an atlas whose contents `align` has compared.
_COMPARED = ("sweep_spec", "sweep_fingerprint")


@dataclass(frozen=True)
class Cell:
    """The cell where two atlases differ most: its coordinates [SI], its values, and its coordinates in words."""

    where: dict[str, float]
    new: float | None
    reference: float | None
    place: str


@dataclass(frozen=True)
class Finding:
    """The comparison of one variable.

    `different` counts the values beyond the tolerance, `on_edge` those that differ because a borderline cell flipped;
    `largest` is the largest absolute difference among all values that both have, in the units of the variable.
    """

    name: str
    units: str
    values: int
    different: int
    on_edge: int
    largest: float
    worst: Cell | None
    tolerance: Tolerance
    note: str = ""


@dataclass(frozen=True)
class Comparison:
    """The result of a comparison: `same` if no value differs, except because of borderline cells."""

    cells: int
    common: bool
    findings: tuple[Finding, ...]
    #: attribute -> (new, reference): when, by what and in which words they were made; these may differ
    provenance: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    @property
    def same(self) -> bool:
        """Whether the two atlases agree."""
        return not any(finding.different for finding in self.findings)

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain types, for JSON."""
        found: dict[str, Any] = {"same": self.same, **asdict(self)}
        for finding in found["findings"]:
            if finding["worst"] is not None:
                del finding["worst"]["place"]
        return found


def compare(new: "xr.Dataset", reference: "xr.Dataset", *, common: bool = False) -> Comparison:
    """Compare an atlas with a trusted one.

    Parameters
    ----------
    new, reference : xarray.Dataset
        Atlases, as `sweep.run` or `sweep.open_atlas` returns them.
    common : bool
        Compare only the cells that both have; otherwise the grids must be the same.

    Returns
    -------
    Comparison

    Raises
    ------
    RequestError
        If the two are not comparable: other parameters, criterion, method, duration or fall_tilt, or other grids.
    """
    pair = align(new, reference, common=common)
    ending = _endings_on_edge(pair)
    verdict = _verdicts_on_edge(pair, ending)
    findings, notes = [], []
    for quantity, axis in _quantities(pair):
        name = quantity.name
        if reason := _left_out(quantity, axis, pair):
            notes.append(f"{name} is not compared: {reason}")
        elif name not in pair.reference and name in pair.cell_variables:
            notes.append(f"{name} is not compared: the reference atlas does not have it")
        elif name not in pair.new or name not in pair.reference:
            side, held = ("reference", pair.new) if name in pair.new else ("new", pair.reference)
            missing = np.ones(held[name].shape, bool)
            findings.append(_finding(quantity, missing, ~missing, f"the {side} atlas does not have it"))
        else:
            findings.append(_compared(quantity, pair, _excused(name, axis, pair, ending, verdict)))
    cells = pair.reference["ending"].size
    return Comparison(cells, common, tuple(findings), _provenance(pair), (*pair.notes, *notes))


def _left_out(quantity: Quantity, axis: str, pair: Pair) -> str:
    """Return why a variable is not compared; empty if it is."""
    along = pair.cut.intersection(pair.axes if quantity.name.startswith(_CURVE) else [axis])
    if along:
        return f"only a part of {', '.join(sorted(along))} is common"
    if quantity.name.startswith(_MEASURED) and pair.boundaries[0] != pair.boundaries[1]:
        return f"boundary differs: {' and '.join(pair.boundaries)}"
    # errors and work of the integration belong to its steps and its kernels, not to the motion
    if quantity.tolerance in (ERROR_GAUGE, STEP_COUNT):
        if pair.other_steps:
            return f"{', '.join(pair.other_steps)} differ"
        if pair.new.attrs.get("kernel_hash") != pair.reference.attrs.get("kernel_hash"):
            return "the kernels differ"
    return ""


def _quantities(pair: Pair) -> Iterator[tuple[Quantity, str]]:
    """Yield the quantities that either atlas holds; an edge of the boundary with the axis that it lies on."""
    model = pair.spec.model
    known = [(each, "") for each in (*pair.cell_variables.values(), *model.parameters.values())]
    for axis in pair.axes:
        for edge in EDGES:
            known += [(each, axis) for each in edge_quantities(model.parameters[axis], edge).values()]
    known += [(each, "") for each in curve_quantities().values()]
    known += [(each, "") for each in point_quantities(model.parameters, pair.spec.axes).values()]
    for quantity, axis in known:
        if quantity.name in pair.new.data_vars or quantity.name in pair.reference.data_vars:
            yield quantity, axis


def _excused(name: str, axis: str, pair: Pair, ending: Truths, verdict: Truths) -> Truths:
    """Return which values may differ because a borderline cell flips: the flag, or what follows from it."""
    if name.startswith(_CURVE):
        return np.full(pair.reference[name].shape, bool(np.any(ending | verdict)))
    if axis:
        along = pair.axes.index(axis)
        # the bracket moves with the verdict that flips; the lines of theory do not depend on cells
        moved = np.any(ending | verdict, axis=along)
        return moved if name.startswith("boundary_") else np.zeros_like(moved)
    return verdict if name == "stability" else ending


def _compared(quantity: Quantity, pair: Pair, excused: Truths) -> Finding:
    new, old = (atlas[quantity.name].values for atlas in (pair.new, pair.reference))
    if new.shape != old.shape:
        # curves of different numbers or lengths cannot be compared point by point
        note = f"{new.size} values, in the reference {old.size}"
        return _finding(quantity, np.ones_like(excused), excused, note)
    distance = np.abs(new.astype(np.float64) - old.astype(np.float64))
    allowed = quantity.tolerance.absolute + quantity.tolerance.relative * np.abs(old.astype(np.float64))
    gaps = np.isnan(new) != np.isnan(old)
    beyond = gaps | (distance > allowed)
    note = _other_meaning(quantity.name, pair)
    if note:
        beyond = np.ones_like(beyond)
    known = distance[~np.isnan(distance)]
    largest = float(known.max()) if known.size else 0.0
    worst = _worst(quantity.name, pair, beyond & ~excused, gaps, distance, allowed)
    return _finding(quantity, beyond, excused, note, largest, worst)


def _finding(
    quantity: Quantity,
    beyond: Truths,
    excused: Truths,
    note: str,
    largest: float = 0.0,
    worst: Cell | None = None,
) -> Finding:
    return Finding(
        name=quantity.name,
        units=quantity.units,
        values=beyond.size,
        different=int((beyond & ~excused).sum()),
        on_edge=int((beyond & excused).sum()),
        largest=largest,
        worst=worst,
        tolerance=quantity.tolerance,
        note=note,
    )


def _worst(
    name: str, pair: Pair, beyond: Truths, gaps: Truths, distance: Array, allowed: Array
) -> Cell | None:
    """Return the cell with the largest difference over its tolerance; a value that is missing in one counts as most."""
    excess = np.where(allowed > 0.0, distance / np.where(allowed > 0.0, allowed, 1.0), distance)
    excess = np.where(gaps, np.inf, np.nan_to_num(excess))
    if not beyond.any() and not excess.any():
        return None
    candidates = beyond if beyond.any() else np.ones_like(beyond)
    place = np.unravel_index(int(np.argmax(np.where(candidates, excess, -1.0))), excess.shape)
    where = {
        str(dim): float(pair.reference[dim].values[i])
        for dim, i in zip(pair.reference[name].dims, place, strict=True)
    }
    values = [float(atlas[name].values[place]) for atlas in (pair.new, pair.reference)]
    known = pair.spec.model.parameters
    words = (
        f"{dim} {known[dim].spell(value) if dim in known else int(value)}" for dim, value in where.items()
    )
    new, reference = (None if np.isnan(value) else value for value in values)
    return Cell(where, new, reference, ", ".join(words) or "the only one")


def _other_meaning(name: str, pair: Pair) -> str:
    for key in _MEANING:
        new, old = (atlas[name].attrs.get(key) for atlas in (pair.new, pair.reference))
        if not np.array_equal(np.asarray(new), np.asarray(old)):
            return f"its {key} differ: {new} and {old}"
    return ""


def _provenance(pair: Pair) -> dict[str, tuple[str, str]]:
    """Return the attributes in which the two differ: when, by what and in which words they were made."""
    found = _different(pair.new.attrs, pair.reference.attrs, _COMPARED)
    for name in pair.reference.variables:
        if name in pair.new.variables:
            both = (pair.new[name].attrs, pair.reference[name].attrs)
            found |= {f"{name}:{key}": values for key, values in _different(*both, _MEANING).items()}
    return found


def _different(
    new: Mapping[Any, Any], old: Mapping[Any, Any], leave: tuple[str, ...]
) -> dict[str, tuple[str, str]]:
    return {
        str(key): (str(new.get(key, "")), str(old.get(key, "")))
        for key in dict.fromkeys([*old, *new])
        if key not in leave and str(new.get(key, "")) != str(old.get(key, ""))
    }


def _endings_on_edge(pair: Pair) -> Truths:
    """Return where the endings differ and a neighbour of the cell, in the reference, ended as the new atlas says.

    An ending changes where time, error or coordinate reaches its limit, and that edge runs between cells.
    """
    new, old = (atlas["ending"].values for atlas in (pair.new, pair.reference))
    on_edge: Truths = (new != old) & _beside(new, old)
    return on_edge


def _verdicts_on_edge(pair: Pair, endings: Truths) -> Truths:
    """Return where the verdicts differ and the cell stands on the edge between them.

    With the same ending, a cell may be stable in one and unstable in the other where the limit of the criterion lies
    between the departures of the two, or within the tolerance of the extremes from either. Where the ending flips
    (`endings`), the verdict that follows from it may flip too.
    """
    new, old = (atlas["stability"].values for atlas in (pair.new, pair.reference))
    decided = np.isin(new, (STABLE, UNSTABLE)) & np.isin(old, (STABLE, UNSTABLE))
    same_ending = pair.new["ending"].values == pair.reference["ending"].values
    on_edge: Truths = (new != old) & (endings | (decided & same_ending & _at_limit(pair)))
    return on_edge


def _beside(new: npt.NDArray[np.integer], old: npt.NDArray[np.integer]) -> Truths:
    """Return where a neighbour along any axis has, in `old`, the code that the cell has in `new`."""
    found = np.zeros(new.shape, bool)
    for axis in range(new.ndim):
        for here, there in ((slice(1, None), slice(None, -1)), (slice(None, -1), slice(1, None))):
            at = (slice(None),) * axis
            found[(*at, here)] |= new[(*at, here)] == old[(*at, there)]
    return found


def _at_limit(pair: Pair) -> Truths:
    model, ending = pair.spec.model, pair.reference["ending"]
    starts = {
        str(name): values.broadcast_like(ending).transpose(*pair.axes).values
        for name, values in pair.reference.coords.items()
    }
    reaches = []
    for atlas in (pair.new, pair.reference):
        measured = {name: atlas[name].values for name in model.extremes}
        reach, scale = reach_and_scale(pair.spec, starts, measured)
        reaches.append(reach)
    limit = np.nan_to_num(pair.spec.criterion.allowed(scale))
    slack = model.variables[model.extremes[1]].tolerance.absolute
    at: Truths = (np.minimum(*reaches) - slack <= limit) & (limit <= np.maximum(*reaches) + slack)
    return at
