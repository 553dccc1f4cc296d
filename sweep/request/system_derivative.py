"""The derivative of an expression of a user's system, in the language of systems."""

from sweep.model.system.definition import Constant, Node, Symbol
from sweep.request.system_tree import Part, Tree
from sweep.request.system_units import PURE


class Derivative:
    """Derivatives with respect to one name; all other names are constants.

    Parameters
    ----------
    tree : Tree
        The tree that makes the derivatives; they share parts with the expression.
    name : str
        A state that is an angle or a pure number, so that differentiation keeps the units, which have been checked.
    """

    def __init__(self, tree: Tree, name: str) -> None:
        self._tree, self._name = tree, name
        # by identity: an expression that occurs several times is one object
        self._parts: dict[int, Part] = {}
        self._known: dict[int, Part] = {}

    def of(self, node: Node) -> Part:
        """Return the derivative of an expression.

        Raises
        ------
        RequestError
            If it is too large.
        """
        if not isinstance(node, Constant | Symbol):
            if id(node) not in self._known:
                self._known[id(node)] = self._differentiate(node.name, *node.arguments, whole=self.part(node))
            return self._known[id(node)]
        return self._number(float(node == Symbol(self._name)))

    def part(self, node: Node) -> Part:
        """Return an expression as a part of the tree, with the dimension of a pure number."""
        if isinstance(node, Constant | Symbol):
            return Part(node, PURE)
        if id(node) not in self._parts:
            inner = [self.part(each) for each in node.arguments]
            deep, nodes = 1 + max(each.deep for each in inner), 1 + sum(each.nodes for each in inner)
            self._parts[id(node)] = Part(node, PURE, deep, nodes)
        return self._parts[id(node)]

    def _number(self, value: float) -> Part:
        return Part(Constant(value), PURE)

    def _differentiate(self, operation: str, *arguments: Node, whole: Part) -> Part:
        tree, one = self._tree, self._number(1.0)
        rates = [self.of(each) for each in arguments]
        inner, *others = (self.part(each) for each in arguments)
        match operation:
            case "+" | "-":
                return self._add(operation, *rates)
            case "neg":
                return tree.negated(rates[0])
            case "*":
                return self._add("+", self._multiply(rates[0], others[0]), self._multiply(inner, rates[1]))
            case "/":
                above = self._add("-", rates[0], self._multiply(whole, rates[1]))
                return above if above.value == 0.0 else tree.multiplied("/", above, others[0])
            case "atan2":
                y, x = inner, others[0]
                above = self._add("-", self._multiply(x, rates[0]), self._multiply(y, rates[1]))
                squares = (tree.multiplied("*", part, part) for part in (y, x))
                return (
                    above if above.value == 0.0 else tree.multiplied("/", above, tree.summed("+", *squares))
                )
            case "**":
                power = others[0].value or 0.0
                less = one if power == 1.0 else tree.raised(inner, self._number(power - 1.0))
                slope = self._multiply(others[0], less)
            case "sin":
                slope = tree.called("cos", inner)
            case "cos":
                slope = tree.negated(tree.called("sin", inner))
            case "tan":
                slope = tree.summed("+", one, tree.multiplied("*", whole, whole))
            case "tanh":
                slope = tree.summed("-", one, tree.multiplied("*", whole, whole))
            case "exp":
                slope = whole
            case "log":
                slope = tree.multiplied("/", one, inner)
            case "sqrt":
                slope = tree.multiplied("/", self._number(0.5), whole)
            case _:
                raise AssertionError(f"unknown operation {operation}")
        return self._multiply(slope, rates[0])

    def _multiply(self, one: Part, two: Part) -> Part:
        if 0.0 in (one.value, two.value):
            return self._number(0.0)
        if 1.0 in (one.value, two.value):
            return two if one.value == 1.0 else one
        return self._tree.multiplied("*", one, two)

    def _add(self, sign: str, one: Part, two: Part) -> Part:
        if two.value == 0.0:
            return one
        if one.value == 0.0:
            return two if sign == "+" else self._tree.negated(two)
        return self._tree.summed(sign, one, two)
