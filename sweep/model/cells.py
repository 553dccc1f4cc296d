"""The cells of an atlas: the checks that all models share, and the errors of their variables."""

from collections.abc import Iterator
from functools import cached_property

import numpy as np
import numpy.typing as npt

from sweep.model.audit import CellCheck
from sweep.model.description import Columns, Request, Starts
from sweep.model.quantity import AMPLIFIED, EXTREME, PROMISED, Array, Quantity, Truths

#: Largest relative error of a time, however small the swing: a larger one would allow any value.
_MOST_OF_A_TIME = 0.5


def stated_error(
    quantity: Quantity, spec: Request, starts: Starts, columns: Columns, error: Array | float
) -> Array:
    """Return the allowed error of the values of a variable, in its units.

    Parameters
    ----------
    quantity : Quantity
        Its rule (`sweep.model.quantity.Tolerance`) says how its error follows from that of the extremes.
    spec : Request
    starts : mapping of str to array, shape (...)
    columns : mapping of str to array, shape (...)
        `quantity` and the extremes of the cells.
    error : array of float or float
        Error of the extremes, in the unit of the coordinate.

    Returns
    -------
    array of float, shape (...)
        A missing or infinite value is allowed the same error as 0.
    """
    rule, model = quantity.tolerance, spec.model
    size = magnitude(columns[quantity.name])
    allowed = rule.absolute + rule.relative * size
    if not rule.stated:
        return np.asarray(allowed)
    if rule.stated in columns:
        # the cells state their own error
        return np.asarray(allowed + PROMISED * magnitude(columns[rule.stated]))
    if rule.stated == EXTREME:
        return np.asarray(allowed + error)
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = model.perturbation(spec, starts)
        if rule.stated == AMPLIFIED:
            return np.asarray(allowed + np.where(scale > 0.0, error / scale, 0.0))
        low, high = (columns[name] for name in model.extremes)
        swing = np.minimum(1.0, np.minimum(scale, high - low))
        share = np.minimum(_MOST_OF_A_TIME, np.where(swing > 0.0, error / swing, 0.0))
        return np.asarray(allowed + size * share)


def magnitude(values: npt.NDArray[np.generic]) -> Array:
    """Return magnitudes; 0 for missing and infinite values, so that a relative tolerance allows them no difference."""
    numbers = np.abs(values.astype(np.float64))
    return np.where(np.isfinite(numbers), numbers, 0.0)


#: Share of an error (2e-14 at least) by which rounding may move the bound of an extreme.
_CLOSE = 0.02

#: Relative rounding error of a few operations on stored values, on any processor.
ROUNDING = 1e-12

#: Rounding of the coordinate in its unit: the last bit of the logarithm in an axis differs between processors.
LAST_BIT = 1e-15


class AuditedCells:
    """Some cells of an atlas with their starts and stored values, arrays of shape (n,).

    Parameters
    ----------
    spec : Request
    starts : mapping of str to array
    stored : mapping of str to array
        The variables of the cells in the atlas: another program may have dropped some.
    """

    def __init__(self, spec: Request, starts: Starts, stored: Columns) -> None:
        self.spec, self.starts, self.stored = spec, starts, stored
        #: all cells, and the difference 0 in all of them
        self.every, self.nothing = np.ones(stored["ending"].shape, bool), np.zeros(stored["ending"].shape)

    def ended(self, *names: str) -> Truths:
        """Return which cells have one of the endings."""
        return self.spec.model.endings.among(self.stored["ending"], *names)

    @cached_property
    def scale(self) -> Array:
        """The size of the perturbation, in the unit of the coordinate."""
        return self.spec.model.perturbation(self.spec, self.starts)

    @cached_property
    def reach(self) -> Array:
        """The largest distance of the coordinate from its undisturbed value, from the stored extremes."""
        with np.errstate(invalid="ignore"):
            return self.spec.model.reach(self.spec, self.starts, self.stored)

    @cached_property
    def derived(self) -> Columns:
        """Variables derived from the stored measures; a measure that the atlas lacks counts as missing."""
        model, missing = self.spec.model, np.full(self.every.shape, np.nan)
        measured = {**dict.fromkeys((*model.measures, *model.counts), missing), **self.stored}
        return {**model.derive(self.starts, measured), "amplification": amplification(self.reach, self.scale)}

    @cached_property
    def amplification_rounding(self) -> Array:
        """Largest difference of an amplification between processors; not finite where there is no amplification."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(ROUNDING * self.derived["amplification"] + LAST_BIT / self.scale)

    @cached_property
    def verdict_follows(self) -> Truths:
        """Whether the criterion gives the stored verdict for the stored values.

        Where only rounding decides whether the limit is within the error, both verdicts are accepted.
        """
        spec, columns = self.spec, {**self.stored, **self.derived}
        follows = np.zeros(self.every.shape, bool)
        for share in (1.0, 1.0 + _CLOSE, 1.0 - _CLOSE):
            follows |= self.stored["stability"] == spec.criterion.decide(
                spec, self.starts, columns, self.reach, self.scale, share
            )
            if follows.all():
                break
        return follows

    def decided(
        self,
        name: str,
        against: str,
        right: Truths,
        judged: Truths | None = None,
        promise: bool = False,
        unknown: Truths | None = None,
    ) -> CellCheck:
        """Return the check of a decision: the difference is 0 if it is right, 1 if it is wrong."""
        difference = self.nothing if right.all() else np.where(right, 0.0, 1.0)
        judged = self.every if judged is None else judged
        return CellCheck(name, against, difference, self.nothing, judged, promise, unknown=unknown)

    def following(self) -> Iterator[CellCheck]:
        """Yield the checks of the variables that follow from the start and the stored measures."""
        rounding = self.amplification_rounding
        for name, against, values, allowed in (
            ("peak_tilt", "the stored extremes", self.derived["peak_tilt"], self.nothing),
            (
                "amplification",
                "the stored extremes and the start",
                self.derived["amplification"],
                np.where(np.isfinite(rounding), rounding, 0.0),
            ),
        ):
            yield self.same(name, against, values, allowed)
        for name in [name for name in self.derived if name not in ("peak_tilt", "amplification")]:
            if name in self.stored:
                yield self.same(name, "the stored measures", np.asarray(self.derived[name], np.float64))
        for rate in [name for name in ("precession_rate", "roll_rate") if name in self.stored]:
            known = np.isfinite(self.starts[rate]) & ~self.ended("not_computed")
            values = np.where(known, self.starts[rate], np.nan)
            yield self.same(rate, "the equation of steady motion", values)

    def same(self, name: str, against: str, values: Array, allowed: Array | None = None) -> CellCheck:
        """Return the check that stored values equal expected ones to rounding, and are missing where those are."""
        if allowed is None:
            allowed = ROUNDING * np.abs(np.nan_to_num(values))
        return CellCheck(name, against, self.unless_same(self.stored[name], values), allowed, self.every)

    def unless_same(self, stored: Array, values: Array) -> Array:
        """Return the differences of stored values from others: 0 where they are the same, or both are missing."""
        right: Truths = stored == values
        if right.all():
            return self.nothing
        right |= np.isnan(stored) & np.isnan(values)
        with np.errstate(invalid="ignore"):
            return np.where(right, 0.0, np.abs(stored - values))


def amplification(reach: Array, scale: Array) -> Array:
    """Return the reach over the size of the perturbation; missing where nothing disturbs the motion."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(scale > 0.0, reach / scale, np.nan)
