"""A system of ordinary differential equations as data, for the atlas that carries it and for its kernels.

An expression is a tree of numbers, names and operations; Python never executes it. Units are SI, as in files, in CF's
spelling; ``1`` for a pure number. All numbers are in these units.
"""

from collections.abc import Iterator
from dataclasses import dataclass


@dataclass(frozen=True)
class Constant:
    """A number."""

    value: float


@dataclass(frozen=True)
class Symbol:
    """A state, a parameter, or the time ``t``."""

    name: str


@dataclass(frozen=True)
class Operation:
    """An operation or a function of one or two expressions.

    Parameters
    ----------
    name : str
        ``+``, ``-``, ``*``, ``/``, ``atan2`` of two expressions; ``**`` of an expression and a `Constant`; ``neg`` and
        the other functions in `OPERATIONS` of one expression.
    arguments : tuple of Constant, Symbol or Operation
    """

    name: str
    arguments: tuple["Node", ...]


Node = Constant | Symbol | Operation

#: Functions of an `Operation`.
OPERATIONS = ("sin", "cos", "tan", "exp", "log", "sqrt", "tanh", "atan2")

#: Functions that a right-hand side, an event or a measure may call; the others are composed of `OPERATIONS`.
FUNCTIONS = (*OPERATIONS, "sinh", "cosh", "atan", "asin", "acos")

#: The name of the time.
TIME = "t"


@dataclass(frozen=True)
class Declared:
    """A state or a parameter: its name, its units, and its default value."""

    name: str
    units: str
    default: float


@dataclass(frozen=True)
class Event:
    """A condition that is true if one of its expressions is positive.

    ``abs(x) > 2`` has ``x - 2`` and ``-x - 2``; ``a > 1 or b > 1`` has ``a - 1`` and ``b - 1``.
    """

    name: str
    any_positive: tuple[Node, ...]


@dataclass(frozen=True)
class Label:
    """A name for the place where a motion ends, if all expressions are positive there; the first fitting label counts.

    A label without expressions fits everywhere.
    """

    name: str
    all_positive: tuple[Node, ...]


@dataclass(frozen=True)
class Moment:
    """A moment of a motion.

    Parameters
    ----------
    kind : {"first", "last", "max", "min"}
        When a condition became true for the first or the last time, or when the value of any of the expressions was
        greatest or least.
    expressions : tuple of Node
        Those of the condition, which is true where any of them, or every one, is positive; or those of the value.
    every : bool
    """

    kind: str
    expressions: tuple[Node, ...]
    every: bool = False

    @property
    def is_of_condition(self) -> bool:
        """Whether it is a moment of a condition."""
        return self.kind in ("first", "last")


@dataclass(frozen=True)
class Measure:
    """A number that a motion yields.

    Parameters
    ----------
    name, units : str
    kind : {"max", "min", "last", "mean", "integral", "count", "time", "value"}
        The greatest or the least value of any of the expressions over the motion, or the value of the first expression
        at its end, its mean, or its integral over time; how often the condition of `moment` became true; the time of
        `moment`, or the value of the first expression then. ``max abs(x)`` is the greatest value of ``x`` and ``-x``.
    expressions : tuple of Node
        Empty for ``count`` and ``time``.
    text : str
        The measure as the user wrote it.
    moment : Moment, optional
        For ``count`` (the last moment of its condition), ``time`` and ``value``.
    """

    name: str
    units: str
    kind: str
    expressions: tuple[Node, ...]
    text: str
    moment: Moment | None = None

    @property
    def tops(self) -> int:
        """The number of greatest values that it needs."""
        return len(self.expressions) if self.kind in ("max", "min") else 0

    @property
    def is_integral(self) -> bool:
        """Whether it follows from the integral of its expression over time."""
        return self.kind in ("mean", "integral")


@dataclass(frozen=True)
class Meridian:
    """The body of a system: lengths over its `radius`, moments over m radius^2.

    Parameters
    ----------
    height : Node
        The height of the centre of mass over the plane as a function of the tilt: the support function of the meridian.
    curvature : Node
        The radius of curvature of the meridian: the height plus its second derivative with respect to the tilt.
    axial, transverse : Node
        The moments of inertia about the centre of mass, about the axis and across it.
    """

    height: Node
    curvature: Node
    axial: Node
    transverse: Node


@dataclass(frozen=True)
class Definition:
    """A system: its states, its parameters, its right-hand side, and its outputs.

    Parameters
    ----------
    name : str
        The name of its function.
    title : str
        Its docstring, one line; may be empty.
    states, parameters : tuple of Declared
    time_units : str
        ``s``, or ``1`` if the system has no units.
    duration : float
        The default duration.
    rates : tuple of Node
        The rate of change of each state.
    ends : tuple of Event
        A motion ends with the first event that happens.
    measures : tuple of Measure
    labels : tuple of Label
    conserved : tuple of Node
        Expressions that are constant along a motion; empty if none are known.
    stable : str
        The condition for a stable cell: ``runs on``, or the expression of a criterion; empty for the default.
    theory : tuple of (str, Node)
        Parameter -> its value at the boundary in theory, an expression of the other parameters and the start.
    meridian : Meridian, optional
        The meridian of a body of revolution, which determines the rates.
    text : str
        Its file in canonical spelling, the same for equivalent files; reading it gives this definition again.
    """

    name: str
    title: str
    states: tuple[Declared, ...]
    parameters: tuple[Declared, ...]
    time_units: str
    duration: float
    rates: tuple[Node, ...]
    ends: tuple[Event, ...] = ()
    measures: tuple[Measure, ...] = ()
    labels: tuple[Label, ...] = ()
    conserved: tuple[Node, ...] = ()
    stable: str = ""
    theory: tuple[tuple[str, Node], ...] = ()
    meridian: Meridian | None = None
    text: str = ""

    @property
    def integrands(self) -> tuple[Node, ...]:
        """The expressions of the measures that follow from an integral."""
        return tuple(measure.expressions[0] for measure in self.measures if measure.is_integral)

    @property
    def autonomous(self) -> bool:
        """Whether no rate depends on the time."""
        return not any(TIME in symbols(rate) for rate in self.rates)


def symbols(node: Node) -> Iterator[str]:
    """Yield the names in an expression, each as often as it occurs."""
    if isinstance(node, Symbol):
        yield node.name
    elif isinstance(node, Operation):
        for argument in node.arguments:
            yield from symbols(argument)
