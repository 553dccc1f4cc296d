"""A system as text: one canonical spelling for all equivalent files, in ASCII.

Parts that occur several times get names ``v1``, ``v2``, ...; all numbers are in SI.
"""

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping

from sweep.model.system.definition import (
    OPERATIONS,
    TIME,
    Constant,
    Declared,
    Definition,
    Label,
    Moment,
    Node,
    Operation,
    Symbol,
    symbols,
)

#: How strongly an operation binds its parts; a function, a name or a number binds most.
_BINDS: Mapping[str, int] = {"+": 1, "-": 1, "*": 2, "/": 2, "neg": 3, "**": 4}
_MOST = 5

#: Least number of nodes of a repeated part that gets a name.
_WORTH_A_NAME = 4


def spelled(node: Node, names: Mapping[Node, str] | None = None) -> str:
    """Return the text of an expression, valid in Python code and in the strings of a system.

    Parameters
    ----------
    node : Node
    names : mapping of Node to str, optional
        Parts to write as a name.
    """
    if isinstance(node, Constant):
        return repr(node.value).removesuffix(".0")
    if isinstance(node, Symbol):
        return node.name
    if names and node in names:
        return names[node]
    if node.name in OPERATIONS:
        return f"{node.name}({', '.join(spelled(argument, names) for argument in node.arguments)})"
    binds = _BINDS[node.name]
    if node.name == "neg":
        return f"-{_bracketed(node.arguments[0], binds, names)}"
    left, right = node.arguments
    if node.name == "**":
        return f"{_bracketed(left, _MOST, names)}**{spelled(right)}"
    space = " " if binds == _BINDS["+"] else ""
    return f"{_bracketed(left, binds, names)}{space}{node.name}{space}{_bracketed(right, binds + 1, names)}"


def _bracketed(node: Node, least: int, names: Mapping[Node, str] | None) -> str:
    """Return the text of a part, in parentheses if it binds less strongly than `least`."""
    text = spelled(node, names)
    if not isinstance(node, Operation) or (names and node in names):
        return text
    return text if _BINDS.get(node.name, _MOST) >= least else f"({text})"


def spelled_measure(kind: str, expressions: tuple[Node, ...], moment: Moment | None) -> str:
    """Return the text of a measure: ``max abs(x)`` for the expressions ``x`` and ``-x``."""
    if moment is None:
        return f"{kind} {_spelled_side(expressions)}"
    when = _spelled_condition(moment) if moment.is_of_condition else _spelled_side(moment.expressions)
    if kind == "count":
        return f"count {when}"
    return (
        f"time of {moment.kind} {when}"
        if kind == "time"
        else (f"value of {spelled(expressions[0])} at {moment.kind} {when}")
    )


def _spelled_condition(moment: Moment) -> str:
    """Return the text of a condition: ``abs(x) > 2`` for the expressions ``x - 2`` and ``-x - 2``."""
    pairs = [_sides(node) for node in moment.expressions]
    if len(pairs) == 2:
        (one, two), (other, three) = pairs
        if not moment.every and two == three and other == Operation("neg", (one,)):
            return f"abs({spelled(one)}) > {spelled(two)}"
        if moment.every and one == other and three == Operation("neg", (two,)):
            return f"abs({spelled(two)}) < {spelled(one)}"
    word = " and " if moment.every else " or "
    return word.join(f"{spelled(greater)} > {spelled(less)}" for greater, less in pairs)


def _sides(node: Node) -> tuple[Node, ...]:
    """Return what is greater than what where an expression is positive."""
    if not isinstance(node, Operation) or node.name != "-":
        return node, Constant(0.0)
    # a number of more than a turn without a unit is refused next to an angle
    large = any(isinstance(each, Constant) and each.value >= math.tau for each in node.arguments)
    return (node, Constant(0.0)) if large else node.arguments


def _spelled_side(expressions: tuple[Node, ...]) -> str:
    text = spelled(expressions[0])
    return f"abs({text})" if len(expressions) == 2 else text


def system_text(system: Definition) -> str:
    """Return a file that reads as this system; its attribute `text` is not used."""
    mark, returned = "system", system.rates
    if system.meridian is not None:
        # the rates follow from these
        mark, returned = "body", (system.meridian.height, system.meridian.axial, system.meridian.transverse)
    names, lines = _named_parts(system, returned)
    used = {operation.name for operation in _operations(returned)} & set(OPERATIONS)
    imported = ", ".join([mark, *(name for name in OPERATIONS if name in used)])
    words = "".join(f"    {name}={value},\n" for name, value in _words(system))
    values = ", ".join(spelled(node, names) for node in returned)
    title = [ascii(system.title)] if system.title else []
    body = "".join(f"    {line}\n" for line in [*title, *lines, f"return {values}"])
    return (
        f"from sweep.systems import {imported}\n\n\n"
        f"@{mark}(\n{words})\ndef {system.name}({', '.join(_arguments(system))}):\n{body}"
    )


def _named_parts(system: Definition, returned: Iterable[Node]) -> tuple[dict[Node, str], list[str]]:
    """Return names for the repeated parts of the returned expressions, and the lines that assign them."""
    times: Counter[Node] = Counter()
    order: list[tuple[Node, int]] = []

    def count(node: Node) -> int:
        """Count the occurrences of a part, and return its number of nodes."""
        if not isinstance(node, Operation):
            return 1
        times[node] += 1
        if times[node] > 1:
            return sizes[node]
        sizes[node] = 1 + sum(map(count, node.arguments))
        order.append((node, sizes[node]))
        return sizes[node]

    sizes: dict[Node, int] = {}
    for node in returned:
        count(node)
    taken = {state.name for state in (*system.states, *system.parameters)}
    fresh = (name for number in range(1, len(order) + len(taken) + 1) if (name := f"v{number}") not in taken)
    names: dict[Node, str] = {}
    lines = []
    for node, size in order:
        if times[node] > 1 and size >= _WORTH_A_NAME:
            text, name = spelled(node, names), next(fresh)
            names[node] = name
            lines.append(f"{name} = {text}")
    return names, lines


def _operations(nodes: Iterable[Node]) -> Iterator[Operation]:
    for node in nodes:
        if isinstance(node, Operation):
            yield node
            yield from _operations(node.arguments)


def _arguments(system: Definition) -> Iterator[str]:
    def argument(declared: Declared) -> str:
        unit = "" if declared.units == "1" else f': "{declared.units}"'
        return f"{declared.name}{unit} = {declared.default!r}"

    yield from map(argument, system.states)
    with_time = any(TIME in symbols(rate) for rate in system.rates)
    if system.parameters or with_time:
        yield "*"
    yield from map(argument, system.parameters)
    if with_time:
        yield TIME


def _words(system: Definition) -> Iterator[tuple[str, str]]:
    """Yield the keywords of the decorator with their values as Python code."""
    unit = "" if system.time_units == "1" else f" {system.time_units}"
    yield "duration", f'"{system.duration!r}{unit}"'
    if system.ends:
        yield (
            "ends",
            _table((event.name, _quoted(_comparison(event.any_positive, "or"))) for event in system.ends),
        )
    if system.measures:
        yield "measures", _table((measure.name, _quoted(measure.text)) for measure in system.measures)
    if system.labels:
        yield "label", _table((label.name, _condition(label)) for label in system.labels)
    if system.conserved and system.meridian is None:
        yield "conserved", f"[{', '.join(_quoted(spelled(node)) for node in system.conserved)}]"
    if system.stable:
        yield "stable", _quoted(system.stable)
    if system.theory:
        yield "theory", _table((name, _quoted(spelled(node))) for name, node in system.theory)


def _condition(label: Label) -> str:
    return _quoted(_comparison(label.all_positive, "and")) if label.all_positive else "True"


def _comparison(nodes: tuple[Node, ...], word: str) -> str:
    return f" {word} ".join(f"{spelled(node)} > 0" for node in nodes)


def _table(rows: Iterable[tuple[str, str]]) -> str:
    return "{" + ", ".join(f"{_quoted(name)}: {value}" for name, value in rows) + "}"


def _quoted(text: str) -> str:
    """Return text of a system in quotes; it contains no quotes and no backslashes."""
    return f'"{text}"'
