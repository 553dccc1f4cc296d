"""Checks of everything an atlas states against its spec and its model's reference."""

import os
from collections.abc import Generator, Iterator
from functools import partial
from typing import TYPE_CHECKING, Any, Final, NoReturn

import numpy as np
import numpy.typing as npt

from sweep.atlas.boundary_search import boundary_groups
from sweep.atlas.cf_metadata import (
    coordinate_declarations,
    created,
    declare_cells,
    start_declarations,
)
from sweep.atlas.dataset import as_variable, coordinates, place_of, require, spec_named, spec_of
from sweep.atlas.row_edges import legal
from sweep.atlas.selection import as_atlas, attributes_of, require_atlas
from sweep.checks.attribute_audit import attribute_statements
from sweep.checks.boundary_audit import boundary_statements
from sweep.checks.cell_audit import STEPS, AuditedBlock, CellAudit, stride_of
from sweep.checks.findings import AuditSummary, Findings
from sweep.checks.statement import Checks, Statement, from_text, row_in_words, to_text
from sweep.checks.tally import Tally, difference
from sweep.engine.compute import arithmetic_hash, use_threads
from sweep.engine.grid import Span, blocks, starts_of
from sweep.errors import RequestError
from sweep.files.cell_reader import CellReader, UnreadableError
from sweep.files.reading import atlas_of
from sweep.model.description import Reference
from sweep.model.quantity import Array, Quantity
from sweep.progress.display import following
from sweep.progress.timetable import SEARCHING, Progress, Show, Stage, Timetable
from sweep.request.spec import SweepSpec
from sweep.runs.executor import no_op, prefetch
from sweep.runs.forecast import bisected_cells

if TYPE_CHECKING:
    import xarray as xr

#: Name of the progress stage.
CHECKING: Final = "checking"

#: Rounding error of a value in a range, relative to the larger end of the range.
_ROUNDING = 1e-15

#: Attributes of an audit: its statements, and a description of its sample of cells.
_STATEMENTS, _SAMPLE = "audit_statements", "audit_sample"


def verify(
    dataset: "xr.Dataset | str | os.PathLike[str]", *, seed: int | None = None, progress: Progress = None
) -> "xr.Dataset":
    """Check everything an atlas states against its spec and its model's reference.

    Parameters
    ----------
    dataset : xarray.Dataset, str or Path
        An atlas from `sweep.run` or `sweep.open_atlas`, a selection from one, or its file.
    seed : int, optional
        Selects the cells to recompute for a model without an exact reference; a new selection each time if not given.
    progress : bool or callable, optional
        As in `sweep.run`.

    Returns
    -------
    xarray.Dataset
        The variables of the model's audit (docs/atlas.md), on the dimensions of the atlas. A cell agrees if its
        extremes lie within the tolerance that the atlas records, its period lies within the error implied by that
        tolerance, its ending and verdict are exact, its derived numbers follow from its extremes, and a repeated
        integration reproduces its other variables. The attribute ``audit_statements`` holds the result for each
        variable and attribute, including the boundary and its curves; `findings` reads it. If the model has no exact
        reference, every cell is checked by the model's own rules and a sample is recomputed; the attribute
        ``audit_sample`` describes the sample.

    Raises
    ------
    RequestError
        If the model has no reference, the atlas lacks a required variable or cannot be read, or `progress` is
        invalid.
    """
    with atlas_of(dataset) as atlas:
        return _audited(_Audit(atlas, seed), progress)


def _audited(audit: "_Audit", progress: Progress) -> "xr.Dataset":
    """Return the audit as a dataset; see `verify`."""
    import xarray as xr

    spec, declared = audit.spec, audit.declared
    found = {each.name: np.empty(spec.size, each.dtype) for each in declared}
    with following(progress) as show:
        for span, variables in audit.blocks(show):
            for name, column in found.items():
                column[span.start : span.stop] = variables[name]
        attributes = audit.attributes() | audit.result()
    starts = [(each, audit.dataset[each.name].values) for each in start_declarations(spec)]
    return xr.Dataset(
        {each.name: as_variable(each, found[each.name].reshape(spec.shape), spec) for each in declared},
        {each.name: as_variable(each, values, spec) for each, values in (*coordinates(spec), *starts)},
        attributes,
    )


def findings(audited: "xr.Dataset") -> Findings:
    """Return the counts and statistics of an audit made by `sweep.verify`.

    Raises
    ------
    RequestError
        If the dataset is not an audit.
    """
    if _STATEMENTS not in attributes_of(audited) or "audit" not in audited:
        raise RequestError(
            "This is not an audit of an atlas: it lacks the variable audit or the attribute audit_statements.",
            hint="Pass the result of sweep.verify, with its attributes.",
        )
    spec = spec_named(audited)
    summary = AuditSummary(_reference(spec).audit)
    columns = {str(name): each.values.reshape(-1) for name, each in audited.data_vars.items()}
    for span in blocks(audited["audit"].size):
        summary.add(span.start, {name: each[span.start : span.stop] for name, each in columns.items()})
    statements = from_text(str(audited.attrs[_STATEMENTS]))
    return summary.findings(spec, statements, str(audited.attrs.get(_SAMPLE, "")))


def findings_of(dataset: "xr.Dataset", seed: int | None = None, show: Show = no_op) -> Findings:
    """Return the `findings` of an atlas's audit, keeping only a few blocks in memory.

    Parameters
    ----------
    dataset : xarray.Dataset
    seed : int, optional
        As in `verify`.
    show : callable, optional
        Called with the progress of the audit.

    Raises
    ------
    RequestError
        As in `verify`.
    """
    audit = _Audit(dataset, seed)
    for span, found in audit.blocks(show):
        audit.summary.add(span.start, found)
    result = audit.result()
    return audit.summary.findings(audit.spec, from_text(result[_STATEMENTS]), result.get(_SAMPLE, ""))


class _Audit:
    """The audit of an atlas: first its cells, block by block, then everything else.

    Raises
    ------
    RequestError
        If `dataset` cannot be verified.
    """

    def __init__(self, dataset: "xr.Dataset", seed: int | None) -> None:
        require_atlas(dataset)
        self.dataset = as_atlas(dataset, trusting=True)
        self.spec, self._reference = _checked(self.dataset, seed)
        self.declared = declare_cells(self.spec, self._reference.audit.variables, "audit")
        self.summary = AuditSummary(self._reference.audit)
        use_threads(None)
        spec, names = (
            self.spec,
            (*self._reference.needed(self.spec), *self.spec.model.cell_variables(self.spec)),
        )
        # another program may have dropped some variables
        self._held = [
            name
            for name in dict.fromkeys(names)
            if name in self.dataset and self.dataset[name].dims == spec.axes
        ]
        self._reader = CellReader(self.dataset, self._held)
        self._own = self.dataset.attrs.get("kernel_hash") == arithmetic_hash(spec) and spec.device == "cpu"
        self._cells = CellAudit(
            spec, self._reference, self._held, self._own, self._stride() if self._own else 0
        )

    def _stride(self) -> int:
        if STEPS not in self._held:
            return stride_of(np.ones(len(span)) for span in self._reader.spans())
        return stride_of(stored[STEPS] for _, stored in self._reader.blocks([STEPS]))

    def blocks(self, show: Show = no_op) -> Iterator[AuditedBlock]:
        """Yield all cells in C order with the variables of the audit, and report progress."""
        timetable = Timetable(
            [Stage(CHECKING, self.spec.size), Stage(SEARCHING, bisected_cells(self.spec))], show
        )
        timetable.begin(CHECKING)
        with prefetch(self._read()) as stored:
            for span, variables in self._cells.audited(stored):
                yield span, variables
                # the first block includes the compilation of kernels that are not cached on disk
                (timetable.report if span.start else timetable.measure_from)(span.stop)
        timetable.begin(SEARCHING)

    def _read(self) -> Generator[tuple[Span, dict[str, npt.NDArray[Any]]]]:
        try:
            yield from self._reader.blocks(self._held)
        except UnreadableError as problem:
            _refuse(self.dataset, f"{problem.name} cannot be read ({problem})")

    def attributes(self) -> dict[str, Any]:
        """Return the attributes of the audit, except for its result."""
        held = {str(name): value for name, value in self.dataset.attrs.items()}
        return held | {
            "title": f"Audit of: {held.get('title', 'a stability atlas')}",
            "summary": self._reference.audit.summary,
            "history": f"{held.get('history', '')}\n{created()} sweep.verify".lstrip("\n"),
            "tolerance": self.spec.tolerance,
            "method": self.spec.method,
        }

    def result(self) -> dict[str, str]:
        """Return the statements and the description of the sample; call this after all cells have been checked."""
        spec, dataset = self.spec, self.dataset
        verdicts = legal(self._reader.read("stability", Span(0, spec.size))).reshape(spec.shape)
        again = boundary_groups(spec, verdicts)
        boundary = list(boundary_statements(spec, dataset, again, self._cells.repeated))
        statements = [
            *_coordinate_statements(spec, dataset),
            *self._cells.statements(),
            *(statement for _, statement in boundary if statement is not None),
            *attribute_statements(spec, dataset, [declared for declared, _ in boundary], self._own),
        ]
        sampled = {_SAMPLE: self._reference.sampled} if self._reference.sampled else {}
        return {_STATEMENTS: to_text(statements), **sampled}


def _coordinate_statements(spec: SweepSpec, dataset: "xr.Dataset") -> Iterator[Statement]:
    """Yield the results for the coordinates of the dataset; their shapes have been checked before."""
    found = {
        name: Checks(name, spec.quantities[name].units) for name in (*spec.axes, *spec.fixed, *spec.listed)
    }
    for declared, expected in coordinates(spec):
        if (name := declared.name) in dataset.variables:
            against = "the axis of the spec" if declared.dims else "the value in the spec"
            _compare(found[name], against, 0, dataset[name], expected, spec.quantities[name])
    for span in blocks(spec.size) if spec.listed else ():
        starts = starts_of(spec, span)
        for name in spec.listed:
            stored, against = dataset[name][span.start : span.stop], f"{getattr(spec, name)} of the spec"
            _compare(found[name], against, span.start, stored, starts[name], spec.quantities[name])
    for name, checks in found.items():
        if checks.tallies:
            yield checks.statement(partial(_value_in_words, spec, tuple(map(str, dataset[name].dims))))


def _compare(
    checks: Checks, against: str, start: int, found: "xr.DataArray", expected: Array, quantity: Quantity
) -> None:
    """Compare values of a coordinate with the values in the spec, starting at a flat index."""
    stored, right, rule = np.asarray(found, np.float64).reshape(-1), expected.reshape(-1), quantity.tolerance
    # a value near 0 inside a range is only as accurate as the rounding of the ends
    allowed = rule.absolute + rule.relative * np.abs(right) + _ROUNDING * np.abs(right).max()
    checks.tallies.setdefault(against, Tally()).add(start, difference(stored, right), allowed)


def _value_in_words(spec: SweepSpec, dims: tuple[str, ...], place: int) -> str:
    return row_in_words(spec, {name: np.intp(place) for name in dims}) if dims else "the only value"


def _reference(spec: SweepSpec, seed: int | None = None) -> Reference:
    found = spec.model.reference(spec.size, seed)
    if found is None:
        raise RequestError(
            f"An atlas of the model {spec.model.name} cannot be verified: the model has no exact reference.",
            hint="Compare it with an atlas of smaller tolerance instead: eulerdisk compare.",
        )
    return found


def _checked(dataset: "xr.Dataset", seed: int | None) -> tuple[SweepSpec, Reference]:
    """Return the spec of an atlas and the reference of its model, or refuse an atlas that cannot be verified."""
    reference = _reference(spec_named(dataset), seed)
    names = reference.needed(spec_named(dataset))
    listed = spec_named(dataset).listed
    require(dataset, (*names, *listed))
    spec = spec_of(dataset)
    if odd := [name for name in (*names, *listed) if dataset[name].dims != spec.axes]:
        _refuse(
            dataset,
            f"{', '.join(odd)} must have the dimensions {', '.join(spec.axes) or '()'}, as every variable of the cells",
        )
    for each in coordinate_declarations(spec):
        shape = tuple(len(getattr(spec, name)) for name in each.dims)
        if each.name not in dataset or dataset[each.name].shape != shape:
            _refuse(dataset, f"the coordinate {each.name} is missing, or its length differs from the spec")
    return spec, reference


def _refuse(dataset: "xr.Dataset", reason: str) -> NoReturn:
    raise RequestError(
        f"The atlas cannot be verified: {reason}.",
        hint="Recompute it with eulerdisk run.",
        where=place_of(dataset),
    )
