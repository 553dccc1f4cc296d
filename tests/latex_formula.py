r"""Formulas of a page, evaluated as printed: a reader of the LaTeX in docs/theory.md.

`Page` finds them: each is displayed below a comment with its name.

A line such as ``\dot\psi^2 > \frac{g}{R}`` has sides with relations between them; each side becomes a function of the
values of its symbols. Symbols are named as printed: ``\dot\psi`` is "dot psi", ``\theta_0`` is "theta_0", ``V''`` is
"V''", ``\frac{ds}{d\theta}`` is "ds/dtheta", ``\frac{d^2 s}{du^2}`` is "d2s/du2". Adjacent factors are multiplied, and
only one factor may follow ``/``, so that a formula is read as a person reads it.
"""

import math
import re
from collections.abc import Callable, Container, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mpmath

Values = Mapping[str, Any]
Side = Callable[[Values], Any]

_TOKEN = re.compile(r"\\operatorname\{\w+\}|\\[a-zA-Z]+|\\[,;!:| ]|\d+(?:\.\d+)?|[a-zA-Z]|\S")
_NAMED = re.compile(r"<!-- formula: ([\w-]+) -->\n\$\$\n(.*?)\n\$\$\n", re.S)
#: Signs that make a formula a statement.
_STATES = re.compile(r"=|<|>|\\leq?\b|\\geq?\b|\\approx|\\sim")
_SPACE = {r"\,", r"\;", r"\!", r"\:", r"\ ", r"\quad", r"\qquad", r"\left", r"\right", "&"}
RELATIONS = {"=": "=", ">": ">", "<": "<", r"\le": "<=", r"\ge": ">=", r"\leq": "<=", r"\geq": ">="}
_BRACKETS = {"(": ")", "[": "]", "{": "}"}
_FUNCTIONS = {
    r"\sin": "math.sin",
    r"\cos": "math.cos",
    r"\tan": "math.tan",
    r"\cosh": "math.cosh",
    r"\operatorname{artanh}": "math.atanh",
}
_ACCENTS = {r"\dot": "dot ", r"\ddot": "ddot "}
_ENDS = {")", "]", "}", "|", "+", "-", "^", "_", "/", ",", ".", r"\cdot", *RELATIONS}


@dataclass(frozen=True)
class Line:
    """One line of a formula: its sides, and the relation before each side except the first."""

    text: str
    sides: tuple[Side, ...]
    relations: tuple[str, ...]
    first: str | None

    def value(self, values: Values) -> Any:
        """Return the second side: the value of the symbol on the first side."""
        return self.sides[1](values)

    def error(self, values: Values) -> float:
        """Return the largest difference of equal sides, relative to the larger of 1 and their size."""
        found = [side(values) for side in self.sides]
        pairs = zip(found[1:], self.relations, strict=True)
        return max(abs(found[0] - x) / max(1.0, abs(x)) for x, relation in pairs if relation == "=")

    def holds(self, values: Values) -> bool:
        """Return whether the only inequality of this line is true."""
        (relation,), (left, right) = self.relations, (side(values) for side in self.sides)
        return bool(
            {">": left > right, "<": left < right, "<=": left <= right, ">=": left >= right}[relation]
        )


def lines(text: str) -> list[Line]:
    """Return the lines of a displayed formula."""
    for name in ("aligned", "gathered"):
        text = text.replace(rf"\begin{{{name}}}", "").replace(rf"\end{{{name}}}", "")
    return [_Reader(row).line() for row in re.split(r"\\\\", text) if row.strip()]


class Page:
    """The formulas of a page by name; `tested` returns those that a test file uses."""

    def __init__(self, name: str) -> None:
        docs = Path(__file__).resolve().parents[1] / "docs"
        self.text = (docs / name).read_text(encoding="utf-8")
        found = _NAMED.findall(self.text)
        self.formulas = {name: lines(text) for name, text in found}
        self.all_named = len(found) == len(self.formulas) == self.text.count("$$") / 2

    def check(
        self, name: str, values: Values, tolerance: float = 1e-12, defines: Container[str] = ()
    ) -> None:
        """Check the lines of a formula against the values; lines of symbols in `defines` add values for later lines."""
        held = 0
        for line in self.formulas[name]:
            if line.first in defines:
                values = {**values, line.first: line.value(values)}
            else:
                assert line.error(values) <= tolerance, (name, line.text)
                held += 1
        assert held

    def tested(self, source: str) -> set[str]:
        """Return the names of the formulas that the test file `source` uses."""
        text = Path(source).read_text(encoding="utf-8")
        return set(re.findall(r'(?:check\(|formulas\[|FORMULAS\[)\s*"([\w-]+)"', text))

    def inline(self) -> list[str]:
        """Return the inline formulas."""
        return re.findall(r"\$([^$\n]+)\$", _NAMED.sub("", self.text))

    def statements(self) -> list[str]:
        """Return the inline formulas that state something: they belong on their own line."""
        return [each for each in self.inline() if _STATES.search(each)]


class _Reader:
    """Parser that reads one line from left to right and writes each side as Python; `v` are the symbols' values."""

    def __init__(self, text: str) -> None:
        self.text = " ".join(text.split())
        self.tokens = [token for token in _TOKEN.findall(text) if token not in _SPACE]
        self.at, self.bars, self.integrals = 0, 0, 0

    def line(self) -> Line:
        sides, relations = [self.sum()], []
        symbol = re.fullmatch(r"v\[('[^'\[]*'|\"[^\"\[]*\")\]", sides[0])
        while self.peek() in RELATIONS:
            relations.append(RELATIONS[self.take()])
            sides.append(self.sum())
        if self.peek() in (",", "."):
            self.take()
        if self.peek():
            raise ValueError(f"cannot read {self.peek()!r} in {self.text!r}")
        functions = tuple(eval(f"lambda v: {side}", {"math": math, "integral": _integral}) for side in sides)
        return Line(
            self.text,
            tuple(lambda values, side=side: side(_Called(values)) for side in functions),
            tuple(relations),
            symbol and symbol[1][1:-1],
        )

    def peek(self) -> str:
        return self.tokens[self.at] if self.at < len(self.tokens) else ""

    def take(self, wanted: str | None = None) -> str:
        token = self.peek()
        if not token or (wanted is not None and token != wanted):
            raise ValueError(f"{wanted or 'more'} is missing in {self.text!r}")
        self.at += 1
        return token

    def enclosed(self, first: str, last: str) -> str:
        self.take(first)
        inside = self.sum()
        self.take(last)
        return f"({inside})"

    def group(self) -> str:
        return self.enclosed("{", "}")

    def sum(self) -> str:
        found = self.take() if self.peek() in ("+", "-") else ""
        found += self.product()
        while self.peek() in ("+", "-"):
            found += f" {self.take()} {self.product()}"
        return found

    def product(self) -> str:
        found = self.power()
        while True:
            if self.peek() in (r"\cdot", "/"):
                found += f" {'/' if self.take() == '/' else '*'} {self.power()}"
            elif self.starts_factor():
                found += f" * {self.power()}"
            else:
                return found

    def starts_factor(self) -> bool:
        token = self.peek()
        if token == "|":
            return not self.bars
        return bool(token) and token not in _ENDS and not (token == "d" and self.integrals)

    def power(self) -> str:
        return self.factor() + self.exponent()

    def exponent(self) -> str:
        if self.peek() != "^":
            return ""
        self.take()
        return "**" + (self.group() if self.peek() == "{" else self.number())

    def factor(self) -> str:
        token = self.peek()
        if token in _BRACKETS:
            return self.enclosed(token, _BRACKETS[token])
        if token == "|":
            self.bars += 1
            self.take()
            inside = self.sum()
            self.bars -= 1
            self.take("|")
            return f"abs({inside})"
        if token[:1].isdigit():
            return self.number()
        if token in (r"\frac", r"\tfrac"):
            return self.fraction()
        if token == r"\sqrt":
            self.take()
            return f"math.sqrt{self.group()}"
        if token == r"\int":
            return self.integral()
        if token in _FUNCTIONS:
            return self.function()
        return self.symbol()

    def number(self) -> str:
        token = self.take()
        if not token[:1].isdigit():
            raise ValueError(f"a number or braces are missing before {token!r} in {self.text!r}")
        return str(float(token))

    def fraction(self) -> str:
        self.take()
        start = self.at
        try:
            above = self.differential()
            return f"v[{above + '/' + self.differential()!r}]"
        except ValueError:
            # This is not a derivative such as {ds}{dt}.
            self.at = start
        return f"({self.group()} / {self.group()})"

    def differential(self) -> str:
        self.take("{")
        self.take("d")
        order = self.take_after("^")
        name = f"d{order}{self.name()}{self.take_after('^')}"
        self.take("}")
        return name

    def take_after(self, sign: str) -> str:
        if self.peek() != sign:
            return ""
        self.take()
        return self.take()

    def integral(self) -> str:
        self.take(r"\int")
        self.take("_")
        low = self.group()
        self.take("^")
        high = self.group()
        self.integrals += 1
        inside = self.product()
        self.integrals -= 1
        self.take("d")
        return f"integral(lambda v: {inside}, v, {self.name()!r}, {low}, {high})"

    def function(self) -> str:
        function = _FUNCTIONS[self.take()]
        exponent = self.exponent()
        return f"{function}({self.argument()}){exponent}"

    def argument(self) -> str:
        """Return the argument of a function without parentheses: a symbol, perhaps after a number."""
        if self.peek() in ("(", "{"):
            return self.factor()
        number = f"{self.number()} * " if self.peek()[:1].isdigit() else ""
        return number + self.symbol()

    def symbol(self) -> str:
        return f"v[{self.name()!r}]"

    def name(self) -> str:
        token = self.take()
        if token not in _ACCENTS:
            found = self.letter(token)
        elif self.peek() == "{":
            self.take()
            found = _ACCENTS[token] + self.name()
            self.take("}")
        else:
            found = _ACCENTS[token] + self.letter(self.take())
        while self.peek() == "'":
            found += self.take()
        if self.peek() != "_":
            return found
        self.take()
        below = [self.take()]
        while below[0] == "{" and below[-1] != "}":
            below.append(self.take())
        return f"{found}_" + "".join(each.removeprefix("\\") for each in below if each not in "{}")

    def letter(self, token: str) -> str:
        if not re.fullmatch(r"\\?[a-zA-Z]+", token) or token in _FUNCTIONS:
            raise ValueError(f"cannot read {token!r} in {self.text!r}")
        return token.removeprefix("\\")


class _Called(dict[str, Any]):
    """Values by name; a function is called with all values."""

    def __getitem__(self, name: str) -> Any:
        found = super().__getitem__(name)
        return found(self) if callable(found) else found


def _integral(inside: Side, values: Values, name: str, low: float, high: float) -> float:
    places = [low, 0.5 * (low + high), high]
    return float(mpmath.quad(lambda x: inside(_Called({**values, name: float(x)})), places))
