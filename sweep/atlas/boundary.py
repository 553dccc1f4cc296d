"""The boundary between verdicts: bisection of the brackets around it, and the lines that theory predicts."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from sweep.engine.compute import compute
from sweep.engine.grid import Span, blocks, completed, starts_of
from sweep.model.description import Starts
from sweep.model.quantity import UNDECIDED, Array, Truths
from sweep.request.spec import SweepSpec

#: Largest width of each side of an undecided stretch, as a share of the requested width.
_SIDE = 0.25

#: Rows of theoretical lines, or brackets, that are processed at a time: 50 MB of starts and results.
AT_ONCE = 2**16

#: Type of a function that is called with the completed share of some work, from 0 to 1.
Seen = Callable[[float], None]

Places = npt.NDArray[np.intp]
Codes = npt.NDArray[np.integer]


@dataclass(frozen=True)
class Brackets:
    """Segments of the space of starts, each along one parameter, whose two ends have different verdicts.

    Parameters
    ----------
    starts : mapping of str to array, shape (n,)
        The starts, in SI; their values of the segment's own parameter do not matter.
    along : array of int, shape (n,)
        The parameter along which each segment runs, as an index into the parameters of the model.
    near, far : arrays, shape (n,)
        Values of that parameter at the two ends, in SI, in either order.
    near_verdict, far_verdict : arrays of int, shape (n,)
        Verdicts at the two ends, stable or unstable.
    """

    starts: Starts
    along: Places
    near: Array
    far: Array
    near_verdict: Codes
    far_verdict: Codes

    def part(self, which: slice) -> "Brackets":
        """Return some of the segments."""
        return Brackets(
            {name: each[which] for name, each in self.starts.items()},
            self.along[which],
            self.near[which],
            self.far[which],
            self.near_verdict[which],
            self.far_verdict[which],
        )


def unseen(share: float) -> None:
    """Ignore the progress."""


def bisected(spec: SweepSpec, given: Brackets, width: float, seen: Seen = unseen) -> Brackets:
    """Bisect every bracket until it is no wider than `width`, or no number lies between its ends.

    Parameters
    ----------
    spec : SweepSpec
        How starts are integrated and judged.
    given : Brackets
    width : float
        In the SI unit of each segment's parameter.
    seen : callable, optional
        Called after each halving with the completed share of the halvings that the widest bracket needs.

    Returns
    -------
    Brackets
        The ends keep their verdicts. Starts between them may be undecided, or have a verdict that the estimated error
        of their extremes leaves open: then the bracket contains this whole stretch, and on each side of it at most a
        quarter of `width`.
        If the verdict changes more than once between the given ends, one of the changes is found.
    """
    near, far = given.near.copy(), given.far.copy()
    for span in blocks(near.size, AT_ONCE):
        part = slice(span.start, span.stop)

        def seen_part(share: float, span: Span = span) -> None:
            seen((span.start + share * len(span)) / near.size)

        near[part], far[part] = _bisected(spec, given.part(part), width, seen_part)
    seen(1.0)
    return replace(given, near=near, far=far)


def _bisected(spec: SweepSpec, given: Brackets, width: float, seen: Seen) -> tuple[Array, Array]:
    search, halvings, done = _Search(given), _halvings(given, width), 0
    while True:
        before, after = search.unknown(width)
        if not before.size + after.size:
            return search.near, search.far
        # an undecided stretch takes more halvings, because both of its sides are narrowed
        seen(min(done / halvings, 1.0))
        done += 1
        middle = search.middles(before, after)
        found = verdicts(spec, given, np.concatenate((before, after)), middle)
        search.record_before(before, middle[: before.size], found[: before.size])
        search.record_after(after, middle[before.size :], found[before.size :])


def _halvings(given: Brackets, width: float) -> int:
    """Return the number of halvings that the widest bracket needs, at least 1."""
    widest = float(np.max(np.abs(given.far - given.near), initial=0.0))
    return max(1, math.ceil(math.log2(max(widest / width, 1.0)))) if widest else 1


class _Search:
    """The segments: their ends and, where `has_undecided`, the undecided stretch from `first` to `last`."""

    def __init__(self, given: Brackets) -> None:
        self.given = given
        self.near, self.far = given.near.copy(), given.far.copy()
        self.first, self.last = self.far.copy(), self.near.copy()
        self.has_undecided = np.zeros(self.near.shape, bool)

    def unknown(self, width: float) -> tuple[Places, Places]:
        """Return the segments that are too wide before their undecided stretch (or as a whole), and those after it."""
        before = _divisible(self.near, self._before(), np.where(self.has_undecided, _SIDE * width, width))
        after = self.has_undecided & _divisible(self.last, self.far, np.full(self.near.shape, _SIDE * width))
        return np.flatnonzero(before), np.flatnonzero(after)

    def middles(self, before: Places, after: Places) -> Array:
        """Return the middles of the stretches that are too wide."""
        first = 0.5 * (self.near + self._before())[before]
        return np.concatenate((first, 0.5 * (self.last + self.far)[after]))

    def record_before(self, which: Places, places: Array, codes: Codes) -> None:
        """Record the verdicts at the middles before the undecided stretch, or of segments without such a stretch."""
        _, on_far = self._sides(which, places, codes)
        self.has_undecided[on_far] = False
        unclear, unclear_places = which[codes == UNDECIDED], places[codes == UNDECIDED]
        fresh = ~self.has_undecided[unclear]
        self.first[unclear], self.last[unclear[fresh]] = unclear_places, unclear_places[fresh]
        self.has_undecided[unclear] = True

    def record_after(self, which: Places, places: Array, codes: Codes) -> None:
        """Record the verdicts at the middles after the undecided stretch."""
        # if a change was found before the stretch, there is nothing to find after it
        still_open = self.has_undecided[which]
        which, places, codes = which[still_open], places[still_open], codes[still_open]
        on_near, _ = self._sides(which, places, codes)
        self.has_undecided[on_near] = False
        self.last[which[codes == UNDECIDED]] = places[codes == UNDECIDED]

    def _before(self) -> Array:
        return np.where(self.has_undecided, self.first, self.far)

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
    """Return the verdicts of starts, undecided where the stated errors could change them.

    Otherwise a bracket would close around the boundary of the integration, however coarse that is: with a tolerance of
    1e-6 rad, brackets of 1e-9 rad/s missed the exact boundary by 1e-7 rad/s.
    """
    return np.asarray(compute(spec, starts, verdicts_only=True)["stability"])


def _divisible(one: Array, other: Array, width: Array) -> Truths:
    """Return where a stretch is wider than `width` and has a number between its ends."""
    middle = 0.5 * (one + other)
    return np.asarray((np.abs(other - one) > width) & (middle != one) & (middle != other))


def theory_lines(spec: SweepSpec, axis: str) -> dict[str, tuple[Array, Array]]:
    """Return the theoretical edges along an axis, over the other axes; see `sweep.model.description.Model.lines`.

    The predicted boundary is NaN for a criterion that theory does not cover.
    """
    rows, found = rows_along(spec, axis), dict[str, tuple[Array, Array]]()
    for span in blocks(rows.size, AT_ONCE):
        for name, lines in spec.model.lines(spec, axis, starts_of(rows, span)).items():
            # theory may give no line for rows without an edge
            into = found.setdefault(name, (np.full(rows.size, np.nan), np.full(rows.size, np.nan)))
            known = lines if spec.criterion.predictable else lines[:1]
            for values, part in zip(into, known, strict=False):
                values[span.start : span.stop] = part
    return {name: (line[0].reshape(rows.shape), line[1].reshape(rows.shape)) for name, line in found.items()}


def rows_along(spec: SweepSpec, axis: str) -> SweepSpec:
    """Return the spec of the rows along an axis: the axis has a single value, if possible not zero."""
    return spec.replace(**{axis: next((float(end) for end in getattr(spec, axis).ends() if end), 1.0)})
