"""Systems by other means: DOP853 in a compiled loop over cells with libm, and SciPy's DOP853.

The loop is what one would write in C: every stage is unrolled in local variables, and powers are products and roots.
"""

import math
from typing import Any

import numba
import numpy as np
from scipy.integrate import solve_ivp
from scipy.integrate._ivp import dop853_coefficients as table

from bench.problem import Array
from kernels.system.series import power
from sweep.model.system.definition import Constant, Definition, Node, Symbol

_STAGES = table.N_STAGES


def _rates_source(definition: Definition) -> str:
    """Return the right-hand side as source of a function of the states, the time and the parameters."""
    lines: list[str] = []
    names: dict[int, str] = {}

    def text(node: Node) -> str:
        if isinstance(node, Constant):
            return f"({node.value!r})"
        if isinstance(node, Symbol):
            return node.name
        if id(node) not in names:
            names[id(node)] = f"v{len(names)}"
            given = [text(each) for each in node.arguments]
            lines.append(f"    {names[id(node)]} = {_operation(node, given)}")
        return names[id(node)]

    found = ", ".join(text(each) for each in definition.rates)
    parameters = [each.name for each in definition.parameters]
    head = ", ".join([*(each.name for each in definition.states), "t", *parameters])
    return "\n".join([f"def rates({head}):", *lines, f"    return ({found},)"])


def _operation(node: Any, given: list[str]) -> str:
    if node.name == "**":
        return str(power(given[0], f"(1.0 / {given[0]})", node.arguments[1].value))
    if node.name in ("+", "-", "*", "/"):
        return f"{given[0]} {node.name} {given[1]}"
    return f"-{given[0]}" if node.name == "neg" else f"math.{node.name}({given[0]})"


def _terms(coefficients: Array, state: int) -> str:
    return " + ".join(f"{float(c)!r} * k{j}_{state}" for j, c in enumerate(coefficients) if c != 0.0) or "0.0"


def _loop_source(definition: Definition) -> str:
    """Return the source of the loop over cells: steps of DOP853 with Hairer's error and step control."""
    states, count = range(len(definition.states)), len(definition.states)
    given = ", ".join(f"p{i}" for i in range(len(definition.parameters)))

    def slopes(stage: int, at: list[str], time: str) -> str:
        return f"{', '.join(f'k{stage}_{i}' for i in states)}, = rates({', '.join(at)}, {time}, {given})"

    step = [
        slopes(
            j, [f"y{i} + h * ({_terms(table.A[j, :j], i)})" for i in states], f"t + {float(table.C[j])!r} * h"
        )
        for j in range(1, _STAGES)
    ]
    for i in states:
        step.append(f"n{i} = y{i} + h * ({_terms(table.B, i)})")
        step.append(f"w{i} = 1.0 / (tol + tol * max(abs(y{i}), abs(n{i})))")
    fifth, third = (
        " + ".join(f"(({_terms(each, i)}) * w{i})**2" for i in states) for each in (table.E5, table.E3)
    )
    step += [
        f"five, three = {fifth}, {third}",
        f"below = (five + 0.01 * three) * {float(count)!r}",
        "error = h * five / math.sqrt(below) if below > 0.0 else 0.0",
        "factor = min(5.0, max(0.2, 0.9 * max(error, 1e-12)**-0.125))",
        "if error <= 1.0:",
        "    t += h",
        *(f"    y{i} = n{i}" for i in states),
        f"    {slopes(0, [f'y{i}' for i in states], 't')}",
        "h = min(h * factor, end - t)",
    ]
    return "\n".join([
        "def loop(starts, end, tol, found):",
        "    for cell in range(starts.shape[1]):",
        *(f"        y{i} = starts[{i}, cell]" for i in states),
        *(f"        p{i} = starts[{count + i}, cell]" for i in range(len(definition.parameters))),
        "        t, h = 0.0, min(1e-3, end)",
        f"        {slopes(0, [f'y{i}' for i in states], 't')}",
        "        while t < end * (1.0 - 1e-14):",
        *(f"            {line}" for line in step),
        *(f"        found[{i}, cell] = y{i}" for i in states),
    ])  # fmt: skip


class Loop:
    """DOP853 in a compiled loop over cells, with libm.

    Parameters
    ----------
    definition : Definition
    """

    def __init__(self, definition: Definition) -> None:
        space: dict[str, Any] = {"math": math}
        exec(_rates_source(definition), space)
        space["rates"] = numba.njit(inline="always")(space["rates"])
        exec(_loop_source(definition), space)
        self._loop, self._definition = numba.njit(error_model="numpy")(space["loop"]), definition

    def __call__(self, starts: Array, tolerance: float) -> Array:
        """Return the states of cells at the end of the duration."""
        found = np.empty((len(self._definition.states), starts.shape[1]))
        self._loop(starts, self._definition.duration, tolerance, found)
        return found


class Scipy:
    """SciPy's DOP853 with a right-hand side in Python.

    Parameters
    ----------
    definition : Definition
    """

    def __init__(self, definition: Definition) -> None:
        space: dict[str, Any] = {"math": math}
        exec(_rates_source(definition), space)
        self._rates, self._definition = space["rates"], definition

    def __call__(self, starts: Array, tolerance: float) -> Array:
        """Return the states of cells at the end of the duration."""
        count, rates = len(self._definition.states), self._rates
        found = np.empty((count, starts.shape[1]))
        for cell, column in enumerate(starts.T.tolist()):
            known = tuple(column[count:])
            done = solve_ivp(
                lambda t, y, *given: rates(*y.tolist(), t, *given), (0.0, self._definition.duration), column[:count],
                method="DOP853", rtol=max(tolerance, 3e-14), atol=tolerance, args=known,
            )  # fmt: skip
            found[:, cell] = done.y[:, -1]
        return found
