"""Sources of cell values: ranges and lists for axes, and distributions for random starts.

A random value depends only on the seed, the name of its parameter and the number of its start. So a run gives the same
starts for all block sizes, thread counts and machines, and for any number of starts.
"""

import hashlib
import math
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Self

import numpy as np
import numpy.typing as npt

from sweep.errors import RequestError, shown
from sweep.model.quantity import Array, Quantity

UNIFORM, LOGUNIFORM, NORMAL = "uniform", "loguniform", "normal"

#: Distribution -> its notation in a request.
KINDS = {UNIFORM: "uniform:LOW:HIGH", LOGUNIFORM: "loguniform:LOW:HIGH", NORMAL: "normal:MEAN:DEVIATION"}

_SPACINGS = ("linear", "log")

#: Smallest distance of neighbors, relative to the larger end: closer ones could be equal after rounding.
_CLOSEST = 1e-12

#: Up to this size (8 MB) all values are computed, even if only some of them are needed.
_MANY = 2**20

#: Largest number of values of a range: no disk could hold more.
_MOST_VALUES = 2**40

#: Bounds of values: above the first, steps, sums and logarithms may overflow; below the second, values may be equal.
_LARGEST, _SMALLEST = 1e300, 1e-300

#: Number of 64-bit words that a step of Philox yields.
_WORDS = 4

#: Larger gaps between start numbers are jumped over: a jump takes as long as drawing this many words.
_APART = 128

#: Chunk size for random values, so that all passes over a chunk stay in the processor's cache.
_AT_ONCE = 2**13

#: A rule: whether it is broken, its text, and the hint.
_Rule = tuple[bool, str, str]


class SourceError(RequestError):
    """An error in the values of an axis or a distribution, with the rule that they break."""

    def __init__(self, message: str, hint: str = "", where: str | None = None, rule: str = "") -> None:
        super().__init__(message, hint, where)
        self.args, self.rule = (*self.args, rule), rule

    @classmethod
    def of(cls, rule: str, given: object, hint: str) -> Self:
        """Return the error for values that break a rule."""
        return cls(f"{rule}; got {shown(given)}.", hint, rule=rule)

    def with_given(self, given: object) -> Self:
        """Return the same error with the value as a request gave it, instead of the values in SI."""
        return self.of(self.rule, given, self.hint)


def _check(rules: Iterable[_Rule], given: object) -> None:
    """Refuse values that break a rule; rules after the first broken one are not evaluated."""
    for broken, rule, hint in rules:
        if broken:
            raise SourceError.of(rule, given, hint)


@dataclass(frozen=True)
class Range:
    """Evenly spaced values from `start` to `stop`, both included exactly.

    Parameters
    ----------
    start, stop : float
        The ends, start < stop (equal if `count` is 1), in SI.
    count : int
        Number of values, at least 1.
    spacing : {"linear", "log"}
        Even spacing of the values or of their logarithms.

    Raises
    ------
    RequestError
        If the range is reversed, empty, not finite, too fine for distinct values, or logarithmic and not positive.
    """

    start: float
    stop: float
    count: int
    spacing: str = "linear"

    def __post_init__(self) -> None:
        """Refuse ends and counts that do not give an increasing sequence of finite numbers."""
        whole = isinstance(self.count, int | np.integer) and not isinstance(self.count, bool)
        hint = "Give the number of values, as in 0.5:6:400."
        _check([(not whole, "The count of a range must be a whole number", hint)], self)
        start, stop = _floats((self.start, self.stop))
        for name, value in (("start", start), ("stop", stop), ("count", int(self.count))):
            object.__setattr__(self, name, value)
        _check(self._rules(), self)

    def _rules(self) -> Iterator[_Rule]:
        hint = "Give the number of values, as in 0.5:6:400."
        largest, several = max(abs(self.start), abs(self.stop)), self.count > 1
        yield (
            not largest <= _LARGEST or math.isnan(self.stop),
            "The ends of a range must be finite and below 1e300",
            "Give smaller ends.",
        )
        yield self.count < 1, "A range must have count >= 1", hint
        yield (
            several and largest < _SMALLEST,
            "The larger end of a range of several values must be at least 1e-300 in size",
            "Widen the range, or give one value.",
        )
        yield self.count > _MOST_VALUES, f"A range has at most {_MOST_VALUES} values", "Give a smaller count."
        yield self.start > self.stop, "A range must increase, start < stop", "Put the smaller end first."
        yield (
            not several and self.start != self.stop,
            "A range includes both ends, so with a count of 1 they must be equal",
            "Give a count of 2 or more, or one number.",
        )
        yield (
            self.spacing not in _SPACINGS,
            "The spacing must be linear or log",
            "Write start:stop:count or start:stop:count:log.",
        )
        # below the first normal number, neighbors with a constant ratio may be the same number
        yield (
            self.spacing == "log" and self.start < sys.float_info.min,
            "A logarithmic range must start above 0, at least at 2.3e-308",
            "Give a larger start, or leave out :log.",
        )
        yield (
            several and not self._finest() > _CLOSEST,
            "The neighboring values of a range must differ by more than 1e-12 of the larger end",
            "Widen the range or lower the count.",
        )

    def _finest(self) -> float:
        gaps = self.count - 1
        if self.spacing == "log":
            return (math.log(self.stop) - math.log(self.start)) / gaps
        largest = max(abs(self.start), abs(self.stop))
        return (self.stop / largest - self.start / largest) / gaps if largest > 0.0 else 0.0

    def __len__(self) -> int:
        """Return the number of values."""
        return self.count

    def __str__(self) -> str:
        """Return the range in the notation of a request, in SI."""
        return f"{self.start!r}:{self.stop!r}:{self.count}" + (":log" if self.spacing == "log" else "")

    def ends(self) -> Array:
        """Return the smallest and the largest value, shape (2,)."""
        return np.array([self.start, self.stop])

    required = ends

    def at(self, places: npt.ArrayLike) -> Array:
        """Return the values at some indices, shape of `places`; they are bitwise equal to the values of `array`."""
        chosen = np.asarray(places, np.intp)
        if self.count <= _MANY:
            return self.array()[chosen]
        # the same arithmetic as in np.linspace and np.geomspace
        first, last = np.log10(self.ends()) if self.spacing == "log" else self.ends()
        values = np.where(
            chosen == self.count - 1, last, chosen * ((last - first) / (self.count - 1)) + first
        )
        if self.spacing == "log":
            values = np.power(10.0, values)
        return np.select((chosen == 0, chosen == self.count - 1), self.ends(), values)

    def array(self) -> Array:
        """Return the values, shape (count,), float64, increasing, in SI; the ends are exact."""
        if self.spacing == "log":
            return np.geomspace(self.start, self.stop, self.count)
        return np.linspace(self.start, self.stop, self.count)


@dataclass(frozen=True)
class Values:
    """Values given one by one.

    Parameters
    ----------
    values : tuple of float
        At least one, finite, strictly increasing, in SI.

    Raises
    ------
    RequestError
        If the list is empty, or its values are not finite or not strictly increasing.
    """

    values: tuple[float, ...]

    def __post_init__(self) -> None:
        """Refuse values that are not an increasing sequence of finite numbers."""
        object.__setattr__(self, "values", _floats(self.values))
        rising = all(after > before for before, after in zip(self.values, self.values[1:], strict=False))
        rules = [
            (not self.values, "A list must have at least one value", "Give a value."),
            (
                not all(map(math.isfinite, self.values)),
                "The values of a list must be finite",
                "Remove nan and inf.",
            ),
            (
                not rising,
                "A list must be strictly increasing, because it becomes a coordinate",
                "Sort it and remove repetitions.",
            ),
        ]
        _check(rules, self.values)

    def __len__(self) -> int:
        """Return the number of values."""
        return len(self.values)

    def __str__(self) -> str:
        """Return the list in the notation of a request, in SI."""
        text = ",".join(map(repr, self.values))
        return text if len(self.values) > 1 else text + ","

    def ends(self) -> Array:
        """Return the smallest and the largest value, shape (2,)."""
        return np.array([self.values[0], self.values[-1]])

    required = ends

    def at(self, places: npt.ArrayLike) -> Array:
        """Return the values at some indices, shape of `places`."""
        return self.array()[np.asarray(places, np.intp)]

    def array(self) -> Array:
        """Return the values, shape (n,), float64, increasing, in SI."""
        return np.array(self.values)


def _floats(numbers: Iterable[float]) -> tuple[float, ...]:
    try:
        # + 0.0 turns -0.0 into 0.0, so that equal axes also have the same text
        return tuple(float(number) + 0.0 for number in numbers)
    except (TypeError, ValueError, OverflowError) as problem:
        raise RequestError(
            f"The values of an axis must be numbers in SI; got {shown(numbers)}.", "Give numbers."
        ) from problem


@dataclass(frozen=True)
class Distribution:
    """A distribution of one parameter.

    Parameters
    ----------
    kind : {"uniform", "loguniform", "normal"}
    first, second : float
        The ends, first < second; for a normal distribution the mean and the standard deviation; in SI.

    Raises
    ------
    RequestError
        If the kind is unknown or the numbers are not possible.
    """

    kind: str
    first: float
    second: float

    def __post_init__(self) -> None:
        """Refuse an unknown kind and impossible numbers."""
        _check(self._rules(), self)

    def _rules(self) -> Iterator[_Rule]:
        yield (
            self.kind not in KINDS,
            f"A distribution is {', '.join(KINDS.values())}",
            "Write one of these forms.",
        )
        yield (
            not max(abs(self.first), abs(self.second)) <= _LARGEST,
            "The numbers of a distribution must be finite and below 1e300",
            "Give smaller numbers.",
        )
        yield (
            self.kind == NORMAL and not self.second > 0.0,
            "The standard deviation of a normal distribution must be greater than 0",
            "Give mean and standard deviation, as in normal:1deg:0.2deg, or one number for all starts.",
        )
        yield (
            self.kind != NORMAL and not self.first < self.second,
            f"A {self.kind} distribution must increase, low < high",
            "Put the smaller end first, or give one number for all starts.",
        )
        yield (
            self.kind == LOGUNIFORM and self.first < _SMALLEST,
            "A loguniform distribution must start above 0, at least at 1e-300",
            "Give a larger low end.",
        )

    def __str__(self) -> str:
        """Return the distribution in the notation of a request, in SI."""
        return f"{self.kind}:{self.first!r}:{self.second!r}"

    def in_words(self, quantity: Quantity) -> str:
        """Return the distribution in words, in the quantity's display unit."""
        first, second = (quantity.spell(each, 6) for each in (self.first, self.second))
        return f"normal, {first} +- {second}" if self.kind == NORMAL else f"{self.kind}, {first} to {second}"

    def ends(self) -> Array:
        """Return the ends, or for a normal distribution mean -+ standard deviation, shape (2,)."""
        if self.kind == NORMAL:
            return np.array([self.first - self.second, self.first + self.second])
        return np.array([self.first, self.second])

    def required(self) -> Array:
        """Return the values that the parameter's rule must allow: the ends, or the mean of a normal distribution."""
        return self.ends() if self.kind != NORMAL else np.array([self.first])

    def at(self, numbers: npt.NDArray[np.int64], stream: str) -> Array:
        """Return the values of some starts.

        Parameters
        ----------
        numbers : array of int, shape (n,)
            The numbers of the starts, from 0.
        stream : str
            The key of an independent sequence: the seed and the name of the parameter.

        Returns
        -------
        array, shape (n,)
            In SI.

        Notes
        -----
        Start number i uses the i-th 64-bit word of the counter-based generator Philox 4x64-10 (Salmon et al., SC11),
        whose key is the first half of the SHA-256 of `stream`. The upper 52 bits k of the word select one of 2**52
        equal intervals of (0, 1); the value is the distribution's quantile at the middle, (k + 1/2) / 2**52.
        """
        words = philox(stream, numbers)
        values = np.empty(numbers.size)
        for begin in range(0, numbers.size, _AT_ONCE):
            part = slice(begin, begin + _AT_ONCE)
            share = ((words[part] >> np.uint64(12)).astype(np.float64) + 0.5) * 2.0**-52
            values[part] = self._quantile(share)
        return values

    def _quantile(self, share: Array) -> Array:
        if self.kind == NORMAL:
            from scipy.special import ndtri

            return np.asarray(self.first + self.second * ndtri(share))
        if self.kind == UNIFORM:
            return self.first + (self.second - self.first) * share
        low, high = np.log(self.ends())
        # rounding may give values beyond the ends
        return np.asarray(np.clip(np.exp(low + (high - low) * share), self.first, self.second))


def philox(stream: str, numbers: npt.NDArray[np.int64]) -> npt.NDArray[np.uint64]:
    """Return the random words of a stream with some numbers, shape of `numbers`.

    Words with close numbers are drawn together.
    """
    if not numbers.size:
        return np.empty(0, np.uint64)
    order = np.argsort(numbers, kind="stable") if np.any(np.diff(numbers) < 0) else None
    rising = numbers if order is None else numbers[order]
    key = np.frombuffer(hashlib.sha256(stream.encode("ascii")).digest()[:16], "<u8").astype(np.uint64)
    found, place, generator = np.empty(numbers.size, np.uint64), 0, np.random.Philox(key=key)
    cuts = np.flatnonzero(np.diff(rising) > _APART) + 1
    for begin, end in zip([0, *cuts], [*cuts, rising.size], strict=True):
        group = rising[begin:end]
        step = int(group[0]) // _WORDS
        generator.advance(step - place)
        count = -(-(int(group[-1]) + 1) // _WORDS) - step
        found[begin:end] = generator.random_raw(count * _WORDS)[group - step * _WORDS]
        place = step + count
    if order is not None:
        found[order] = found.copy()
    return found
