"""Brackets around changes of verdict, halved all at once: one call of the kernel per halving."""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from sweep.engine.compute import compute, reach_and_scale
from sweep.engine.grid import completed
from sweep.model.description import LOST, Starts
from sweep.model.quantity import STABLE, UNDECIDED, Array, Truths
from sweep.request.spec import SweepSpec

#: Share of the width that each side of an undecided stretch may keep.
_SIDE = 0.25

#: What rounding alone may do to an extreme [rad]: the estimated errors do not count it.
_ROUNDING = 2e-14


Places = npt.NDArray[np.intp]
Codes = npt.NDArray[np.integer]


@dataclass(frozen=True)
class Brackets:
    """Segments of the space of starts, each along one parameter, whose two ends have unlike verdicts.

    Parameters
    ----------
    starts : mapping of str to array, shape (n,)
        The starts, in SI; what they hold for the parameter of the segment does not matter.
    along : array of int, shape (n,)
        Which parameter each segment runs along: a place among the parameters of the model.
    near, far : arrays, shape (n,)
        Value of that parameter at the two ends, in SI, in either order.
    near_verdict, far_verdict : arrays of int, shape (n,)
        Verdicts there, stable or unstable.
    """

    starts: Starts
    along: Places
    near: Array
    far: Array
    near_verdict: Codes
    far_verdict: Codes


def bisected(spec: SweepSpec, given: Brackets, width: float) -> Brackets:
    """Bisect every bracket until it is no wider than `width`, or has no number left between its ends.

    Parameters
    ----------
    spec : SweepSpec
        How starts are integrated and judged.
    given : Brackets
    width : float
        In the SI unit of each segment's parameter.

    Returns
    -------
    Brackets
        The ends have the verdicts that they had. Where starts between them are undecided, or have a verdict that the
        estimated error of their extremes leaves open, the bracket holds all of these and each side of them is no wider
        than a quarter of `width`: it stays as wide as what is not known.
        Where the verdict changes more than once between the given ends, one of the changes is found.
    """
    known = _Known(given)
    while True:
        ahead, behind = known.unknown(width)
        if not ahead.size + behind.size:
            return replace(given, near=known.near, far=known.far)
        middle = known.middles(ahead, behind)
        found = verdicts(spec, given, np.concatenate((ahead, behind)), middle)
        known.learn_ahead(ahead, middle[: ahead.size], found[: ahead.size])
        known.learn_behind(behind, middle[ahead.size :], found[ahead.size :])


class _Known:
    """What is known of the segments: their ends, and where `blurred` the undecided stretch from `first` to `last`."""

    def __init__(self, given: Brackets) -> None:
        self.given = given
        self.near, self.far = given.near.copy(), given.far.copy()
        self.first, self.last = self.far.copy(), self.near.copy()
        self.blurred = np.zeros(self.near.shape, bool)

    def unknown(self, width: float) -> tuple[Places, Places]:
        """Return the segments that are too wide before the undecided stretch (or as a whole), and behind it."""
        ahead = _open(self.near, self._before(), np.where(self.blurred, _SIDE * width, width))
        behind = self.blurred & _open(self.last, self.far, np.full(self.near.shape, _SIDE * width))
        return np.flatnonzero(ahead), np.flatnonzero(behind)

    def middles(self, ahead: Places, behind: Places) -> Array:
        """Return the middles of what is too wide."""
        before = 0.5 * (self.near + self._before())[ahead]
        return np.concatenate((before, 0.5 * (self.last + self.far)[behind]))

    def learn_ahead(self, which: Places, places: Array, codes: Codes) -> None:
        """Take in the verdicts at the middles before the undecided stretch, or of segments that have none."""
        _, on_far = self._sides(which, places, codes)
        self.blurred[on_far] = False
        unclear, there = which[codes == UNDECIDED], places[codes == UNDECIDED]
        fresh = ~self.blurred[unclear]
        self.first[unclear], self.last[unclear[fresh]] = there, there[fresh]
        self.blurred[unclear] = True

    def learn_behind(self, which: Places, places: Array, codes: Codes) -> None:
        """Take in the verdicts at the middles behind the undecided stretch."""
        # a change found before the stretch leaves nothing to look for behind it
        held = self.blurred[which]
        which, places, codes = which[held], places[held], codes[held]
        on_near, _ = self._sides(which, places, codes)
        self.blurred[on_near] = False
        self.last[which[codes == UNDECIDED]] = places[codes == UNDECIDED]

    def _before(self) -> Array:
        return np.where(self.blurred, self.first, self.far)

    def _sides(self, which: Places, places: Array, codes: Codes) -> tuple[Places, Places]:
        like_near, like_far = codes == self.given.near_verdict[which], codes == self.given.far_verdict[which]
        self.near[which[like_near]], self.far[which[like_far]] = places[like_near], places[like_far]
        return which[like_near], which[like_far]


def verdicts(spec: SweepSpec, given: Brackets, which: Places, places: Array) -> npt.NDArray[np.int8]:
    """Return the verdicts at places on some of the segments, shape of `which`."""
    along = given.along[which]
    starts = {
        name: np.where(along == number, places, given.starts[name][which])
        for number, name in enumerate(spec.model.parameters)
    }
    return judged(spec, completed(spec, starts))


def judged(spec: SweepSpec, starts: Starts) -> npt.NDArray[np.int8]:
    """Return the verdicts of starts, undecided where the estimated error of the extremes may change them.

    Without this a bracket would close around where the integration puts the boundary, however coarse it is: with a
    tolerance of 1e-6 rad brackets of 1e-9 rad/s lay 1e-7 rad/s beside the exact boundary.
    """
    model, found = spec.model, compute(spec, starts)
    error = model.error(found) + _ROUNDING
    low, high = (np.asarray(found[name], np.float64) for name in model.extremes)
    wide, narrow = (
        spec.criterion.verdict(model.endings, moved, *reach_and_scale(spec, starts, moved))
        for moved in (
            {**found, model.extremes[0]: low - by, model.extremes[1]: high + by} for by in (error, -error)
        )
    )
    whole = (found["stability"] == STABLE) & ~model.endings.have(LOST, found["ending"])
    lost = whole & model.may_be_lost(spec, found, error)
    codes = np.where((wide != narrow) | lost, UNDECIDED, found["stability"])
    return codes.astype(np.int8, copy=False)


def _open(one: Array, other: Array, width: Array) -> Truths:
    """Return where a stretch is wider than `width` and has a number between its ends."""
    middle = 0.5 * (one + other)
    return np.asarray((np.abs(other - one) > width) & (middle != one) & (middle != other))
