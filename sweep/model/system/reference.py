"""The reference for an atlas of a system: its rules in every cell, and SciPy's DOP853 in a sample.

DOP853 integrates the sampled cells (`sweep.model.system.sample`) to their stored end times. This gives the states there
and the greatest values until then, and shows whether an event happened earlier.
"""

from collections.abc import Iterator
from itertools import count
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.errors import counted
from sweep.model.audit import Audit, CellCheck
from sweep.model.cells import ROUNDING, AuditedCells
from sweep.model.description import Columns, Request, Starts
from sweep.model.quantity import (
    DECISION,
    FAILED,
    FINAL,
    MISSING,
    SENSITIVE,
    UNKNOWN_ERROR,
    Array,
    Endings,
    Quantity,
    Tolerance,
    table,
)
from sweep.model.system import tables
from sweep.model.system.cell_values import evaluated, labels_of, off_by, sizes
from sweep.model.system.definition import TIME, Definition, Measure
from sweep.model.system.passes import conserved_change, conserved_room
from sweep.model.system.sample import FOUND, INTEGRAL, OFF, TOP, Sample

NOT_COMPUTED, CONSISTENT, AGREES, UNRESOLVED, SENSITIVE_CELL, CONTRADICTORY, DIFFERS, OTHER_DIFFERS = range(8)

# fmt: off
AUDIT = Audit(
    variables=table(
        Quantity("audit", "", "1", "result of the audit of the cell", DECISION,
                 "consistent: ending, label, verdict and conserved quantities follow from the stored values; agrees: "
                 "also with DOP853; other_values_differ: another variable is wrong", "i1",
                 {
                     NOT_COMPUTED: "not_computed", CONSISTENT: "consistent", AGREES: "agrees",
                     UNRESOLVED: "unresolved_in_the_atlas", SENSITIVE_CELL: "sensitive", CONTRADICTORY: "contradictory",
                     DIFFERS: "differs", OTHER_DIFFERS: "other_values_differ"}),
        Quantity("place_difference", "", "1", "difference of the states at the end from DOP853, over their size",
                 Tolerance(1e-8, 0.0, "it is a difference, as large as the error that it measures"),
                 "the largest of all states; missing where the cell is not in the sample"),
    ),
    agreeing=(CONSISTENT, AGREES, SENSITIVE_CELL),
    disagreeing=(CONTRADICTORY, DIFFERS, OTHER_DIFFERS),
    missing=NOT_COMPUTED,
    other=OTHER_DIFFERS,
    difference="place_difference",
    units="of their size",
    told="states       at the end of the sample differ from DOP853 by",
    summary="Every cell of a system's atlas checked against the rules of the system, and a sample against DOP853.",
)
# fmt: on

#: Largest error of any value: this multiple of its stated error, plus this share of its size. Share of the values that
#: may have a larger error than the stated one.
_TIMES, _SHARE, _MOST = 100.0, 1e-9, 1e-3

_SCIPY = "SciPy's DOP853, of a sample"
_RULES = "the ending, which decides where it is missing"


class SampledReference:
    """See `sweep.model.description.Reference`; each audit needs its own.

    Parameters
    ----------
    definition : Definition
    endings : Endings
    size : int
        Number of cells of the atlas.
    seed : int, optional
        Seed of the sample; a new one if not given.
    """

    audit = AUDIT

    def __init__(self, definition: Definition, endings: Endings, size: int, seed: int | None = None) -> None:
        self._definition, self._endings = definition, endings
        self._seed = int(np.random.SeedSequence().generate_state(1)[0]) if seed is None else seed
        self._sample = Sample(definition, size, self._seed)

    @property
    def sampled(self) -> str:
        """A description of the sample that DOP853 has integrated."""
        cells = counted(self._sample.followed, "cell", self._sample.count)
        return f"{cells} drawn with seed {self._seed}, by SciPy's DOP853"

    def needed(self, spec: Request) -> tuple[str, ...]:
        """Return the variables of an atlas that `check` reads."""
        return tuple(spec.model.variables)

    def truth(self, spec: Request, starts: Starts, first: int, stored: Columns) -> Columns:
        """Return the results of DOP853 for the drawn cells that have ended, among the cells from `first` on."""
        time = stored[tables.END_TIME]
        # a motion that is over at its start needs no integration
        known = self._endings.have(FINAL, stored["ending"]) & (time > 0.0) & (time <= spec.duration)
        return self._sample.of(starts, first, stored, known)

    def check(
        self, spec: Request, starts: Starts, stored: Columns, truth: Columns
    ) -> tuple[dict[str, npt.NDArray[Any]], list[CellCheck]]:
        """Check cells against the rules of their system, and drawn cells against DOP853."""
        cells = AuditedCells(spec, starts, stored)
        checks = list(self._rules(cells))
        difference = np.full(cells.every.shape, np.nan)
        checks += self._by_dop853(cells, truth, difference)
        code = np.full(cells.every.shape, CONSISTENT, np.int8)
        code[np.isfinite(difference)] = AGREES
        code[self._endings.have(SENSITIVE, stored["ending"])] = SENSITIVE_CELL
        code[self._endings.have(FAILED, stored["ending"])] = UNRESOLVED
        for check in checks:
            if check.share:
                continue
            code[check.wrong] = DIFFERS if check.against.startswith(_SCIPY) else CONTRADICTORY
        code[self._endings.have(MISSING, stored["ending"])] = NOT_COMPUTED
        return {"audit": code, "place_difference": difference}, checks

    def _rules(self, cells: AuditedCells) -> Iterator[CellCheck]:
        spec, stored, ending = cells.spec, cells.stored, cells.stored["ending"]
        codes = list(self._endings.flags)
        yield cells.decided("ending", "the codes of endings", np.isin(ending, codes))
        yield cells.decided("stability", "the criterion, on the stored values", cells.verdict_follows)
        known = ~self._endings.have(FAILED, ending) & ~self._endings.have(MISSING, ending)
        times = [each.name for each in self._definition.measures if each.kind in ("time", "value")]
        may_miss = {name: tables.stated(name) for name in times}
        may_miss |= {error: name for name, error in may_miss.items()}
        counts = [each.name for each in self._definition.measures if each.kind == "count"]
        for name, quantity in spec.model.variables.items():
            if quantity.dtype.startswith("f"):
                # a failed motion has an end time too
                present = ~self._endings.have(MISSING, ending) if name == tables.END_TIME else known
                right = np.isfinite(stored[name]) == present
                if name in may_miss:
                    right |= known & ~np.isfinite(stored[may_miss[name]]) & ~np.isfinite(stored[name])
                if name in counts:
                    right &= ~known | ((stored[name] >= 0.0) & (stored[name] % 1.0 == 0.0))
                if name.endswith(tables.ERROR) or name == "conserved_change":
                    right &= ~(stored[name] < 0.0)
                yield cells.decided(name, _RULES, right)
        time, duration = stored[tables.END_TIME], np.full(ending.shape, float(spec.duration))
        with np.errstate(invalid="ignore"):
            ended = np.where(
                cells.ended(tables.RUNNING), np.abs(time - duration), np.maximum(time - duration, -time)
            )
        yield CellCheck(tables.END_TIME, "the duration", np.nan_to_num(ended), ROUNDING * duration, known)
        ends = self._at_end(cells)
        yield from self._at_events(cells, ends)
        if self._definition.conserved:
            yield cells.same(
                "conserved_change", "the stored start and end",
                np.asarray(conserved_change(self._definition, cells.starts, ends), np.float32).astype(np.float64),
                np.full(ending.shape, 1e-12) + 1e-6 * np.abs(np.nan_to_num(stored["conserved_change"])),
            )  # fmt: skip
            yield CellCheck(
                "conserved_change", "no change beyond the errors of the states at the end",
                np.nan_to_num(stored["conserved_change"].astype(np.float64)),
                conserved_room(self._definition, cells.starts, ends, self._errors(cells)), known,
            )  # fmt: skip
        if self._definition.labels:
            label = labels_of(self._definition.labels, ends, ending.shape)
            free = self._endings.have(FINAL, ending)
            yield cells.decided(
                "label",
                "the stored states at the end",
                np.where(free, (stored["label"] == label) | (stored["label"] == 0), stored["label"] == 0),
            )

    def _at_events(self, cells: AuditedCells, ends: Columns) -> Iterator[CellCheck]:
        """Yield the checks that motions ended by an event are where it happens, up to truncation errors."""
        share = _SHARE + 100.0 * float(cells.spec.tolerance)
        errors = self._errors(cells)
        for event in self._definition.ends:
            values = np.array(evaluated(event.any_positive, ends))
            # with a threshold of 0 the terms may vanish: then the errors of states and time allow a difference
            allowed = [
                share * size + off_by(node, ends, errors)
                for node, size in zip(event.any_positive, sizes(event.any_positive, ends), strict=True)
            ]
            first = np.argmax(values, axis=0)[np.newaxis]
            value, most = (
                np.take_along_axis(np.array(np.broadcast_arrays(*arrays)), first, axis=0)[0]
                for arrays in (values, allowed)
            )
            ended = cells.ended(event.name) & (cells.stored[tables.END_TIME] > 0.0)
            yield CellCheck("ending", f"where {event.name} happens", np.abs(value), most, ended)

    @staticmethod
    def _of_moment(
        cells: AuditedCells, measure: Measure, truth: Columns, ends: Columns
    ) -> Iterator[CellCheck]:
        """Yield the checks of a count, a time or a value of a moment, except where it is undecided."""
        counted, name = (f"{measure.name} {each}" for each in ("count", measure.kind))
        stored, found, off = cells.stored[measure.name], truth[FOUND + name], truth[OFF + name]
        error = cells.stored[tables.stated(measure.name)].astype(np.float64)
        apart = np.abs(stored - found)
        apart[np.isnan(stored) & np.isnan(found)] = 0.0
        apart[np.isnan(stored) != np.isnan(found)] = np.inf
        # a count that DOP853 leaves open, with both tolerances, may have any moment
        apart[np.isnan(truth[FOUND + counted] + truth[OFF + counted]) | (error >= UNKNOWN_ERROR)] = np.nan
        size = np.max([np.abs(np.nan_to_num(stored)), *sizes(measure.expressions, ends)], axis=0)
        apart = np.where(apart == np.inf, 1e200, apart)
        yield from _value_checks(
            measure.name, apart, np.nan_to_num(error), np.nan_to_num(off) + _SHARE * size
        )

    def _errors(self, cells: AuditedCells) -> dict[str, Array]:
        """Return the allowed errors of the stored states and time at the end, a multiple of their stated errors."""
        names = {state.name: state.name + tables.AT_END for state in self._definition.states} | {
            TIME: tables.END_TIME
        }
        return {
            name: _TIMES * cells.stored[tables.stated(stored)].astype(np.float64)
            for name, stored in names.items()
        }

    def _at_end(self, cells: AuditedCells) -> dict[str, Array]:
        """Return parameters, states and time at the end of the stored motions."""
        states = {state.name: cells.stored[state.name + tables.AT_END] for state in self._definition.states}
        return {**cells.starts, **states, TIME: cells.stored[tables.END_TIME]}

    def _by_dop853(self, cells: AuditedCells, truth: Columns, difference: Array) -> Iterator[CellCheck]:
        """Yield the checks against DOP853, and write the largest difference of a state over its size."""
        errors = self._errors(cells)
        ends, second = self._at_end(cells), {**cells.starts, TIME: cells.stored[tables.END_TIME]}
        # the largest relative error of the states is allowed for the terms of expressions of them too
        share = np.full(difference.shape, _SHARE)
        for state in self._definition.states:
            found, off, stored = truth[FOUND + state.name], truth[OFF + state.name], ends[state.name]
            size = np.maximum(np.abs(stored), np.abs(cells.starts[state.name]))
            error = cells.stored[tables.stated(state.name + tables.AT_END)].astype(np.float64)
            apart = np.abs(stored - found)
            with np.errstate(invalid="ignore", divide="ignore"):
                difference[:] = np.fmax(difference, np.where(size > 0.0, apart / size, apart))
                share = np.fmax(share, np.where(size > 0.0, (_TIMES * error + off) / size, 0.0))
            second[state.name] = found
            yield from _value_checks(state.name + tables.AT_END, apart, error, off + _SHARE * size)
        numbers = count()
        for measure in self._definition.measures:
            rows = [TOP.format(next(numbers)) for _ in range(measure.tops)]
            if measure.moment is not None:
                yield from self._of_moment(cells, measure, truth, ends)
                continue
            if measure.is_integral:
                name, time = INTEGRAL.format(measure.name), second[TIME] if measure.kind == "mean" else 1.0
                with np.errstate(invalid="ignore", divide="ignore"):
                    found, off = truth[FOUND + name] / time, truth[OFF + name] / time
            elif rows:
                found = np.stack([truth[FOUND + name] for name in rows]).max(axis=0)
                found = found if measure.kind == "max" else -found
                off = np.max([truth[OFF + name] for name in rows], axis=0)
            else:
                (found,), off = evaluated(measure.expressions, second), np.zeros(share.shape)
            stored = cells.stored[measure.name]
            error = cells.stored[tables.stated(measure.name)].astype(np.float64)
            size = np.max([np.abs(stored), *sizes(measure.expressions, ends)], axis=0)
            room = off + (_SHARE if rows else share) * size
            yield from _value_checks(measure.name, np.abs(stored - found), error, room)
        late = np.where(np.isfinite(apart), 0.0, np.nan)
        for event in self._definition.ends:
            for node, size in zip(event.any_positive, sizes(event.any_positive, ends), strict=True):
                name = TOP.format(next(numbers))
                room = truth[OFF + name] + share * size + off_by(node, ends, errors)
                late = np.fmax(late, truth[FOUND + name] - room)
        if self._definition.ends:
            judged = np.isfinite(late)
            words = f"{_SCIPY}: no event before the end"
            yield CellCheck("ending", words, np.nan_to_num(late), np.zeros(late.shape), judged)


def _value_checks(name: str, apart: Array, error: Array, room: Array) -> Iterator[CellCheck]:
    """Yield the checks of a value where DOP853 has a result; `room` allows for the error of DOP853."""
    for times, share, words in ((_TIMES, 0.0, _SCIPY), (1.0, _MOST, f"{_SCIPY}, by its stated error")):
        allowed = times * error + room
        judged = np.isfinite(apart) & np.isfinite(allowed)
        yield CellCheck(name, words, np.nan_to_num(apart), np.nan_to_num(allowed), judged, share=share)
