"""Results of a cell from its passes: ending, values and stated errors."""

from collections.abc import Iterator
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from kernels.system.endings import DIFFERENT, FAILURES, RUNS_ON
from sweep.model.description import Columns, Starts
from sweep.model.quantity import UNKNOWN_ERROR, Array, Endings, Truths
from sweep.model.system import tables
from sweep.model.system.cell_values import evaluated, off_by, sizes
from sweep.model.system.definition import TIME, Definition, Label, Measure, Moment, Node, Symbol

#: The names of the kernel's passes (`kernels.system.lanes.LEGS`).
PASSES = ("first", "second", "third", "fourth")

#: A cell is decided if the last two passes agree within this share of the duration, and of the largest value of each
#: state. With 1e-2 for the states, one of 25,000 cells of the three magnets had a wrong label; with 1e-3, none of
#: 13,000 others (`scripts/audit_systems.py labels`).
SAME_TIME, SAME_PLACE = 1e-4, 1e-3

#: Each pass has a hundredth of the tolerance of the pass before and, in the median, a 150th of its error. So the
#: difference of successive passes is about the error of the earlier one; divided by these numbers, it is several times
#: the error of the last pass. In about one cell of ten a difference is small by chance, so all three count, as the
#: root of the sum of squares.
#:
#: With this and the numbers below, of 500,000 values of ten systems at tolerances from 1e-8 to 1e-13, 0.085 % exceed
#: their stated error; the median stated error is 21.5 times the true one. Measured by `scripts/audit_systems.py errors`
#: on other seeds than those used to choose the numbers. Other weights, or the ratio of the differences, did no better.
_SHARES = (1.5e6, 5000.0, 26.0)

#: Weight of the largest relative difference of the states: all differences of one value can be small by chance.
_OF_STATES = 0.15

#: A motion of few steps ends within one of them, so the differences of its passes follow no rule. The stated error is
#: at least the tolerance times the size times this sum: the first number, plus the second over the steps of all passes.
_LEAST, _FEW_STEPS = 0.022, 0.7

#: Size of a time in the stated errors, over its value: the error of a time is smaller than that of the states.
_OF_TIMES = 0.6

#: Rounding errors: of the largest value that the steps of a motion add up to; and of each step. The second grows like
#: the error of a pass, whose steps have an error of about a hundredth of its tolerance, and like the root of the number
#: of steps.
_ROUNDING, _GROWN = 16.0 * np.finfo(np.float64).eps, 0.7 * np.finfo(np.float64).eps

#: Change of a conserved quantity, over its largest term, from the rounding errors of a whole motion.
CONSERVED = 1e-9

#: These numbers under the names that the explorer's page uses.
NUMBERS = {
    "runs_on": RUNS_ON, "different": DIFFERENT, "same_time": SAME_TIME, "same_place": SAME_PLACE, "shares": _SHARES,
    "of_states": _OF_STATES, "least": _LEAST, "few_steps": _FEW_STEPS, "of_times": _OF_TIMES,
    "rounding": _ROUNDING, "grown": _GROWN, "unknown": UNKNOWN_ERROR,
}  # fmt: skip


class Passes:
    """The passes of some cells, arrays of shape (n,).

    Parameters
    ----------
    definition : Definition
    endings : Endings
    starts : mapping of str to array
    measured : mapping of str to array
        The output of the kernel, under the names of `SystemModel.measures` and `SystemModel.counts`.
    duration, tolerance : float
    """

    def __init__(
        self,
        definition: Definition,
        endings: Endings,
        starts: Starts,
        measured: Columns,
        duration: float,
        tolerance: float,
    ) -> None:
        self._definition, self._starts, self._measured = definition, starts, measured
        self._duration, self._tolerance = duration, tolerance
        self._places = [
            {state.name: measured[f"{name}: {state.name}"] for state in definition.states} for name in PASSES
        ]
        self._times = [measured[f"{name}: {tables.END_TIME}"] for name in PASSES]

    def columns(self) -> Columns:
        """Return all measured variables of the cells."""
        measured, columns = self._measured, dict[str, npt.NDArray[Any]]()
        ending = self._ending()
        known = ~np.isin(ending, FAILURES)
        for name, passes, size, largest in self._values():
            # the end time of a cell that could not be computed is the time that it reached
            value = self._time_reached() if name == tables.END_TIME else np.nan
            # adding 0 turns -0, which reports would show, into 0
            columns[name] = np.where(known, passes[-1] + 0.0, value)
            error = self._error(passes, size) + _ROUNDING * largest
            columns[tables.stated(name)] = np.where(known, error, np.nan)
        for measure in self._definition.measures:
            if measure.moment is not None:
                self._decide(measure, measure.moment, ending, columns)
        if self._definition.labels:
            columns["label"] = self._label(ending, columns)
        if self._definition.conserved:
            columns["conserved_change"] = np.where(known, self._change(), np.nan)
        return {**columns, "ending": ending, "steps": measured["steps"], "unproved": measured["unproved"]}

    def _ending(self) -> Array:
        """Return the code of each ending: that of the last pass, if the pass before has the same result."""
        first, second = (self._measured[f"{name}: ending"] for name in PASSES[-2:])
        same: Truths = (first == second) & (
            np.abs(self._times[-2] - self._times[-1]) <= SAME_TIME * self._duration
        )
        for state in self._definition.states:
            one, other = (place[state.name] for place in self._places[-2:])
            with np.errstate(invalid="ignore"):
                same &= np.abs(one - other) <= SAME_PLACE * self._size(state.name)
        known = np.where(same, second, DIFFERENT)
        return np.where(np.isin(second, FAILURES), second, np.where(np.isin(first, FAILURES), first, known))

    def _time_reached(self) -> Array:
        """Return the time at which the last pass failed, or the pass before if the last one did not."""
        last = np.isin(self._measured[f"{PASSES[-1]}: ending"], FAILURES)
        # a first step that failed may have gone to a time before the start
        return np.maximum(np.where(last, self._times[-1], self._times[-2]), 0.0)

    def _size(self, state: str) -> Array:
        return self._measured[f"{PASSES[-1]}: largest {state}"]

    def _error(self, passes: list[Array], size: Array) -> Array:
        """Return the stated error of the last pass, from the values of all passes and the size of the value."""
        steps = np.maximum(self._measured["steps"], 1)
        rounding = _GROWN * np.sqrt(steps) / self._tolerance
        squares = ((_LEAST + _FEW_STEPS / steps) * self._tolerance * size) ** 2
        for number, (one, other, states) in enumerate(
            zip(passes, passes[1:], self._differences, strict=False)
        ):
            weight = 1.0 / _SHARES[number] + rounding * 100.0 ** (number + 1 - len(_SHARES))
            with np.errstate(invalid="ignore", over="ignore"):
                apart = np.hypot(weight * (other - one), weight * _OF_STATES * size * states)
            # an earlier pass may have no value
            squares = squares + np.where(np.isfinite(apart), apart, 0.0) ** 2
        return np.asarray(np.sqrt(squares))

    @cached_property
    def _differences(self) -> list[Array]:
        """The largest difference of a state between each pass and the next, over its size."""
        differences = []
        for one, other in pairwise(self._places):
            with np.errstate(invalid="ignore", divide="ignore"):
                differences.append(
                    np.fmax.reduce([np.abs(other[name] - one[name]) / self._size(name) for name in one])
                )
        return differences

    def _values(self) -> Iterator[tuple[str, list[Array], Array, Array]]:
        """Yield the name of each value, its passes, its size, and the largest value that its steps add up to."""
        for measure in self._definition.measures:
            passes = self._of_measure(measure)
            if measure.is_integral or measure.kind == "value":
                terms = self._terms(measure.expressions)
                terms = terms * self._times[-1] if measure.kind == "integral" else terms
            else:
                terms = np.max(
                    np.broadcast_arrays(*sizes(measure.expressions, self._at_end(-1)), passes[-1]), axis=0
                )
            size = np.fmax(np.abs(passes[-1]), terms)
            rounding = np.full(size.shape, self._duration) if measure.kind == "time" else size
            yield measure.name, passes, size, rounding
        whole = np.full(self._times[0].shape, self._duration)
        yield tables.END_TIME, self._times, _OF_TIMES * self._times[-1], whole
        for state in self._definition.states:
            passes = [place[state.name] for place in self._places]
            yield f"{state.name}{tables.AT_END}", passes, self._size(state.name), self._size(state.name)

    def _of_measure(self, measure: Measure) -> list[Array]:
        if measure.kind == "last":
            return [evaluated(measure.expressions, self._at_end(n))[0] for n in range(len(PASSES))]
        if measure.moment is not None:
            return [self._measured[f"{name}: {measure.name} {measure.kind}"] for name in PASSES]
        if measure.is_integral:
            return [self._integral_or_mean(measure, number) for number in range(len(PASSES))]
        rows = range(len(measure.expressions))
        tops: list[Array] = [
            np.stack([self._measured[f"{name}: {measure.name} {row}"] for row in rows]).max(axis=0)
            for name in PASSES
        ]
        return tops if measure.kind == "max" else [-top for top in tops]

    def _integral_or_mean(self, measure: Measure, number: int) -> Array:
        """Return an integral at the end of a pass, or that over the time; for no time, the value at the start."""
        integral, time = self._measured[f"{PASSES[number]}: {measure.name} integral"], self._times[number]
        if measure.kind == "integral":
            return integral
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(
                time > 0.0, integral / time, evaluated(measure.expressions, self._at_end(number))[0]
            )

    def _terms(self, nodes: tuple[Node, ...]) -> Array:
        """Return the largest magnitude of the terms of expressions, for the largest values of all states."""
        largest = {state.name: self._size(state.name) for state in self._definition.states}
        terms = sizes(nodes, {**self._at_end(-1), **largest})
        return np.asarray(np.max(np.broadcast_arrays(*terms, self._times[-1] * 0.0), axis=0))

    def _decide(
        self, measure: Measure, moment: Moment, ending: Array, columns: dict[str, npt.NDArray[Any]]
    ) -> None:
        """Write the stated error of a count, and mark the cells where errors can change a count or move a moment.

        A moment is decided if the last two passes agree, and if no condition came so near its limit at a turning
        point, and no second maximum so near the greatest one, that errors can exchange them.
        """
        before, last = (
            {each: self._measured[f"{name}: {measure.name} {each}"] for each in tables.OF_MOMENT}
            for name in PASSES[-2:]
        )
        share = np.max([self._share_of_error(state.name) for state in self._definition.states], axis=0)
        with np.errstate(invalid="ignore"):
            distance = last["level"] - (0.0 if moment.is_of_condition else last["count"])
            near = distance <= (share + _ROUNDING) * self._terms(moment.expressions)
            apart = ~(np.abs(before["time"] - last["time"]) <= SAME_TIME * self._duration)
        apart &= ~(np.isnan(before["time"]) & np.isnan(last["time"]))
        if moment.kind == "last":
            doubtful = (before["count"] != last["count"]) | near | (ending == DIFFERENT)
        else:
            # what happens early may be known, even if the end is not
            doubtful = near & (ending != DIFFERENT)
        doubtful = ~np.isin(ending, FAILURES) & (doubtful | (apart & (measure.kind != "count")))
        error = columns[tables.stated(measure.name)]
        if measure.kind == "count":
            error = error * 0.0
        else:
            value = columns[measure.name]
            instead = evaluated(measure.expressions or (Symbol(TIME),), self._at_end(-1))[0]
            columns[measure.name] = np.where(doubtful & np.isnan(value), instead, value)
            error = np.where(np.isnan(value), np.nan, error)
        columns[tables.stated(measure.name)] = np.where(doubtful, UNKNOWN_ERROR, error)

    def _share_of_error(self, state: str) -> Array:
        """Return the stated error of a state at the end, over its size."""
        size = self._size(state)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(size > 0.0, self._error([each[state] for each in self._places], size) / size, 0.0)

    def _at_end(self, number: int) -> dict[str, Array]:
        """Return parameters, states and time at the end of a pass."""
        return {**self._starts, **self._places[number], TIME: self._times[number]}

    def _label(self, ending: Array, columns: Columns) -> npt.NDArray[np.int8]:
        """Return the first label that certainly fits; none where an earlier label may fit."""
        errors = {TIME: columns[tables.stated(tables.END_TIME)]}
        errors |= {
            state.name: columns[tables.stated(state.name + tables.AT_END)]
            for state in self._definition.states
        }
        decided = ~np.isin(ending, (DIFFERENT, *FAILURES))
        numbers, open_ = np.zeros(ending.shape, np.int8), decided.copy()
        for number, label in enumerate(self._definition.labels, 1):
            surely, possibly = self._fits(label, errors)
            numbers[open_ & surely] = number
            open_ &= ~possibly
        return numbers

    def _fits(self, label: Label, errors: Columns) -> tuple[Truths, Truths]:
        """Return where a label certainly fits at the end, and where it may fit within the errors of its expressions."""
        ends = self._at_end(-1)
        surely = possibly = np.ones(self._times[-1].shape, bool)
        for node in label.all_positive:
            value = evaluated([node], ends)[0]
            with np.errstate(invalid="ignore", over="ignore"):
                error = _ROUNDING * sizes([node], ends)[0] + off_by(node, ends, errors)
            with np.errstate(invalid="ignore"):
                surely, possibly = surely & (value > error), possibly & (value > -error)
        return surely, possibly

    def _change(self) -> Array:
        """Return the largest change of a conserved expression, over its largest term."""
        return conserved_change(self._definition, self._starts, self._at_end(-1))


def conserved_change(definition: Definition, starts: Starts, ends: Columns) -> Array:
    """Return the largest change of a conserved expression from starts to ends, over the magnitude of its terms."""
    at_start = {**starts, TIME: np.zeros(ends[TIME].shape)}
    before, terms = evaluated(definition.conserved, at_start), sizes(definition.conserved, at_start)
    after, later = evaluated(definition.conserved, ends), sizes(definition.conserved, ends)
    with np.errstate(invalid="ignore", divide="ignore"):
        changes = [
            np.where(new == old, 0.0, np.abs(new - old) / np.maximum(one, other))
            for old, new, one, other in zip(before, after, terms, later, strict=True)
        ]
    return np.asarray(np.max(np.broadcast_arrays(*changes, ends[TIME] * 0.0), axis=0))


def conserved_room(definition: Definition, starts: Starts, ends: Columns, errors: Columns) -> Array:
    """Return the `conserved_change` allowed by the errors of states and time at the end.

    Parameters
    ----------
    definition : Definition
    starts, ends, errors : mapping of str to array
    """
    at_start = {**starts, TIME: np.zeros(ends[TIME].shape)}
    room = np.zeros(ends[TIME].shape)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        for node, one, other in zip(
            definition.conserved,
            sizes(definition.conserved, at_start),
            sizes(definition.conserved, ends),
            strict=True,
        ):
            terms = np.maximum(one, other)
            error = np.where(terms > 0.0, off_by(node, ends, errors) / terms, 0.0)
            room = np.fmax(room, CONSERVED + error)
    return room
