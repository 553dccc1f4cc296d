"""Parse the text of a criterion's expression into its tree, with one function for each rule of the grammar.

::

    any        = all { "or" all }
    all        = each { "and" each }
    each       = "not" each | "(" any ")" | comparison
    comparison = term sign term { sign term }
    sign       = "<" | "<=" | ">" | ">=" | "==" | "!="
    term       = number [ unit ] | [ number "*" ] ( NAME | "abs" "(" NAME ")" ) | FLAG

NAME is a variable or a parameter of the cells, FLAG the name of a code of the variable on the other side. The text is
never executed.
"""

import difflib
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple, NoReturn

from sweep.errors import RequestError, shown
from sweep.model.quantity import Quantity
from sweep.request.expression import (
    SIGNS,
    Comparison,
    Expression,
    Not,
    Number,
    Term,
    Variable,
    joined,
)
from sweep.request.tokens import NUMBER, UNIT, Token, Tokens, refuse
from sweep.request.values import read_number

#: Largest number of characters of a text, and of brackets and words ``not`` around a comparison.
MOST_CHARACTERS, MOST_NESTED = 1000, 20

_KEYWORDS = ("and", "or", "not", "abs")

_TOKEN = re.compile(
    rf"""
    (?P<number>[+-]?{NUMBER})
    (?:\s*(?P<unit>{UNIT}))?
    | (?P<sign>{"|".join(SIGNS)})
    | (?P<word>[A-Za-z_][A-Za-z_0-9]*)
    | (?P<mark>[()*])
    """,
    re.VERBOSE,
)

#: Signs of other languages and of printed text -> a hint with the sign used here.
_INSTEAD = {
    "=": "Write == for equality.",
    "&": "Write and.",
    "|": "Write or.",
    "!": "Write not, or != for inequality.",
    "\u2264": "Write <=.",
    "\u2265": "Write >=.",
    "\u2260": "Write !=.",
    "\u2212": "Write the minus sign as a hyphen, as in -1deg.",
} | dict.fromkeys("+-/", "The only arithmetic is the product of a number and a name, as in 3*tilt.")

_NAME = "the name of a variable or a parameter"
_EXAMPLE = "Write, for instance, peak_tilt > 10deg or fall_time < 2s."


class _Raw(NamedTuple):
    """A term before its quantity is known: a number, or a name with its factor."""

    token: Token
    name: str = ""
    factor: float = 1.0
    absolute: bool = False

    @property
    def bare(self) -> bool:
        """Whether it is only a name, without factor or ``abs``."""
        return bool(self.name) and self.factor == 1.0 and not self.absolute


def read_expression(text: str, quantities: Mapping[str, Quantity]) -> Expression:
    """Return the tree of an expression.

    Parameters
    ----------
    text : str
    quantities : mapping of str to Quantity
        The variables and parameters that it may name.

    Raises
    ------
    RequestError
        If the text does not follow the grammar of this module, names something that is not in `quantities`, compares
        quantities with different units, or is too long. The message gives the position of the character.
    """
    _check_length(text)
    tree = _Parser(text, quantities).whole()
    # files hold this spelling, and it must be readable again
    _check_length(str(tree))
    return tree


def _check_length(text: str) -> None:
    if len(text) > MOST_CHARACTERS:
        raise RequestError(
            f"An expression has at most {MOST_CHARACTERS} characters, including spaces and units; got {len(text)}.",
            hint="Write a shorter expression, or classify in Python with reclassify(atlas, function).",
        )


class _Parser(Tokens):
    """A parser of criteria."""

    def __init__(self, text: str, quantities: Mapping[str, Quantity]) -> None:
        super().__init__(text, _TOKEN, _INSTEAD, _EXAMPLE)
        self._quantities = quantities

    def whole(self) -> Expression:
        """Read the whole text."""
        tree = self._read_joined("or", 0)
        if self.peek() is not None:
            self.unexpected("the end, or one of and, or, <, <=, >, >=, ==, !=")
        return tree

    def _read_joined(self, word: str, nested: int) -> Expression:
        """Read expressions joined by a word; parts of an ``or`` may be joined by ``and``."""
        parts: list[Expression] = []
        while not parts or self.takes(word):
            parts.append(self._read_joined("and", nested) if word == "or" else self._read_operand(nested))
        return joined(word, parts)

    def _read_operand(self, nested: int) -> Expression:
        if nested > MOST_NESTED:
            refuse(f"a comparison is nested in at most {MOST_NESTED} brackets and nots", self.at(), _EXAMPLE)
        if self.takes("not"):
            return Not(self._read_operand(nested + 1))
        if self.takes("("):
            found = self._read_joined("or", nested + 1)
            self.expect(")")
            return found
        return self._read_comparison()

    def _read_comparison(self) -> Expression:
        raws, signs = [self._read_term()], list[str]()
        while (token := self.peek()) is not None and token.kind == "sign":
            self.next += 1
            signs.append(token.text)
            raws.append(self._read_term())
        if not signs:
            self.unexpected("a comparison: one of <, <=, >, >=, ==, !=")
        return Comparison(self._resolve_terms(raws, signs), tuple(signs))

    def _read_term(self) -> _Raw:
        token = self.peek()
        if token is not None and token.kind == "number":
            self.next += 1
            return self._read_name(_factor(token)) if self.takes("*") else _Raw(token)
        return self._read_name(1.0, "a number or a name")

    def _read_name(self, factor: float, wanted: str = _NAME) -> _Raw:
        """Read a name, or ``abs`` of a name."""
        absolute = self.takes("abs")
        if absolute:
            self.expect("(")
            wanted = _NAME
        token = self.peek()
        if token is None or token.kind != "word" or token.text in _KEYWORDS:
            self.unexpected(wanted)
        self.next += 1
        if absolute:
            self.expect(")")
        return _Raw(token, token.text, factor, absolute)

    def _resolve_terms(self, raws: Sequence[_Raw], signs: Sequence[str]) -> tuple[Term, ...]:
        """Return the terms of a comparison, with numbers in the units of the named quantities."""
        known = [raw for raw in raws if raw.name in self._quantities]
        if flagged := [raw for raw in known if self._quantities[raw.name].flags is not None]:
            return self._resolve_flags(raws, signs, flagged[0])
        for raw in raws:
            if raw.name and raw not in known:
                _refuse_name(raw, raw.name, self._quantities)
        if not known:
            refuse("a comparison names at least one variable or parameter", raws[0].token.at, _EXAMPLE)
        quantity = self._quantities[known[0].name]
        for raw in known:
            other = self._quantities[raw.name]
            if other.units != quantity.units:
                refuse(
                    f"quantities with different units cannot be compared: {quantity.name} is in {quantity.units} and "
                    f"{other.name} in {other.units}",
                    raw.token.at,
                    f"Compare {other.name} with numbers and quantities in {other.units}.",
                )
        return tuple(
            Variable(raw.name, raw.factor, raw.absolute) if raw.name else _read_number_in(raw.token, quantity)
            for raw in raws
        )

    def _resolve_flags(self, raws: Sequence[_Raw], signs: Sequence[str], flagged: _Raw) -> tuple[Term, ...]:
        """Return a variable and the name of one of its codes."""
        quantity = self._quantities[flagged.name]
        codes = {name: code for code, name in (quantity.flags or {}).items()}
        others = [raw for raw in raws if raw is not flagged]
        if len(raws) != 2 or signs[0] not in ("==", "!=") or not flagged.bare or not others[0].bare:
            refuse(
                f"{flagged.name} can only be compared by == or != with one of {', '.join(codes)}",
                flagged.token.at,
                f"Write {flagged.name} == and one of these names.",
            )
        if others[0].name not in codes:
            _refuse_name(others[0], f"{flagged.name} == {others[0].name}", codes)
        flag = Number(codes[others[0].name], name=others[0].name)
        return tuple(Variable(raw.name) if raw is flagged else flag for raw in raws)


def _factor(token: Token) -> float:
    factor = float(token.number) + 0.0
    if token.unit or not math.isfinite(factor):
        refuse(f"a factor is a finite number without a unit; got {shown(token.text)}", token.at, _EXAMPLE)
    return factor


def _read_number_in(token: Token, quantity: Quantity) -> Number:
    """Return a number in the SI units of a quantity."""
    try:
        value = read_number(f"{token.number} {token.unit}".strip(), quantity)
    except RequestError as error:
        raise RequestError(f"At character {token.at + 1}: {error.message}", hint=error.hint) from None
    # no tilt is this large: the user meant degrees, not radians
    if quantity.units == "rad" and not token.unit and abs(value) >= math.pi:
        refuse(
            f"a bare number is in rad, and {quantity.name} is below 180 deg; got {shown(token.text)}",
            token.at,
            f"Write {token.text}deg.",
        )
    return Number(value, quantity.units)


def _refuse_name(raw: _Raw, given: str, known: Iterable[str]) -> NoReturn:
    names = tuple(known)
    close = difflib.get_close_matches(raw.name.lower(), names, n=1)
    refuse(
        f"{shown(given)} is not a known name; the names are {', '.join(names)}",
        raw.token.at,
        f"Did you mean {close[0]}?" if close else "Use one of these names.",
    )
