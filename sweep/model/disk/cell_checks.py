"""The check of every variable that an atlas of the disk holds of its cells."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sweep.model.description import CellCheck, Columns, Request, Starts
from sweep.model.disk.initial_conditions import computed_rate
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


@dataclass(frozen=True)
class Facts:
    """What an audit knows of its cells, arrays of shape (n,).

    `stored` and `exact` hold the values of the atlas and of the reduction; `low` and `high` are the differences of the
    extreme tilts [rad], which may be `allowed`; `period_allowed` [s] is that of the period; the truths say whether
    ending and verdict are the exact ones, whether the verdict follows from the stored extremes, and whether a cell
    has to have a period; `derived` is what
    follows from the stored extremes, of which the amplification may be off by `rounding`.
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
    derived: Columns
    rounding: Array


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
    with np.errstate(invalid="ignore"):
        found: Truths = (np.abs(one - other) <= within) | (one == other) | (np.isnan(one) & np.isnan(other))
    return found


def _decided(
    name: str, against: str, right: Truths, judged: Truths | None = None, promise: bool = False
) -> CellCheck:
    """Return the check of a decision, which is right or wrong: the difference is 0 or 1."""
    none = np.zeros(right.shape)
    every = np.ones(right.shape, bool) if judged is None else judged
    return CellCheck(name, against, np.where(right, 0.0, 1.0), none, every, promise)


def _ended(columns: Columns, *names: str) -> Truths:
    return np.asarray(np.isin(columns["ending"], [ENDINGS.code(name) for name in names]))


def _failed(stored: Columns) -> Truths:
    """Return which cells have no numbers."""
    return _ended(stored, "not_computed", "unresolved", "invalid")


def _resolved(facts: Facts) -> Truths:
    """Return which cells both the atlas and the reduction have resolved."""
    exact = facts.exact
    vague = _ended(exact, "unresolved", "invalid") | (
        _ended(exact, "bounded") & np.isnan(exact["nutation_period"])
    )
    return np.asarray(~vague & ~_failed(facts.stored))


def _present(values: npt.NDArray[np.float64], wanted: Truths, difference: Array) -> Array:
    """Return a difference that is NaN where a value is missing or is not wanted, and 0 where none is wanted."""
    return np.where(np.isfinite(values) != wanted, np.nan, np.where(wanted, difference, 0.0))


def _decisions(facts: Facts) -> Iterator[CellCheck]:
    stored, exact, resolved = facts.stored, facts.exact, _resolved(facts)
    possible = _ended(stored, "invalid") == _ended(exact, "invalid")
    known = np.isin(stored["ending"], list(ENDINGS.flags))
    with np.errstate(invalid="ignore"):
        right = known & (possible | _ended(stored, "not_computed")) & (facts.ending_right | ~resolved)
    yield _decided("ending", _EXACT, right)
    yield _decided(
        "stability",
        f"the criterion, on the stored extremes and on those of {_EXACT}",
        facts.verdict_follows & (facts.verdict_right | ~resolved),
    )


def _extremes(facts: Facts) -> Iterator[CellCheck]:
    resolved, failed = _resolved(facts), _failed(facts.stored)
    for name, difference in (("tilt_min", facts.low), ("tilt_max", facts.high)):
        values = facts.stored[name]
        empty = np.where(np.isnan(values), 0.0, np.nan)
        yield CellCheck(name, _EXACT, np.where(failed, empty, difference), facts.allowed, resolved | failed)
    period, exact = facts.stored["nutation_period"], facts.exact["nutation_period"]
    both = facts.has_period & np.isfinite(exact)
    difference = np.where(both, np.abs(period - exact), 0.0)
    yield CellCheck(
        "nutation_period",
        _EXACT,
        _present(period, facts.has_period, difference),
        np.where(both, facts.period_allowed, 0.0),
        np.ones(period.shape, bool),
    )


def _following(spec: Request, starts: Starts, facts: Facts) -> Iterator[CellCheck]:
    """Yield the checks of what follows from the extremes and the start."""
    every = np.ones(facts.low.shape, bool)
    expected = [
        ("peak_tilt", "the stored extremes", facts.derived["peak_tilt"], np.zeros(every.shape)),
        (
            "amplification",
            "the stored extremes and the start",
            facts.derived["amplification"],
            np.nan_to_num(facts.rounding, posinf=0.0),
        ),
    ]
    if (rate := computed_rate(spec)) is not None:
        known = np.isfinite(starts[rate]) & ~_ended(facts.stored, "not_computed")
        values = np.where(known, starts[rate], np.nan)
        expected.append(
            (rate, "the equation of steady motion", values, _ROUNDING * np.abs(np.nan_to_num(values)))
        )
    for name, against, values, allowed in expected:
        right = same(facts.stored[name], values, 0.0)
        with np.errstate(invalid="ignore"):
            yield CellCheck(
                name, against, np.where(right, 0.0, np.abs(facts.stored[name] - values)), allowed, every
            )


def _of_the_integration(spec: Request, facts: Facts) -> Iterator[CellCheck]:
    """Yield the checks of what only an integration in time knows."""
    stored, failed = facts.stored, _failed(facts.stored)
    integrated = np.full(failed.shape, spec.method != "exact")
    for name, there in (("fall_time", _ended(stored, "fell")), ("energy_drift", ~failed)):
        if name in stored:
            values = np.asarray(stored[name], np.float64)
            right = (np.isfinite(values) == (there & integrated)) & ~(values < 0.0)
            yield _decided(name, _PRESENT, right)
    if "fall_time" in stored and spec.method != "exact":
        yield _fall_time(spec, facts)
    for name in ("steps", "refinements"):
        if name in stored:
            may = integrated & ~_ended(stored, "not_computed", "invalid")
            yield _decided(name, "its range", (stored[name] == 0) | ((stored[name] > 0) & may))
    if "tilt_error" in stored and "steps" in stored:
        yield from _stated_error(facts)


def _fall_time(spec: Request, facts: Facts) -> CellCheck:
    """Return the check of the fall times: like a period, they are the longer the nearer the saddle is passed."""
    stored, exact = facts.stored["fall_time"], facts.exact["fall_time"]
    judged = _ended(facts.stored, "fell") & np.isfinite(exact)
    with np.errstate(divide="ignore", invalid="ignore"):
        lingering = np.nan_to_num(1.0 / np.abs(facts.exact["separatrix"]), nan=0.0, posinf=np.inf)
        allowed = (_FALL_TIME + spec.tolerance * (_FALL_TOLERANCE + 2.0 * lingering)) * exact
        difference = np.where(judged, np.abs(stored - exact), 0.0)
    return CellCheck("fall_time", "a quadrature over the tilt", difference, allowed, judged)


def _stated_error(facts: Facts) -> Iterator[CellCheck]:
    """Yield the checks of the stated error: where it is above 0, and how often the true error is above twice it."""
    stored, failed = facts.stored, _failed(facts.stored)
    error = np.asarray(stored["tilt_error"], np.float64)
    integrated = ~failed & (stored["steps"] != 0)
    with np.errstate(invalid="ignore"):
        right = np.where(failed, np.isnan(error), np.isfinite(error) & (error >= 0.0))
        yield _decided("tilt_error", _PRESENT, right)
        yield _decided("tilt_error", "0, which no integration states", error > 0.0, integrated, promise=True)
        true = np.maximum(facts.low, facts.high)
        judged = _resolved(facts) & integrated & ~_ended(stored, "horizon")
        allowed = PROMISED * error + np.nan_to_num(facts.exact["tilt_error"]) + _TILT_ROUNDING
    yield CellCheck(
        "tilt_error", "the true error, of which it states half at least", true, allowed, judged, True, _SHARE
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
            yield _decided(name, f"{_EXACT}, again", stored[name] == exact[name])
        else:
            right = same(stored[name], exact[name], 0.0)
            with np.errstate(invalid="ignore"):
                difference = np.where(right, 0.0, np.abs(stored[name] - exact[name]))
            allowed = _ENERGY_ROUNDING * (1.0 + np.abs(np.nan_to_num(exact[name])))
            yield CellCheck(name, f"{_EXACT}, again", difference, allowed, np.ones(right.shape, bool))
