"""Values of expressions for many cells at once, with NumPy."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from sweep.model.quantity import Array, Truths
from sweep.model.system.definition import Constant, Label, Node, Symbol, symbols

_OPERATIONS: Mapping[str, Callable[..., Any]] = {
    "+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide, "**": np.power, "neg": np.negative,
    "sin": np.sin, "cos": np.cos, "tan": np.tan, "exp": np.exp, "log": np.log, "sqrt": np.sqrt, "tanh": np.tanh,
    "atan2": np.arctan2,
}  # fmt: skip


def evaluated(nodes: Sequence[Node], values: Mapping[str, Any]) -> list[Array]:
    """Return the values of expressions; NaN where they are not defined.

    Parameters
    ----------
    nodes : sequence of Node
    values : mapping of str to array or float
        States, parameters and ``t``, in the units of the definition.
    """
    known: dict[int, Array] = {}

    def value(node: Node) -> Array:
        if isinstance(node, Constant):
            return np.asarray(node.value)
        if isinstance(node, Symbol):
            return np.asarray(values[node.name], np.float64)
        # an expression that occurs several times is one object
        if id(node) not in known:
            known[id(node)] = np.asarray(_OPERATIONS[node.name](*map(value, node.arguments)))
        return known[id(node)]

    with np.errstate(all="ignore"):
        return [value(node) for node in nodes]


class Expressions:
    """Expressions to evaluate many times, as a list of operations; operations on parameters only are done once.

    Parameters
    ----------
    nodes : sequence of Node
    variables : sequence of str
        The names whose values change.
    fixed : mapping of str to array
        The values of all other names.
    """

    def __init__(self, nodes: Sequence[Node], variables: Sequence[str], fixed: Mapping[str, Any]) -> None:
        # the numbered values begin with the variables; None stands for a value that changes
        self._values: list[Any] = [None] * len(variables)
        self._operations = list[tuple[Callable[..., Any], int, tuple[int, ...]]]()
        self._numbers: dict[str | int, int] = {name: number for number, name in enumerate(variables)}
        self._wanted = [self._number_of(node, fixed) for node in nodes]

    def _number_of(self, node: Node, fixed: Mapping[str, Any]) -> int:
        # an expression that occurs several times is one object
        key = node.name if isinstance(node, Symbol) else id(node)
        if key not in self._numbers:
            value = self._add_node(node, fixed)
            self._numbers[key] = len(self._values)
            self._values.append(value)
        return self._numbers[key]

    def _add_node(self, node: Node, fixed: Mapping[str, Any]) -> Any:
        """Return the value of a new node; if it changes, add its operation and return None."""
        if isinstance(node, Constant):
            return np.float64(node.value)
        if isinstance(node, Symbol):
            return np.asarray(fixed[node.name], np.float64)
        operation = _OPERATIONS[node.name]
        arguments = tuple(self._number_of(argument, fixed) for argument in node.arguments)
        values = [self._values[number] for number in arguments]
        if all(value is not None for value in values):
            return operation(*values)
        self._operations.append((operation, len(self._values), arguments))
        return None

    def values(self, variables: Sequence[Any]) -> list[Any]:
        """Return the values of the expressions for values of the variables; NaN where they are not defined."""
        values = self._values.copy()
        values[: len(variables)] = variables
        for operation, number, arguments in self._operations:
            values[number] = operation(*[values[argument] for argument in arguments])
        return [values[number] for number in self._wanted]


def sizes(nodes: Sequence[Node], values: Mapping[str, Any]) -> list[Array]:
    """Return the sums of the magnitudes of the terms of expressions, which scale their rounding errors."""

    def size(node: Node) -> Array:
        if isinstance(node, Constant | Symbol) or node.name not in ("+", "-", "*", "/", "neg"):
            return np.asarray(np.abs(evaluated([node], values)[0]))
        parts = [size(argument) for argument in node.arguments]
        operation = _OPERATIONS["+" if node.name == "-" else node.name]
        return parts[0] if node.name == "neg" else np.asarray(operation(*parts))

    with np.errstate(all="ignore"):
        return [size(node) for node in nodes]


def off_by(node: Node, values: Mapping[str, Any], errors: Mapping[str, Array]) -> Array:
    """Return the error of an expression from the errors of names in it: the sum of the effects of each.

    Parameters
    ----------
    node : Node
    values : mapping of str to array or float
        As in `evaluated`.
    errors : mapping of str to array
        The errors of some of the names.
    """
    value = evaluated([node], values)[0]
    error = np.zeros(np.shape(value))
    for name in sorted({*symbols(node)} & {*errors}):
        changes = [
            np.abs(evaluated([node], {**values, name: values[name] + sign * errors[name]})[0] - value)
            for sign in (1.0, -1.0)
        ]
        error = error + np.fmax(*changes)
    return error


def labels_of(
    labels: Sequence[Label], values: Mapping[str, Any], shape: tuple[int, ...]
) -> np.ndarray[Any, Any]:
    """Return the number of the first label that fits, counted from 1, int8; 0 where none fits.

    Parameters
    ----------
    labels : sequence of Label
    values : mapping of str to array, shape `shape`
    shape : tuple of int
    """
    numbers = np.zeros(shape, np.int8)
    for number, label in reversed([*enumerate(labels, 1)]):
        fits: Truths = np.ones(shape, bool)
        for value in evaluated(label.all_positive, values):
            fits = fits & (value > 0.0)
        numbers[fits] = number
    return numbers
