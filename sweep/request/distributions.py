"""Random values of a parameter: ``uniform:2:4``, ``loguniform:0.1:10``, ``normal:1deg:0.2deg``.

A value is a function of the seed, the name of its parameter and the number of its start alone. So the same starts come
out for any blocks, threads and machines of a run, and for any number of starts.
"""

import hashlib
from dataclasses import dataclass
from typing import NoReturn

import numpy as np
import numpy.typing as npt

from sweep.errors import RequestError, shown
from sweep.model.quantity import Array, Input, Quantity
from sweep.request.as_given import as_given, rule_in
from sweep.request.axes import AxisError
from sweep.request.values import NOT_FINITE, read_numbers

UNIFORM, LOGUNIFORM, NORMAL = "uniform", "loguniform", "normal"

#: Each distribution with the words that it is written in.
KINDS = {UNIFORM: "uniform:LOW:HIGH", LOGUNIFORM: "loguniform:LOW:HIGH", NORMAL: "normal:MEAN:DEVIATION"}

#: Nearer to the largest float, and to 0, sums and logarithms overflow.
_LARGEST, _SMALLEST = 1e300, 1e-300

#: Words of 64 bits that a step of Philox yields.
_WORDS = 4

#: Numbers of starts further apart than this are drawn one by one: a jump takes as long as so many words.
_APART = 128

#: Values made at a time, so that all passes over them stay in the cache of the processor.
_AT_ONCE = 2**13


@dataclass(frozen=True)
class Distribution:
    """A distribution of one parameter.

    Parameters
    ----------
    kind : {"uniform", "loguniform", "normal"}
    first, second : float
        The ends, first < second; of a normal distribution mean and standard deviation; in SI.

    Raises
    ------
    RequestError
        If there is no such distribution.
    """

    kind: str
    first: float
    second: float

    def __post_init__(self) -> None:
        """Refuse numbers that no distribution has."""
        if self.kind not in KINDS:
            self._refuse(f"A distribution is {', '.join(KINDS.values())}", "Write one of these.")
        if not max(abs(self.first), abs(self.second)) <= _LARGEST:
            self._refuse(
                "The numbers of a distribution must be finite and below 1e300", "Give numbers below that."
            )
        if self.kind == NORMAL:
            if not self.second > 0.0:
                self._refuse(
                    "The standard deviation of a normal distribution must be greater than 0",
                    "Give mean and standard deviation, as in normal:1deg:0.2deg, or one number for all starts.",
                )
        elif not self.first < self.second:
            self._refuse(
                f"A {self.kind} distribution goes up, low < high",
                "Put the smaller end first, or give one number for all starts.",
            )
        if self.kind == LOGUNIFORM and self.first < _SMALLEST:
            self._refuse(
                "A loguniform distribution must start above 0, at 1e-300 at least", "Start above that."
            )

    def _refuse(self, rule: str, hint: str) -> NoReturn:
        raise AxisError.of(rule, str(self), hint)

    def __str__(self) -> str:
        """Return the distribution as it is written in a request, in SI."""
        return f"{self.kind}:{self.first!r}:{self.second!r}"

    def in_words(self, quantity: Quantity) -> str:
        """Return the distribution as people read it."""
        first, second = (quantity.spell(each, 6) for each in (self.first, self.second))
        return f"normal, {first} +- {second}" if self.kind == NORMAL else f"{self.kind}, {first} to {second}"

    def ends(self) -> Array:
        """Return a low and a high value, shape (2,): the ends, of a normal distribution mean -+ deviation."""
        if self.kind == NORMAL:
            return np.array([self.first - self.second, self.first + self.second])
        return np.array([self.first, self.second])

    def required(self) -> Array:
        """Return the values that the rule of the parameter must allow: the ends, or the mean of a normal one."""
        return self.ends() if self.kind != NORMAL else np.array([self.first])

    def at(self, numbers: npt.NDArray[np.int64], stream: str) -> Array:
        """Return the values of some starts.

        Parameters
        ----------
        numbers : array of int, shape (n,)
            The numbers of the starts, from 0.
        stream : str
            What tells independent sequences apart: the seed and the name of the parameter.

        Returns
        -------
        array, shape (n,)
            In SI.

        Notes
        -----
        Start number i has the i-th 64-bit word of the counter-based generator Philox 4x64-10 (Salmon et al., SC11),
        whose key is the first half of the SHA-256 of `stream`. Its upper 52 bits k say which of 2**52 equal intervals
        of (0, 1) is meant; the value is the quantile of the distribution in the middle, (k + 1/2) / 2**52.
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
        # rounding may lead beyond the ends
        return np.asarray(np.clip(np.exp(low + (high - low) * share), self.first, self.second))


def philox(stream: str, numbers: npt.NDArray[np.int64]) -> npt.NDArray[np.uint64]:
    """Return the words of the sequence of a stream at some places, shape of `numbers`.

    Numbers that follow each other closely are drawn together.
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


def is_distribution(raw: object) -> bool:
    """Return whether what was given for a parameter is a distribution, or text that begins like one."""
    if not isinstance(raw, str):
        return isinstance(raw, Distribution)
    kind, colon, _ = raw.partition(":")
    kind = kind.strip()
    return bool(colon) and kind.replace("-", "").isalpha() and not NOT_FINITE.fullmatch(kind)


def parse_distribution(raw: object, quantity: Quantity) -> Distribution:
    """Return the distribution that was given for a quantity, in its SI units, with any values.

    Raises
    ------
    RequestError
        If it cannot be read.
    """
    try:
        return raw if isinstance(raw, Distribution) else _read_text(str(raw), quantity)
    except AxisError as error:
        raise error.with_given(str(raw).strip()).at(f"{quantity.name}={shown(raw)}") from None
    except RequestError as error:
        raise error.at(f"{quantity.name}={shown(raw)}") from None


def read_distribution(raw: object, quantity: Input, given: object = None) -> Distribution:
    """Return the distribution that was given for a parameter, in its SI units.

    Parameters
    ----------
    raw : str or Distribution
        Such as ``normal:1deg:0.2deg``; bare numbers are SI.
    quantity : Input
        Says which units fit, and which values are allowed.
    given : object, optional
        What a request gave, if `raw` was made of it.

    Raises
    ------
    RequestError
        If it cannot be read, or its ends (of a normal distribution its mean) are not possible.
    """
    where, found = f"{quantity.name}={shown(raw)}", parse_distribution(raw, quantity)
    required = found.required()
    if quantity.allows(required).all():
        return found
    outside = as_given(float(required[~quantity.allows(required)][0]), quantity, given or raw)
    what = "a mean of" if found.kind == NORMAL else "an end of"
    raise RequestError(
        f"The distribution has {what} {outside.text}, which is not possible: {rule_in(quantity, outside.unit)}.",
        hint="Choose values with that rule; a bare number is in SI (radians for an angle).",
        where=where,
    )


def _read_text(text: str, quantity: Quantity) -> Distribution:
    kind, *numbers = (part.strip() for part in text.split(":"))
    if kind not in KINDS or len(numbers) != 2:
        raise RequestError(
            f"{shown(text)} is no distribution. A distribution is {', '.join(KINDS.values())}.",
            hint="Write one of these, as in normal:1deg:0.2deg.",
        )
    return Distribution(kind, *read_numbers(numbers, quantity))
