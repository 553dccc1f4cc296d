"""The check of every variable that an atlas of the disk holds of its cells."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.model.description import CellCheck, Columns, Request, Starts
from sweep.model.disk.initial_conditions import computed_rates
from sweep.model.disk.tables import ENDINGS, REDUCTION
from sweep.model.quantity import PROMISED, Array, Truths

_EXACT = "the exact reduction"
_PRESENT = "the ending, which says where it is missing"

#: Share of cells that may be further off than `tilt_error` promises.
_SHARE = 1e-3

#: Relative rounding of a computed rate: the square root of the processor, and what the equation makes of it.
_ROUNDING = 1e-12

#: What rounding alone may change in an extreme tilt [rad], and in a difference of energies.
_TILT_ROUNDING, _ENERGY_ROUNDING = 2e-14, 1e-12


#: Relative error of a fall time: of the quadrature (8e-7 was seen in 6800 random falls), and over the tolerance of the
#: integration (0.4 was seen).
_FALL_TIME, _FALL_TOLERANCE = 1e-5, 20.0

#: Of a value so large a share may not be allowed if it is to count as checked.
_WIDE = 0.1


@dataclass(frozen=True)
class Facts:
    """What an audit knows of its cells, arrays of shape (n,).

    `stored` and `exact` hold the values of the atlas and of the reduction; `low` and `high` are the differences of the
    extreme tilts [rad], which may be `allowed`; `period_allowed` [s] is that of the period; the truths say whether
    ending and verdict are the exact ones, whether the verdict follows from the stored extremes, and whether a cell has
    to have a period; `decidable` says whether the reduction can judge by the criterion; `derived` is what follows from
    the stored extremes, of which the amplification may be off by `rounding`.
    """

    stored: Columns
    exact: Columns
    low: Array
    high: Array
    allowed: Array
    period_allowed: Array
    ending_right: Truths
    verdict_right: Truths
    verdict_follows: Truths
    has_period: Truths
    decidable: bool
    derived: Columns
    rounding: Array

    @cached_property
    def failed(self) -> Truths:
        """Which cells of the atlas have no numbers."""
        return ended(self.stored, "not_computed", "unresolved", "invalid")

    @cached_property
    def resolved(self) -> Truths:
        """Which cells both the atlas and the reduction have resolved."""
        exact = self.exact
        vague = ended(exact, "unresolved", "invalid") | (
            ended(exact, "bounded") & np.isnan(exact["nutation_period"])
        )
        return np.asarray(~vague & ~self.failed)

    @cached_property
    def every(self) -> Truths:
        """All cells."""
        return np.ones(self.low.shape, bool)

    @cached_property
    def nothing(self) -> Array:
        """The difference 0 in all cells."""
        return np.zeros(self.low.shape)


def cell_checks(spec: Request, starts: Starts, facts: Facts) -> list[CellCheck]:
    """Return the checks of all variables; those that an older atlas does not hold are left out.

    Parameters
    ----------
    spec : Request
    starts : mapping of str to array, shape (n,)
    facts : Facts
    """
    checks = [
        *_decisions(facts),
        *_extremes(facts),
        *_following(spec, starts, facts),
        *_of_the_integration(spec, facts),
        *_of_the_reduction(spec, facts),
    ]
    return [each for each in checks if each.name in facts.stored]


def same(one: Array, other: Array, within: Array | float) -> Truths:
    """Return where two values differ by no more than `within`, or both are missing."""
    found: Truths = one == other
    if found.all():
        return found
    with np.errstate(invalid="ignore"):
        return np.asarray(found | (np.abs(one - other) <= within) | (np.isnan(one) & np.isnan(other)))


def _decided(
    facts: Facts,
    name: str,
    against: str,
    right: Truths,
    judged: Truths | None = None,
    promise: bool = False,
    unknown: Truths | None = None,
) -> CellCheck:
    """Return the check of a decision, which is right or wrong: the difference is 0 or 1."""
    difference = facts.nothing if right.all() else np.where(right, 0.0, 1.0)
    judged = facts.every if judged is None else judged
    return CellCheck(name, against, difference, facts.nothing, judged, promise, unknown=unknown)


def ended(columns: Columns, *names: str) -> Truths:
    """Return which cells have one of the endings."""
    # a tenth of the time of numpy.isin
    return _among(columns["ending"], tuple(map(ENDINGS.code, names)))


def _among(values: npt.NDArray[Any], codes: Sequence[int]) -> Truths:
    found: Truths = values == codes[0]
    for code in codes[1:]:
        found |= values == code
    return found


def _present(values: npt.NDArray[np.float64], wanted: Truths, difference: Array) -> Array:
    """Return a difference that is NaN where a value is missing or is not wanted, and 0 where none is wanted."""
    return np.where(np.isfinite(values) != wanted, np.nan, np.where(wanted, difference, 0.0))


def _narrow(allowed: Array, values: Array) -> Truths:
    """Return where a check says something of a value: beside a separatrix any time may be within the tolerance."""
    with np.errstate(invalid="ignore"):
        return np.asarray(allowed <= _WIDE * np.abs(values))


def _decisions(facts: Facts) -> Iterator[CellCheck]:
    stored, exact, resolved = facts.stored, facts.exact, facts.resolved
    possible = ended(stored, "invalid") == ended(exact, "invalid")
    known = _among(stored["ending"], tuple(ENDINGS.flags))
    right = known & (possible | ended(stored, "not_computed")) & (facts.ending_right | ~resolved)
    yield _decided(facts, "ending", _EXACT, right)
    yield _decided(
        facts,
        "stability",
        f"the criterion, on the stored {f'extremes and on those of {_EXACT}' if facts.decidable else 'values'}",
        facts.verdict_follows & (facts.verdict_right | ~resolved),
    )


def _extremes(facts: Facts) -> Iterator[CellCheck]:
    failed, judged = facts.failed, facts.resolved | facts.failed
    for name, difference in (("tilt_min", facts.low), ("tilt_max", facts.high)):
        if failed.any():
            empty = np.where(np.isnan(facts.stored[name]), 0.0, np.nan)
            difference = np.where(failed, empty, difference)
        yield CellCheck(name, _EXACT, difference, facts.allowed, judged)
    period, exact = facts.stored["nutation_period"], facts.exact["nutation_period"]
    both = facts.has_period & np.isfinite(exact)
    difference = np.where(both, np.abs(period - exact), 0.0)
    yield CellCheck(
        "nutation_period",
        _EXACT,
        _present(period, facts.has_period, difference),
        np.where(both, facts.period_allowed, 0.0),
        facts.every,
        unknown=facts.has_period & ~(both & _narrow(facts.period_allowed, exact)),
    )


def _following(spec: Request, starts: Starts, facts: Facts) -> Iterator[CellCheck]:
    """Yield the checks of what follows from the extremes and the start."""
    expected = [
        ("peak_tilt", "the stored extremes", facts.derived["peak_tilt"], facts.nothing),
        (
            "amplification",
            "the stored extremes and the start",
            facts.derived["amplification"],
            np.where(np.isfinite(facts.rounding), facts.rounding, 0.0),
        ),
    ]
    for name in [each for each in facts.derived if each not in ("peak_tilt", "amplification")]:
        values = np.asarray(facts.derived[name], np.float64)
        expected.append((name, "the stored measures", values, _ROUNDING * np.abs(np.nan_to_num(values))))
    for rate in computed_rates(spec):
        known = np.isfinite(starts[rate]) & ~ended(facts.stored, "not_computed")
        values = np.where(known, starts[rate], np.nan)
        expected.append(
            (rate, "the equation of steady motion", values, _ROUNDING * np.abs(np.nan_to_num(values)))
        )
    for name, against, values, allowed in expected:
        difference = _unless_same(facts, facts.stored[name], values)
        yield CellCheck(name, against, difference, allowed, facts.every)


def _unless_same(facts: Facts, stored: Array, values: Array) -> Array:
    """Return how far stored values are from others: 0 where they are the same, or both are missing."""
    right = same(stored, values, 0.0)
    if right.all():
        return facts.nothing
    with np.errstate(invalid="ignore"):
        return np.where(right, 0.0, np.abs(stored - values))


def _of_the_integration(spec: Request, facts: Facts) -> Iterator[CellCheck]:
    """Yield the checks of what only an integration in time knows."""
    stored, integrated = facts.stored, spec.method != "exact"
    for name, there in (("fall_time", ended(stored, "fell")), ("energy_drift", ~facts.failed)):
        if name in stored:
            values = stored[name]
            right = (np.isfinite(values) == (there & integrated)) & ~(values < 0.0)
            yield _decided(facts, name, _PRESENT, right, unknown=there & integrated)
    if "fall_time" in stored and integrated:
        yield _fall_time(spec, facts)
    for name in ("steps", "refinements"):
        if name in stored:
            may = integrated & ~ended(stored, "not_computed", "invalid")
            right = (stored[name] == 0) | ((stored[name] > 0) & may)
            yield _decided(facts, name, "its range", right, unknown=np.asarray(may))
    if "tilt_error" in stored and "steps" in stored:
        yield from _stated_error(facts)


def _fall_time(spec: Request, facts: Facts) -> CellCheck:
    """Return the check of the fall times: like a period, they are the longer the nearer the saddle is passed."""
    stored, exact = facts.stored["fall_time"], facts.exact["fall_time"]
    fell = ended(facts.stored, "fell")
    judged = fell & np.isfinite(exact)
    against = "a quadrature over the tilt"
    if not judged.any():
        return CellCheck("fall_time", against, facts.nothing, facts.nothing, judged, unknown=fell)
    with np.errstate(divide="ignore", invalid="ignore"):
        lingering = np.fmax(1.0 / np.abs(facts.exact["separatrix"]), 0.0)
        allowed = (_FALL_TIME + spec.tolerance * (_FALL_TOLERANCE + 2.0 * lingering)) * exact
        difference = np.where(judged, np.abs(stored - exact), 0.0)
    return CellCheck(
        "fall_time", against, difference, allowed, judged, unknown=fell & ~_narrow(allowed, exact)
    )


def _stated_error(facts: Facts) -> Iterator[CellCheck]:
    """Yield the checks of the stated error: where it is above 0, and how often the true error is above twice it."""
    stored, failed = facts.stored, facts.failed
    error = np.asarray(stored["tilt_error"], np.float64)
    integrated = ~failed & (stored["steps"] != 0)
    with np.errstate(invalid="ignore"):
        right = np.isfinite(error) & (error >= 0.0)
        if failed.any():
            right = np.where(failed, np.isnan(error), right)
        yield _decided(facts, "tilt_error", _PRESENT, right, unknown=~failed)
        yield _decided(
            facts,
            "tilt_error",
            "0, which no integration states",
            error > 0.0,
            integrated,
            promise=True,
            unknown=~failed,
        )
        true = np.maximum(facts.low, facts.high)
        judged = facts.resolved & integrated & ~ended(stored, "horizon")
        allowed = PROMISED * error + np.fmax(facts.exact["tilt_error"], 0.0) + _TILT_ROUNDING
    yield CellCheck(
        "tilt_error",
        "the true error, of which it states half at least",
        true,
        allowed,
        judged,
        True,
        _SHARE,
        unknown=~failed,
    )


def _of_the_reduction(spec: Request, facts: Facts) -> Iterator[CellCheck]:
    """Yield the checks of what an atlas of ``method=exact`` holds besides."""
    if spec.method != "exact":
        return
    stored, exact = facts.stored, facts.exact
    for name, quantity in REDUCTION.items():
        if name not in stored:
            continue
        if quantity.flags is not None:
            yield _decided(facts, name, f"{_EXACT}, again", stored[name] == exact[name])
        else:
            difference = _unless_same(facts, stored[name], exact[name])
            allowed = _ENERGY_ROUNDING * (1.0 + np.abs(np.nan_to_num(exact[name])))
            yield CellCheck(name, f"{_EXACT}, again", difference, allowed, facts.every)
