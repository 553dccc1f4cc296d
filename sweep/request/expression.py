"""The tree of a criterion of one's own: comparisons of variables and parameters, joined by ``and``, ``or``, ``not``.

``peak_tilt > 10deg or fall_time < 2s`` is an `AnyOf` two comparisons. `sweep.request.expression_text` reads the text;
``str`` of a tree is the text again, in one spelling for each tree.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import reduce
from itertools import pairwise

import numpy as np

from sweep.model.quantity import Array, Quantity, Truths

#: Variables and parameters of cells, float64, NaN where a value is missing.
Values = Mapping[str, Array]
#: Of an expression over cells that are known to lie between two sets of values: where it is true in any case, and where
#: it may be true.
Truth = tuple[Truths, Truths]

#: SI units as CF spells them -> as they are written here.
_SPELLED = {"1": "", "rad s-1": "rad/s", "m s-2": "m/s2"}


@dataclass(frozen=True)
class Number:
    """A number [SI] of a quantity with these units."""

    value: float
    units: str

    def __str__(self) -> str:
        """Return it with a unit, in the shortest form that reads back to the same number."""
        if self.value == 0.0:
            return "0"
        if self.units == "rad":
            return spell_angle(self.value)
        return _shortest(self.value) + _SPELLED.get(self.units, self.units)

    def between(self, low: Values, high: Values) -> tuple[Array, Array]:
        """Return its least and its largest value."""
        value = np.asarray(self.value)
        return value, value


@dataclass(frozen=True)
class Variable:
    """A variable or parameter of the cells, or its magnitude, times a pure number."""

    name: str
    factor: float = 1.0
    absolute: bool = False

    def __str__(self) -> str:
        """Return it as it is written: ``tilt``, ``3*tilt``, ``3*abs(tilt)``."""
        name = f"abs({self.name})" if self.absolute else self.name
        return name if self.factor == 1.0 else f"{_shortest(self.factor)}*{name}"

    def between(self, low: Values, high: Values) -> tuple[Array, Array]:
        """Return its least and its largest value in each cell, between two sets of values."""
        least, greatest = low[self.name], high[self.name]
        if self.absolute:
            nearest = np.maximum(0.0, np.maximum(least, -greatest))
            least, greatest = nearest, np.maximum(np.abs(least), np.abs(greatest))
        if self.factor != 1.0:
            # a product beyond all numbers compares as infinity
            with np.errstate(over="ignore"):
                ends = self.factor * least, self.factor * greatest
            least, greatest = ends if self.factor > 0.0 else ends[::-1]
        return least, greatest


@dataclass(frozen=True)
class Flag:
    """The name of one code of an enumerated variable."""

    name: str
    code: int

    def __str__(self) -> str:
        """Return the name."""
        return self.name

    def between(self, low: Values, high: Values) -> tuple[Array, Array]:
        """Return its code, twice."""
        code = np.asarray(float(self.code))
        return code, code


Term = Number | Variable | Flag
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


#: Each sign with its comparison. All are false of a value that is missing.
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
    """Terms with a sign between each two of them, as in ``1deg < tilt_max <= 5deg``: true if all of these hold."""

    terms: tuple[Term, ...]
    signs: tuple[str, ...]

    def __str__(self) -> str:
        """Return it as it is written."""
        rest = zip(self.signs, self.terms[1:], strict=True)
        return f"{self.terms[0]}" + "".join(f" {sign} {term}" for sign, term in rest)

    def truth(self, low: Values, high: Values) -> Truth:
        """Return where it is true, and where it may be; see `Truth`."""
        ends = [term.between(low, high) for term in self.terms]
        found = [SIGNS[sign](*pair) for sign, pair in zip(self.signs, pairwise(ends), strict=True)]
        return _all(found)

    def comparisons(self) -> Iterator["Comparison"]:
        """Yield itself."""
        yield self


@dataclass(frozen=True)
class Not:
    """True where something else is false."""

    part: "Expression"

    def __str__(self) -> str:
        """Return it as it is written."""
        return f"not {_in_brackets(self.part, AllOf, AnyOf)}"

    def truth(self, low: Values, high: Values) -> Truth:
        """Return where it is true, and where it may be; see `Truth`."""
        sure, possible = self.part.truth(low, high)
        return ~possible, ~sure

    def comparisons(self) -> Iterator[Comparison]:
        """Yield the comparisons in it."""
        yield from self.part.comparisons()


@dataclass(frozen=True)
class _Joined:
    """Two parts or more; none of them is of the same class: ``a and (b and c)`` is ``a and b and c``."""

    parts: tuple["Expression", ...]

    def comparisons(self) -> Iterator[Comparison]:
        """Yield the comparisons in it."""
        for part in self.parts:
            yield from part.comparisons()


class AllOf(_Joined):
    """True where all of its parts are."""

    def __str__(self) -> str:
        """Return it as it is written."""
        return " and ".join(_in_brackets(part, AnyOf) for part in self.parts)

    def truth(self, low: Values, high: Values) -> Truth:
        """Return where it is true, and where it may be; see `Truth`."""
        return _all([part.truth(low, high) for part in self.parts])


class AnyOf(_Joined):
    """True where one of its parts is."""

    def __str__(self) -> str:
        """Return it as it is written."""
        return " or ".join(map(str, self.parts))

    def truth(self, low: Values, high: Values) -> Truth:
        """Return where it is true, and where it may be; see `Truth`."""
        sure, possible = zip(*(part.truth(low, high) for part in self.parts), strict=True)
        return reduce(np.logical_or, sure), reduce(np.logical_or, possible)


Expression = Comparison | Not | AllOf | AnyOf


def variables(tree: Expression) -> tuple[str, ...]:
    """Return the names of the variables and parameters in an expression, each once, in their order."""
    terms = (term for comparison in tree.comparisons() for term in comparison.terms)
    return tuple(dict.fromkeys(term.name for term in terms if isinstance(term, Variable)))


def spell_angle(angle: float) -> str:
    """Return an angle [rad] with its unit, so that it reads back to the same double.

    Degrees where they say exactly the same angle, because 5deg can be read and 0.08726646259971647rad cannot.
    """
    degrees = f"{round(math.degrees(angle), 9):.15g}"
    return f"{degrees}deg" if math.radians(float(degrees)) == angle else f"{_shortest(angle)}rad"


def spelled(quantity: Quantity, value: float) -> str:
    """Return the value of a variable as a sentence says it."""
    if math.isnan(value):
        return "missing"
    return quantity.spell(value, 6) if quantity.flags is None else quantity.flag(value)


def _shortest(value: float) -> str:
    return repr(value).removesuffix(".0")


def _all(truths: list[Truth]) -> Truth:
    sure, possible = zip(*truths, strict=True)
    return reduce(np.logical_and, sure), reduce(np.logical_and, possible)


def _in_brackets(part: Expression, *kinds: type) -> str:
    return f"({part})" if isinstance(part, kinds) else str(part)
