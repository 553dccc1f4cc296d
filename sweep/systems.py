"""Imports for a file of systems: the decorators ``@system(...)`` and ``@body(...)``, functions, and pi.

A decorator reads the source of the function and never calls it::

    from sweep.systems import system, sin

    @system(duration="20 s", label={"turning": "abs(angle) > pi", "swinging": True})
    def pendulum(angle: "rad" = 0.2, rate: "rad/s" = 1.0, *, natural: "rad/s" = 1.0):
        return rate, -natural**2*sin(angle)
"""

import inspect
import textwrap
from collections.abc import Callable, Mapping
from math import acos as acos
from math import asin as asin
from math import atan as atan
from math import atan2 as atan2
from math import cos as cos
from math import cosh as cosh
from math import exp as exp
from math import log as log
from math import pi as pi
from math import sin as sin
from math import sinh as sinh
from math import sqrt as sqrt
from math import tan as tan
from math import tanh as tanh
from pathlib import Path
from typing import Any

from sweep.errors import RequestError, shown
from sweep.model.system.definition import TIME, Definition
from sweep.model.system.evaluation import evaluated
from sweep.request.system_file import is_number, read_function

__all__ = [
    "System", "acos", "asin", "atan", "atan2", "body", "cos", "cosh", "exp", "log", "pi", "sin", "sinh", "sqrt",
    "system", "tan", "tanh",
]  # fmt: skip


class System:
    """A user's system, made by the decorator ``@system(...)`` or ``@body(...)``.

    Parameters
    ----------
    definition : Definition
    """

    def __init__(self, definition: Definition) -> None:
        self.definition = definition
        self.__name__, self.__doc__ = definition.name, definition.title or None

    def __repr__(self) -> str:
        """Return a short text for notebooks."""
        names = ", ".join(each.name for each in self.definition.states)
        return f"<system {self.definition.name} of {names}>"

    def __call__(self, *states: float, **parameters: float) -> tuple[float, ...]:
        """Return the rates of the states at one point.

        Parameters
        ----------
        *states : float
            Values in SI units; states that are not given have their start values.
        **parameters : float
            Parameters and states by name, in SI, and the time ``t``, 0 by default.

        Returns
        -------
        tuple of float
            NaN or infinity if a rate has no value.

        Raises
        ------
        TypeError
            As for any function, if an argument is unknown, repeated or one too many.
        """
        found = self.definition
        given = dict(zip((each.name for each in found.states), states, strict=False))
        known = {each.name: each.default for each in (*found.states, *found.parameters)} | {TIME: 0.0}
        strange = [name for name in parameters if name not in known or name in given]
        if strange or len(states) > len(found.states):
            raise TypeError(
                f"{found.name} has the states {', '.join(each.name for each in found.states)} and the keyword "
                f"arguments {', '.join(each.name for each in found.parameters)}; got {len(states)} states"
                + f" and {shown(', '.join(strange))}"
                * bool(strange)
            )
        return evaluated(found.rates, known | given | parameters)


def system(*args: Any, **words: Any) -> Callable[[Callable[..., Any]], System]:
    """Return a decorator that reads a system from the source of a function.

    Parameters
    ----------
    **words
        ``duration``, ``ends``, ``measures``, ``label``, ``conserved``, ``stable``, ``theory``. They are read from the
        source like the function, so a text must be a string literal.

    Raises
    ------
    RequestError
        From the decorator: if the source of the function cannot be found, or cannot be computed; with the line.
    """
    return _mark("system", args, words)


def body(*args: Any, **words: Any) -> Callable[[Callable[..., Any]], System]:
    """Return a decorator that reads a rolling body of revolution from the source of a function.

    The function returns three values (docs/own-system.md). The first is the height of the center of mass above the
    plane, divided by the radius, as a function of ``tilt``: the support function of the body's meridian. The others are
    the axial and the transverse moment of inertia about the center of mass, divided by mass times radius squared.

    Parameters
    ----------
    **words
        As in `system`, except ``conserved``: for a body this is the energy.

    Raises
    ------
    RequestError
        As in `system`; also if the meridian is not convex, or no body has these moments.
    """
    return _mark("body", args, words)


def _mark(
    name: str, args: tuple[Any, ...], words: Mapping[str, Any]
) -> Callable[[Callable[..., Any]], System]:
    def mark(function: Callable[..., Any]) -> System:
        try:
            lines, first = inspect.getsourcelines(function)
        # TypeError: the argument is not a function
        except (OSError, TypeError) as problem:
            raise RequestError(
                "The source of this system cannot be found; a system is read from its source.",
                hint="Write it in a file or in a notebook cell.",
                where=shown(getattr(function, "__name__", repr(function))),
            ) from problem
        path = Path(inspect.getsourcefile(function) or "")
        # a notebook cell has no file
        where = path.name if path.is_file() else "this cell"
        return System(read_function(textwrap.dedent("".join(lines)), where, first, _constants(function)))

    if len(args) == 1 and not words and callable(args[0]):
        has_units = name == "body" or bool(getattr(args[0], "__annotations__", {}))
        raise RequestError(
            f"@{name} needs at least the argument duration; got none.",
            hint=f'Write @{name}(duration="{"10 s" if has_units else "10"}").',
            where=shown(getattr(args[0], "__name__", repr(args[0]))),
        )
    return mark


def _constants(function: Callable[..., Any]) -> dict[str, float]:
    """Return the numbers that a function may use: globals of its module, and variables of enclosing functions."""
    found = dict(getattr(function, "__globals__", {}))
    cells = getattr(function, "__closure__", None) or ()
    for name, cell in zip(getattr(function, "__code__").co_freevars, cells, strict=True):  # noqa: B009
        found[name] = cell.cell_contents
    return {name: float(value) for name, value in found.items() if is_number(value)}
