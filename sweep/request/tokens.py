"""Tokens of a text in the language of criteria and of a system's strings, for the parsers.

The pattern of a token has the groups ``number``, ``unit``, ``sign``, ``word`` and ``mark``.
"""

import re
from collections.abc import Iterator, Mapping
from typing import NamedTuple, NoReturn

from sweep.errors import RequestError, shown

#: A number without a sign.
NUMBER = r"(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"

#: One factor of a unit with a small power, as in `sweep.request.units`; and, or, not and at are not units.
_FACTOR = r"(?!(?:and|or|not|at)\b)(?:[^\W\d]\w*|[\u00b0%])(?:(?:\*\*|\^)[+-]?[0-9]{1,2}|[+-][0-9]{1,2})?"
#: The unit after a number.
UNIT = rf"{_FACTOR}(?:(?:\s?[*/]\s?|\s){_FACTOR}){{0,9}}"


class Token(NamedTuple):
    """A token: its `kind` is a group of the pattern, `at` the number of characters before it."""

    kind: str
    text: str
    at: int
    number: str = ""
    unit: str = ""


class Tokens:
    """The tokens of a text, with the index of the next one.

    Parameters
    ----------
    text : str
    pattern : re.Pattern
        The pattern of one token.
    instead : mapping of str to str
        Characters of other languages -> a hint with the notation used here.
    example : str
        The default hint of refusals.
    """

    def __init__(self, text: str, pattern: re.Pattern[str], instead: Mapping[str, str], example: str) -> None:
        self._length, self._example = len(text), example
        self._tokens, self.next = list(_tokens(text, pattern, instead, example)), 0

    def takes(self, text: str) -> bool:
        """Skip the next token if it has this text, and return whether it has."""
        token = self.peek()
        here = token is not None and token.text == text
        self.next += here
        return here

    def expect(self, text: str) -> None:
        """Skip the next token; refuse it if it has another text."""
        if not self.takes(text):
            self.unexpected(text)

    def peek(self) -> Token | None:
        """Return the next token; None at the end."""
        return self._tokens[self.next] if self.next < len(self._tokens) else None

    def at(self) -> int:
        """Return the number of characters before the next token."""
        token = self.peek()
        return self._length if token is None else token.at

    def unexpected(self, wanted: str) -> NoReturn:
        """Refuse the next token, because something else is expected."""
        token = self.peek()
        text = "the end" if token is None else shown(token.text)
        refuse(f"expected {wanted}; got {text}", self.at(), self._example)


def _tokens(text: str, pattern: re.Pattern[str], instead: Mapping[str, str], example: str) -> Iterator[Token]:
    at = 0
    while at < len(text):
        if text[at].isspace():
            at += 1
            continue
        found = pattern.match(text, at)
        if found is None:
            refuse(f"{shown(text[at])} is not allowed in an expression", at, instead.get(text[at], example))
        number, unit = found["number"] or "", found["unit"] or ""
        kind = "number" if number else str(found.lastgroup)
        yield Token(kind, found[0], at, number, unit)
        at = found.end()


def refuse(problem: str, at: int, hint: str) -> NoReturn:
    """Refuse a text at a position, given by the number of characters before it."""
    raise RequestError(f"At character {at + 1}: {problem}.", hint=hint)
