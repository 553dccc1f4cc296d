"""Hold all that an atlas states against what it follows from: its spec, and the exact extremes of the same starts."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
import numpy.typing as npt

from sweep.atlas.cf_metadata import coordinates, created, declare_cells
from sweep.atlas.dataset import as_variable, place_of, require, spec_named, spec_of
from sweep.checks.attribute_audit import attribute_statements, coordinate_statements, made_by
from sweep.checks.boundary_audit import boundary_statements, found_again
from sweep.checks.cell_audit import CellAudit
from sweep.checks.statement import Statement, from_text, to_text
from sweep.engine.compute import arithmetic_hash, use_threads
from sweep.errors import RequestError
from sweep.model.description import ExactReference
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr

#: Number of disagreeing cells that are named.
_MOST_NAMED = 5

#: The attribute of an audit that holds its statements.
_STATEMENTS = "audit_statements"


@dataclass(frozen=True)
class Findings:
    """Counts and statistics of an audit.

    Parameters
    ----------
    counts : mapping of str to int
        Each flag of the audit to its number of cells.
    agreeing, disagreeing, missing : int
        Cells that agree (as far as time and the tolerance let them), that disagree, that have not been computed. The
        others are unresolved or invalid, in the atlas or in the reference.
    coordinate, units : str
        Whose extremes were held against the exact ones, and their unit.
    extremes : (median, 99 %, largest)
        Distribution of the error of the extremes [SI], over the cells that have one and were not ended by time; NaN if
        none.
    period : (median, 99 %, largest)
        The same of the error of the period over the exact period.
    period_share : float
        Largest error of a period over what the tolerance allows.
    named : sequence of (str, mapping of str to float)
        Cells by their coordinates, each with its flag: of those that disagree the first few, or else the one with the
        largest difference.
    tolerance : float
        That of the atlas, in the same unit.
    method : str
        That of the atlas.
    statements : sequence of Statement
        What was found of each variable and attribute.
    """

    counts: Mapping[str, int]
    agreeing: int
    disagreeing: int
    missing: int
    coordinate: str
    units: str
    extremes: tuple[float, float, float]
    period: tuple[float, float, float]
    period_share: float
    named: Sequence[tuple[str, Mapping[str, float]]]
    tolerance: float
    method: str
    statements: Sequence[Statement]

    @property
    def cells(self) -> int:
        """Cells in all."""
        return sum(self.counts.values())

    @property
    def wrong(self) -> Sequence[Statement]:
        """The statements of the atlas that are wrong."""
        return [each for each in self.statements if each.wrong]

    @property
    def passed(self) -> bool:
        """Whether no cell disagrees, none is missing, and nothing that the atlas states is wrong."""
        return not self.disagreeing and not self.missing and not self.wrong


def verify(dataset: "xr.Dataset") -> "xr.Dataset":
    """Hold all that an atlas states against its spec and the exact reference of its model.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas, as `sweep.run` or `sweep.open_atlas` returns it.

    Returns
    -------
    xarray.Dataset
        On the dimensions of the atlas: the variables of its model's audit (`sweep.model.description.Audit`). A cell
        agrees if its extremes lie within the tolerance that the atlas records, its period within what that tolerance
        means for it, its ending and verdict are the exact ones, its derived numbers follow from its extremes, and its
        other variables are what its integration gives again. What was found of each variable and attribute, the
        boundary and its curves too, is in the attribute ``audit_statements``; `findings` reads it.

    Raises
    ------
    RequestError
        If its model has no exact reference, or the atlas lacks a variable that is needed, cannot be read, or is only a
        part of an atlas.
    """
    import xarray as xr

    spec, reference, stored = _read(dataset)
    use_threads(None)
    own = made_by(dataset, arithmetic_hash(spec)) and spec.device == "cpu"
    cells = CellAudit(spec, reference, stored, own)
    declared = declare_cells(spec, reference.audit.variables, "audit")
    found = cells.audited([each.name for each in declared])
    again = found_again(spec, dataset)
    statements = [
        *coordinate_statements(spec, dataset),
        *cells.statements(),
        *boundary_statements(spec, dataset, again, cells.repeated),
        *attribute_statements(spec, dataset, [each for each, _ in again.values()], own),
    ]
    return xr.Dataset(
        {each.name: as_variable(each, found[each.name].reshape(spec.shape), spec) for each in declared},
        {each.name: as_variable(each, values, spec) for each, values in coordinates(spec)},
        {
            **dataset.attrs,
            "title": f"Audit of: {dataset.attrs.get('title', 'a stability atlas')}",
            "summary": "Every cell of a stability atlas held against the exact extreme "
            f"{spec.model.coordinate}s and period of its motion.",
            "history": f"{dataset.attrs.get('history', '')}\n{created()} sweep.verify".lstrip("\n"),
            "tolerance": spec.tolerance,
            "method": spec.method,
            _STATEMENTS: to_text(statements),
        },
    )


def findings(audited: "xr.Dataset") -> Findings:
    """Return the counts and statistics of an audit, as from `verify`."""
    spec = spec_named(audited)
    model, audit = spec.model, _reference(spec).audit
    codes = audited["audit"].values
    flags = audit.variables["audit"].flags or {}
    wrong = np.isin(codes, audit.disagreeing)
    difference = np.where(codes == audit.ended_by_time, np.nan, audited[audit.difference].values)
    error, exact, share = (audited[name].values for name in audit.period)
    places = np.argwhere(wrong)[:_MOST_NAMED]
    if not wrong.any() and np.isfinite(difference).any():
        places = np.array([np.unravel_index(int(np.nanargmax(difference)), difference.shape)], dtype=np.intp)
    return Findings(
        counts={name: int((codes == code).sum()) for code, name in flags.items()},
        agreeing=int(np.isin(codes, audit.agreeing).sum()),
        disagreeing=int(wrong.sum()),
        missing=int((codes == audit.missing).sum()),
        coordinate=model.coordinate,
        units=model.parameters[model.coordinate].units,
        extremes=_distribution(difference),
        period=_distribution(np.abs(error) / exact),
        period_share=_distribution(share)[2],
        named=[
            (
                flags[int(codes[tuple(place)])],
                {
                    str(name): float(audited[name][i])
                    for name, i in zip(audited["audit"].dims, place, strict=True)
                },
            )
            for place in places
        ],
        tolerance=float(audited.attrs["tolerance"]),
        method=str(audited.attrs["method"]),
        statements=from_text(str(audited.attrs[_STATEMENTS])),
    )


def _reference(spec: SweepSpec) -> ExactReference:
    if spec.model.exact is None:
        raise RequestError(
            f"The model {spec.model.name} has no exact reference to verify an atlas with.",
            hint="Compare with an atlas of a smaller tolerance instead: eulerdisk compare.",
        )
    return spec.model.exact


def _read(dataset: "xr.Dataset") -> tuple[SweepSpec, ExactReference, dict[str, npt.NDArray[Any]]]:
    """Return the spec of an atlas, the reference of its model, and the variables that an audit needs, flat."""
    if "sweep_spec" not in dataset.attrs:
        _refuse(dataset, "it lacks the attribute sweep_spec")
    reference = _reference(spec_named(dataset))
    names = reference.needed(spec_named(dataset))
    require(dataset, names)
    spec = spec_of(dataset)
    if odd := [name for name in names if dataset[name].dims != spec.axes]:
        _refuse(
            dataset,
            f"each variable must have the dimensions {', '.join(spec.axes) or '()'}; {', '.join(odd)} has others",
        )
    # an older file has no coordinate for a parameter that was added later
    later = {name for name in spec.fixed if spec.model.parameters[name].added_later}
    for each, values in coordinates(spec):
        if each.name in later and each.name not in dataset:
            continue
        if each.name not in dataset or dataset[each.name].values.shape != values.shape:
            _refuse(dataset, f"the coordinate {each.name} does not have the values of its spec")
    stored = {}
    for name in dict.fromkeys((*names, *spec.model.cell_variables(spec))):
        # an older file lacks the variables that were added later
        if name not in dataset or dataset[name].dims != spec.axes:
            continue
        try:
            stored[name] = dataset[name].values.ravel()
        except (OSError, RuntimeError) as problem:
            _refuse(dataset, f"{name} cannot be read, {problem}")
    return spec, reference, stored


def _refuse(dataset: "xr.Dataset", reason: str) -> NoReturn:
    raise RequestError(
        f"The atlas cannot be verified: {reason}.",
        hint="Make it again with eulerdisk run.",
        where=place_of(dataset),
    )


def _distribution(values: npt.NDArray[np.float64]) -> tuple[float, float, float]:
    known = values[np.isfinite(values)]
    median, high, most = np.percentile(known, [50, 99, 100]) if known.size else (np.nan,) * 3
    return float(median), float(high), float(most)
