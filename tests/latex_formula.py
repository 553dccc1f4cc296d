r"""Formulas of a page, evaluated as they are printed: a reader of the LaTeX that docs/theory.md is written in.

`Page` finds them: each stands on lines of its own below the name that its comment gives it.

A line such as ``\dot\psi^2 > \frac{g}{R}`` has sides and relations between them; each side becomes a function of the
values of its symbols. Symbols are named by what is printed: ``\dot\psi`` is "dot psi", ``\theta_0`` is "theta_0",
``V''`` is "V''", ``\frac{ds}{d\theta}`` is "ds/dtheta",
``\frac{d^2 s}{du^2}`` is "d2s/du2". A factor beside a factor is a product, and after ``/`` stands
one factor alone, so that nothing is read in another way than a person reads it.
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
#: Signs that make a statement of a formula.
_STATES = re.compile(r"=|<|>|\\leq?\b|\\geq?\b|\\approx|\\sim")
_SPACE = {r"\,", r"\;", r"\!", r"\:", r"\ ", r"\quad", r"\qquad", r"\left", r"\right", "&"}
RELATIONS = {"=": "=", ">": ">", "<": "<", r"\le": "<=", r"\ge": ">=", r"\leq": "<=", r"\geq": ">="}
_FUNCTIONS: dict[str, Callable[[Any], Any]] = {
    r"\sin": math.sin, r"\cos": math.cos, r"\tan": math.tan, r"\cosh": math.cosh,
    r"\operatorname{artanh}": math.atanh,
}  # fmt: skip
_ACCENTS = {r"\dot": "dot ", r"\ddot": "ddot "}
_ENDS = {")", "]", "}", "|", "+", "-", "^", "_", "/", ",", ".", r"\cdot", *RELATIONS}


@dataclass(frozen=True)
class Line:
    """One line of a formula: its sides, and the relation in front of each but the first."""

    text: str
    sides: tuple[Side, ...]
    relations: tuple[str, ...]
    first: str | None

    def value(self, values: Values) -> Any:
        """Return the second side: the value of the symbol that is the first one."""
        return self.sides[1](values)

    def error(self, values: Values) -> float:
        """Return the largest difference of two equal sides, over the larger of 1 and their size."""
        found = [side(values) for side in self.sides]
        pairs = zip(found[1:], self.relations, strict=True)
        return max(abs(found[0] - x) / max(1.0, abs(x)) for x, relation in pairs if relation == "=")

    def holds(self, values: Values) -> bool:
        """Return whether the one inequality of this line is true."""
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
    """The formulas of a page, by their names; `tested` are those that a file of tests takes."""

    def __init__(self, name: str) -> None:
        docs = Path(__file__).resolve().parents[1] / "docs"
        self.text = (docs / name).read_text(encoding="utf-8")
        found = _NAMED.findall(self.text)
        self.formulas = {name: lines(text) for name, text in found}
        self.all_named = len(found) == len(self.formulas) == self.text.count("$$") / 2

    def check(
        self, name: str, values: Values, tolerance: float = 1e-12, defines: Container[str] = ()
    ) -> None:
        """Hold the lines of a formula against the values; those of the symbols named add a value for those below."""
        held = 0
        for line in self.formulas[name]:
            if line.first in defines:
                values = {**values, line.first: line.value(values)}
            else:
                assert line.error(values) <= tolerance, (name, line.text)
                held += 1
        assert held

    def tested(self, source: str) -> set[str]:
        """Return the names of the formulas that the file of tests `source` takes."""
        text = Path(source).read_text(encoding="utf-8")
        return set(re.findall(r'(?:check\(|formulas\[|FORMULAS\[)\s*"([\w-]+)"', text))

    def inline(self) -> list[str]:
        """Return the formulas between words."""
        return re.findall(r"\$([^$\n]+)\$", _NAMED.sub("", self.text))

    def statements(self) -> list[str]:
        """Return those between words that state something: it belongs on a line of its own."""
        return [each for each in self.inline() if _STATES.search(each)]


class _Reader:
    """Reads one line from left to right."""

    def __init__(self, text: str) -> None:
        self.text = " ".join(text.split())
        self.tokens = [token for token in _TOKEN.findall(text) if token not in _SPACE]
        self.at, self.bars, self.integrals = 0, 0, 0

    def line(self) -> Line:
        sides, relations = [self.sum()], []
        first = self._only_symbol()
        while self.peek() in RELATIONS:
            relations.append(RELATIONS[self.take()])
            sides.append(self.sum())
        if self.peek() in (",", "."):
            self.take()
        if self.peek():
            raise ValueError(f"cannot read {self.peek()!r} in {self.text!r}")
        return Line(self.text, tuple(sides), tuple(relations), first)

    def _only_symbol(self) -> str | None:
        """Return the name of the first side if it is nothing but a symbol."""
        end, self.at = self.at, 0
        try:
            name = self.symbol() if self.tokens[0] not in _FUNCTIONS else None
        except ValueError:
            name = None
        alone, self.at = self.at == end, end
        return name if alone else None

    def peek(self, ahead: int = 0) -> str:
        place = self.at + ahead
        return self.tokens[place] if place < len(self.tokens) else ""

    def take(self, wanted: str | None = None) -> str:
        token = self.peek()
        if not token or (wanted is not None and token != wanted):
            raise ValueError(f"{wanted or 'more'} is missing in {self.text!r}")
        self.at += 1
        return token

    def sum(self) -> Side:
        negative = self.peek() == "-"
        if self.peek() in ("+", "-"):
            self.take()
        first = self.product()
        total: Side = (lambda v: -first(v)) if negative else first
        while self.peek() in ("+", "-"):
            total = _added(total, self.product_after(self.take()))
        return total

    def product_after(self, sign: str) -> Side:
        part = self.product()
        return part if sign == "+" else lambda v: -part(v)

    def product(self) -> Side:
        result = self.power()
        while True:
            if self.peek() == r"\cdot":
                self.take()
                result = _multiplied(result, self.power())
            elif self.peek() == "/":
                self.take()
                result = _divided(result, self.power())
            elif self.starts_factor():
                result = _multiplied(result, self.power())
            else:
                return result

    def starts_factor(self) -> bool:
        token = self.peek()
        if token == "|":
            return not self.bars
        return bool(token) and token not in _ENDS and not (token == "d" and self.integrals)

    def power(self) -> Side:
        base = self.factor()
        return self._raised(base)

    def _raised(self, base: Side) -> Side:
        if self.peek() != "^":
            return base
        self.take()
        exponent = self.group() if self.peek() == "{" else self.number()
        return lambda v: base(v) ** exponent(v)

    def factor(self) -> Side:
        token = self.peek()
        if token in ("(", "["):
            self.take()
            inside = self.sum()
            self.take(")" if token == "(" else "]")
            return inside
        if token == "{":
            return self.group()
        if token == "|":
            return self.magnitude()
        if token[:1].isdigit():
            return self.number()
        if token == r"\frac" or token == r"\tfrac":
            return self.fraction()
        if token == r"\sqrt":
            self.take()
            inside = self.group()
            return lambda v: math.sqrt(inside(v))
        if token == r"\int":
            return self.integral()
        if token in _FUNCTIONS:
            return self.function()
        return _value_of(self.symbol())

    def number(self) -> Side:
        token = self.take()
        if not token[:1].isdigit():
            raise ValueError(f"a number or braces are missing before {token!r} in {self.text!r}")
        value = float(token)
        return lambda v: value

    def group(self) -> Side:
        self.take("{")
        inside = self.sum()
        self.take("}")
        return inside

    def magnitude(self) -> Side:
        self.take("|")
        self.bars += 1
        inside = self.sum()
        self.bars -= 1
        self.take("|")
        return lambda v: abs(inside(v))

    def fraction(self) -> Side:
        self.take()
        derivative = self.derivative()
        if derivative is not None:
            return _value_of(derivative)
        return _divided(self.group(), self.group())

    def derivative(self) -> str | None:
        """Return the name of a derivative such as {ds}{dt}, or None, and stay, if it is another fraction."""
        start = self.at
        try:
            self.take("{")
            name = self._differential()
            self.take("}")
            self.take("{")
            name += "/" + self._differential()
            self.take("}")
        except ValueError:
            self.at = start
            return None
        return name

    def _differential(self) -> str:
        self.take("d")
        order = ""
        if self.peek() == "^":
            self.take()
            order = self.take()
        name = f"d{order}{self.symbol()}"
        if self.peek() == "^":
            self.take()
            name += self.take()
        return name

    def integral(self) -> Side:
        self.take(r"\int")
        self.take("_")
        low = self.group()
        self.take("^")
        high = self.group()
        self.integrals += 1
        inside = self.product()
        self.integrals -= 1
        self.take("d")
        name = self.symbol()
        return lambda v: float(
            mpmath.quad(lambda x: inside({**v, name: float(x)}), [low(v), 0.5 * (low(v) + high(v)), high(v)])
        )

    def function(self) -> Side:
        function = _FUNCTIONS[self.take()]
        exponent = None
        if self.peek() == "^":
            self.take()
            exponent = self.number()
        argument = self.argument()
        if exponent is None:
            return lambda v: function(argument(v))
        return lambda v: function(argument(v)) ** exponent(v)

    def argument(self) -> Side:
        """Return what a function without parentheses is taken of: a symbol, perhaps with a number before it."""
        if self.peek() in ("(", "{"):
            return self.factor()
        if self.peek()[:1].isdigit():
            return _multiplied(self.number(), _value_of(self.symbol()))
        return _value_of(self.symbol())

    def symbol(self) -> str:
        token = self.take()
        if token in _ACCENTS:
            if self.peek() == "{":
                self.take()
                name = _ACCENTS[token] + self.symbol()
                self.take("}")
            else:
                name = _ACCENTS[token] + self._letter(self.take())
        else:
            name = self._letter(token)
        while self.peek() == "'":
            name += self.take()
        if self.peek() == "_":
            self.take()
            name += "_" + self._subscript()
        return name

    def _letter(self, token: str) -> str:
        if not re.fullmatch(r"\\?[a-zA-Z]+", token) or token in _FUNCTIONS:
            raise ValueError(f"cannot read {token!r} in {self.text!r}")
        return token.removeprefix("\\")

    def _subscript(self) -> str:
        if self.peek() != "{":
            return self.take().removeprefix("\\")
        self.take()
        parts = []
        while self.peek() != "}":
            parts.append(self.take().removeprefix("\\"))
        self.take("}")
        return "".join(parts)


def _value_of(name: str) -> Side:
    def value(values: Values) -> Any:
        found = values[name]
        return found(values) if callable(found) else found

    return value


def _added(first: Side, second: Side) -> Side:
    return lambda v: first(v) + second(v)


def _multiplied(first: Side, second: Side) -> Side:
    return lambda v: first(v) * second(v)


def _divided(first: Side, second: Side) -> Side:
    return lambda v: first(v) / second(v)
