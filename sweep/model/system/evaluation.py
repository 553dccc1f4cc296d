"""Values of expressions in plain Python, with the functions of `math`."""

import math
from collections.abc import Callable, Iterable, Mapping

from sweep.model.system.definition import Constant, Node, Symbol

_CALLS: Mapping[str, Callable[..., float]] = {
    "+": lambda one, two: one + two,
    "-": lambda one, two: one - two,
    "*": lambda one, two: one * two,
    "/": lambda one, two: one / two,
    "**": math.pow,
    "neg": lambda one: -one,
    "sin": math.sin,
    "cos": math.cos,
    "tan": math.tan,
    "exp": math.exp,
    "log": math.log,
    "sqrt": math.sqrt,
    "tanh": math.tanh,
    "atan2": math.atan2,
}


def operate(name: str, *values: float) -> float:
    """Return the value of an operation; NaN if it is not defined, such as 1/0, infinity if it overflows."""
    try:
        return _CALLS[name](*values)
    except (ValueError, ZeroDivisionError):
        return math.nan
    except OverflowError:
        return math.inf


def evaluated(nodes: Iterable[Node], values: Mapping[str, float]) -> tuple[float, ...]:
    """Return the values of expressions; a part that occurs several times as the same object is computed once.

    Parameters
    ----------
    nodes : iterable of Node
    values : mapping of str to float
        The values of all names, in the units of the system.
    """
    known: dict[int, float] = {}

    def value(node: Node) -> float:
        if isinstance(node, Constant):
            return node.value
        if isinstance(node, Symbol):
            return values[node.name]
        if id(node) not in known:
            known[id(node)] = operate(node.name, *map(value, node.arguments))
        return known[id(node)]

    return tuple(map(value, nodes))
