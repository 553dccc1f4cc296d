"""Comparison of the cells of an atlas with the model's reference, and with a repeated integration."""

from collections import deque
from collections.abc import Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.checks.statement import Checks, Statement, cell_in_words
from sweep.checks.tally import difference
from sweep.engine.compute import measure, measured_quantities
from sweep.engine.grid import Span, starts_of
from sweep.model.audit import CellCheck
from sweep.model.description import Columns, Reference, Starts
from sweep.model.quantity import MISSING, Quantity, Truths
from sweep.request.spec import SweepSpec
from sweep.request.words import MOST_STEPS

#: Largest number of steps to repeat, about a second's work. Beyond it, only every k-th cell is integrated again.
_MOST_STEPS = 1e9

#: Variable with the step count of each cell.
STEPS = "steps"

#: Number of cells judged at a time: their arrays of doubles stay in the processor's cache.
_JUDGED_CELLS = 2**15

#: Share of the cells of a block whose times must be bit-identical if this processor rounds like the one that made the
#: atlas; and the number of corrupt cells that a small block may have.
_SAME, _FEW = 0.99, 3

_AGAIN = "its repeated computation"
_FOLLOWS = "its computation repeated from the stored extremes"

#: Blocks of cells in C order, with their stored variables.
StoredBlocks = Iterable[tuple[Span, Columns]]

#: A block of cells with their audit variables.
AuditedBlock = tuple[Span, dict[str, npt.NDArray[np.generic]]]


@dataclass(frozen=True)
class _Computed:
    """Results of the kernels for the cells of a block: starts, reference, and repeated integration.

    `again` holds the measures of every k-th cell, starting with cell `first` of the block; `follows` holds the results
    that another kernel computes from the stored extremes. Both may be empty.
    """

    starts: Starts
    exact: Columns
    first: int
    again: Columns
    follows: Columns


class CellAudit:
    """The audit of the cells of an atlas, block by block.

    Parameters
    ----------
    spec : SweepSpec
    reference : Reference
    held : iterable of str
        The variables in the atlas with one value per cell.
    own : bool
        Whether this code made the atlas, judging by its hash.
    stride : int
        Every `stride`-th cell is integrated again (`stride_of`).

    Attributes
    ----------
    repeated : bool
        Whether repeated integrations gave the same bits; another processor may round differently.
    """

    def __init__(
        self, spec: SweepSpec, reference: Reference, held: Iterable[str], own: bool, stride: int
    ) -> None:
        self.repeated = own
        self._spec, self._reference, self._held, self._own = spec, reference, set(held), own
        self._stride = stride if own else 0
        self._quantities = {
            **spec.model.cell_variables(spec),
            **{n: spec.model.parameters[n] for n in spec.computed},
        }
        self._checks = {name: Checks(name, each.units) for name, each in self._quantities.items()}
        self._named = set[str]()

    def audited(self, blocks: StoredBlocks) -> Iterator[AuditedBlock]:
        """Check all cells, and yield the variables of the audit, arrays of shape (len(span),).

        The kernels run in the caller's thread. Meanwhile another thread judges the previous block.
        """
        with ThreadPoolExecutor(max_workers=1) as pool:
            waiting: deque[Future[AuditedBlock]] = deque()
            for span, stored in blocks:
                computed = self._compute(span, stored)
                waiting.append(pool.submit(self._judge, span, stored, computed))
                if len(waiting) > 1:
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()

    def statements(self) -> Iterator[Statement]:
        """Yield the result for each variable, in the order of the file."""
        for name, checks in self._checks.items():
            if name in self._held & self._named:
                yield checks.statement(lambda place: cell_in_words(self._spec, place))

    def _compute(self, span: Span, stored: Columns) -> _Computed:
        """Return the results of the kernels for a block."""
        spec, starts = self._spec, starts_of(self._spec, span)
        exact = self._reference.truth(spec, starts, span.start, stored)
        nothing: Columns = {}
        first, again, follows = 0, nothing, nothing
        if self._stride:
            first = -span.start % self._stride
            which = slice(first, None, self._stride)
            again = measure(spec, {name: np.ascontiguousarray(each[which]) for name, each in starts.items()})
        # the kernel of the contact forces needs the stated error, which another program may have dropped
        if self._stride != 1 and spec.model.error_name in stored:
            follows = spec.model.measure_more(spec, starts, stored)
        return _Computed(starts, exact, first, again, follows)

    def _judge(self, span: Span, stored: Columns, computed: _Computed) -> AuditedBlock:
        """Compare the cells of a block with their computed values."""
        audit, wrong = self._reference.audit, np.zeros(len(span), bool)
        parts = []
        for start in range(0, len(span), _JUDGED_CELLS):
            part = slice(start, start + _JUDGED_CELLS)
            starts, kept, exact = (_cut(each, part) for each in (computed.starts, stored, computed.exact))
            variables, checks = self._reference.check(self._spec, starts, kept, exact)
            parts.append(variables)
            self._add(checks, span, part, wrong)
        self._add(
            self._again(stored, computed), span, slice(computed.first, None, self._stride or None), wrong
        )
        self._add(self._follows(stored, computed), span, slice(None), wrong)
        found = {name: np.concatenate([each[name] for each in parts]) for name in parts[0]}
        if wrong.any():
            wrong &= ~np.isin(found["audit"], (*audit.disagreeing, audit.missing))
            found["audit"] = np.where(wrong, audit.other, found["audit"])
        return span, found

    def _add(self, checks: Iterable[CellCheck], span: Span, part: slice, wrong: Truths) -> None:
        """Add checks of part of a block to the checks of their variables, and mark wrong cells."""
        for check in checks:
            self._named.add(check.name)
            # promises of this code do not apply to files made by other code
            if check.promise and not self._own:
                continue
            start = span.start + (part.start or 0)
            beyond = self._checks[check.name].add(start, check, part.step or 1)
            if beyond is not None and not check.share:
                wrong[part] |= beyond

    def _again(self, stored: Columns, computed: _Computed) -> Iterator[CellCheck]:
        """Yield the checks against a repeated integration of every k-th cell."""
        if not self._stride:
            return
        spec, measured = self._spec, computed.again
        kept = _cut(stored, slice(computed.first, None, self._stride))
        there = ~spec.model.endings.have(MISSING, kept["ending"])
        exactly = _same_rounding(spec, kept, measured, there)
        self.repeated &= exactly
        against = _AGAIN if exactly else f"{_AGAIN} on a processor that rounds differently"
        for name in measured_quantities(spec):
            if name in stored:
                yield _repeated(self._quantities[name], against, kept[name], measured[name], exactly, there)

    def _follows(self, stored: Columns, computed: _Computed) -> Iterator[CellCheck]:
        """Yield the checks of results that follow from the stored extremes."""
        for name, values in computed.follows.items():
            if name in stored:
                there = np.ones(stored[name].shape, bool)
                yield _repeated(self._quantities[name], _FOLLOWS, stored[name], values, False, there)


def stride_of(steps: Iterable[npt.NDArray[np.generic]]) -> int:
    """Return the stride k of the cells to integrate again, from the step counts of all cells in blocks."""
    total = 0.0
    for each in steps:
        # a corrupt file may hold any step counts
        counts = np.abs(np.nan_to_num(np.asarray(each, np.float64), posinf=0.0))
        total += float(np.minimum(counts, MOST_STEPS).sum())
    return max(1, int(np.ceil(total / _MOST_STEPS)))


def _cut(columns: Columns, part: slice) -> dict[str, npt.NDArray[Any]]:
    return {name: each[part] for name, each in columns.items()}


def _same_rounding(spec: SweepSpec, stored: Columns, measured: Columns, there: Truths) -> bool:
    """Return whether the times (without times, the extremes) are bit-identical in nearly all computed cells.

    Their last bits depend on whether the processor has a fused multiply-add.
    """
    names = [
        name
        for name in spec.model.measures
        if name in stored and name not in spec.model.extremes and stored[name].dtype == np.float64
    ]
    pairs = [(stored[name], measured[name]) for name in names]
    if not any(np.isfinite(pair[1]).any() for pair in pairs):
        pairs = [(stored[name], measured[name]) for name in spec.model.extremes]
    for ours, theirs in pairs:
        known = there & (np.isfinite(ours) | np.isfinite(theirs))
        other = int(np.count_nonzero(known & (ours != theirs)))
        count = int(np.count_nonzero(known))
        if count and (other <= _FEW < count or other <= (1.0 - _SAME) * count):
            return True
    return not any(np.isfinite(theirs).any() for _, theirs in pairs)


def _repeated(
    quantity: Quantity,
    against: str,
    stored: npt.NDArray[np.generic],
    again: npt.NDArray[np.generic],
    exactly: bool,
    judged: Truths,
) -> CellCheck:
    """Return the check of a variable against its repeated computation, bit for bit or within its tolerance."""
    bound, size = quantity.tolerance, np.abs(np.nan_to_num(np.asarray(again, np.float64)))
    allowed = np.zeros(size.shape) if exactly else bound.absolute + bound.relative * size
    return CellCheck(quantity.name, against, difference(stored, again), allowed, judged)
