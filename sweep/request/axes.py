"""The axes of a grid: evenly spaced values, and values given one by one."""

import math
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NoReturn, Self

import numpy as np
import numpy.typing as npt

from sweep.errors import RequestError, shown
from sweep.model.quantity import Array

_SPACINGS = ("linear", "log")

#: Neighbours closer than this, relative to the larger end, could come out equal after rounding.
_CLOSEST = 1e-12

#: Values that are all made where some of them are asked for: 8 MB.
_MANY = 2**20

#: Beyond this no disk holds the values.
_MOST_VALUES = 2**40

#: Nearer to the largest float, the steps between the ends overflow; nearer to zero, values to the same number.
_LARGEST, _SMALLEST = 1e300, 1e-300


class AxisError(RequestError):
    """Values that make no axis: the rule that they break, and what was given."""

    @classmethod
    def of(cls, rule: str, given: object, hint: str) -> Self:
        """Return the error that some values break a rule."""
        return cls(f"{rule}; got {shown(given)}.", hint)

    def with_given(self, given: object) -> Self:
        """Return the same error with what a request gave, in place of the values in SI."""
        return type(self).of(self.message.partition("; got ")[0], given, self.hint)


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
        Evenly in the value, or in its logarithm.

    Raises
    ------
    RequestError
        If the range is reversed, empty, not finite, too fine to tell its values apart, or logarithmic and not
        positive.
    """

    start: float
    stop: float
    count: int
    spacing: str = "linear"

    def __post_init__(self) -> None:
        """Refuse what is not an increasing sequence of finite numbers."""
        if isinstance(self.count, bool) or not isinstance(self.count, int | np.integer):
            self._refuse(
                "The count of a range must be a whole number",
                "Give how many values the range has, as in 0.5:6:400.",
            )
        start, stop = _floats((self.start, self.stop))
        object.__setattr__(self, "start", start)
        object.__setattr__(self, "stop", stop)
        object.__setattr__(self, "count", int(self.count))
        self._check_ends()
        self._check_spacing()

    def _check_ends(self) -> None:
        if not max(abs(self.start), abs(self.stop)) <= _LARGEST or math.isnan(self.stop):
            self._refuse("The ends of a range must be finite and below 1e300", "Give ends below that.")
        if self.count < 1:
            self._refuse(
                "A range must have count >= 1", "Give how many values the range has, as in 0.5:6:400."
            )
        if self.count > 1 and max(abs(self.start), abs(self.stop)) < _SMALLEST:
            self._refuse("A range of several values must reach 1e-300", "Widen it, or give one value.")
        if self.count > _MOST_VALUES:
            self._refuse(f"A range has at most {_MOST_VALUES} values", "Give a smaller count.")
        if self.start > self.stop:
            self._refuse("A range must go up, start < stop", "Put the smaller end first.")
        if self.count == 1 and self.start != self.stop:
            self._refuse(
                "A range includes both ends, so with a count of 1 they must be equal",
                "Give a count of 2 or more, or one number.",
            )

    def _check_spacing(self) -> None:
        if self.spacing not in _SPACINGS:
            self._refuse(
                "The spacing must be linear or log", "Write start:stop:count or start:stop:count:log."
            )
        # below the first normal number neighbours of one ratio may be the same number
        if self.spacing == "log" and self.start < sys.float_info.min:
            self._refuse(
                "A logarithmic range must start above 0, at 2.3e-308 at least",
                "Start above that, or leave out :log.",
            )
        if self.count > 1 and not self._finest() > _CLOSEST:
            self._refuse(
                "The neighbouring values of a range must differ by more than 1e-12 of the larger end",
                "Widen it or lower the count.",
            )

    def _finest(self) -> float:
        gaps = self.count - 1
        if self.spacing == "log":
            return (math.log(self.stop) - math.log(self.start)) / gaps
        largest = max(abs(self.start), abs(self.stop))
        return (self.stop / largest - self.start / largest) / gaps if largest > 0.0 else 0.0

    def _refuse(self, rule: str, hint: str) -> NoReturn:
        raise AxisError.of(rule, str(self), hint)

    def __len__(self) -> int:
        """Return the number of values."""
        return self.count

    def __str__(self) -> str:
        """Return the range as it is written in a request, in SI."""
        return f"{self.start!r}:{self.stop!r}:{self.count}" + (":log" if self.spacing == "log" else "")

    def ends(self) -> Array:
        """Return the smallest and the largest value, shape (2,)."""
        return np.array([self.start, self.stop])

    def at(self, places: npt.ArrayLike) -> Array:
        """Return the values at some places, shape of `places`: those of `array`, to the bit."""
        chosen = np.asarray(places, np.intp)
        if self.count <= _MANY:
            return self.array()[chosen]
        # the arithmetic of np.linspace and np.geomspace
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
        If there is none, or they are not finite or not strictly increasing.
    """

    values: tuple[float, ...]

    def __post_init__(self) -> None:
        """Refuse what is not an increasing sequence of finite numbers."""
        object.__setattr__(self, "values", _floats(self.values))
        if not self.values:
            self._refuse("A list must have at least one value", "Give a value.")
        if not all(map(math.isfinite, self.values)):
            self._refuse("The values of a list must be finite", "Leave out nan and inf.")
        if any(after <= before for before, after in zip(self.values, self.values[1:], strict=False)):
            self._refuse(
                "A list must be strictly increasing, because it becomes a coordinate",
                "Sort it and leave out repetitions.",
            )

    def _refuse(self, rule: str, hint: str) -> NoReturn:
        raise AxisError.of(rule, self.values, hint)

    def __len__(self) -> int:
        """Return the number of values."""
        return len(self.values)

    def __str__(self) -> str:
        """Return the list as it is written in a request, in SI."""
        text = ",".join(map(repr, self.values))
        return text if len(self.values) > 1 else text + ","

    def ends(self) -> Array:
        """Return the smallest and the largest value, shape (2,)."""
        return np.array([self.values[0], self.values[-1]])

    def at(self, places: npt.ArrayLike) -> Array:
        """Return the values at some places, shape of `places`."""
        return self.array()[np.asarray(places, np.intp)]

    def array(self) -> Array:
        """Return the values, shape (n,), float64, increasing, in SI."""
        return np.array(self.values)


def _floats(numbers: Iterable[float]) -> tuple[float, ...]:
    try:
        # + 0.0 turns -0.0 into 0.0, so that equal axes also read the same.
        return tuple(float(number) + 0.0 for number in numbers)
    except (TypeError, ValueError, OverflowError) as problem:
        raise RequestError(
            f"An axis holds numbers in SI; got {shown(numbers)}.", "Give numbers."
        ) from problem
