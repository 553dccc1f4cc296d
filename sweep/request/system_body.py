"""The body of a user's right-hand side: conversion of Python's syntax tree to expressions; all else is refused."""

import ast
from collections.abc import Mapping
from typing import NoReturn

from sweep.errors import RequestError, counted, shown
from sweep.model.system.definition import FUNCTIONS, TIME, Declared, Node, symbols
from sweep.model.system.evaluation import evaluated
from sweep.model.system.spelling import spelled
from sweep.request.system_source import Source
from sweep.request.system_tree import MOST_DEEP, NUMBERS, Part, Tree, check_nodes, refuse_kink, refuse_size
from sweep.request.system_units import PURE, SECOND, alike, product, told

_SIGNS: Mapping[type[ast.operator], str] = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}

_ONE_EACH = "Give each number its own name, on a separate line: x1 = expression."
_PLAIN = "Use only numbers, names, + - * / **, brackets and functions."

#: Syntax that an expression may not contain -> its name, and a hint.
_NO_EXPRESSION: Mapping[type[ast.expr], tuple[str, str]] = {
    ast.Compare: ("a comparison", "Write it as an ending or a label, such as ends={'fell': 'x > 2'}."),
    ast.BoolOp: (
        "a condition with and, or",
        "Write it as an ending or a label, such as ends={'fell': 'x > 2 or y > 2'}.",
    ),
    ast.Subscript: ("a subscript", "Give each number its own name: x1, x2."),
    ast.Attribute: ("a dotted name", "Write sin(x), after from sweep.systems import sin."),
    ast.Lambda: ("a function", "Write the expression itself."),
    ast.Tuple: ("a group of values", _ONE_EACH),
    ast.List: ("a list", _ONE_EACH),
    ast.Dict: ("a table", _ONE_EACH),
    ast.Set: ("a set", _ONE_EACH),
    ast.ListComp: ("a loop", "Write the terms out: x1 + x2 + x3."),
    ast.GeneratorExp: ("a loop", "Write the terms out: x1 + x2 + x3."),
    ast.NamedExpr: ("an assignment", "Write name = expression on a separate line."),
    ast.JoinedStr: ("a text", "Write a number; a number with a unit must be a parameter."),
}

#: Statements that a body may not contain -> their name, and a hint.
_NO_STATEMENT: Mapping[type[ast.stmt], tuple[str, str]] = {
    ast.For: ("a loop", "Write the terms out: x1 + x2 + x3."),
    ast.While: ("a loop", "Write the terms out: x1 + x2 + x3."),
    ast.AugAssign: ("an assignment with an operator", "Write it out: y = y*2."),
    ast.AnnAssign: ("an annotation", "Write name = expression: its unit follows from the expression."),
    ast.FunctionDef: ("a function", "Write name = expression."),
    ast.Import: ("an import", "Write it at the top of the file."),
    ast.ImportFrom: ("an import", "Write it at the top of the file."),
    ast.Expr: ("an expression without a name", "Write name = expression, or return."),
    ast.Assert: ("the word assert", "Remove it: endings define where a motion ends."),
    ast.Raise: ("the word raise", "Remove it: endings define where a motion ends."),
    ast.Pass: ("the word pass", "Remove it."),
}


class Arithmetic:
    """A reader of Python's syntax trees of expressions.

    Parameters
    ----------
    source : Source
    tree : Tree
    """

    def __init__(self, source: Source, tree: Tree) -> None:
        self._source, self._tree = source, tree
        #: The names read so far.
        self.used: set[str] = set()

    def part(self, node: ast.expr, deep: int = 0) -> Part:
        """Return the expression of a syntax tree.

        Raises
        ------
        RequestError
            If it contains syntax that is not allowed, or its units do not fit; with its line.
        """
        with self._source.at(node):
            if deep > 2 * MOST_DEEP:
                refuse_size()
            parts = [self.part(each, deep + 1) for each in _operands(node)]
            self._tree.place = node.lineno
            return self._build_part(node, parts)

    def number(self, node: ast.expr) -> float:
        """Return the value of an expression that contains only numbers."""
        if is_collection(node):
            self._source.refuse(
                node.lineno, "this must be one number", "Write a number, such as 0.5 or pi/2."
            )
        value = self.part(node).value
        if value is None:
            self._source.refuse(node.lineno, "this must be a number", "Write a number, such as 0.5 or pi/2.")
        return value

    def _build_part(self, node: ast.expr, parts: list[Part]) -> Part:
        match node:
            case ast.Constant(value=(int() | float()) as value) if not isinstance(value, bool):
                return self._tree.number(_as_float(value))
            case ast.Constant():
                raise RequestError(
                    f"{shown(repr(node.value))} is not a number",
                    hint="Write a number; a number with a unit must be a parameter.",
                )
            case ast.Name():
                self.used.add(node.id)
                return self._tree.named(node.id)
            case ast.UnaryOp(op=ast.USub()):
                return self._tree.negated(parts[0])
            case ast.UnaryOp(op=ast.UAdd()):
                return parts[0]
            case ast.BinOp(op=ast.Add() | ast.Sub()):
                return self._tree.summed(_SIGNS[type(node.op)], *parts)
            case ast.BinOp(op=ast.Mult() | ast.Div()):
                return self._tree.multiplied(_SIGNS[type(node.op)], *parts)
            case ast.BinOp(op=ast.Pow()):
                return self._tree.raised(*parts)
            case ast.Call(func=ast.Name(id=name), keywords=[]):
                return self._tree.called(name, *parts)
        _refuse_expression(node)


def is_collection(node: ast.expr | None) -> bool:
    """Return whether an expression is a list, a tuple, a dict or a set."""
    return isinstance(node, ast.List | ast.Tuple | ast.Dict | ast.Set)


def _operands(node: ast.expr) -> list[ast.expr]:
    """Return the operands of an allowed operation; an empty list for any other expression."""
    match node:
        case ast.UnaryOp(op=ast.USub() | ast.UAdd()):
            return [node.operand]
        case ast.BinOp(op=ast.Add() | ast.Sub() | ast.Mult() | ast.Div() | ast.Pow()):
            return [node.left, node.right]
        case ast.Call(func=ast.Name(id=name), keywords=[]) if name in FUNCTIONS:
            return node.args
    return []


def _as_float(value: float) -> float:
    try:
        return float(value)
    except OverflowError:
        raise RequestError("this number is too large for a float", hint="Write a smaller one.") from None


def _refuse_expression(node: ast.expr) -> NoReturn:
    if isinstance(node, ast.IfExp):
        refuse_kink(
            "a choice with if", "Write a smooth step such as (1 + tanh(x/width))/2, or make it an ending."
        )
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
        what, instead = _NO_EXPRESSION[ast.Attribute]
        raise RequestError(f"{what} is not allowed in an expression", hint=instead)
    if isinstance(node, ast.Call):
        raise RequestError("a function must be called by its name, without keywords", hint="Write sin(x).")
    if isinstance(node, ast.BinOp | ast.UnaryOp):
        name = type(node.op).__name__
        what = {"Mod": "the remainder %", "FloorDiv": "the sign //", "BitXor": "the sign ^"}.get(
            name, "this sign"
        )
        if name in ("Mod", "FloorDiv"):
            refuse_kink(what, "Leave it out: angles may exceed a full turn.")
        hint = "Write ** for a power." if name == "BitXor" else _PLAIN
        raise RequestError(f"{what} is not allowed in an expression", hint=hint)
    what, instead = _NO_EXPRESSION.get(type(node), ("this", _PLAIN))
    raise RequestError(f"{what} is not allowed in an expression", hint=instead)


class Body:
    """A reader of the lines of a right-hand side.

    Parameters
    ----------
    source : Source
    tree : Tree
        The tree that makes the expressions; its `names` are the arguments and the constants.
    states : tuple of Declared
    fixed : frozenset of str
        Names that no line may assign: arguments, functions, numbers.
    """

    def __init__(
        self, source: Source, tree: Tree, states: tuple[Declared, ...], fixed: frozenset[str]
    ) -> None:
        self._source, self._tree, self._states, self._fixed = source, tree, states, fixed
        self._arithmetic = Arithmetic(source, tree)
        # assigned names -> their lines
        self._waiting: dict[str, ast.stmt] = {}

    def read(self, function: ast.FunctionDef, time_units: str) -> tuple[Node, ...]:
        """Return the rates of the states.

        Raises
        ------
        RequestError
            With the line.
        """
        states = self._states
        names = ", ".join(f"d{each.name}" for each in states)
        line, nodes = self.returned(function, names, "Return the rate of each state.")
        if len(nodes) != len(states):
            told = ", ".join(each.name for each in states)
            self._source.refuse(
                line.lineno,
                f"the system has {counted(len(states), 'state')} ({told}), but return has "
                f"{counted(len(nodes), 'value')}",
                "Return the rate of each state, in the order of the states.",
            )
        parts = self.parts(nodes)
        with self._source.at(line):
            check_nodes(parts)
        for state, node, part in zip(states, nodes, parts, strict=True):
            self._check_rate(state, node, part, time_units)
        return tuple(part.node for part in parts)

    def returned(
        self, function: ast.FunctionDef, names: str, instead: str
    ) -> tuple[ast.Return, list[ast.expr]]:
        """Read the lines before ``return``, and return this line and its values, which `parts` reads.

        Parameters
        ----------
        function : ast.FunctionDef
        names : str
            The expected values, for hints.
        instead : str
            The hint for an empty ``return``.

        Raises
        ------
        RequestError
            With the line.
        """
        lines = function.body[ast.get_docstring(function) is not None :]
        if not lines or not isinstance(lines[-1], ast.Return):
            last = lines[-1] if lines else function
            if not isinstance(last, ast.Assign | ast.FunctionDef):
                self._refuse_line(last)
            self._source.refuse(
                last.lineno, "the function ends without return", f"End it with return {names}."
            )
        # an assigned name hides a constant with the same name
        assigned = {found[0] for line in lines if (found := _assignment(line))}
        for name in assigned - self._fixed:
            self._tree.names.pop(name, None)
        for line in lines[:-1]:
            self._assign(line)
        value = lines[-1].value
        if value is None:
            self._source.refuse(lines[-1].lineno, "nothing is returned", instead)
        if is_collection(value) and not isinstance(value, ast.Tuple):
            self._source.refuse(
                lines[-1].lineno,
                "the values after return must not be in a list, a set or a dict",
                f"Write return {names}.",
            )
        return lines[-1], value.elts if isinstance(value, ast.Tuple) else [value]

    def parts(self, nodes: list[ast.expr]) -> list[Part]:
        """Return the expressions after ``return``; refuse an assigned name that is not used."""
        found = [self._arithmetic.part(node) for node in nodes]
        for name, line in self._waiting.items():
            if name not in self._arithmetic.used:
                self._refuse_unused(name, line)
        return found

    def _assign(self, line: ast.stmt) -> None:
        found = _assignment(line)
        if found is None:
            self._refuse_line(line)
        name, value = found
        if name in self._fixed:
            kind = "a function or a number" if name in (*FUNCTIONS, *NUMBERS) else "an argument"
            self._source.refuse(
                line.lineno,
                f"the name {name} cannot be assigned, because it is {kind}",
                "Choose another name.",
            )
        part = self._arithmetic.part(value)
        if name in self._waiting and name not in self._arithmetic.used:
            self._refuse_unused(name, self._waiting[name])
        self._arithmetic.used.discard(name)
        self._tree.names[name] = part
        self._waiting[name] = line

    def _refuse_unused(self, name: str, line: ast.stmt) -> NoReturn:
        self._source.refuse(
            line.lineno, f"the name {shown(name)} is not used", "Remove this line, or use the name."
        )

    def _refuse_line(self, line: ast.stmt) -> NoReturn:
        with self._source.at(line):
            if isinstance(line, ast.If):
                refuse_kink(
                    "a choice with if",
                    "Write a smooth step such as (1 + tanh(x/width))/2, or make it an ending.",
                )
            if isinstance(line, ast.Return):
                raise RequestError("only the last line may be return", hint="Remove this one.")
            what, instead = _NO_STATEMENT.get(
                type(line), ("this", "A line is name = expression; the last one is return.")
            )
            if isinstance(line, ast.Assign):
                what, instead = "an assignment of this form", "Write one name = expression in each line."
            raise RequestError(f"{what} is not allowed in a right-hand side", hint=instead)
        raise AssertionError("it was refused")

    def _check_rate(self, state: Declared, node: ast.expr, part: Part, time_units: str) -> None:
        own = self._tree.names[state.name].dimension or PURE
        wanted = product(own, PURE if time_units == "1" else SECOND, -1.0)
        if part.dimension is None or alike(part.dimension, wanted):
            return
        hint = "Check the formula and the units of the arguments."
        if time_units == "1" and alike(part.dimension, product(own, SECOND, -1.0)):
            hint = 'Give the duration a unit, as in duration="10 s".'
        elif time_units != "1" and alike(part.dimension, own):
            hint = 'Write the duration without a unit, as in duration="10", or give the arguments units.'
        self._source.refuse(
            node.lineno,
            f"the rate of {state.name} must be {told(wanted)}; {part} is {told(part.dimension)}",
            hint,
        )


def check_start(source: Source, tree: Tree, declared: tuple[Declared, ...], rates: tuple[Node, ...]) -> None:
    """Refuse rates that are not finite at the default start, naming the line of the first value that is not finite."""
    start = {each.name: each.default for each in declared} | {TIME: 0.0}
    made = list(tree.made)
    values = evaluated([node for node, _ in made], start)
    for (node, line), value in zip(made, values, strict=True):
        if value - value != 0.0:
            told_start = ", ".join(f"{name} = {start[name]:g}" for name in sorted(set(symbols(node))))
            source.refuse(
                int(str(line)),
                f"the value of {shown(spelled(node))} is not finite at the start, where {shown(told_start)}",
                "Choose another start or another default value.",
            )


def _assignment(line: ast.stmt) -> tuple[str, ast.expr] | None:
    """Return the name and the expression of ``name = expression``."""
    match line:
        case ast.Assign(targets=[ast.Name(id=name)], value=value):
            return name, value
    return None
