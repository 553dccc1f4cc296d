"""The strings of a user's system: endings, labels, measures, conserved quantities, and the boundary from theory.

::

    comparisons = comparison { "or" comparison } | comparison { "and" comparison }
    comparison  = side ( "<" | ">" ) side
    measure     = ( "max" | "min" | "last" ) side | ( "mean" | "integral" ) sum | "count" comparisons
                | "time" "of" moment | "value" "of" sum "at" moment
    moment      = ( "first" | "last" ) comparisons | ( "max" | "min" ) side
    side        = "abs" "(" sum ")" | sum
    sum         = product { ( "+" | "-" ) product }
    product     = signed { ( "*" | "/" ) signed }
    signed      = ( "+" | "-" ) signed | atom [ "**" signed ]
    atom        = number [ unit ] | NAME | FUNCTION "(" sum { "," sum } ")" | "(" sum ")"

A bare number is in SI, in the units of the quantity that it is added to or compared with, as in a criterion. The text
is never executed.
"""

import math
import re
from collections.abc import Callable
from typing import NamedTuple, NoReturn, TypeVar

from sweep.errors import RequestError, shown
from sweep.model.quantity import DECISION, Quantity
from sweep.model.system.definition import TIME, Measure, Moment, Node, symbols
from sweep.model.system.spelling import spelled, spelled_measure
from sweep.request.expression import SIGNS
from sweep.request.system_tree import MOST_DEEP, NUMBERS, Part, Tree
from sweep.request.system_units import ANGLE, PURE, Dimension, of_result, product, read_dimension, written
from sweep.request.tokens import NUMBER, UNIT, Tokens, refuse
from sweep.request.values import read_number

#: Largest number of characters of a string, both as given and in the system's canonical text.
MOST_CHARACTERS = 2000

#: The first words of measures, and the words of moments.
KINDS, MOMENTS = (
    ("max", "min", "last", "mean", "integral", "count", "time", "value"),
    ("first", "last", "max", "min"),
)

_TOKEN = re.compile(
    rf"""
    (?P<number>{NUMBER})
    (?:\s*(?P<unit>{UNIT}))?
    | (?P<sign>{"|".join(SIGNS)})
    | (?P<word>[A-Za-z_][A-Za-z_0-9]*)
    | (?P<mark>\*\*|[-+*/(),])
    """,
    re.VERBOSE,
)
_INSTEAD = {
    "=": "Write > or <.",
    "^": "Write ** for a power.",
    "&": "Write and.",
    "|": "Write or.",
    "\u2264": "Write <.",
    "\u2265": "Write >.",
    "\u2212": "Write the minus sign as a hyphen.",
    "\u03c0": "Write pi.",
    ",": "Write one expression.",
}
_EXAMPLE = "Write, for instance, abs(angle) > 90deg or x - y > 2."
_WORDS = ("and", "or", "not", "abs")
_Read = TypeVar("_Read")


class _Side(NamedTuple):
    """A side of a comparison, which may be a magnitude; `bare` is the text of a number without a unit."""

    part: Part
    absolute: bool = False
    bare: str = ""


class _Measured(NamedTuple):
    """The parts of a measure; its moment has a kind, expressions, and whether every one has to be positive."""

    kind: str
    value: _Side | None = None
    moment: str = ""
    parts: tuple[Part, ...] = ()
    every: bool = False


class _Parser(Tokens):
    """A parser of a string, with the tree that makes its expressions."""

    def __init__(self, text: str, tree: Tree) -> None:
        super().__init__(text, _TOKEN, _INSTEAD, _EXAMPLE)
        self._tree, self._nested = tree, 0

    def whole(
        self, read: Callable[["_Parser"], _Read], wanted: str = "the end or one of + - * / **"
    ) -> _Read:
        """Read the whole text."""
        found = read(self)
        if self.peek() is not None:
            self.unexpected(wanted)
        return found

    def comparisons(self, word: str, otherwise: str) -> tuple[Part, ...]:
        """Return the expressions that are positive where comparisons, joined by one word, are true.

        The word is ``or`` or ``and``; the other word is refused with the hint `otherwise`.
        """
        found = [*self._comparison(word)]
        while self.takes(word):
            found += self._comparison(word)
        token = self.peek()
        if token is not None and token.text in ("and", "or"):
            refuse(f"{token.text} is not allowed here, only {word}", token.at, otherwise)
        return tuple(found)

    def condition(self) -> tuple[tuple[Part, ...], bool]:
        """Return the expressions of a condition, and whether every one has to be positive or any of them."""
        words = [token.text for token in self._tokens[self.next :]]
        word = next((each for each in ("and", "or") if each in words), "")
        parts = self.comparisons(word, "Measure each condition separately.")
        # abs(x) < 2 has two comparisons that are both true
        both = not word and len(parts) > 1 and (words[0] == "abs") == ("<" in words)
        return parts, word == "and" or both

    def measure(self) -> _Measured:
        """Read a measure."""
        kind = self._word(KINDS)
        if kind in ("max", "min", "last"):
            return _Measured(kind, self.side())
        if kind in ("mean", "integral"):
            return _Measured(kind, _Side(self.sum()))
        if kind == "count":
            return _Measured(kind, None, "last", *self.condition())
        self.expect("of")
        value = None
        if kind == "value":
            value = _Side(self.sum())
            self.expect("at")
        moment = self._word(MOMENTS)
        if moment in ("first", "last"):
            return _Measured(kind, value, moment, *self.condition())
        return _Measured(kind, value, moment, _parts_of(self._tree, self.side(), moment))

    def _word(self, words: tuple[str, ...]) -> str:
        token = self.peek()
        if token is None or token.text not in words:
            self.unexpected(f"one of {', '.join(words)}")
        self.next += 1
        return token.text

    def _comparison(self, word: str) -> tuple[Part, ...]:
        if (token := self.peek()) is not None and token.text == "not":
            refuse("not is not allowed here", token.at, "Reverse the comparison: x > 2 instead of not x < 2.")
        first, token = self.side(), self.peek()
        if token is None or token.kind != "sign":
            self.unexpected("a comparison, > or <")
        if token.text not in (">", "<"):
            refuse(f"a comparison must be > or <; got {token.text}", token.at, "Write > or <.")
        self.next += 1
        second = self.side()
        if (more := self.peek()) is not None and more.kind == "sign":
            refuse("a comparison has two sides", more.at, "Write 1 < x and x < 2, or two endings.")
        greater, less = (first, second) if token.text == ">" else (second, first)
        return self._locate_errors(token.at, lambda: self._positive(greater, less, word))

    def _positive(self, greater: _Side, less: _Side, word: str) -> tuple[Part, ...]:
        """Return the expressions that are positive where one side is greater than the other."""
        tree = self._tree
        for one, other in ((greater, less), (less, greater)):
            # more than a turn: the user probably meant degrees
            if one.bare and other.part.dimension == ANGLE and (one.part.value or 0.0) >= math.tau:
                raise RequestError(
                    f"a bare number is in rad, and {one.bare} rad is more than a turn",
                    hint=f"Write {one.bare}deg, or {one.bare}rad if you mean radians.",
                )
        if greater.absolute and less.absolute:
            raise RequestError("abs is allowed only on one side", hint="Write x**2 > y**2.")
        if greater.absolute and word == "and":
            # |x| > c as one comparison: (x - c)*(x + c) > 0
            if less.part.value is None or less.part.value < 0.0:
                raise RequestError(
                    f"with and, abs({greater.part}) can only be compared with a number above 0; got {less.part}",
                    hint="Write x**2 > y**2.",
                )
            factors = (tree.summed(sign, greater.part, less.part) for sign in "-+")
            return (tree.multiplied("*", *factors),)
        if less.absolute and word == "or":
            squares = f"({less.part})**2 < ({greater.part})**2"
            raise RequestError(
                "abs(...) below a limit needs two comparisons joined by and, which an ending does not allow",
                hint=f"Write squares instead: {squares}.",
            )
        if greater.absolute:
            return self._difference(greater.part, less.part), self._difference(
                tree.negated(greater.part), less.part
            )
        if less.absolute:
            return self._difference(greater.part, less.part), self._difference(
                greater.part, tree.negated(less.part)
            )
        return (self._difference(greater.part, less.part),)

    def _difference(self, greater: Part, less: Part) -> Part:
        """Return an expression that is positive where one expression is greater than another."""
        found = self._tree.summed("-", greater, less)
        if less.value == 0.0:
            return greater
        return self._tree.negated(less) if greater.value == 0.0 else found

    def side(self) -> _Side:
        """Read an expression, or the magnitude of one."""
        at, begun, token = self.at(), self.next, self.peek()
        if token is None or token.text != "abs":
            part = self.sum()
            bare = token is not None and not token.unit and self.next == begun + 1
            return _Side(part, bare=token.number if token is not None and bare else "")
        self.next += 1
        self.expect("(")
        part = self.sum()
        self.expect(")")
        after = self.peek()
        if after is not None and after.kind == "mark" and after.text != ")":
            self._refuse_abs(at)
        return _Side(part, absolute=True)

    def sum(self) -> Part:
        """Read a sum."""
        return self._chain("+-", self._product, self._tree.summed)

    def _product(self) -> Part:
        return self._chain("*/", self._signed, self._tree.multiplied)

    def _chain(self, signs: str, read: Callable[[], Part], join: Callable[[str, Part, Part], Part]) -> Part:
        found = read()
        while (token := self.peek()) is not None and token.kind == "mark" and token.text in signs:
            self.next += 1
            one, two, sign = found, read(), token.text
            found = self._locate_errors(token.at, lambda one=one, two=two, sign=sign: join(sign, one, two))  # type: ignore[misc]
        return found

    def _signed(self) -> Part:
        self._nested += 1
        if self._nested > MOST_DEEP:
            refuse(
                f"at most {MOST_DEEP} brackets, signs and functions may be nested",
                self.at(),
                _EXAMPLE,
            )
        if self.takes("+"):
            found = self._signed()
        elif self.takes("-"):
            found = self._tree.negated(self._signed())
        else:
            found = self._atom()
            at = self.at()
            if self.takes("**"):
                base, exponent = found, self._signed()
                found = self._locate_errors(at, lambda: self._tree.raised(base, exponent))
        self._nested -= 1
        return found

    def _atom(self) -> Part:
        token = self.peek()
        if token is None or (token.kind not in ("number", "word") and token.text != "("):
            self.unexpected("a number, a name or a bracket")
        self.next += 1
        if token.text == "(":
            found = self.sum()
            self.expect(")")
            return found
        if token.kind == "number":
            return self._locate_errors(token.at, lambda: _number(self._tree, token.number, token.unit))
        if token.text == "abs":
            self._refuse_abs(token.at)
        if token.text in _WORDS:
            self.next -= 1
            self.unexpected("a number, a name or a bracket")
        if not self.takes("("):
            return self._locate_errors(token.at, lambda: self._tree.named(token.text))
        if token.text in self._tree.names or token.text in NUMBERS:
            refuse(
                f"{shown(token.text)} is not a function", token.at, f"Write {token.text}*(...) for a product."
            )
        # an unclosed bracket is refused first, then errors in the argument, then an unknown function
        arguments = [self.sum() if self.peek() is not None else self._refuse_unclosed()]
        while self.takes(","):
            arguments.append(self.sum())
        self.expect(")")
        return self._locate_errors(token.at, lambda: self._tree.called(token.text, *arguments))

    def _refuse_unclosed(self) -> NoReturn:
        self.unexpected("an expression")

    def _locate_errors(self, at: int, make: Callable[[], _Read]) -> _Read:
        """Return the result of `make`, and add the position of a character to its error."""
        try:
            return make()
        except RequestError as error:
            refuse(error.message, at, error.hint)

    def _refuse_abs(self, at: int) -> NoReturn:
        refuse(
            "abs must be a whole side of a comparison, or follow max",
            at,
            "Write, for instance, abs(x) > 2 or max abs(x).",
        )


def _number(tree: Tree, number: str, unit: str) -> Part:
    if not unit:
        return tree.number(float(number))
    try:
        dimension = read_dimension(unit)
    except RequestError as error:
        name = re.match(r"\w+", unit)
        if name is not None and name[0] in (*tree.names, *NUMBERS):
            raise RequestError(f"the unit {unit} is not known", hint=f"Write {number}*{unit}.") from None
        if len(re.split(r"[\s*/]", unit)) > 1:
            raise RequestError(error.message, hint=f"Use brackets: ({number} unit)/x. {error.hint}") from None
        raise
    units = written(dimension)
    if units is None:
        raise RequestError(
            f"the unit {shown(unit)!r} has too large a power", hint="Write a unit such as m/s2."
        )
    quantity = Quantity("a number", "", units, "", DECISION)
    return tree.number(read_number(f"{number} {unit}", quantity), dimension)


def _read[Read](text: str, tree: Tree, read: Callable[[_Parser], Read]) -> Read:
    if len(text) > MOST_CHARACTERS:
        raise RequestError(
            f"A string of a system has at most {MOST_CHARACTERS} characters; got {len(text)}.",
            hint="Write a shorter string.",
        )
    return _Parser(text, tree).whole(read)


def _check_length(nodes: tuple[Node, ...]) -> tuple[Node, ...]:
    # files hold the canonical spelling, and it must be readable again
    if sum(len(spelled(node)) + len(" > 0 and ") for node in nodes) > MOST_CHARACTERS:
        raise RequestError(
            "This string is too long with all its numbers written out.", hint="Write a shorter string."
        )
    return nodes


def _check_moving(parts: tuple[Part, ...], states: tuple[str, ...]) -> tuple[Node, ...]:
    """Return the nodes of expressions; refuse an expression that is constant along a motion."""
    for part in parts:
        if not set(symbols(part.node)) & {*states, TIME}:
            raise RequestError(
                f"the value of {part} is constant along a motion",
                hint=f"Name a state: {', '.join(states)}.",
            )
    return _check_length(tuple(part.node for part in parts))


def read_ending(text: str, tree: Tree, states: tuple[str, ...]) -> tuple[Node, ...]:
    """Return the expressions of an ending: a motion ends when one of them becomes positive.

    Parameters
    ----------
    text : str
    tree : Tree
        The tree that makes the expressions; its `names` are the names allowed in the text.
    states : tuple of str
        The names of the states.

    Raises
    ------
    RequestError
        If the text does not follow the grammar of this module, or compares quantities with different units.
    """
    otherwise = "Write two endings: the first one to happen ends the motion."
    return _check_moving(_read(text, tree, lambda parser: parser.comparisons("or", otherwise)), states)


def read_label(text: str, tree: Tree, states: tuple[str, ...]) -> tuple[Node, ...]:
    """Return the expressions of a label, which are all positive where it applies; see `read_ending`."""
    otherwise = "Write a label for each case: the first matching label applies."
    return _check_moving(_read(text, tree, lambda parser: parser.comparisons("and", otherwise)), states)


def read_measure(name: str, text: str, tree: Tree, states: tuple[str, ...]) -> Measure:
    """Return a measure; see `read_ending`."""
    first, *rest = text.split() or [""]
    instead = ""
    if first in MOMENTS and rest[:2] == ["time", "of"]:
        instead = " ".join(["time of", first, *rest[2:]])
    elif first not in KINDS and "at" in rest:
        instead = f"value of {text.strip()}"
    if instead or first not in KINDS or not rest:
        example = "max abs(angle), last x - y, mean x, count x > 2 or time of first x > 2"
        raise RequestError(
            f"A measure is one of {', '.join(KINDS)}, followed by an expression; got {shown(text)!r}.",
            hint=f"Write {shown(instead)}." if instead else f"Write, for instance, {example}.",
        )
    read = _read(text, tree, lambda parser: parser.measure())
    time = tree.names[TIME].dimension or PURE
    dimension: Dimension = time if read.kind == "time" else PURE
    nodes: tuple[Node, ...] = ()
    if read.value is not None:
        parts = _parts_of(tree, read.value, read.kind)
        nodes = (*_check_moving(parts[:1], states), *(part.node for part in parts[1:]))
        dimension = product(read.value.part.dimension or PURE, time, 1.0 if read.kind == "integral" else 0.0)
    moment = Moment(read.moment, _check_moving(read.parts, states), read.every) if read.moment else None
    units = written(of_result(dimension))
    if units is None:
        raise RequestError(
            "The unit of this measure has a fractional or too large power.", hint="Raise it to a whole power."
        )
    return Measure(name, units, read.kind, nodes, spelled_measure(read.kind, nodes, moment), moment)


def _parts_of(tree: Tree, side: _Side, kind: str) -> tuple[Part, ...]:
    """Return the expressions whose greatest or other value is measured: two for a magnitude."""
    if side.absolute and kind != "max":
        raise RequestError(
            "abs is allowed only after max", hint="Write max abs(x), or the expression without abs."
        )
    return (side.part, tree.negated(side.part)) if side.absolute else (side.part,)


def read_conserved(text: str, tree: Tree, states: tuple[str, ...]) -> Node:
    """Return the expression of a conserved quantity; see `read_ending`."""
    return _check_moving((_read(text, tree, lambda parser: parser.sum()),), states)[0]


def read_theory(text: str, tree: Tree, wanted: Part) -> Node:
    """Return the expression for the boundary along a parameter, in the parameter's units; see `read_ending`."""
    part = _read(text, tree, lambda parser: parser.sum())
    # this refuses another unit
    tree.summed("-", wanted, part)
    return _check_length((part.node,))[0]
