"""Results of a cell from its passes: ending, whether it is decided, and stated errors."""

from collections.abc import Iterator
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from kernels.system.endings import DIFFERENT, FAILURES, RUNS_ON
from sweep.model.description import Columns, Starts
from sweep.model.quantity import Array, Endings, Truths
from sweep.model.system import tables
from sweep.model.system.cell_values import evaluated, off_by, sizes
from sweep.model.system.definition import TIME, Definition, Label, Measure

#: The names of the kernel's passes (`kernels.system.lanes.LEGS`).
PASSES = ("first", "second", "third", "fourth")

#: A cell is decided if the last two passes end within this share of the duration, and of the largest value of each
#: state. Within 1e-2 of it one of 25,000 cells of the three magnets had a wrong label, within 1e-3 none of 13,000
#: others (`scripts/audit_systems.py labels`).
SAME_TIME, SAME_PLACE = 1e-4, 1e-3

#: Each pass has a hundredth of the tolerance of the one before and, in the median, a 150th of its error. So the
#: difference of two neighbours is about the error of the earlier one: over these numbers, several times that of the
#: last pass. One difference is small by chance in one cell of some ten, so all three count, as a root of squares.
#:
#: With what follows, of 500,000 values of ten systems, at tolerances from 1e-8 to 1e-13, 0.085 % are further off than
#: is stated; in the median 21.5 times the true error is stated: `scripts/audit_systems.py errors`, on seeds that the
#: numbers were not chosen by. Other weights, or the ratio of the differences of a cell, did no better there.
_SHARES = (1.5e6, 5000.0, 26.0)

#: All differences of a value can be small by chance, so the largest of the states, over their sizes, count as well,
#: with this share.
_OF_STATES = 0.15

#: A motion of few steps ends somewhere in one, so that the differences of its passes follow no rule. The first share of
#: the tolerance is stated at least, and the second one, over the steps of all passes, more.
_LEAST, _FEW_STEPS = 0.022, 0.7

#: A time is off by less than the states beside it: this share of it stands for its size.
_OF_TIMES = 0.6

#: Rounding: of the largest value that a motion's steps add up to; and of each step, which grows as the error of a pass
#: does, whose steps are off by about a hundredth of its tolerance. It adds up as the root of the number of steps.
_ROUNDING, _GROWN = 16.0 * np.finfo(np.float64).eps, 0.7 * np.finfo(np.float64).eps

#: Change of what is conserved, over its largest term, that the rounding of a whole motion may make.
CONSERVED = 1e-9

#: All of these numbers, under the names by which a page knows them.
NUMBERS = {
    "runs_on": RUNS_ON, "different": DIFFERENT, "same_time": SAME_TIME, "same_place": SAME_PLACE, "shares": _SHARES,
    "of_states": _OF_STATES, "least": _LEAST, "few_steps": _FEW_STEPS, "of_times": _OF_TIMES,
    "rounding": _ROUNDING, "grown": _GROWN,
}  # fmt: skip


class Passes:
    """The passes of some cells, arrays of shape (n,).

    Parameters
    ----------
    definition : Definition
    endings : Endings
    starts : mapping of str to array
    measured : mapping of str to array
        What the kernel found, under the names of `SystemModel.measures` and `SystemModel.counts`.
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
            {each.name: measured[f"{name}: {each.name}"] for each in definition.states} for name in PASSES
        ]
        self._times = [measured[f"{name}: {tables.END_TIME}"] for name in PASSES]

    def columns(self) -> Columns:
        """Return all that is measured of the cells."""
        measured, found = self._measured, dict[str, npt.NDArray[Any]]()
        ending = self._ending()
        known = ~np.isin(ending, FAILURES)
        for name, passes, size, largest in self._values():
            # no -0, which reports would show
            # of one that could not be followed the end is until when it was
            value = self._followed_until() if name == tables.END_TIME else np.nan
            found[name] = np.where(known, passes[-1] + 0.0, value)
            error = self._error(passes, size) + _ROUNDING * largest
            found[tables.stated(name)] = np.where(known, error, np.nan)
        if self._definition.labels:
            found["label"] = self._label(ending, found)
        if self._definition.conserved:
            found["conserved_change"] = np.where(known, self._change(), np.nan)
        return {**found, "ending": ending, "steps": measured["steps"], "unproved": measured["unproved"]}

    def _ending(self) -> Array:
        """Return the code of each ending: that of the last pass, if the one before it says the same."""
        first, second = (self._measured[f"{name}: ending"] for name in PASSES[-2:])
        same: Truths = (first == second) & (
            np.abs(self._times[-2] - self._times[-1]) <= SAME_TIME * self._duration
        )
        for each in self._definition.states:
            one, other = (place[each.name] for place in self._places[-2:])
            with np.errstate(invalid="ignore"):
                same &= np.abs(one - other) <= SAME_PLACE * self._size(each.name)
        known = np.where(same, second, DIFFERENT)
        return np.where(np.isin(second, FAILURES), second, np.where(np.isin(first, FAILURES), first, known))

    def _followed_until(self) -> Array:
        """Return until when the pass went on that could not be followed, the last of two."""
        last = np.isin(self._measured[f"{PASSES[-1]}: ending"], FAILURES)
        # a step that failed at once may have led before the start
        return np.maximum(np.where(last, self._times[-1], self._times[-2]), 0.0)

    def _size(self, state: str) -> Array:
        return self._measured[f"{PASSES[-1]}: largest {state}"]

    def _error(self, passes: list[Array], size: Array) -> Array:
        """Return how far the last pass may be off, from what each says of a value, and the size of the value."""
        steps = np.maximum(self._measured["steps"], 1)
        rounding = _GROWN * np.sqrt(steps) / self._tolerance
        squares = ((_LEAST + _FEW_STEPS / steps) * self._tolerance * size) ** 2
        for number, (one, other, states) in enumerate(
            zip(passes, passes[1:], self._differences, strict=False)
        ):
            weight = 1.0 / _SHARES[number] + rounding * 100.0 ** (number + 1 - len(_SHARES))
            with np.errstate(invalid="ignore", over="ignore"):
                apart = np.hypot(weight * (other - one), weight * _OF_STATES * size * states)
            # an earlier pass may have found nothing
            squares = squares + np.where(np.isfinite(apart), apart, 0.0) ** 2
        return np.asarray(np.sqrt(squares))

    @cached_property
    def _differences(self) -> list[Array]:
        """The largest difference of a state of each pass from the next, over its size."""
        found = []
        for one, other in pairwise(self._places):
            with np.errstate(invalid="ignore", divide="ignore"):
                found.append(
                    np.fmax.reduce([np.abs(other[name] - one[name]) / self._size(name) for name in one])
                )
        return found

    def _values(self) -> Iterator[tuple[str, list[Array], Array, Array]]:
        """Yield each value with what the passes say of it, its size, and the largest that its steps add up to."""
        for each in self._definition.measures:
            found = self._of_measure(each)
            terms = np.max(np.broadcast_arrays(*sizes(each.expressions, self._at_end(-1)), found[-1]), axis=0)
            size = np.fmax(np.abs(found[-1]), terms)
            yield each.name, found, size, size
        whole = np.full(self._times[0].shape, self._duration)
        yield tables.END_TIME, self._times, _OF_TIMES * self._times[-1], whole
        for state in self._definition.states:
            found = [place[state.name] for place in self._places]
            yield f"{state.name}{tables.AT_END}", found, self._size(state.name), self._size(state.name)

    def _of_measure(self, measure: Measure) -> list[Array]:
        if measure.kind == "last":
            return [evaluated(measure.expressions, self._at_end(n))[0] for n in range(len(PASSES))]
        rows = range(len(measure.expressions))
        tops: list[Array] = [
            np.stack([self._measured[f"{name}: {measure.name} {row}"] for row in rows]).max(axis=0)
            for name in PASSES
        ]
        return tops if measure.kind == "max" else [-each for each in tops]

    def _at_end(self, number: int) -> dict[str, Array]:
        """Return parameters, states and time at the end of a pass."""
        return {**self._starts, **self._places[number], TIME: self._times[number]}

    def _label(self, ending: Array, found: Columns) -> npt.NDArray[np.int8]:
        """Return the first label that fits in any case; none where one before it may fit as well."""
        errors = {TIME: found[tables.stated(tables.END_TIME)]}
        errors |= {
            each.name: found[tables.stated(each.name + tables.AT_END)] for each in self._definition.states
        }
        decided = ~np.isin(ending, (DIFFERENT, *FAILURES))
        label, open_ = np.zeros(ending.shape, np.int8), decided.copy()
        for number, each in enumerate(self._definition.labels, 1):
            surely, possibly = self._fits(each, errors)
            label[open_ & surely] = number
            open_ &= ~possibly
        return label

    def _fits(self, label: Label, errors: Columns) -> tuple[Truths, Truths]:
        """Return where a label fits at the end in any case, and where it may within what its expressions are off by."""
        ends = self._at_end(-1)
        surely = possibly = np.ones(self._times[-1].shape, bool)
        for each in label.all_positive:
            value = evaluated([each], ends)[0]
            with np.errstate(invalid="ignore", over="ignore"):
                off = _ROUNDING * sizes([each], ends)[0] + off_by(each, ends, errors)
            with np.errstate(invalid="ignore"):
                surely, possibly = surely & (value > off), possibly & (value > -off)
        return surely, possibly

    def _change(self) -> Array:
        """Return the largest change of what is conserved, over its largest term."""
        return conserved_change(self._definition, self._starts, self._at_end(-1))


def conserved_change(definition: Definition, starts: Starts, ends: Columns) -> Array:
    """Return by how much each conserved expression changes from starts to ends, over its terms: the largest of them."""
    begun = {**starts, TIME: np.zeros(ends[TIME].shape)}
    before, terms = evaluated(definition.conserved, begun), sizes(definition.conserved, begun)
    after, later = evaluated(definition.conserved, ends), sizes(definition.conserved, ends)
    with np.errstate(invalid="ignore", divide="ignore"):
        changes = [
            np.where(new == old, 0.0, np.abs(new - old) / np.maximum(one, other))
            for old, new, one, other in zip(before, after, terms, later, strict=True)
        ]
    return np.asarray(np.max(np.broadcast_arrays(*changes, ends[TIME] * 0.0), axis=0))


def conserved_room(definition: Definition, starts: Starts, ends: Columns, errors: Columns) -> Array:
    """Return what `conserved_change` may be of what is conserved indeed, by the errors of states and time at the end.

    Parameters
    ----------
    definition : Definition
    starts, ends, errors : mapping of str to array
    """
    begun = {**starts, TIME: np.zeros(ends[TIME].shape)}
    room = np.zeros(ends[TIME].shape)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        for node, one, other in zip(
            definition.conserved,
            sizes(definition.conserved, begun),
            sizes(definition.conserved, ends),
            strict=True,
        ):
            terms = np.maximum(one, other)
            off = np.where(terms > 0.0, off_by(node, ends, errors) / terms, 0.0)
            room = np.fmax(room, CONSERVED + off)
    return room
