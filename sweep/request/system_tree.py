"""Expressions of a user's system, built part by part, with constants folded, dimensions checked and sizes limited.

Errors raised here have no position yet: the reader of the text adds the line or the character.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import NoReturn

from sweep.errors import RequestError, counted, shown
from sweep.model.system.definition import FUNCTIONS, Constant, Node, Operation, Symbol
from sweep.model.system.evaluation import operate
from sweep.model.system.spelling import spelled
from sweep.request.suggestions import suggestion
from sweep.request.system_units import ANGLE, PURE, Dimension, alike, product, told, wider

#: Limits of the nesting depth of an expression, of the number of different operations in a system, and of the total
#: number of nodes in its rates with all names expanded: compilers take seconds for more.
MOST_DEEP, MOST_PARTS, MOST_NODES = 64, 300, 20_000

#: Largest size of an exponent: the factors of a power's series are products of the order and the exponent.
MOST_POWER = 1e6

#: Constants that need no import.
NUMBERS: Mapping[str, float] = {"pi": math.pi}

_SMOOTH = {
    "abs": "write an ending with abs, or a smooth form such as sqrt(x**2 + small**2)",
    "min": "write a smooth form such as (a + b - sqrt((a - b)**2 + small**2))/2",
    "max": "write a smooth form such as (a + b + sqrt((a - b)**2 + small**2))/2",
}
_INSTEAD = {
    "pow": "x**2 with a number as exponent",
    "log10": "log(x)/log(10)",
    "log2": "log(x)/log(2)",
    "cbrt": "x**(1/3)",
    "hypot": "sqrt(x**2 + y**2)",
    "square": "x**2",
    "radians": "a parameter with the unit deg",
}
_KINKED = {"fabs": "abs", "minimum": "min", "maximum": "max", "absolute": "abs"}


@dataclass(frozen=True)
class Part:
    """An expression during reading.

    Parameters
    ----------
    node : Node
    dimension : Dimension or None
        None for a number that takes the unit of the other operand.
    deep, nodes : int
        The nesting depth, and the number of nodes with all names expanded.
    """

    node: Node
    dimension: Dimension | None
    deep: int = 0
    nodes: int = 1

    @property
    def value(self) -> float | None:
        """The value of a constant; None for any other expression."""
        return self.node.value if isinstance(self.node, Constant) else None

    def __str__(self) -> str:
        """Return the expression as text for messages."""
        return shown(spelled(self.node)) if self.nodes < MOST_PARTS else "a long expression"


@dataclass
class Tree:
    """A builder of the expressions of one system, in which equal parts are one object.

    Parameters
    ----------
    bare : bool
        Whether a number without a unit takes the SI unit of the other operand, as in criteria; otherwise it is a pure
        number.
    names : dict of str to Part
        The expressions of the names that may be used.
    place : object
        The current position in the text, which `made` reports.
    """

    bare: bool = False
    names: dict[str, Part] = field(default_factory=dict)
    place: object = None
    _made: dict[tuple[object, ...], tuple[Operation, object]] = field(default_factory=dict)

    @property
    def made(self) -> Iterator[tuple[Operation, object]]:
        """The operations, each after its arguments, with the positions of their first occurrence."""
        yield from self._made.values()

    def number(self, value: float, dimension: Dimension | None = None) -> Part:
        """Return a number as an expression; if it has a dimension, the value is in SI units."""
        if not math.isfinite(value):
            raise RequestError(f"every number must be finite; got {value:g}", hint="Write a finite number.")
        # zero fits any unit
        fits_all = dimension is None and (self.bare or value == 0.0)
        return Part(Constant(value), None if fits_all else dimension or PURE)

    def named(self, name: str) -> Part:
        """Return the expression of a name."""
        if name in self.names:
            return self.names[name]
        if name in NUMBERS:
            return self.number(NUMBERS[name])
        if name in FUNCTIONS:
            raise RequestError(f"the function {name} has no argument", hint=f"Write {name}(x).")
        known = ", ".join((*self.names, *NUMBERS))
        raise RequestError(
            f"the name {shown(name)} is not known here; the names are {shown(known)}",
            hint="Write t as the last keyword-only argument: def name(x=0.0, *, t)."
            if name == "t"
            else suggestion(name, (*self.names, *NUMBERS))
            or "Use one of these names, or make it a parameter after *.",
        )

    def called(self, name: str, *arguments: Part) -> Part:
        """Return the call of a function."""
        kinked = _KINKED.get(name, name)
        if kinked in _SMOOTH:
            refuse_kink(f"the function {kinked}", f"{_SMOOTH[kinked][0].upper()}{_SMOOTH[kinked][1:]}.")
        if name not in FUNCTIONS:
            raise RequestError(
                f"the function {shown(name)} is not known here; the functions are {', '.join(FUNCTIONS)}",
                hint=f"Write {_INSTEAD[name]}."
                if name in _INSTEAD
                else "Use these functions, + - * / and **.",
            )
        count = 2 if name == "atan2" else 1
        if len(arguments) != count:
            usual = "atan2(y, x)" if count == 2 else f"{name}(x)"
            raise RequestError(
                f"the function {name} takes {counted(count, 'argument')}; got {len(arguments)}",
                hint="Write log(x)/log(2) for another base." if name == "log" else f"Write {usual}.",
            )
        if name == "atan2":
            return self._angle(*arguments)
        part = arguments[0]
        dimension = part.dimension or PURE
        if name == "sqrt":
            _check_root(part)
            return self._operation(name, product(PURE, dimension, 0.5), part)
        if not alike(dimension, PURE):
            raise RequestError(
                f"the argument of {name} must be a pure number or an angle; {part} is {told(dimension)}",
                hint="Divide it by a parameter with that unit.",
            )
        return _COMPOSED[name](self, part) if name in _COMPOSED else self._operation(name, PURE, part)

    def _angle(self, y: Part, x: Part) -> Part:
        """Return the angle of a point, as an angle."""
        first, second = y.dimension, x.dimension
        if first is not None and second is not None and not alike(first, second):
            raise RequestError(
                f"both arguments of atan2 must have the same unit: {y} is {told(first)}, and {x} is {told(second)}",
                hint="Check the formula and its units.",
            )
        return self._operation("atan2", ANGLE, y, x)

    def negated(self, part: Part) -> Part:
        """Return the negative of an expression."""
        return self._operation("neg", part.dimension, part)

    def summed(self, sign: str, one: Part, two: Part) -> Part:
        """Return a sum, or a difference for the sign ``-``."""
        first, second = one.dimension, two.dimension
        if first is not None and second is not None and not alike(first, second):
            raise RequestError(
                f"quantities with different units cannot be added or compared: {one} is {told(first)}, and {two} is "
                f"{told(second)}",
                hint="Check the formula and its units; a number with a unit must be a parameter.",
            )
        # the other operand decides whether a number is an angle
        if first is None or one.value is not None:
            return self._operation(sign, second or first, one, two)
        if second is None or two.value is not None:
            return self._operation(sign, first, one, two)
        return self._operation(sign, wider(first, second), one, two)

    def multiplied(self, sign: str, one: Part, two: Part) -> Part:
        """Return a product, or a quotient for the sign ``/``."""
        for part in (one, two):
            self._check_factor(part)
        if one.value is not None and two.value is not None:
            return self._operation(sign, None if self.bare else PURE, one, two)
        first, second = (PURE if part.value is not None else part.dimension or PURE for part in (one, two))
        return self._operation(sign, product(first, second, 1.0 if sign == "*" else -1.0), one, two)

    def raised(self, base: Part, exponent: Part) -> Part:
        """Return a power; the exponent must be a number."""
        power = exponent.value
        if power is None:
            raise RequestError(
                f"an exponent must be a number; got {exponent}",
                hint="Write exp(y*log(x)) for x to the power of y.",
            )
        if not abs(power) <= MOST_POWER:
            raise RequestError(
                f"an exponent is at most {MOST_POWER:g} in size; got {power:g}",
                hint="Write exp(a*log(x)) with a parameter a.",
            )
        self._check_factor(base)
        if not alike(exponent.dimension or PURE, PURE):
            raise RequestError(
                f"an exponent must be a pure number; got one {told(exponent.dimension or PURE)}"
            )
        if power != round(power):
            _check_root(base)
        if base.value is not None:
            return self._operation("**", None if self.bare else PURE, base, exponent)
        dimension = base.dimension or PURE
        if any(dimension) and abs(power) > 99:
            raise RequestError(
                f"the power of a quantity with a unit is at most 99; got {power:g}",
                hint="Divide the quantity by its unit first.",
            )
        return self._operation(
            "**", product(PURE, dimension, power) if any(dimension) else PURE, base, exponent
        )

    def _check_factor(self, part: Part) -> None:
        """Refuse a number with a unit in a product, because numbers in the canonical text have no units."""
        if part.value is not None and part.dimension is not None and not alike(part.dimension, PURE):
            raise RequestError(
                f"a number as a factor must not have a unit; got one {told(part.dimension)}",
                hint="Make it a parameter, which may have a unit.",
            )

    def _operation(self, name: str, dimension: Dimension | None, *parts: Part) -> Part:
        numbers = [part.node.value for part in parts if isinstance(part.node, Constant)]
        if len(numbers) == len(parts):
            value = operate(name, *numbers)
            if not math.isfinite(value):
                whole = Operation(name, tuple(part.node for part in parts))
                raise RequestError(
                    f"the number {shown(spelled(whole))} is not finite",
                    hint="Correct these numbers.",
                )
            return Part(Constant(value + 0.0), None if value == 0.0 and dimension == PURE else dimension)
        deep, nodes = 1 + max(part.deep for part in parts), 1 + sum(part.nodes for part in parts)
        key = (name, *(self._key(part.node) for part in parts))
        if key not in self._made:
            self._made[key] = Operation(name, tuple(part.node for part in parts)), self.place
        if deep > MOST_DEEP or nodes > MOST_NODES or len(self._made) > MOST_PARTS:
            refuse_size()
        return Part(self._made[key][0], dimension, deep, nodes)

    @staticmethod
    def _key(node: Node) -> object:
        """Return a key that is equal for equal nodes; equal operations are the same object."""
        return id(node) if isinstance(node, Operation) else node


def _cosh(tree: Tree, x: Part) -> Part:
    half = tree.number(0.5, PURE)
    grows, falls = tree.called("exp", x), tree.called("exp", tree.negated(x))
    return tree.multiplied("*", half, tree.summed("+", grows, falls))


def _sinh(tree: Tree, x: Part) -> Part:
    # unlike the difference of two exponentials, exact near 0
    return tree.multiplied("*", tree.called("tanh", x), _cosh(tree, x))


def _across(tree: Tree, x: Part) -> Part:
    """Return sqrt(1 - x^2), exact near 1."""
    one = tree.number(1.0, PURE)
    return tree.called("sqrt", tree.multiplied("*", tree.summed("-", one, x), tree.summed("+", one, x)))


#: Functions that are composed of others.
_COMPOSED: Mapping[str, Callable[[Tree, Part], Part]] = {
    "sinh": _sinh,
    "cosh": _cosh,
    "atan": lambda tree, x: tree.called("atan2", x, tree.number(1.0, PURE)),
    "asin": lambda tree, x: tree.called("atan2", x, _across(tree, x)),
    "acos": lambda tree, x: tree.called("atan2", _across(tree, x), x),
}


def _check_root(part: Part) -> None:
    """Refuse the root of a square, which is a magnitude."""
    node = part.node
    if not isinstance(node, Operation):
        return
    one, *rest = node.arguments
    power = rest[0].value if node.name == "**" and isinstance(rest[0], Constant) else 0.0
    if (power and power % 2.0 == 0.0) or (node.name == "*" and one is rest[0]):
        refuse_kink(f"the root of {part}", "Write an ending with abs, or sqrt(x**2 + small**2).")


def check_nodes(parts: Iterable[Part]) -> None:
    """Refuse expressions that are too large together."""
    if sum(part.nodes for part in parts) > MOST_NODES:
        refuse_size()


def refuse_size() -> NoReturn:
    """Refuse an expression that is too large."""
    raise RequestError(
        f"this is too large: at most {MOST_DEEP} operations may be nested, and a system has at most {MOST_PARTS} "
        f"different operations and {MOST_NODES} with all names expanded",
        hint="Put brackets around groups of a long sum, or simplify the expression.",
    )


def refuse_kink(what: str, hint: str) -> NoReturn:
    """Refuse an operation that makes a right-hand side not smooth."""
    raise RequestError(
        f"{what} has a kink or a jump, where steps of high order give wrong results", hint=hint
    )


def symbol(name: str, dimension: Dimension) -> Part:
    """Return the expression of a state, a parameter or the time."""
    return Part(Symbol(name), dimension)
