"""Hold all that an atlas states against what it follows from: its spec, and the reference of its model."""

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

#: Name of the stage.
CHECKING: Final = "checking"

#: Rounding of a value of a range, as a share of its larger end.
_ROUNDING = 1e-15

#: The attributes of an audit that hold its statements, and which cells were a sample.
_STATEMENTS, _SAMPLE = "audit_statements", "audit_sample"


def verify(
    dataset: "xr.Dataset | str | os.PathLike[str]", *, seed: int | None = None, progress: Progress = None
) -> "xr.Dataset":
    """Hold all that an atlas states against its spec and the reference of its model.

    Parameters
    ----------
    dataset : xarray.Dataset, str or Path
        An atlas, as `sweep.run` or `sweep.open_atlas` returns it, or a selection from one, or its file.
    seed : int, optional
        Which cells are computed a second time, of a model without an exact reference; fresh ones if not given.
    progress : bool or callable, optional
        As in `sweep.run`.

    Returns
    -------
    xarray.Dataset
        On the dimensions of the atlas: the variables of its model's audit (docs/atlas.md). A cell
        agrees if its extremes lie within the tolerance that the atlas records, its period within what that tolerance
        means for it, its ending and verdict are the exact ones, its derived numbers follow from its extremes, and its
        other variables are what its integration gives again. What was found of each variable and attribute, the
        boundary and its curves too, is in the attribute ``audit_statements``; `findings` reads it. A model without an
        exact reference has every cell checked by its own rules and a sample by a second computation, which the
        attribute ``audit_sample`` names.

    Raises
    ------
    RequestError
        If its model has no reference, or the atlas lacks a variable that is needed, or cannot be read, or `progress`
        is something else.
    """
    with atlas_of(dataset) as atlas:
        return _audited(_Audit(atlas, seed), progress)


def _audited(audit: "_Audit", progress: Progress) -> "xr.Dataset":
    """Return what `verify` returns."""
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
    """Return the counts and statistics of an audit, as from `sweep.verify`.

    Raises
    ------
    RequestError
        If it is none.
    """
    if _STATEMENTS not in attributes_of(audited) or "audit" not in audited:
        raise RequestError(
            "This is no audit of an atlas: it lacks the variable audit, or the attribute audit_statements.",
            hint="Give what sweep.verify returns, with its attributes.",
        )
    spec = spec_named(audited)
    summary = AuditSummary(_reference(spec).audit)
    columns = {str(name): each.values.reshape(-1) for name, each in audited.data_vars.items()}
    for span in blocks(audited["audit"].size):
        summary.add(span.start, {name: each[span.start : span.stop] for name, each in columns.items()})
    statements = from_text(str(audited.attrs[_STATEMENTS]))
    return summary.findings(spec, statements, str(audited.attrs.get(_SAMPLE, "")))


def findings_of(dataset: "xr.Dataset", seed: int | None = None, show: Show = no_op) -> Findings:
    """Return `findings` of the audit of an atlas, of which no more than some blocks are in memory at once.

    Parameters
    ----------
    dataset : xarray.Dataset
    seed : int, optional
        As in `verify`.
    show : callable, optional
        Called with how far the audit is.

    Raises
    ------
    RequestError
        As from `verify`.
    """
    audit = _Audit(dataset, seed)
    for span, found in audit.blocks(show):
        audit.summary.add(span.start, found)
    result = audit.result()
    return audit.summary.findings(audit.spec, from_text(result[_STATEMENTS]), result.get(_SAMPLE, ""))


class _Audit:
    """The audit of an atlas: first of its cells, block by block, then of all else.

    Raises
    ------
    RequestError
        Where `dataset` cannot be verified.
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
        # another program may have left some out
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
        """Yield all cells in C order with the variables of the audit, and show how far it is."""
        timetable = Timetable(
            [Stage(CHECKING, self.spec.size), Stage(SEARCHING, bisected_cells(self.spec))], show
        )
        timetable.begin(CHECKING)
        with prefetch(self._read()) as stored:
            for span, variables in self._cells.audited(stored):
                yield span, variables
                # kernels that are not kept on disk are compiled in the first block
                (timetable.report if span.start else timetable.measure_from)(span.stop)
        timetable.begin(SEARCHING)

    def _read(self) -> Generator[tuple[Span, dict[str, npt.NDArray[Any]]]]:
        try:
            yield from self._reader.blocks(self._held)
        except UnreadableError as problem:
            _refuse(self.dataset, f"{problem.name} cannot be read, {problem}")

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
        """Return what is found of each variable and attribute, once all cells were taken, and which were a sample."""
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
    """Yield what is found of the coordinates that are there, whose shapes are known to be right."""
    found = {
        name: Checks(name, spec.quantities[name].units) for name in (*spec.axes, *spec.fixed, *spec.listed)
    }
    for declared, expected in coordinates(spec):
        if (name := declared.name) in dataset.variables:
            against = "the axis of the spec" if declared.dims else "the value in the spec"
            _hold(found[name], against, 0, dataset[name], expected, spec.quantities[name])
    for span in blocks(spec.size) if spec.listed else ():
        starts = starts_of(spec, span)
        for name in spec.listed:
            stored, against = dataset[name][span.start : span.stop], f"{getattr(spec, name)} of the spec"
            _hold(found[name], against, span.start, stored, starts[name], spec.quantities[name])
    for name, checks in found.items():
        if checks.tallies:
            yield checks.statement(partial(_value_in_words, spec, tuple(map(str, dataset[name].dims))))


def _hold(
    checks: Checks, against: str, start: int, found: "xr.DataArray", expected: Array, quantity: Quantity
) -> None:
    """Hold some values of a coordinate against those of the spec, from a flat index on."""
    stored, right, rule = np.asarray(found, np.float64).reshape(-1), expected.reshape(-1), quantity.tolerance
    # a value near 0 inside a range is known to the rounding of its ends
    allowed = rule.absolute + rule.relative * np.abs(right) + _ROUNDING * np.abs(right).max()
    checks.tallies.setdefault(against, Tally()).add(start, difference(stored, right), allowed)


def _value_in_words(spec: SweepSpec, dims: tuple[str, ...], place: int) -> str:
    return row_in_words(spec, {name: np.intp(place) for name in dims}) if dims else "the one value"


def _reference(spec: SweepSpec, seed: int | None = None) -> Reference:
    found = spec.model.reference(spec.size, seed)
    if found is None:
        raise RequestError(
            f"The model {spec.model.name} has no exact reference to verify an atlas with.",
            hint="Compare with an atlas of a smaller tolerance instead: eulerdisk compare.",
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
            f"each variable must have the dimensions {', '.join(spec.axes) or '()'}; {', '.join(odd)} has others",
        )
    for each in coordinate_declarations(spec):
        shape = tuple(len(getattr(spec, name)) for name in each.dims)
        if each.name not in dataset or dataset[each.name].shape != shape:
            _refuse(dataset, f"the coordinate {each.name} does not have the values of its spec")
    return spec, reference


def _refuse(dataset: "xr.Dataset", reason: str) -> NoReturn:
    raise RequestError(
        f"The atlas cannot be verified: {reason}.",
        hint="Make it again with eulerdisk run.",
        where=place_of(dataset),
    )
