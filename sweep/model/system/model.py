"""The model of a user's system, made from its definition."""

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from kernels.system.endings import FIRST, GREATEST, LAST
from sweep.errors import RequestError, counted
from sweep.model.description import Columns, LineWords, Model, Reference, Request, Starts, Words
from sweep.model.kernel import Kernel
from sweep.model.quantity import Array
from sweep.model.system import tables
from sweep.model.system.cell_values import evaluated
from sweep.model.system.definition import TIME, Definition, Measure, Node, Operation
from sweep.model.system.meridian import check_body
from sweep.model.system.passes import PASSES, Passes
from sweep.model.system.program import Program
from sweep.model.system.reference import SampledReference

#: Longest time [s] to compile a system: one that takes longer is refused.
MOST_SECONDS = 60.0


@lru_cache(maxsize=64)
def model_of(definition: Definition) -> "SystemModel":
    """Return the model of a system: one object for equal definitions."""
    return SystemModel(definition)


class SystemModel(Model):
    """A user's system of ordinary differential equations.

    Parameters
    ----------
    definition : Definition
    """

    methods = ("taylor",)
    coordinate, extremes = "", ()
    # a system has no presets: `sweep.request.spec_file` finds those of the examples
    presets = Path(__file__).with_name("none")
    motion = "sweep.motion.system_path:motion_of_system"
    trajectory = "sweep.figures.system_motion:figure_of_cell"

    def __init__(self, definition: Definition) -> None:
        self.definition, self.name, self.text = definition, definition.name, definition.text
        self.parameters, self.settings = tables.parameters(definition), tables.settings(definition)
        self.endings = tables.endings(definition)
        self.variables = tables.variables(definition, self.endings)
        self.integrate = _kernel(definition)
        states = [state.name for state in definition.states]
        tops = [
            f"{measure.name} {number}" for measure in definition.measures for number in range(measure.tops)
        ]
        integrals = [f"{measure.name} integral" for measure in definition.measures if measure.is_integral]
        moments = [
            f"{measure.name} {number}"
            for measure in definition.measures
            if measure.moment
            for number in tables.OF_MOMENT
        ]
        followed = [*states, *integrals]
        rows = [*followed, tables.END_TIME, *tops, *(f"largest {name}" for name in followed), *moments]
        self.measures = tuple(f"{leg}: {name}" for leg in PASSES for name in rows)
        self.counts = (*(f"{leg}: ending" for leg in PASSES), "steps", "unproved")
        values = (*(measure.name for measure in definition.measures), tables.END_TIME)
        self.drawn = "label" if definition.labels else "" if definition.measures else "ending"
        self.shown = ("label", "ending", *(measure.name for measure in definition.measures))
        self.peak, self.error_name = values[0], tables.stated(values[0])
        self.default_criterion = _criterion(definition.stable)
        self.criterion_words = {_criterion("runs on"): "the motion ends before its duration is over"}
        title = definition.title or f"The system {definition.name}"
        self.words = Words(
            summary=f"{title.rstrip('.')}: how the motion of every start ends, {{}}, and its measures.",
            keywords="ordinary differential equations, parameter sweep, stability",
            references="method: Jorba and Zou, Experimental Mathematics 14 (2005) 99",
        )
        self.line_words = LineWords(critical="{} at the boundary in the system's own theory", label="theory")

    def __eq__(self, other: object) -> bool:
        """Return whether two models have the same system."""
        return isinstance(other, SystemModel) and self.definition == other.definition

    def __hash__(self) -> int:
        """Return the hash of the text of the system."""
        return hash(self.text)

    def __reduce__(self) -> tuple[Any, ...]:
        """Return the function and the arguments with which pickle makes the model again."""
        return model_of, (self.definition,)

    @property
    def measured(self) -> frozenset[str]:
        """All variables except the verdict: the passes that they follow from are not stored."""
        return frozenset(self.variables.keys() - {"stability"})

    def subject(self, spec: Request) -> tuple[str, str]:
        """Return the title of the system."""
        return self.definition.title.rstrip(".") or f"The system {self.name}", ""

    def check(self, values: Mapping[str, Any]) -> None:
        """Refuse values that make no body that rolls, if the system is a body of revolution."""
        if self.definition.meridian is not None:
            check_body(self.definition, values)

    def undisturbed(self, spec: Request, starts: Starts) -> Array:
        """Return NaN: the undisturbed motion of a system is not known."""
        return np.full(next(iter(starts.values())).shape, np.nan)

    def perturbation(self, spec: Request, starts: Starts) -> Array:
        """Return NaN: the undisturbed motion of a system is not known."""
        return self.undisturbed(spec, starts)

    def code(self, spec: Request) -> Sequence[str | Callable[..., Any]]:
        """Return the code that computes the variables of an atlas from the passes."""
        return [__name__, Passes.__module__, evaluated.__module__]

    def measure_more(self, spec: Request, starts: Starts, measured: Columns) -> Columns:
        """Return the variables of an atlas from the passes; nothing without them."""
        if self.measures[0] not in measured:
            return {}
        return Passes(
            self.definition, self.endings, starts, measured, spec.duration, spec.tolerance
        ).columns()

    def lines(self, spec: Request, axis: str, starts: Starts) -> dict[str, tuple[Array, Array]]:
        """Return the boundary in the system's own theory as both edges: the theory does not say which one it is."""
        node = dict(self.definition.theory).get(axis)
        if node is None:
            return {}
        (line,) = evaluated([node], {**starts, TIME: 0.0})
        line = np.broadcast_to(line, starts[axis].shape).astype(np.float64)
        return dict.fromkeys(("upper", "lower"), (line, np.full(line.shape, np.nan)))

    def upward(self, axes: Sequence[str]) -> str:
        """Return the vertical axis of a map: the first parameter or, in a plane of two states, the second state."""
        return next(iter(self.controls(axes)), axes[min(1, len(axes) - 1)])

    def open_in_words(self, spec: Request, stored: Mapping[str, float]) -> str:
        """Return why nothing more is known about a cell."""
        return self.endings.of(stored["ending"]).reason

    def reference(self, size: int, seed: int | None = None) -> Reference | None:
        """Return the reference: the rules of the system, and a sample computed by DOP853."""
        return SampledReference(self.definition, self.endings, size, seed)


def _criterion(stable: str) -> str:
    """Return the criterion of unstable cells for the condition of stable cells."""
    if stable in ("", "runs on"):
        return f"ending != {tables.RUNNING}"
    return f"not ({stable})"


def _kernel(definition: Definition) -> Kernel:
    """Return the kernel of a system; its program, which `kernels.system.integrate` compiles, is its function name."""
    program = Program(definition)
    rates = program.add(definition.rates)
    tops: Iterable[Node] = (
        _signed(measure.kind, node)
        for measure in definition.measures
        if measure.tops
        for node in measure.expressions
    )
    extremes = program.add(tops)
    events = [(number, node) for number, event in enumerate(definition.ends) for node in event.any_positive]
    conditions = program.add(node for _, node in events)
    integrals = program.add(definition.integrands)
    moments = [_watched(program, measure) for measure in definition.measures if measure.moment]
    numbers = [number for number, _ in events]
    name = json.dumps([program.instructions, rates, extremes, conditions, numbers, integrals, moments])
    # two thirds of the time on a busy machine, for 2 to 32 states, up to 24 endings and 16 greatest values
    seconds = 5.0 + 0.2 * len(program.instructions) + 0.8 * (len(extremes) + len(moments))
    if seconds > MOST_SECONDS:
        raise RequestError(
            f"This system takes about {seconds:.0f} s to compile; at most {MOST_SECONDS:.0f} s are allowed. It has "
            f"{counted(len(definition.states), 'state')}, {counted(len(events), 'condition')} that end it, "
            f"{counted(len(extremes), 'greatest value')}, {counted(len(moments), 'moment')} and "
            f"{counted(len(program.instructions), 'operation')}.",
            hint="Split endings and measures between two systems, or leave some out.",
            where=f"the system {definition.name}",
        )
    return Kernel("kernels.system.integrate", name, seconds=seconds, told=f"the system {definition.name}")


def _watched(program: Program, measure: Measure) -> tuple[int, ...]:
    """Return a moment as `kernels.system.integrate.entry_point` takes it; a count and a time need no value."""
    moment = measure.moment
    assert moment is not None
    kind = {"first": FIRST, "last": LAST}.get(moment.kind, GREATEST)
    expressions = program.add(_signed(moment.kind, node) for node in moment.expressions)
    value = program.add(measure.expressions) or expressions
    return kind, int(moment.every), value[0], *expressions


def _signed(kind: str, node: Node) -> Node:
    """Return the expression whose greatest value gives a measure: the negative one for a least value."""
    return Operation("neg", (node,)) if kind == "min" else node
