"""Imports for a file of systems: the marks ``@system(...)`` and ``@body(...)``, functions, and a number.

A mark reads the source of the function and never calls it::

    from sweep.systems import system, sin

    @system(duration="20 s", label={"turning": "abs(angle) > pi", "swinging": True})
    def pendulum(angle: "rad" = 0.2, rate: "rad/s" = 1.0, *, natural: "rad/s" = 1.0):
        return rate, -natural**2*sin(angle)
"""

import inspect
import textwrap
from collections.abc import Callable, Mapping
from math import cos as cos
from math import exp as exp
from math import log as log
from math import pi as pi
from math import sin as sin
from math import sqrt as sqrt
from math import tan as tan
from math import tanh as tanh
from pathlib import Path
from typing import Any

from sweep.errors import RequestError, shown
from sweep.model.system.definition import TIME, Definition
from sweep.model.system.evaluation import evaluated
from sweep.request.system_file import is_number, read_function

__all__ = ["System", "body", "cos", "exp", "log", "pi", "sin", "sqrt", "system", "tan", "tanh"]


class System:
    """A system of a user, made by the mark ``@system(...)``.

    Parameters
    ----------
    definition : Definition
    """

    def __init__(self, definition: Definition) -> None:
        self.definition = definition
        self.__name__, self.__doc__ = definition.name, definition.title or None

    def __repr__(self) -> str:
        """Return what a notebook shows."""
        names = ", ".join(each.name for each in self.definition.states)
        return f"<system {self.definition.name} of {names}>"

    def __call__(self, *states: float, **parameters: float) -> tuple[float, ...]:
        """Return the rates of the states at one place.

        Parameters
        ----------
        *states : float
            In their units in SI; the start for those that are left out.
        **parameters : float
            Parameters and states by name, in SI, and ``t`` [time], which is 0 otherwise.

        Returns
        -------
        tuple of float
            NaN or infinity where a rate has no value.

        Raises
        ------
        TypeError
            As of any function that is called with other arguments than it has.
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
    """Return a mark that reads a system from the source of a function.

    Parameters
    ----------
    **words
        ``duration``, ``ends``, ``measures``, ``label``, ``conserved``, ``stable``, ``theory``. They are read from the
        source like the function: a text stands there itself, in quotes.

    Raises
    ------
    RequestError
        When it marks a function: if its source cannot be found, or what it says cannot be computed; with the line.
    """
    return _mark("system", args, words)


def body(*args: Any, **words: Any) -> Callable[[Callable[..., Any]], System]:
    """Return a mark that reads a body of revolution, which rolls on a plane, from the source of a function.

    The function returns the height of the centre of mass over the plane, over the radius, as a function of ``tilt``,
    which is the support function of the body's meridian, and the axial and the transverse moment of inertia about the
    centre of mass, over mass times radius squared (docs/own-system.md).

    Parameters
    ----------
    **words
        Those of `system`, except for ``conserved``: of a body that is its energy.

    Raises
    ------
    RequestError
        Also if the meridian is not convex, or the moments are those of no body.
    """
    return _mark("body", args, words)


def _mark(
    name: str, args: tuple[Any, ...], words: Mapping[str, Any]
) -> Callable[[Callable[..., Any]], System]:
    def mark(function: Callable[..., Any]) -> System:
        try:
            lines, first = inspect.getsourcelines(function)
        # TypeError: of what is no function
        except (OSError, TypeError) as problem:
            raise RequestError(
                "The source of this system cannot be found, and it is read from its source.",
                hint="Write it in a file or in a cell of a notebook.",
                where=shown(getattr(function, "__name__", repr(function))),
            ) from problem
        path = Path(inspect.getsourcefile(function) or "")
        # a cell of a notebook has a name of digits
        where = path.name if path.is_file() else "this cell"
        return System(read_function(textwrap.dedent("".join(lines)), where, first, _constants(function)))

    if len(args) == 1 and not words and callable(args[0]):
        has_units = name == "body" or bool(getattr(args[0], "__annotations__", {}))
        raise RequestError(
            f"@{name} has no words: duration is missing.",
            hint=f'Write @{name}(duration="{"10 s" if has_units else "10"}").',
            where=shown(getattr(args[0], "__name__", repr(args[0]))),
        )
    return mark


def _constants(function: Callable[..., Any]) -> dict[str, float]:
    """Return the numbers that a function may name: of its module, and of a function around it."""
    found = dict(getattr(function, "__globals__", {}))
    cells = getattr(function, "__closure__", None) or ()
    for name, cell in zip(getattr(function, "__code__").co_freevars, cells, strict=True):  # noqa: B009
        found[name] = cell.cell_contents
    return {name: float(value) for name, value in found.items() if is_number(value)}
