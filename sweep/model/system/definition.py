"""A system of ordinary differential equations as data: what an atlas carries, and what kernels are made of.

An expression is a tree of numbers, names and operations; nothing of it is ever run by Python. Units are those of
files: SI, in CF's spelling; ``1`` for a pure number. All numbers are in these units.
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
        ``+``, ``-``, ``*``, ``/`` of two; ``**`` of an expression and a `Constant`; ``neg`` and the functions of
        `FUNCTIONS` of one.
    arguments : tuple of Constant, Symbol or Operation
    """

    name: str
    arguments: tuple["Node", ...]


Node = Constant | Symbol | Operation

#: Functions that a right-hand side, an event or a measure may call.
FUNCTIONS = ("sin", "cos", "tan", "exp", "log", "sqrt", "tanh")

#: The name of the time.
TIME = "t"


@dataclass(frozen=True)
class Declared:
    """A state or a parameter: its name, its units, and its value where a request gives none."""

    name: str
    units: str
    default: float


@dataclass(frozen=True)
class Event:
    """A condition that is true once one of its expressions is positive.

    ``abs(x) > 2`` is that of ``x - 2`` and ``-x - 2``; ``a > 1 or b > 1`` that of ``a - 1`` and ``b - 1``.
    """

    name: str
    any_positive: tuple[Node, ...]


@dataclass(frozen=True)
class Label:
    """A name for where a motion is at its end: all of some expressions are positive there; the first that fits counts.

    Without expressions it is the name of what nothing else fits.
    """

    name: str
    all_positive: tuple[Node, ...]


@dataclass(frozen=True)
class Measure:
    """A number that a motion leaves behind.

    Parameters
    ----------
    name, units : str
    kind : {"max", "min", "last"}
        The greatest or the least value of one of some expressions over the motion, or the value of the first one at
        its end. ``max abs(x)`` is the greatest value of ``x`` and ``-x``.
    expressions : tuple of Node
    text : str
        As it was written.
    """

    name: str
    units: str
    kind: str
    expressions: tuple[Node, ...]
    text: str

    @property
    def tops(self) -> int:
        """How many greatest values are sought for it."""
        return 0 if self.kind == "last" else len(self.expressions)


@dataclass(frozen=True)
class Meridian:
    """The body of a system: lengths over its `radius`, moments over m radius^2.

    Parameters
    ----------
    height : Node
        The height of the centre of mass over the plane, which is the support function of the meridian: of the tilt.
    curvature : Node
        The radius of curvature of the meridian: the height and its second derivative by the tilt.
    axial, transverse : Node
        The moments of inertia about the centre of mass, about the axis and across it.
    """

    height: Node
    curvature: Node
    axial: Node
    transverse: Node


@dataclass(frozen=True)
class Definition:
    """A system: its states, its parameters, its right-hand side, and what is looked at.

    Parameters
    ----------
    name : str
        Of its function.
    title : str
        Its docstring, one line; may be empty.
    states, parameters : tuple of Declared
    time_units : str
        ``s``, or ``1`` where the system has no units.
    duration : float
        How long a motion is followed where a request says nothing.
    rates : tuple of Node
        The rate of change of each state.
    ends : tuple of Event
        In their order; a motion ends with the first that happens.
    measures : tuple of Measure
    labels : tuple of Label
    conserved : tuple of Node
        What the right-hand side leaves as it is; empty if nothing is known.
    stable : str
        When a cell is stable: ``runs on``, or the text of a criterion's expression; empty if the system says nothing.
    theory : tuple of (str, Node)
        Parameter -> an expression of the other parameters and the start: where theory puts the boundary along it.
    meridian : Meridian, optional
        Of a body of revolution, from which its rates follow.
    text : str
        The file that it was read from, in one spelling for all files that say the same: reading it gives this
        definition again.
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
    def autonomous(self) -> bool:
        """Whether no rate depends on the time."""
        return not any(TIME in symbols(each) for each in self.rates)


def symbols(node: Node) -> Iterator[str]:
    """Yield the names in an expression, each as often as it stands there."""
    if isinstance(node, Symbol):
        yield node.name
    elif isinstance(node, Operation):
        for each in node.arguments:
            yield from symbols(each)
