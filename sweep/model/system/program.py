"""Translation of expressions to the program of the kernels (`kernels.system.series`): each value is computed once."""

import math
from collections.abc import Iterable

from sweep.model.system.definition import TIME, Constant, Definition, Node, Symbol

#: An instruction: an operation, and the indices of earlier instructions, or a number.
Instruction = tuple[str | int | float, ...]


class Program:
    """The instructions of expressions of a definition.

    Attributes
    ----------
    instructions : list of tuple
    """

    def __init__(self, definition: Definition) -> None:
        self.instructions = list[Instruction]()
        self._numbers: dict[Instruction, int] = {}
        self._known: dict[int, tuple[Node, int]] = {}
        self._leaves: dict[str, Instruction] = {TIME: ("time",)}
        for kind, row in (("state", definition.states), ("parameter", definition.parameters)):
            self._leaves |= {declared.name: (kind, number) for number, declared in enumerate(row)}

    def add(self, nodes: Iterable[Node]) -> tuple[int, ...]:
        """Add the instructions of expressions, and return the indices of their values."""
        return tuple(self._number_of(node) for node in nodes)

    def _number_of(self, node: Node) -> int:
        # an expression that occurs several times is one object
        if id(node) not in self._known:
            self._known[id(node)] = node, self._add_node(node)
        return self._known[id(node)][1]

    def _add_node(self, node: Node) -> int:
        if isinstance(node, Constant):
            return self._instruction("number", float(node.value))
        if isinstance(node, Symbol):
            return self._instruction(*self._leaves[node.name])
        if node.name == "**":
            base, exponent = node.arguments
            power = float(exponent.value) if isinstance(exponent, Constant) else math.nan
            return self._number_of(base) if power == 1.0 else self._power(self._number_of(base), power)
        given = tuple(map(self._number_of, node.arguments))
        if node.name == "atan2":
            squares = (self._instruction("*", number, number) for number in given)
            given = *given, self._instruction("+", *squares)
        return self._instruction(node.name, *given)

    def _power(self, base: int, exponent: float) -> int:
        """Add a power: integer powers as products, defined at 0 and below; below -8 as 1 over a product."""
        if exponent != int(exponent) or exponent in (2.0, 3.0, 4.0) or abs(exponent) > 1024.0:
            return self._instruction("**", base, exponent)
        if exponent < -8.0:
            return self._instruction("/", self._instruction("number", 1.0), self._power(base, -exponent))
        if exponent < 0.0:
            return self._instruction("**", base, exponent)
        if exponent == 0.0:
            return self._instruction("number", 1.0)
        half = self._power(base, float(exponent // 2)) if exponent > 3.0 else base
        square = self._instruction("**", half, 2.0) if exponent > 3.0 else base
        return self._instruction("*", square, base) if exponent % 2.0 else square

    def _instruction(self, *parts: str | int | float) -> int:
        if parts not in self._numbers:
            self._numbers[parts] = len(self.instructions)
            self.instructions.append(parts)
        return self._numbers[parts]
