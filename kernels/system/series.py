"""The Taylor series of a solution, coefficient by coefficient, as source code generated from a right-hand side.

A *program* is a tuple of instructions. Each instruction refers to the results of earlier ones by their numbers:

``("number", value)``, ``("parameter", i)``, ``("state", i)``, ``("time",)``,
``("+", a, b)``, ``("-", a, b)``, ``("*", a, b)``, ``("/", a, b)``, ``("**", a, exponent)``, ``("neg", a)``,
``("sin", a)`` and so on for the functions of `FUNCTIONS`, and ``("atan2", y, x, square)``, where ``square`` is the
instruction of y^2 + x^2.

The rules are those of automatic differentiation, one for each operation: Jorba and Zou, "A software package for the
numerical integration of ODEs by means of high-order Taylor methods", Experimental Mathematics 14 (2005), section 2.
Expressions that depend only on parameters are constants of the cell, computed once.
"""

import math

from kernels.system.hidden import HIGH

#: Functions of one argument -> the function of `kernels.elementary` that returns its value (for sin and cos, both).
FUNCTIONS = {
    "sin": "sine_cosine",
    "cos": "sine_cosine",
    "tan": "sine_cosine",
    "exp": "exponential",
    "log": "logarithm",
    "sqrt": "math.sqrt",
    "tanh": "hyperbolic_tangent",
}


def is_constant(program):
    """Return, as a list of bool, which instructions depend only on parameters and numbers."""
    found = []
    for kind, *given in program:
        leaf = kind in ("number", "parameter")
        inner = kind not in ("number", "parameter", "state", "time")
        operands = given[:1] if kind == "**" else given
        found.append(leaf or (inner and all(found[each] for each in operands)))
    return found


class ConstantSource:
    """The constants of a cell that the series needs, and the source that computes them.

    Parameters
    ----------
    program : tuple
    """

    def __init__(self, program):
        self._program, self._lines, self._texts = program, [], {}
        #: Text of each constant that the series needs -> its name there.
        self.names = {}

    def name(self, number, inverse=False):
        """Return the name or the literal of the value of an instruction, or of its reciprocal, in the series."""
        kind, *given = self._program[number]
        if kind == "number":
            return _literal((1.0 / given[0] if given[0] else math.inf) if inverse else given[0])
        text = self._text(number)
        text = f"1.0 / {text}" if inverse else text
        return self.names.setdefault(text, f"k{len(self.names)}")

    def lines(self):
        """Return the assignments of the values that the texts of `names` use."""
        return self._lines

    def _text(self, number):
        if number not in self._texts:
            kind, *given = self._program[number]
            if kind == "number":
                return repr(given[0])
            if kind == "parameter":
                return f"p{given[0]}"
            value = self._value(kind, given)
            self._texts[number] = f"n{number}"
            self._lines.append(f"n{number} = {value}")
        return self._texts[number]

    def _value(self, kind, given):
        if kind in ("+", "-", "*", "/"):
            return f"{self._text(given[0])} {kind} {self._text(given[1])}"
        argument = self._text(given[0])
        if kind == "**":
            return power(argument, f"(1.0 / {argument})", given[1])
        if kind == "neg":
            return f"-{argument}"
        if kind == "atan2":
            return f"arc_tangent({argument}, {self._text(given[1])})"
        call = f"{FUNCTIONS[kind]}({argument})"
        if kind == "tan":
            return f"{call}[0] / {call}[1]"
        return call + {"sin": "[0]", "cos": "[1]"}.get(kind, "")


def _literal(value):
    """Return a number as source; numbers that are not finite make cells unresolved."""
    return repr(value) if math.isfinite(value) else "math.nan"


def power(base, inverse, exponent):
    """Return the source of a power; multiples of 1/2 up to 8 are computed by products and a root."""
    whole, half = int(abs(exponent)), 2.0 * abs(exponent) % 2.0 == 1.0
    if abs(exponent) > 8.0 or (2.0 * exponent) % 1.0:
        return f"exponential({exponent!r} * logarithm({base}))"
    used = base if exponent > 0.0 else inverse
    factors = [used] * whole + [f"math.sqrt({used})"] * half
    return " * ".join(factors) or "1.0"


def _product(one, other):
    if not one or not other:
        return ""
    if one == "1.0" or other == "1.0":
        return other if one == "1.0" else one
    return f"{one} * {other}"


def _sum(terms):
    return " + ".join(term for term in terms if term)


def _less(one, other):
    """Return the source of a difference; either text may be empty, which means zero."""
    return f"{one} - ({other})" if one and other else (one or (f"-({other})" if other else ""))


class SeriesSource:
    """The source of the coefficients of states and other expressions along a solution.

    An empty text means a coefficient that is zero for all cells.

    Parameters
    ----------
    program : tuple
    rates : tuple of int
        The instruction of the rate of each state.
    wanted : tuple of int
        Instructions whose coefficients are needed.
    order : int
        The highest order of the states, and of `wanted`.

    Attributes
    ----------
    lines : list of str
        Assignments. They need y0, y1 ... (the states), t, and the names of `constants`.
    states, wanted : list of list of str
        The coefficients of each from order 0 to `order`, as texts of the lines.
    rounding : list of str
        For each rate, the magnitude of its terms at order 0.
    watched : list of tuple
        For each argument of a function that may hide its later growth: the way of watching it
        (`kernels.system.hidden.step_lines`), an exponent, and its coefficients, from order 0 to the last one that is
        not zero for all cells.
    constants : ConstantSource
    """

    def __init__(self, program, rates, wanted, order):
        self._program, self._constant = program, is_constant(program)
        self.constants, self.lines = ConstantSource(program), []
        self._values, self._notes, self._count = [[] for _ in program], {}, 0
        self._sizes = {}
        self.states = [[f"y{i}"] for i in range(len(rates))]
        needed = self._closure(rates)
        for k in range(order):
            self._order(k, needed)
            for i, rate in enumerate(rates):
                text = self._at(rate, k)
                self.states[i].append(self._assigned(_product(text, repr(1.0 / (k + 1)))))
        for k in range(order + 1):
            self._order(k, self._closure(wanted) if k == order else self._closure(wanted) - needed)
        self.wanted = [[self._at(each, k) for k in range(order + 1)] for each in wanted]
        self.rounding = [self._size(rate) for rate in rates]
        self.watched = self._watched(self._closure((*rates, *wanted)), order)

    def _watched(self, needed, order):
        """Return `watched`: each argument once for each way, with its highest exponent."""
        exponents = {}
        for number in sorted(needed):
            for key, exponent in self._ways(number):
                exponents[key] = max(exponent, exponents.get(key, 0.0))
        rows = []
        for (way, argument), exponent in exponents.items():
            texts = [] if self._constant[argument] else [self._at(argument, k) for k in range(order)]
            while texts and not texts[-1]:
                texts.pop()
            if len(texts) > 1:
                rows.append((way, exponent, texts))
        return rows

    def _ways(self, number):
        """Yield how to watch an operation: a way of `kernels.system.hidden` with an argument, and an exponent."""
        kind, *given = self._program[number]
        if kind in ("exp", "tanh"):
            yield (kind, given[0]), 1.0
        elif kind == "log":
            yield ("shrinks", given[0]), 1.0
        elif kind == "atan2":
            yield ("shrinks", given[2]), 1.0
        elif kind == "/":
            base, exponent = self._monomial(given[1])
            if exponent > 0.0:
                yield ("shrinks", base), exponent
        elif kind in ("*", "**", "sqrt"):
            base, exponent = self._monomial(number)
            if exponent > HIGH:
                yield ("grows", base), exponent
            if exponent < 0.0 or exponent % 1.0:
                yield ("shrinks", base), max(1.0, -exponent)

    def _monomial(self, number):
        """Return base and exponent of a value that is a power; for other values, the value itself and 1."""
        kind, *given = self._program[number]
        if kind in ("**", "sqrt"):
            base, exponent = self._monomial(given[0])
            return base, exponent * (given[1] if kind == "**" else 0.5)
        if kind == "*":
            (one, first), (other, second) = map(self._monomial, given)
            if one == other:
                return one, first + second
        return number, 1.0

    def _size(self, number):
        """Return the magnitude of the terms of a value at the start of a step, which scales its rounding error.

        A function passes on the rounding error of its argument, times its derivative.
        """
        if number not in self._sizes:
            kind, *given = self._program[number]
            own = f"abs({self._at(number, 0) or '0.0'})"
            if self._constant[number] or kind in ("state", "time"):
                text = own
            elif kind in ("+", "-"):
                text = _sum(map(self._size, given))
            elif kind == "neg":
                text = self._size(given[0])
            elif kind == "*":
                text = _product(*map(self._size, given))
            elif kind == "/" and self._constant[given[1]]:
                text = f"{self._size(given[0])} * abs({self.constants.name(given[1], inverse=True)})"
            elif kind == "/":
                one, other = map(self._size, given)
                text = f"({one} + {own} * {other}) * abs({self._notes[number, 'inverse']})"
            elif kind == "atan2":
                one, other = (
                    _product(f"abs({self._at(a, 0) or '0.0'})", self._size(b))
                    for a, b in (given[:2], given[1::-1])
                )
                text = f"{own} + ({_sum([one, other])}) * {self._notes[number, 'inverse']}"
            else:
                text = f"{own} + {self._size(given[0])} * abs({self._slope_of(number)})"
            self._sizes[number] = self._assigned(text)
        return self._sizes[number]

    def _slope_of(self, number):
        """Return the derivative of a function or power by its argument at the start of a step."""
        kind, argument, *exponent = self._program[number]
        value = self._at(number, 0)
        if kind in ("sin", "cos"):
            return self._values[number][0][1 if kind == "sin" else 0]
        if kind in ("tan", "tanh"):
            return self._values[number][0][1]
        if kind == "exp":
            return value
        base = self._at(argument, 0) or "0.0"
        if kind == "**" and exponent[0] in (2.0, 3.0, 4.0):
            return f"({exponent[0]!r} * {power(base, '', exponent[0] - 1.0)})"
        inverse = self._notes[number, "inverse"]
        if kind == "log":
            return inverse
        return f"({value} * {exponent[0]!r} * {inverse})" if kind == "**" else inverse

    def _closure(self, roots):
        """Return the instructions that `roots` depend on, including `roots`."""
        found, waiting = set(), list(roots)
        while waiting:
            number = waiting.pop()
            if number not in found and not self._constant[number]:
                found.add(number)
                kind, *given = self._program[number]
                if kind not in ("state", "time"):
                    waiting += given[:1] if kind == "**" else given
        return found

    def _order(self, k, needed):
        for number in sorted(needed):
            if len(self._values[number]) == k:
                self._values[number].append(self._coefficient(number, k))

    def _at(self, number, k):
        """Return the coefficient of order k of an instruction."""
        if self._constant[number]:
            name = self.constants.name(number) if k == 0 else ""
            return "" if name in ("0.0", "-0.0") else name
        kind, *given = self._program[number]
        if kind == "state":
            return self.states[given[0]][k]
        if kind == "time":
            return {0: "t", 1: "1.0"}.get(k, "")
        found = self._values[number][k]
        return found[0 if kind in ("sin", "tan", "tanh") else 1] if isinstance(found, tuple) else found

    def _assigned(self, text):
        """Assign a text to a new name, and return the name; a text that is already a name is returned as it is."""
        if not text or text.isidentifier() or text == "1.0":
            return text
        self._count += 1
        self.lines.append(f"u{self._count} = {text}")
        return f"u{self._count}"

    def _once(self, key, text):
        """Return the name of a value that several orders use."""
        if key not in self._notes:
            self._notes[key] = self._assigned(text)
        return self._notes[key]

    def _coefficient(self, number, k):
        kind, *given = self._program[number]
        if kind in ("state", "time"):
            return ""
        if kind in ("+", "-"):
            one, other = (self._at(each, k) for each in given)
            if kind == "+":
                return self._assigned(_sum([one, other]))
            return self._assigned(f"{one} - {other}" if one and other else one or (other and f"-{other}"))
        rules = {
            "*": self._times, "/": self._over, "**": self._power, "neg": self._negative, "atan2": self._arc_tangent,
        }  # fmt: skip
        if kind in rules:
            return rules[kind](number, k, *given)
        return getattr(self, f"_{'sine_cosine' if kind in ('sin', 'cos') else kind}")(number, k, *given)

    def _negative(self, number, k, a):
        text = self._at(a, k)
        return self._assigned(text and f"-{text}")

    def _times(self, number, k, a, b):
        if self._constant[a] or self._constant[b]:
            a, b = (a, b) if self._constant[a] else (b, a)
            return self._assigned(_product(self._at(b, k), self.constants.name(a)))
        if a == b:
            return self._assigned(self._square(lambda j: self._at(a, j), 0, k))
        return self._assigned(_sum(_product(self._at(a, j), self._at(b, k - j)) for j in range(k + 1)))

    def _square(self, at, first, k):
        """Return the sum of at(j) at(k - j) for j from `first` to k - `first`, computing each product once."""
        twice = _sum(_product(at(j), at(k - j)) for j in range(first, (k + 1) // 2))
        middle = _product(at(k // 2), at(k // 2)) if k % 2 == 0 and k // 2 >= first else ""
        return _sum([f"2.0 * ({twice})" if twice else "", middle])

    def _over(self, number, k, a, b):
        if self._constant[b]:
            return self._assigned(_product(self._at(a, k), self.constants.name(b, inverse=True)))
        inverse = self._once((number, "inverse"), f"1.0 / {self._at(b, 0)}")
        rest = _sum(_product(self._at(b, j), self._values[number][k - j]) for j in range(1, k + 1))
        text = _less(self._at(a, k), rest)
        return self._assigned(f"({text}) * {inverse}" if text else "")

    def _power(self, number, k, a, exponent):
        if exponent in (2.0, 3.0, 4.0):
            return self._whole_power(number, k, a, int(exponent))
        inverse = self._once((number, "inverse"), f"1.0 / {self._at(a, 0)}")
        if k == 0:
            return self._assigned(power(self._at(a, 0), inverse, exponent))
        terms = []
        for j in range(k):
            factor, text = (exponent * (k - j) - j) / k, self._at(a, k - j)
            terms.append(
                _product(_product(text, repr(factor)) if text and factor else "", self._values[number][j])
            )
        text = _sum(terms)
        return self._assigned(f"({text}) * {inverse}" if text else "")

    def _whole_power(self, number, k, a, exponent):
        """Return a coefficient of a small power, by products, which are defined at zero too."""
        square = self._notes.setdefault((number, "square"), [])
        square.append(self._assigned(self._square(lambda j: self._at(a, j), 0, k)))
        if exponent == 2:
            return square[k]
        if exponent == 4:
            return self._assigned(self._square(square.__getitem__, 0, k))
        return self._assigned(_sum(_product(self._at(a, j), square[k - j]) for j in range(k + 1)))

    def _sqrt(self, number, k, a):
        if k == 0:
            return self._assigned(f"math.sqrt({self._at(a, 0)})")
        found = self._values[number]
        inverse = self._once((number, "inverse"), f"0.5 / {found[0]}")
        text = _less(self._at(a, k), self._square(found.__getitem__, 1, k))
        return self._assigned(f"({text}) * {inverse}" if text else "")

    def _weighted(self, number, a, k):
        """Return j times the coefficient of order j of an argument, for j up to k, as in its derivative."""
        return [
            self._once(
                (a, "weighted", j), _product(self._at(a, j), repr(float(j))) if j > 1 else self._at(a, j)
            )
            for j in range(1, k + 1)
        ]

    def _exp(self, number, k, a):
        if k == 0:
            return self._assigned(f"exponential({self._at(a, 0)})")
        weighted, found = self._weighted(number, a, k), self._values[number]
        text = _sum(_product(weighted[j - 1], found[k - j]) for j in range(1, k + 1))
        return self._assigned(f"({text}) * {1.0 / k!r}" if text else "")

    def _log(self, number, k, a):
        if k == 0:
            return self._assigned(f"logarithm({self._at(a, 0)})")
        inverse, found = self._once((number, "inverse"), f"1.0 / {self._at(a, 0)}"), self._values[number]
        rest = _sum(_product(_product(found[j], repr(j / k)), self._at(a, k - j)) for j in range(1, k))
        text = _less(self._at(a, k), rest)
        return self._assigned(f"({text}) * {inverse}" if text else "")

    def _arc_tangent(self, number, k, y, x, square):
        """Return the coefficient of the angle, whose derivative is (x y' - y x')/(x^2 + y^2)."""
        inverse = self._once((number, "inverse"), f"1.0 / {self._at(square, 0)}")
        if k == 0:
            return self._assigned(f"arc_tangent({self._at(y, 0) or '0.0'}, {self._at(x, 0) or '0.0'})")
        one, other = (
            _sum(_product(weighted, self._at(b, k - j)) for j, weighted in enumerate(self._rates(a, k), 1))
            for a, b in ((y, x), (x, y))
        )
        known = _sum(
            _product(_product(self._values[number][k - j], repr(float(k - j))), self._at(square, j))
            for j in range(1, k)
        )
        text = _less(_less(one, other), known)
        return self._assigned(f"({text}) * ({inverse} * {1.0 / k!r})" if text else "")

    def _rates(self, a, k):
        """Return `_weighted` of a value that may be constant."""
        return [""] * k if self._constant[a] else self._weighted(None, a, k)

    def _sine_cosine(self, number, k, a):
        """Return the coefficients of sine and cosine, which depend on each other and are kept for both functions."""
        pairs = self._notes.setdefault((a, "sine and cosine"), [])
        if len(pairs) > k:
            return pairs[k]
        if k == 0:
            self._count += 1
            names = f"s{self._count}", f"c{self._count}"
            self.lines.append(f"{names[0]}, {names[1]} = sine_cosine({self._at(a, 0)})")
            pairs.append(names)
            return names
        weighted = self._weighted(number, a, k)
        sine = _sum(_product(weighted[j - 1], pairs[k - j][1]) for j in range(1, k + 1))
        cosine = _sum(_product(weighted[j - 1], pairs[k - j][0]) for j in range(1, k + 1))
        pairs.append((
            self._assigned(f"({sine}) * {1.0 / k!r}" if sine else ""),
            self._assigned(f"({cosine}) * {-1.0 / k!r}" if cosine else ""),
        ))  # fmt: skip
        return pairs[k]

    def _tan(self, number, k, a):
        return self._tangent(number, k, a, "+")

    def _tanh(self, number, k, a):
        return self._tangent(number, k, a, "-")

    def _tangent(self, number, k, a, sign):
        """Return the coefficients of tan and 1 + tan^2, or of tanh and 1 - tanh^2, which is the derivative."""
        found = self._values[number]
        if k == 0:
            argument = self._at(a, 0)
            if sign == "+":
                sine, cosine = self._sine_cosine(number, 0, a)
                value = self._assigned(f"{sine} / {cosine}")
            else:
                value = self._assigned(f"hyperbolic_tangent({argument})")
            return value, self._assigned(f"1.0 {sign} {value} * {value}")
        weighted = self._weighted(number, a, k)
        text = _sum(_product(weighted[j - 1], found[k - j][1]) for j in range(1, k + 1))
        value = self._assigned(f"({text}) * {1.0 / k!r}" if text else "")
        values = [each for each, _ in found] + [value]
        square = self._square(values.__getitem__, 0, k)
        return value, self._assigned(square if sign == "+" else square and f"-({square})")
