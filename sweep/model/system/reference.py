"""What `verify` holds a system's atlas against: its own rules in every cell, and SciPy's DOP853 in a sample.

SciPy follows the sampled cells with NumPy's functions, which are the C library's, to the times at which the atlas says
that they ended. It does so with two tolerances, whose difference says how far it is off itself.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.errors import counted
from sweep.model.cells import ROUNDING, AuditedCells
from sweep.model.description import Audit, CellCheck, Columns, Request, Starts
from sweep.model.quantity import (
    DECISION,
    FAILED,
    FINAL,
    MISSING,
    SENSITIVE,
    Array,
    Endings,
    Quantity,
    Tolerance,
    table,
)
from sweep.model.system import tables
from sweep.model.system.cell_values import evaluated, labels_of
from sweep.model.system.definition import TIME, Definition
from sweep.model.system.passes import conserved_change

NOT_COMPUTED, CONSISTENT, AGREES, UNRESOLVED, SENSITIVE_CELL, CONTRADICTORY, DIFFERS, OTHER_DIFFERS = range(8)

# fmt: off
AUDIT = Audit(
    variables=table(
        Quantity("audit", "", "1", "what was found of the cell", DECISION,
                 "consistent: ending, label, verdict and conserved quantities follow from the stored values; agrees: "
                 "SciPy's DOP853 too; other_values_differ: another variable is wrong", "i1",
                 {
                     NOT_COMPUTED: "not_computed", CONSISTENT: "consistent", AGREES: "agrees",
                     UNRESOLVED: "unresolved_in_the_atlas", SENSITIVE_CELL: "sensitive", CONTRADICTORY: "contradictory",
                     DIFFERS: "differs", OTHER_DIFFERS: "other_values_differ"}),
        Quantity("place_difference", "", "1", "distance of the states at the end from those of SciPy, over their size",
                 Tolerance(1e-8, 0.0, "a difference is as large as the error that it measures"),
                 "the largest of all states; missing where the cell is not one of the sample"),
    ),
    agreeing=(CONSISTENT, AGREES, SENSITIVE_CELL),
    disagreeing=(CONTRADICTORY, DIFFERS, OTHER_DIFFERS),
    missing=NOT_COMPUTED,
    other=OTHER_DIFFERS,
    difference="place_difference",
    units="of their size",
    told="states       at the end of the sample differ from SciPy's by",
    summary="Every cell of a system's atlas held against its own rules, and a sample against SciPy's DOP853.",
)
# fmt: on

#: Cells of the sample; the largest and the smaller tolerance of SciPy.
_SAMPLE, _TOLERANCES = 24, (1e-10, 1e-12)

#: Evaluations of the rates by SciPy at most, about ten seconds: it would follow a stiff system without end.
_MOST_EVALUATIONS = 200_000

#: A stated error is a magnitude: SciPy may be this many times as far off, and this share of the size of a state.
_TIMES, _SHARE = 4.0, 1e-9

_SCIPY, _RULES = "SciPy's DOP853, of a sample", "the ending, which says where it is missing"


class SampledReference:
    """See `sweep.model.description.Reference`; one for each audit.

    Parameters
    ----------
    definition : Definition
    endings : Endings
    size : int
        Number of cells of the atlas.
    seed : int, optional
        Which cells are drawn; fresh ones if not given.
    """

    audit = AUDIT

    def __init__(self, definition: Definition, endings: Endings, size: int, seed: int | None = None) -> None:
        self._definition, self._endings = definition, endings
        self._seed = int(np.random.SeedSequence().generate_state(1)[0]) if seed is None else seed
        drawn = np.random.default_rng(self._seed).choice(size, min(size, _SAMPLE), replace=False)
        self._drawn = np.sort(drawn)

    @property
    def sampled(self) -> str:
        """Which cells SciPy has followed."""
        return f"{counted(self._drawn.size, 'cell')}, drawn with seed {self._seed}, by SciPy's DOP853"

    def needed(self, spec: Request) -> tuple[str, ...]:
        """Return the variables of an atlas that `check` reads."""
        return tuple(spec.model.variables)

    def truth(self, spec: Request, starts: Starts, first: int) -> Columns:
        """Return which cells from `first` on are drawn."""
        drawn = np.zeros(next(iter(starts.values())).shape, bool)
        places = self._drawn - first
        drawn[places[(places >= 0) & (places < drawn.size)]] = True
        return {"drawn": drawn}

    def check(
        self, spec: Request, starts: Starts, stored: Columns, truth: Columns
    ) -> tuple[dict[str, npt.NDArray[Any]], list[CellCheck]]:
        """Hold cells against the rules of their system, and those that are drawn against SciPy."""
        cells = AuditedCells(spec, starts, stored)
        decided = self._endings.have(FINAL, stored["ending"])
        drawn = truth["drawn"] & decided
        difference = np.full(cells.every.shape, np.nan)
        checks = [*self._rules(cells), *self._by_scipy(cells, drawn, difference)]
        code = np.full(cells.every.shape, CONSISTENT, np.int8)
        code[drawn] = AGREES
        code[self._endings.have(SENSITIVE, stored["ending"])] = SENSITIVE_CELL
        code[self._endings.have(FAILED, stored["ending"])] = UNRESOLVED
        for each in checks:
            code[each.wrong] = DIFFERS if each.against == _SCIPY else CONTRADICTORY
        code[self._endings.have(MISSING, stored["ending"])] = NOT_COMPUTED
        return {"audit": code, "place_difference": difference}, checks

    def _rules(self, cells: AuditedCells) -> Iterator[CellCheck]:
        spec, stored, ending = cells.spec, cells.stored, cells.stored["ending"]
        codes = list(self._endings.flags)
        yield cells.decided("ending", "the codes that there are", np.isin(ending, codes))
        yield cells.decided("stability", "the criterion, on the stored values", cells.verdict_follows)
        known = ~self._endings.have(FAILED, ending) & ~self._endings.have(MISSING, ending)
        for name, quantity in spec.model.variables.items():
            if quantity.dtype.startswith("f"):
                right = np.isfinite(stored[name]) == known
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
        if self._definition.conserved:
            yield cells.same(
                "conserved_change", "the stored start and end",
                np.asarray(conserved_change(self._definition, cells.starts, ends), np.float32).astype(np.float64),
                np.full(ending.shape, 1e-12) + 1e-6 * np.abs(np.nan_to_num(stored["conserved_change"])),
            )  # fmt: skip
        if self._definition.labels:
            label = labels_of(self._definition.labels, ends, ending.shape)
            free = self._endings.have(FINAL, ending)
            yield cells.decided(
                "label",
                "the stored states at the end",
                np.where(free, (stored["label"] == label) | (stored["label"] == 0), stored["label"] == 0),
            )

    def _at_end(self, cells: AuditedCells) -> dict[str, Array]:
        """Return parameters, states and time where the stored motions end."""
        states = {each.name: cells.stored[each.name + tables.AT_END] for each in self._definition.states}
        return {**cells.starts, **states, TIME: cells.stored[tables.END_TIME]}

    def _by_scipy(
        self, cells: AuditedCells, drawn: npt.NDArray[np.bool_], difference: Array
    ) -> Iterator[CellCheck]:
        """Yield the checks of the states at the end by SciPy, and write the largest difference over their size."""
        names = [each.name for each in self._definition.states]
        if not drawn.any():
            return
        starts = {name: np.asarray(each, np.float64)[drawn] for name, each in cells.starts.items()}
        times = cells.stored[tables.END_TIME][drawn]
        rough, fine = (followed(self._definition, starts, times, each) for each in _TOLERANCES)
        largest = np.zeros(times.shape)
        for row, name in enumerate(names):
            stored = cells.stored[name + tables.AT_END][drawn]
            error = cells.stored[tables.stated(name + tables.AT_END)][drawn].astype(np.float64)
            apart, size = np.abs(stored - fine[row]), np.maximum(np.abs(stored), np.abs(starts[name]))
            within = _TIMES * error + 2.0 * np.abs(fine[row] - rough[row]) + _SHARE * size
            with np.errstate(invalid="ignore", divide="ignore"):
                largest = np.fmax(largest, np.where(size > 0.0, apart / size, apart))
            judged, allowed = np.zeros(drawn.shape), np.zeros(drawn.shape)
            # where SciPy itself is far off it says nothing
            said = np.isfinite(fine[row]) & np.isfinite(rough[row])
            judged[drawn], allowed[drawn] = np.where(said, apart, 0.0), within
            yield CellCheck(name + tables.AT_END, _SCIPY, judged, np.nan_to_num(allowed), drawn)
        difference[drawn] = largest


def followed(definition: Definition, starts: Starts, times: Array, tolerance: float) -> Array:
    """Return the states of some cells at a time of each, by SciPy's DOP853, shape (states, n); NaN where it gives up.

    Parameters
    ----------
    definition : Definition
    starts : mapping of str to array, shape (n,)
        States and parameters.
    times : array, shape (n,)
    tolerance : float
        Relative, of all states together.
    """
    # this module is imported with the model, SciPy where an atlas is verified
    from scipy.integrate import solve_ivp

    names = [each.name for each in definition.states]
    first = np.array([starts[name] for name in names])
    shape = first.shape

    left = iter(range(_MOST_EVALUATIONS))

    def rate(share: float, flat: Array) -> Array:
        """Rates for a time that runs from 0 to 1 in every cell; not numbers once there were too many."""
        if next(left, None) is None:
            return np.full(flat.shape, np.nan)
        states = dict(zip(names, flat.reshape(shape), strict=True))
        found = evaluated(definition.rates, {**starts, **states, TIME: share * times})
        return np.ravel([np.broadcast_to(each, times.shape) * times for each in found])

    size = np.abs(first) + np.abs(rate(0.0, first.ravel())).reshape(shape)
    scale = np.broadcast_to(size.max(axis=1, keepdims=True), shape).ravel()
    with np.errstate(all="ignore"):
        found = solve_ivp(
            rate, (0.0, 1.0), first.ravel(), "DOP853", rtol=tolerance, atol=1e-4 * tolerance * scale + 1e-300,
        )  # fmt: skip
    return found.y[:, -1].reshape(shape) if found.success else np.full(shape, np.nan)
