"""A system as text: one spelling for all files that say the same, in ASCII.

What stands in several rates becomes a name ``v1``, ``v2``, ...; all numbers are in SI.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping

from sweep.model.system.definition import (
    FUNCTIONS,
    TIME,
    Constant,
    Declared,
    Definition,
    Label,
    Node,
    Operation,
    Symbol,
    symbols,
)

#: How strongly an operation binds its parts; a function, a name or a number binds most.
_BINDS: Mapping[str, int] = {"+": 1, "-": 1, "*": 2, "/": 2, "neg": 3, "**": 4}
_MOST = 5

#: Nodes from which on a part that stands in several places gets a name.
_WORTH_A_NAME = 4


def spelled(node: Node, names: Mapping[Node, str] | None = None) -> str:
    """Return the text of an expression, which Python and the reader of a system's strings read alike.

    Parameters
    ----------
    node : Node
    names : mapping of Node to str, optional
        Parts that are written as a name.
    """
    if isinstance(node, Constant):
        return repr(node.value).removesuffix(".0")
    if isinstance(node, Symbol):
        return node.name
    if names and node in names:
        return names[node]
    if node.name in FUNCTIONS:
        return f"{node.name}({spelled(node.arguments[0], names)})"
    binds = _BINDS[node.name]
    if node.name == "neg":
        return f"-{_bracketed(node.arguments[0], binds, names)}"
    left, right = node.arguments
    if node.name == "**":
        return f"{_bracketed(left, _MOST, names)}**{spelled(right)}"
    space = " " if binds == _BINDS["+"] else ""
    return f"{_bracketed(left, binds, names)}{space}{node.name}{space}{_bracketed(right, binds + 1, names)}"


def _bracketed(node: Node, least: int, names: Mapping[Node, str] | None) -> str:
    """Return the text of a part, in brackets if it binds less than it must."""
    text = spelled(node, names)
    if not isinstance(node, Operation) or (names and node in names):
        return text
    return text if _BINDS.get(node.name, _MOST) >= least else f"({text})"


def spelled_measure(kind: str, expressions: tuple[Node, ...]) -> str:
    """Return a measure as it is written: ``max abs(x)`` is that of ``x`` and ``-x``."""
    text = spelled(expressions[0])
    return f"{kind} abs({text})" if len(expressions) == 2 else f"{kind} {text}"


def system_text(system: Definition) -> str:
    """Return the file that gives this system when it is read; its own `text` plays no part."""
    mark, returned = "system", system.rates
    if system.meridian is not None:
        # the rates follow from what a body returns
        mark, returned = "body", (system.meridian.height, system.meridian.axial, system.meridian.transverse)
    names, lines = _named_parts(system, returned)
    used = {each.name for each in _operations(returned)} & set(FUNCTIONS)
    imported = ", ".join([mark, *(name for name in FUNCTIONS if name in used)])
    words = "".join(f"    {name}={value},\n" for name, value in _words(system))
    values = ", ".join(spelled(each, names) for each in returned)
    title = [ascii(system.title)] if system.title else []
    body = "".join(f"    {line}\n" for line in [*title, *lines, f"return {values}"])
    return (
        f"from sweep.systems import {imported}\n\n\n"
        f"@{mark}(\n{words})\ndef {system.name}({', '.join(_arguments(system))}):\n{body}"
    )


def _named_parts(system: Definition, returned: Iterable[Node]) -> tuple[dict[Node, str], list[str]]:
    """Return the names of what stands in several places of what is returned, and the lines that assign them."""
    times: Counter[Node] = Counter()
    order: list[tuple[Node, int]] = []

    def count(node: Node) -> int:
        """Count the places of a part, and return how many nodes it has."""
        if not isinstance(node, Operation):
            return 1
        times[node] += 1
        if times[node] > 1:
            return sizes[node]
        sizes[node] = 1 + sum(map(count, node.arguments))
        order.append((node, sizes[node]))
        return sizes[node]

    sizes: dict[Node, int] = {}
    for each in returned:
        count(each)
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
    def written(each: Declared) -> str:
        unit = "" if each.units == "1" else f': "{each.units}"'
        return f"{each.name}{unit} = {each.default!r}"

    yield from map(written, system.states)
    with_time = any(TIME in symbols(each) for each in system.rates)
    if system.parameters or with_time:
        yield "*"
    yield from map(written, system.parameters)
    if with_time:
        yield TIME


def _words(system: Definition) -> Iterator[tuple[str, str]]:
    """Yield the words of the decorator, each with its value as Python writes it."""
    unit = "" if system.time_units == "1" else f" {system.time_units}"
    yield "duration", f'"{system.duration!r}{unit}"'
    if system.ends:
        yield "ends", _table((each.name, _compared(each.any_positive, "or")) for each in system.ends)
    if system.measures:
        yield "measures", _table((each.name, _quoted(each.text)) for each in system.measures)
    if system.labels:
        yield "label", _table((each.name, _condition(each)) for each in system.labels)
    if system.conserved and system.meridian is None:
        yield "conserved", f"[{', '.join(_quoted(spelled(each)) for each in system.conserved)}]"
    if system.stable:
        yield "stable", _quoted(system.stable)
    if system.theory:
        yield "theory", _table((name, _quoted(spelled(node))) for name, node in system.theory)


def _condition(label: Label) -> str:
    return _compared(label.all_positive, "and") if label.all_positive else "True"


def _compared(nodes: tuple[Node, ...], word: str) -> str:
    return _quoted(f" {word} ".join(f"{spelled(each)} > 0" for each in nodes))


def _table(rows: Iterable[tuple[str, str]]) -> str:
    return "{" + ", ".join(f"{_quoted(name)}: {value}" for name, value in rows) + "}"


def _quoted(text: str) -> str:
    """Return text of a system, which has neither quotes nor backslashes, in quotes."""
    return f'"{text}"'
