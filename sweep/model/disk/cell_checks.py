"""The checks of all variables of the cells in an atlas of the disk."""

from collections.abc import Iterator
from functools import cached_property

import numpy as np
import numpy.typing as npt

from sweep.model.audit import CellCheck
from sweep.model.cells import LAST_BIT, AuditedCells, amplification, stated_error
from sweep.model.description import Columns, Request, Starts
from sweep.model.disk.tables import REDUCTION, VARIABLES
from sweep.model.quantity import PROMISED, UNDECIDED, Array, Truths

_EXACT = "the exact reduction"
_PRESENT = "the ending, which decides where it is missing"

#: Share of cells whose error may exceed the promise of `tilt_error`.
_SHARE = 1e-3

#: Possible effect of rounding on an extreme tilt [rad], and on a difference of energies.
_TILT_ROUNDING, _ENERGY_ROUNDING = 2e-14, 1e-12


#: Relative error of a fall time: of the quadrature (at most 8e-7 in 6800 random falls), and of the integration, over
#: its tolerance (at most 0.4).
_FALL_TIME, _FALL_TOLERANCE = 1e-5, 20.0

#: A value counts as checked only if the allowed difference is at most this share of it.
_WIDE = 0.1

#: Variables of an atlas that the audit reads.
MEASURES = ("ending", "stability", "tilt_min", "tilt_max", "peak_tilt", "amplification", "nutation_period")

#: The error of an extreme tilt changes the period, relatively, by about its ratio to the width of the swing; near a
#: saddle by its ratio to the separatrix.
_PERIOD_FACTOR = 2.0

#: Relative error of the period from RK4, which keeps time less well than energy: rounding, a multiple of the tolerance
#: if the engine chose the step, and a constant if the step was given. See `ReducedCells.period_allowed`.
_PERIOD_ROUNDING, _PERIOD_TOLERANCE, _PERIOD_GIVEN_STEP = 1e-9, 10.0, 3e-6

#: A motion passes both turning points within one period; the rest allows for the error of the period.
_MOST_PERIODS = 1.01


class ReducedCells(AuditedCells):
    """Cells of an atlas of the disk with their values from the exact reduction, arrays of shape (n,).

    Parameters
    ----------
    spec : Request
    starts, stored : mapping of str to array
        As in `AuditedCells`.
    exact : mapping of str to array
        The measures of the same starts by the exact reduction (`sweep.model.disk.exact`).
    """

    def __init__(self, spec: Request, starts: Starts, stored: Columns, exact: Columns) -> None:
        super().__init__(spec, starts, stored)
        self.exact = exact

    def exact_ended(self, *names: str) -> Truths:
        """Return which cells have one of the endings in the reduction."""
        return self.spec.model.endings.among(self.exact["ending"], *names)

    @cached_property
    def failed(self) -> Truths:
        """Which cells of the atlas have no numbers."""
        return self.ended("not_computed", "unresolved", "invalid")

    @cached_property
    def without_exact_period(self) -> Truths:
        """Which cells lack only the period in the reduction: next to a separatrix rounding decides it."""
        return self.exact_ended("bounded") & np.isnan(self.exact["nutation_period"])

    @cached_property
    def resolved(self) -> Truths:
        """Which cells are resolved both in the atlas and in the reduction."""
        vague = self.exact_ended("unresolved", "invalid") | self.without_exact_period
        return np.asarray(~vague & ~self.failed)

    @cached_property
    def allowed(self) -> Array:
        """Allowed difference [rad] of an extreme tilt from the exact one."""
        return np.asarray(self.spec.tolerance + np.fmax(self.exact["tilt_error"], 0.0))

    @cached_property
    def differences(self) -> tuple[Array, Array]:
        """The differences [rad] of the smallest and of the largest tilt from the exact ones.

        If a cell ran out of time, its extremes only need to lie inside the exact ones. If a peak is within the
        tolerance of fall_tilt, the atlas or the reduction may end with a fall and know only the extremes before it:
        then one pair of extremes only needs to lie inside the other.
        """
        stored, exact, fall_tilt = self.stored, self.exact, self.spec.fall_tilt
        low, high = stored["tilt_min"] - exact["tilt_min"], stored["tilt_max"] - exact["tilt_max"]
        least, greatest = np.abs(low), np.abs(high)
        fell, open_ = self.ended("fell") | self.exact_ended("fell"), self.ended("horizon")
        if fell.any():
            ends = np.abs([columns[name] for columns in (stored, exact) for name in ("tilt_min", "tilt_max")])
            grazes = fell & np.any((ends < fall_tilt) & (ends >= fall_tilt - self.allowed), axis=0)
            inside = np.maximum(0.0, np.stack((-low, high)))
            around = np.maximum(0.0, np.stack((low, -high)))
            nested = np.where(inside.max(0) <= around.max(0), inside, around)
            least, greatest = np.where(grazes, nested, (least, greatest))
        if open_.any():
            least = np.where(open_, np.maximum(0.0, -low), least)
            greatest = np.where(open_, np.maximum(0.0, high), greatest)
        return least, greatest

    @cached_property
    def difference(self) -> Array:
        """The larger of the differences [rad] of the two extremes."""
        return np.maximum(*self.differences)

    @cached_property
    def period_allowed(self) -> Array:
        """Allowed difference [s] of a period from the exact one.

        Measured over 150000 random motions with rates over six decades, at tolerances from 1e-10 to 1e-2 and with the
        engine's own step: beyond the effect of the extremes, the relative error of the period is at most 2.7 times the
        tolerance.
        """
        spec, exact, own_step = self.spec, self.exact, isinstance(self.spec.step, str)
        with np.errstate(divide="ignore", invalid="ignore"):
            # without a second well there is no saddle to linger at
            lingering = np.fmax(1.0 / np.abs(exact["separatrix"]), 0.0)
            # a given step keeps the extremes to the tolerance, and the period of a small swing no better than that
            apart = np.minimum(np.fmax(self.difference, 0.0), spec.tolerance) if own_step else spec.tolerance
            error = apart + np.fmax(exact["tilt_error"], 0.0) + LAST_BIT
            share = _PERIOD_FACTOR * error * (1.0 + 1.0 / (exact["tilt_max"] - exact["tilt_min"]) + lingering)
        time = _PERIOD_ROUNDING + _PERIOD_TOLERANCE * spec.tolerance
        if not own_step:
            time = max(time, _PERIOD_GIVEN_STEP)
        return np.asarray((time + share) * exact["nutation_period"])

    @cached_property
    def has_period(self) -> Truths:
        """Which cells must have a period: with ``method=exact``, the cells that have one in the reduction."""
        bounded = self.ended("bounded")
        if self.spec.method != "exact":
            return bounded
        return np.asarray(bounded & ~self.without_exact_period)

    @cached_property
    def decidable(self) -> bool:
        """Whether the reduction knows everything that the criterion needs: it has no duration and no fall_time."""
        return set(self.spec.criterion.needs(self.spec.model)) <= {*MEASURES, *REDUCTION}

    @cached_property
    def exact_reach(self) -> Array:
        """The largest distance of the coordinate from its undisturbed value, from the reduction."""
        return self.spec.model.reach(self.spec, self.starts, self.exact)

    @cached_property
    def exact_derived(self) -> Columns:
        """The variables that follow from the exact extremes."""
        least, greatest = self.exact["tilt_min"], self.exact["tilt_max"]
        return {
            "peak_tilt": np.maximum(np.abs(least), np.abs(greatest)),
            "amplification": amplification(self.exact_reach, self.scale),
        }

    @cached_property
    def exact_stability(self) -> npt.NDArray[np.int8]:
        """The verdict of the criterion for the exact values; undecided where the reduction does not know them."""
        criterion = self.spec.criterion
        if not self.decidable and not criterion.limits_reach:
            return np.full(self.every.shape, UNDECIDED, np.int8)
        derives = not {"peak_tilt", "amplification"}.isdisjoint(criterion.needs(self.spec.model))
        columns = {**self.starts, **self.exact, **(self.exact_derived if derives else {})}
        verdict: npt.NDArray[np.int8] = criterion.verdict(
            self.spec.model.endings, columns, self.exact_reach, self.scale
        )
        return verdict

    @cached_property
    def at_rest(self) -> Truths:
        """Where the swing is within the tolerance, so that the cell may count as bounded or as steady."""
        both = self.ended("bounded", "steady") & self.exact_ended("bounded", "steady")
        return np.asarray(both & (self.exact["tilt_max"] - self.exact["tilt_min"] <= self.allowed))

    @cached_property
    def same_ending(self) -> Truths:
        """Where the endings are the same, or the cell may have run out of time."""
        agree: Truths = self.at_rest | (self.stored["ending"] == self.exact["ending"])
        open_ = self.ended("horizon")
        if open_.any():
            agree |= open_ & ~(self.spec.duration > _MOST_PERIODS * self.exact["nutation_period"])
        return agree

    @cached_property
    def same_verdict(self) -> Truths:
        """Where the verdicts are the same, or cannot be compared.

        A cell that ran out of time may be undecided; for a criterion that does not limit the reach, it is judged by the
        measures until then. Next to a separatrix the reduction may lack the period that the criterion needs.
        """
        if not self.decidable:
            return self.every
        criterion, stability = self.spec.criterion, self.stored["stability"]
        agree: Truths = self.at_rest | (stability == self.exact_stability)
        open_ = self.ended("horizon")
        if criterion.limits_reach:
            return np.asarray(agree | (open_ & (stability == UNDECIDED)))
        if "nutation_period" in criterion.needs(self.spec.model):
            open_ |= self.without_exact_period
        return np.asarray(agree | open_)

    @cached_property
    def marginal(self) -> Truths:
        """Where ending or verdict change within the allowed differences of the extremes [rad] and the period [s].

        A fall has no turning point in the reduction and ends at fall_tilt. If the atlas has another ending, its
        extremes must still agree, so they are within the tolerance of fall_tilt.
        """
        if (self.same_ending & self.same_verdict).all():
            return np.zeros(self.every.shape, bool)
        spec, columns = self.spec, {**self.exact, **self.exact_derived}
        near: Truths = np.abs(self.exact_derived["peak_tilt"] - spec.fall_tilt) <= self.allowed
        if not self.decidable and not spec.criterion.limits_reach:
            return near

        def error(name: str) -> Array:
            if name == "nutation_period":
                return self.period_allowed
            return stated_error({**VARIABLES, **REDUCTION}[name], spec, self.starts, columns, self.allowed)

        return np.asarray(near | spec.criterion.on_edge(spec, self.starts, [columns], error))

    @property
    def ending_right(self) -> Truths:
        """Where the ending is the exact one, or is allowed to differ from it."""
        return self.marginal | self.same_ending

    @property
    def verdict_right(self) -> Truths:
        """Where the verdict is the exact one, or is allowed to differ from it."""
        return self.marginal | self.same_verdict


def cell_checks(cells: ReducedCells) -> list[CellCheck]:
    """Return the checks of all variables that the atlas contains.

    Parameters
    ----------
    cells : ReducedCells
    """
    checks = [
        *_decisions(cells),
        *_extremes(cells),
        *cells.following(),
        *_of_the_integration(cells),
        *_of_the_reduction(cells),
    ]
    return [check for check in checks if check.name in cells.stored]


def _present(values: npt.NDArray[np.float64], wanted: Truths, difference: Array) -> Array:
    """Return a difference, but NaN where a value is wrongly missing or wrongly present, and 0 where rightly missing."""
    return np.where(np.isfinite(values) != wanted, np.nan, np.where(wanted, difference, 0.0))


def _narrow(allowed: Array, values: Array) -> Truths:
    """Return where a check is meaningful: next to a separatrix the tolerance may allow any time."""
    with np.errstate(invalid="ignore"):
        return np.asarray(allowed <= _WIDE * np.abs(values))


def _decisions(cells: ReducedCells) -> Iterator[CellCheck]:
    resolved = cells.resolved
    possible = cells.ended("invalid") == cells.exact_ended("invalid")
    endings = cells.spec.model.endings
    known = endings.among(cells.stored["ending"], *endings.flags.values())
    right = known & (possible | cells.ended("not_computed")) & (cells.ending_right | ~resolved)
    yield cells.decided("ending", _EXACT, right)
    yield cells.decided(
        "stability",
        f"the criterion, on the stored {f'extremes and on those of {_EXACT}' if cells.decidable else 'values'}",
        cells.verdict_follows & (cells.verdict_right | ~resolved),
    )


def _extremes(cells: ReducedCells) -> Iterator[CellCheck]:
    failed, judged = cells.failed, cells.resolved | cells.failed
    for name, difference in zip(("tilt_min", "tilt_max"), cells.differences, strict=True):
        if failed.any():
            empty = np.where(np.isnan(cells.stored[name]), 0.0, np.nan)
            difference = np.where(failed, empty, difference)
        yield CellCheck(name, _EXACT, difference, cells.allowed, judged)
    period, exact = cells.stored["nutation_period"], cells.exact["nutation_period"]
    both = cells.has_period & np.isfinite(exact)
    difference = np.where(both, np.abs(period - exact), 0.0)
    yield CellCheck(
        "nutation_period",
        _EXACT,
        _present(period, cells.has_period, difference),
        np.where(both, cells.period_allowed, 0.0),
        cells.every,
        unknown=cells.has_period & ~(both & _narrow(cells.period_allowed, exact)),
    )


def _of_the_integration(cells: ReducedCells) -> Iterator[CellCheck]:
    """Yield the checks of the variables that only an integration in time knows."""
    stored, integrated = cells.stored, cells.spec.method != "exact"
    for name, present in (("fall_time", cells.ended("fell")), ("energy_drift", ~cells.failed)):
        if name in stored:
            values = stored[name]
            right = (np.isfinite(values) == (present & integrated)) & ~(values < 0.0)
            yield cells.decided(name, _PRESENT, right, unknown=present & integrated)
    if "fall_time" in stored and integrated:
        yield _fall_time(cells)
    for name in ("steps", "refinements"):
        if name in stored:
            may = integrated & ~cells.ended("not_computed", "invalid")
            right = (stored[name] == 0) | ((stored[name] > 0) & may)
            yield cells.decided(name, "its range", right, unknown=np.asarray(may))
    if "tilt_error" in stored and "steps" in stored:
        yield from _stated_error(cells)


def _fall_time(cells: ReducedCells) -> CellCheck:
    """Return the check of the fall times; like periods, they grow without bound towards the saddle."""
    stored, exact = cells.stored["fall_time"], cells.exact["fall_time"]
    fell = cells.ended("fell")
    judged = fell & np.isfinite(exact)
    against = "a quadrature over the tilt"
    if not judged.any():
        return CellCheck("fall_time", against, cells.nothing, cells.nothing, judged, unknown=fell)
    with np.errstate(divide="ignore", invalid="ignore"):
        lingering = np.fmax(1.0 / np.abs(cells.exact["separatrix"]), 0.0)
        allowed = (_FALL_TIME + cells.spec.tolerance * (_FALL_TOLERANCE + 2.0 * lingering)) * exact
        difference = np.where(judged, np.abs(stored - exact), 0.0)
    return CellCheck(
        "fall_time", against, difference, allowed, judged, unknown=fell & ~_narrow(allowed, exact)
    )


def _stated_error(cells: ReducedCells) -> Iterator[CellCheck]:
    """Yield the checks of the stated error: it is above 0, and the true error is rarely more than twice as large."""
    stored, failed = cells.stored, cells.failed
    error = np.asarray(stored["tilt_error"], np.float64)
    integrated = ~failed & (stored["steps"] != 0)
    with np.errstate(invalid="ignore"):
        right = np.isfinite(error) & (error >= 0.0)
        if failed.any():
            right = np.where(failed, np.isnan(error), right)
        yield cells.decided("tilt_error", _PRESENT, right, unknown=~failed)
        yield cells.decided(
            "tilt_error",
            "0, which an integration never states",
            error > 0.0,
            integrated,
            promise=True,
            unknown=~failed,
        )
        judged = cells.resolved & integrated & ~cells.ended("horizon")
        allowed = PROMISED * error + np.fmax(cells.exact["tilt_error"], 0.0) + _TILT_ROUNDING
    yield CellCheck(
        "tilt_error",
        "at least half the true error",
        cells.difference,
        allowed,
        judged,
        True,
        _SHARE,
        unknown=~failed,
    )


def _of_the_reduction(cells: ReducedCells) -> Iterator[CellCheck]:
    """Yield the checks of the variables that only an atlas of ``method=exact`` has."""
    if cells.spec.method != "exact":
        return
    stored, exact = cells.stored, cells.exact
    for name, quantity in REDUCTION.items():
        if name not in stored:
            continue
        if quantity.flags is not None:
            yield cells.decided(name, f"{_EXACT}, repeated", stored[name] == exact[name])
        else:
            difference = cells.unless_same(stored[name], exact[name])
            allowed = _ENERGY_ROUNDING * (1.0 + np.abs(np.nan_to_num(exact[name])))
            yield CellCheck(name, f"{_EXACT}, repeated", difference, allowed, cells.every)
