"""The audit of an atlas with losses: the consistency of every cell, and a second computation of a sample.

A motion with losses has no exact reduction. In every cell, ledger, ending and verdict must be consistent. A sample of
cells is integrated with half the step, and a few of these by another integrator.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.errors import counted
from sweep.model.audit import Audit, CellCheck
from sweep.model.cells import ROUNDING, AuditedCells
from sweep.model.description import Columns, Request, Starts
from sweep.model.lossy_disk import tables
from sweep.model.lossy_disk.air import AIR, needs_of
from sweep.model.lossy_disk.sample import AGAIN, COMPARED, OTHER, Sample, smooth_motion
from sweep.model.quantity import DECISION, OPEN, PROMISED, Array, Quantity, Tolerance, Truths, table

NOT_COMPUTED, CONSISTENT, AGREES, UNRESOLVED, INVALID, CONTRADICTORY, DIFFERS, OTHER_DIFFERS = range(8)

_AUDITED = Tolerance(1e-8, 0.0, "it is a difference, as large as the error that it measures")

# fmt: off
AUDIT = Audit(
    variables=table(
        Quantity("audit", "", "1", "result of the audit of the cell", DECISION,
                 "consistent: ending, ledger and verdict agree with each other; agrees: also with a second "
                 "computation; other_values_differ: another variable is wrong", "i1",
                 {
                     NOT_COMPUTED: "not_computed", CONSISTENT: "consistent", AGREES: "agrees",
                     UNRESOLVED: "unresolved_in_the_atlas", INVALID: "invalid", CONTRADICTORY: "contradictory",
                     DIFFERS: "differs", OTHER_DIFFERS: "other_values_differ"}),
        Quantity("time_difference", r"\Delta t", "s", "difference of end_time from a second computation",
                 _AUDITED, "missing where the cell is not in the sample"),
        Quantity("ledger_difference", r"\Delta E", "1", "energy at the start minus all losses and the potential energy "
                 "at the ending, over mass * gravity * radius", _AUDITED,
                 "0 or above; 0 where the disk is at rest"),
    ),
    agreeing=(CONSISTENT, AGREES),
    disagreeing=(CONTRADICTORY, DIFFERS, OTHER_DIFFERS),
    missing=NOT_COMPUTED,
    other=OTHER_DIFFERS,
    difference="time_difference",
    units="s",
    told="times        of the sample differ from a second computation by",
    summary="Every cell of a stability atlas checked against its own ending, ledger of energy and criterion, and a "
    "sample of cells against a second computation.",
)
# fmt: on

_LOSSES = tuple(measure for _, measure in tables.LOSSES.values())
_ENDING = "the ending, which decides where it is missing"

#: A stated error is only a magnitude: a second computation may differ by this multiple of it, plus this share of the
#: value, plus this number.
_TIMES, _SHARE, _LEAST = 10.0, 1e-8, 1e-10

#: Values whose error a cell states -> the variable with the error; and those of them without a rounding error of sums.
_STATED = {
    "end_time": "time_error", "tilt_min": "tilt_error", "tilt_max": "tilt_error", "end_tilt": "tilt_error",
    "heading_turned": "heading_error", "path_length": "path_error",
}  # fmt: skip
_EXACTLY = ("end_time", "tilt_min", "tilt_max")

#: Share of the cells in which a force barely reaches its limit, so that another step finds another moment.
_GRAZING = 0.01


@dataclass(frozen=True)
class Mechanics:
    """Functions of the rolling body that the audit needs.

    Attributes
    ----------
    energy : callable
        Energy over m g R of starts, shape (n,).
    height : callable
        Height of the centre of mass over R, for starts and other tilts [rad], shape (n,).
    smooth : callable
        `sweep.model.lossy_disk.sample.smooth_motion`, or the same for another body.
    """

    energy: Callable[[Request, Starts], Array]
    height: Callable[[Request, Starts, Array], Array]
    smooth: Callable[[Request, Mapping[str, float]], Mapping[str, float]]


def _energy_of_disk(spec: Request, starts: Starts) -> Array:
    unit = np.sqrt(starts["radius"] / starts["gravity"])
    sin, cos = np.sin(starts["tilt"]), np.cos(starts["tilt"])
    w, turn = starts["tilt_rate"] * unit, starts["precession_rate"] * unit
    s, o = starts["roll_rate"] * unit + turn * sin, turn * cos
    kinetic = (
        (1.0 + 0.5 * starts["alpha"]) * w**2 + (1.0 + starts["alpha"]) * s**2 + 0.5 * starts["alpha"] * o**2
    )
    return np.asarray(0.5 * kinetic + cos)


def _height_of_disk(spec: Request, starts: Starts, tilt: Array) -> Array:
    return np.asarray(np.cos(tilt))


THIN_DISK = Mechanics(_energy_of_disk, _height_of_disk, smooth_motion)


class SampledAudit:
    """See `sweep.model.description.Reference`; each audit needs its own.

    Parameters
    ----------
    size : int
        Number of cells of the atlas.
    seed : int, optional
        Seed of the sample.
    mechanics : Mechanics
    """

    audit = AUDIT

    def __init__(self, size: int, seed: int | None = None, mechanics: Mechanics = THIN_DISK) -> None:
        self._sample, self._mechanics = Sample(size, seed, mechanics.smooth), mechanics

    @property
    def sampled(self) -> str:
        """A description of the sample: its cells, and how they were computed again."""
        sample = self._sample
        cells = f"{counted(sample.count, 'cell')}, drawn with seed {sample.seed}"
        return f"{cells}, with half the step, {sample.others} of them also by DOP853"

    def needed(self, spec: Request) -> tuple[str, ...]:
        """Return the variables of an atlas that `check` reads."""
        own = (
            "ending",
            "stability",
            "tilt_min",
            "tilt_max",
            "peak_tilt",
            "amplification",
            "end_time",
            "end_tilt",
        )
        more = (*_LOSSES, "largest_loss", "energy_imbalance", *_STATED.values())
        return tuple(dict.fromkeys((*own, *more, *spec.criterion.reads(spec.model))))

    def truth(self, spec: Request, starts: Starts, first: int, stored: Columns) -> Columns:
        """Return the second computation of the drawn cells among the cells from `first` on."""
        return self._sample.of(spec, starts, first)

    def check(
        self, spec: Request, starts: Starts, stored: Columns, truth: Columns
    ) -> tuple[dict[str, npt.NDArray[Any]], list[CellCheck]]:
        """Check the consistency of cells, and compare them with their second computation."""
        cells = _SampledCells(spec, starts, stored, truth, self._mechanics)
        checks = [
            *_decisions(cells), *_of_the_ending(cells), *_ledger(cells), *cells.following(), *_second(cells),
        ]  # fmt: skip
        code = np.full(cells.every.shape, CONSISTENT, np.int8)
        code[cells.drawn] = AGREES
        code[cells.ended("unresolved")] = UNRESOLVED
        code[cells.ended("invalid")] = INVALID
        for check in checks:
            if not check.share:
                code[check.wrong] = DIFFERS if check.against.startswith(_AGAIN) else CONTRADICTORY
        code[cells.ended("not_computed")] = NOT_COMPUTED
        with np.errstate(invalid="ignore"):
            apart = np.abs(stored["end_time"] - truth[f"{AGAIN}end_time"])
        return {"audit": code, "time_difference": apart, "ledger_difference": cells.left}, checks


class _SampledCells(AuditedCells):
    """Cells of an atlas with losses, and the second computation of some of them, arrays of shape (n,)."""

    def __init__(
        self, spec: Request, starts: Starts, stored: Columns, truth: Columns, mechanics: Mechanics
    ) -> None:
        super().__init__(spec, starts, stored)
        self.truth, self.mechanics = truth, mechanics

    @cached_property
    def moved(self) -> Truths:
        """Which cells have numbers."""
        return self.ended("flat", "rest", "horizon", *_leaving(self.spec))

    @cached_property
    def drawn(self) -> Truths:
        """Which cells have numbers, and also in the second computation."""
        return np.asarray(self.moved & np.isfinite(self.truth[f"{AGAIN}end_time"]))

    @cached_property
    def left(self) -> Array:
        """Energy at the start minus all losses and the potential energy at the ending, over m g R."""
        spec, starts, stored = self.spec, self.starts, self.stored
        with np.errstate(invalid="ignore", over="ignore"):
            lost = np.sum([stored[name] for name in _LOSSES], axis=0)
            height = self.mechanics.height(spec, starts, stored["end_tilt"])
            return np.asarray(self.mechanics.energy(spec, starts) - lost - height)

    @cached_property
    def slack(self) -> Array:
        """Allowed error of the ledger: a multiple of its stated imbalance, plus rounding of the energy."""
        energy = np.abs(self.left) + np.sum([np.abs(self.stored[name]) for name in _LOSSES], axis=0) + 1.0
        return np.asarray(_TIMES * np.nan_to_num(self.stored["energy_imbalance"]) + ROUNDING * energy)


#: The first words of all descriptions of a second computation.
_AGAIN = "a second computation"


def _leaving(spec: Request) -> tuple[str, ...]:
    """Return the endings of motions that leave the model."""
    return tuple(ending.name for ending in spec.model.endings if ending.role == OPEN)


def _decisions(cells: _SampledCells) -> Iterator[CellCheck]:
    """Yield the checks of ending and verdict."""
    endings = cells.spec.model.endings
    known = endings.among(cells.stored["ending"], *endings.flags.values())
    yield cells.decided("ending", "the codes of endings", known)
    yield cells.decided("stability", "the criterion, on the stored values", cells.verdict_follows)


def _of_the_ending(cells: _SampledCells) -> Iterator[CellCheck]:
    """Yield the checks of missing values, times and tilts, which the ending determines."""
    stored, moved, spec = cells.stored, cells.moved, cells.spec
    for name in ("end_time", "end_tilt", "tilt_min", "tilt_max", *_LOSSES):
        yield cells.decided(name, _ENDING, np.isfinite(stored[name]) == moved)
    for name in sorted(set(_STATED.values())):
        error = np.asarray(stored[name], np.float64)
        yield cells.decided(name, "finite and 0 or more", (np.isfinite(error) & (error >= 0.0)) | ~moved)
    time, tilt, duration = stored["end_time"], stored["end_tilt"], np.full(moved.shape, float(spec.duration))
    with np.errstate(invalid="ignore"):
        apart = np.where(
            cells.ended("horizon"),
            np.abs(time - duration),
            np.maximum(time - duration, -np.minimum(time, 0.0)),
        )
        yield CellCheck("end_time", "the duration", np.where(moved, apart, 0.0), ROUNDING * duration, moved)
        flat = cells.ended("flat") & (np.abs(cells.starts["tilt"]) < spec.flat_tilt)
        off = np.abs(np.abs(tilt) - spec.flat_tilt)
        yield CellCheck("end_tilt", "flat_tilt", np.where(flat, off, 0.0), np.full(moved.shape, _LEAST), flat)
        slack = _TIMES * np.nan_to_num(np.asarray(stored["tilt_error"], np.float64)) + _LEAST
        for name, sign in (("tilt_min", 1.0), ("tilt_max", -1.0)):
            beyond = np.maximum(sign * (stored[name] - tilt), sign * (stored[name] - cells.starts["tilt"]))
            yield CellCheck(
                name,
                "the tilts at start and ending",
                np.where(moved, np.maximum(beyond, 0.0), 0.0),
                slack,
                moved,
            )


def _absent(cells: _SampledCells, strength: str) -> Truths:
    """Return whether a loss takes nothing in cells, because its strength is 0, or a parameter of the law of the air."""
    air = strength in AIR
    names = needs_of(cells.spec.air_law) if air else (strength,)
    none = np.full(cells.starts[strength].shape, air and not names)
    for name in names:
        none = none | (cells.starts[name] == 0.0)
    return np.asarray(none)


def _ledger(cells: _SampledCells) -> Iterator[CellCheck]:
    """Yield the checks of the energy and of the losses."""
    stored, moved, left = cells.stored, cells.moved, cells.left
    # at rest only the potential energy is left; a moving disk has more
    apart = np.where(cells.ended("rest"), np.abs(left), np.maximum(-left, 0.0))
    for name in _LOSSES:
        yield CellCheck(
            name, "the energy at start and ending", np.where(moved, apart, 0.0), cells.slack, moved
        )
    for law, name in tables.LOSSES.values():
        with np.errstate(invalid="ignore"):
            right = np.where(_absent(cells, law), stored[name] == 0.0, stored[name] >= 0.0)
        yield cells.decided(name, f"{law}, and no loss below 0", right | ~moved, moved)
    stated = np.asarray(stored["energy_imbalance"], np.float64)
    with np.errstate(invalid="ignore"):
        over = np.where(moved, np.maximum(stated - cells.spec.tolerance, 0.0), 0.0)
    yield CellCheck(
        "energy_imbalance", "the tolerance", over, np.full(moved.shape, 1e-7 * cells.spec.tolerance), moved
    )


def _second(cells: _SampledCells) -> Iterator[CellCheck]:
    """Yield the checks of the sample against its second computations.

    A motion leaves the model when a force reaches its limit. Sometimes it barely does, and another step finds this one
    swing later, so a few of these cells may differ by more than is allowed.
    """
    again, leaving = cells.truth[f"{AGAIN}ending"], _leaving(cells.spec)
    left = cells.ended(*leaving) | cells.spec.model.endings.among(again, *leaving)
    for prefix, words in ((AGAIN, f"{_AGAIN} with half the step"), (OTHER, f"{_AGAIN} by DOP853")):
        computed = cells.moved & np.isfinite(cells.truth[f"{prefix}end_time"])
        for judged, share, which in (
            (computed & ~left, 0.0, "of a sample"),
            (computed & left, _GRAZING, "where it leaves the model"),
        ):
            against = f"{words}, {which}"
            if prefix == AGAIN:
                apart = np.where(_endings_agree(cells) | ~judged, 0.0, 1.0)
                yield CellCheck("ending", against, apart, np.zeros(apart.shape), judged, share=share)
            same_end = judged & ((prefix == OTHER) | (again == cells.stored["ending"]))
            for name in (name for name in COMPARED[1:] if name in cells.stored):
                values = cells.truth[f"{prefix}{name}"]
                known = same_end & np.isfinite(values)
                if name == "breach_time":
                    # a tilt that barely reaches the limit may do so with one step and not with the other
                    known &= np.isfinite(cells.stored[name])
                with np.errstate(invalid="ignore"):
                    apart = np.where(known, np.abs(cells.stored[name] - values), 0.0)
                yield CellCheck(name, against, apart, _allowed(cells, name, values), known, share=share)


def _endings_agree(cells: _SampledCells) -> Truths:
    """Return where the endings are the same, or the motion ends at about the end of the duration."""
    again = cells.truth[f"{AGAIN}ending"]
    with np.errstate(invalid="ignore"):
        late = np.abs(cells.truth[f"{AGAIN}end_time"] - cells.spec.duration) <= _allowed(
            cells, "end_time", cells.stored["end_time"]
        )
    return np.asarray((again == cells.stored["ending"]) | late)


def _allowed(cells: _SampledCells, name: str, values: Array) -> Array:
    """Return the allowed difference of a value from its second computation, in its unit."""
    size = np.abs(np.nan_to_num(values))
    rule = tables.VARIABLES[name].tolerance
    own = _SHARE * size + _LEAST if name in _EXACTLY else rule.absolute + rule.relative * size
    return np.asarray(_TIMES * PROMISED * _error(cells, name, size) + own)


def _error(cells: _SampledCells, name: str, size: Array) -> Array:
    """Return the error of a value, as stated by the cell or from the stated errors of other values."""
    if name in _STATED:
        return _number(cells, _STATED[name])
    # an error of the tilt [rad] changes the energy over m g R by at most as much
    error = _number(cells, "tilt_error")
    if name == "breach_time":
        return np.asarray(error + _number(cells, "time_error"))
    if name in _LOSSES:
        # a longer motion loses more, in proportion to its time
        time = np.nan_to_num(cells.stored["end_time"])
        longer = np.divide(_number(cells, "time_error"), time, out=np.zeros(time.shape), where=time > 0.0)
        return np.asarray(error + size * np.minimum(longer, 1.0))
    return error


def _number(cells: _SampledCells, name: str) -> Array:
    """Return a stored variable, 0 where it is missing."""
    return np.nan_to_num(np.asarray(cells.stored[name], np.float64))
