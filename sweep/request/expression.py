"""The tree of a criterion's expression: comparisons of variables and parameters, joined by ``and``, ``or``, ``not``.

``peak_tilt > 10deg or fall_time < 2s`` is two comparisons, `Joined` by ``or``. `sweep.request.expression_text` reads
the text; ``str`` of a tree writes it again, with a unique spelling for each tree.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import pairwise

import numpy as np

from sweep.model.quantity import Array, Quantity, Truths

#: Variables and parameters of cells, float64, NaN where a value is missing.
Values = Mapping[str, Array]
#: The truth of an expression for cells whose values lie between two sets: where it is certainly true, and where it may
#: be true.
Truth = tuple[Truths, Truths]

#: SI units in CF's spelling -> the spelling in expressions.
_SPELLED = {"1": "", "rad s-1": "rad/s", "m s-2": "m/s2"}


@dataclass(frozen=True)
class Number:
    """A number [SI] with its units, or a code of an enumerated quantity with its name."""

    value: float
    units: str = ""
    name: str = ""

    def __str__(self) -> str:
        """Return the name, or the number with a unit, in the shortest form that reads back to the same number."""
        if self.name or self.value == 0.0:
            return self.name or "0"
        if self.units == "rad":
            return spell_angle(self.value)
        return _shortest(self.value) + _SPELLED.get(self.units, self.units)

    def between(self, low: Values, high: Values) -> tuple[Array, Array]:
        """Return its least and its largest value."""
        value = np.asarray(float(self.value))
        return value, value


@dataclass(frozen=True)
class Variable:
    """A variable or parameter of the cells, or its magnitude, multiplied by a pure number."""

    name: str
    factor: float = 1.0
    absolute: bool = False

    def __str__(self) -> str:
        """Return the text of the term: ``tilt``, ``3*tilt``, ``3*abs(tilt)``."""
        name = f"abs({self.name})" if self.absolute else self.name
        return name if self.factor == 1.0 else f"{_shortest(self.factor)}*{name}"

    def between(self, low: Values, high: Values) -> tuple[Array, Array]:
        """Return its least and its largest value in each cell, between two sets of values."""
        least, greatest = low[self.name], high[self.name]
        if self.absolute:
            nearest = np.maximum(0.0, np.maximum(least, -greatest))
            least, greatest = nearest, np.maximum(np.abs(least), np.abs(greatest))
        if self.factor != 1.0:
            # a product that overflows compares as infinity
            with np.errstate(over="ignore"):
                ends = self.factor * least, self.factor * greatest
            least, greatest = ends if self.factor > 0.0 else ends[::-1]
        return least, greatest


Term = Number | Variable
_Ends = tuple[Array, Array]


def _less(one: _Ends, other: _Ends) -> Truth:
    return one[1] < other[0], one[0] < other[1]


def _at_most(one: _Ends, other: _Ends) -> Truth:
    return one[1] <= other[0], one[0] <= other[1]


def _equal(one: _Ends, other: _Ends) -> Truth:
    return (one[0] == other[1]) & (one[1] == other[0]), (one[0] <= other[1]) & (other[0] <= one[1])


def _unequal(one: _Ends, other: _Ends) -> Truth:
    (same, may_be_same), present = _equal(one, other), (one[0] == one[0]) & (other[0] == other[0])
    return present & ~may_be_same, present & ~same


#: Sign -> its comparison. All comparisons with a missing value are false.
SIGNS: Mapping[str, Callable[[_Ends, _Ends], Truth]] = {
    "<=": _at_most,
    ">=": lambda one, other: _at_most(other, one),
    "==": _equal,
    "!=": _unequal,
    "<": _less,
    ">": lambda one, other: _less(other, one),
}


@dataclass(frozen=True)
class Comparison:
    """A chain of terms with signs between them, as in ``1deg < tilt_max <= 5deg``; true if each pair compares true."""

    terms: tuple[Term, ...]
    signs: tuple[str, ...]

    def __str__(self) -> str:
        """Return the text of the expression."""
        rest = zip(self.signs, self.terms[1:], strict=True)
        return f"{self.terms[0]}" + "".join(f" {sign} {term}" for sign, term in rest)

    def truth(self, low: Values, high: Values) -> Truth:
        """Return where it is true, and where it may be; see `Truth`."""
        ends = [term.between(low, high) for term in self.terms]
        found = [SIGNS[sign](*pair) for sign, pair in zip(self.signs, pairwise(ends), strict=True)]
        sure, possible = zip(*found, strict=True)
        return reduce(np.logical_and, sure), reduce(np.logical_and, possible)

    def comparisons(self) -> Iterator["Comparison"]:
        """Yield itself."""
        yield self


@dataclass(frozen=True)
class Not:
    """The negation of an expression."""

    part: "Expression"

    def __str__(self) -> str:
        """Return the text of the expression."""
        return f"not {_in_brackets(self.part, 'and', 'or')}"

    def truth(self, low: Values, high: Values) -> Truth:
        """Return where it is true, and where it may be; see `Truth`."""
        sure, possible = self.part.truth(low, high)
        return ~possible, ~sure

    def comparisons(self) -> Iterator[Comparison]:
        """Yield the comparisons in it."""
        yield from self.part.comparisons()


@dataclass(frozen=True)
class Joined:
    """Expressions joined by ``and`` or by ``or``; made by `joined`."""

    word: str
    parts: tuple["Expression", ...]

    def __str__(self) -> str:
        """Return the text of the expression."""
        # and binds tighter than or
        parts = (_in_brackets(part, "or") if self.word == "and" else str(part) for part in self.parts)
        return f" {self.word} ".join(parts)

    def truth(self, low: Values, high: Values) -> Truth:
        """Return where it is true, and where it may be; see `Truth`."""
        sure, possible = zip(*(part.truth(low, high) for part in self.parts), strict=True)
        join = np.logical_and if self.word == "and" else np.logical_or
        return reduce(join, sure), reduce(join, possible)

    def comparisons(self) -> Iterator[Comparison]:
        """Yield the comparisons in it."""
        for part in self.parts:
            yield from part.comparisons()


Expression = Comparison | Not | Joined


def joined(word: str, parts: Sequence[Expression]) -> Expression:
    """Return expressions joined by a word; ``a and (b and c)`` becomes ``a and b and c``, a single one stays itself."""
    flat: list[Expression] = []
    for part in parts:
        flat += part.parts if isinstance(part, Joined) and part.word == word else [part]
    return flat[0] if len(flat) == 1 else Joined(word, tuple(flat))


def variables(tree: Expression) -> tuple[str, ...]:
    """Return the names of the variables and parameters in an expression, without repetitions, in their order."""
    terms = (term for comparison in tree.comparisons() for term in comparison.terms)
    return tuple(dict.fromkeys(term.name for term in terms if isinstance(term, Variable)))


def spell_angle(angle: float) -> str:
    """Return an angle [rad] with its unit, in a form that reads back to the same double.

    The unit is the degree where this is exact, because people can read 5deg but not 0.08726646259971647rad.
    """
    degrees = f"{round(math.degrees(angle), 9):.15g}"
    return f"{degrees}deg" if math.radians(float(degrees)) == angle else f"{_shortest(angle)}rad"


def spelled(quantity: Quantity, value: float) -> str:
    """Return the value of a variable for a sentence."""
    if math.isnan(value):
        return "missing"
    return quantity.spell(value, 6) if quantity.flags is None else quantity.flag(value)


def _shortest(value: float) -> str:
    return repr(value).removesuffix(".0")


def _in_brackets(part: Expression, *words: str) -> str:
    return f"({part})" if isinstance(part, Joined) and part.word in words else str(part)
