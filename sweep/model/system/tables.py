"""The tables of a system: parameters, settings, endings and variables, from its definition."""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from kernels.system.endings import DIFFERENT, ENDLESS, FIRST_EVENT, GROWS, JUMPS, RUNS_ON, UNRESOLVED
from sweep.model.quantity import (
    DECISION,
    DURATION,
    ERROR_GAUGE,
    EVENT_COUNT,
    FAILED,
    FINAL,
    GRID,
    MISSING,
    SENSITIVE,
    STABILITY,
    STEP,
    STEP_COUNT,
    UNKNOWN_ERROR,
    Array,
    Ending,
    Endings,
    Input,
    Quantity,
    Tolerance,
    Truths,
    positive,
    table,
)
from sweep.model.system.definition import Declared, Definition, Measure

#: Names of the endings of a motion that no event ends, and of a cell whose last two passes differ.
RUNNING, UNDECIDED_END = "runs_on", "sensitive"

#: Names of the endings that every system has, and of the label of a motion that no label fits.
FAILED_ENDINGS = ("unresolved", "unresolved_growth", "unresolved_jump", "unresolved_steps")
OWN_ENDINGS, NO_LABEL = ("not_computed", RUNNING, UNDECIDED_END, *FAILED_ENDINGS), "undecided"

#: Suffixes of the names of stated errors, and of states at the end.
ERROR, AT_END = "_error", "_end"

#: States of a body along whose initial values the boundary is searched.
_RATES = ("precession_rate", "roll_rate")

#: The variable with the time of the ending.
END_TIME = "end_time"

#: Names of the numbers of a moment (`kernels.system.moments`).
OF_MOMENT = ("count", "level", "time", "value")

_UNDECIDED = f"undecided where its stated error is {UNKNOWN_ERROR:g}"


def parameters(definition: Definition) -> Mapping[str, Input]:
    """Return the initial values of the states, and the parameters; the boundary is searched along the parameters.

    For a body it is also searched along the rates about its axis and the vertical, as for built-in bodies.
    """
    rates = _RATES if definition.meridian is not None else ()
    states = [_input(state, f"{state.name} at the start", state.name in rates) for state in definition.states]
    return table(*states, *(_input(parameter, parameter.name, True) for parameter in definition.parameters))


def _input(declared: Declared, long_name: str, control: bool) -> Input:
    words = long_name.replace("_", " ")
    return Input(declared.name, "", declared.units, words, GRID, default=declared.default, control=control)


def _tolerable(values: Array) -> Truths:
    return np.asarray((values >= 1e-15) & (values <= 1e-3))


def settings(definition: Definition) -> Mapping[str, Input]:
    """Return the settings: the duration, the longest step, and the tolerance."""
    units = definition.time_units
    duration = Input(
        "duration", "t", units, "longest time for which a motion is computed", GRID,
        default=definition.duration, rule=DURATION.rule, allows=positive,
    )  # fmt: skip
    step = Input(
        "step", "h", units, "longest step", GRID,
        default="auto", rule=STEP.rule, allows=positive, words=STEP.words,
    )  # fmt: skip
    tolerance = Input(
        "tolerance", r"\epsilon", "1", "size of the last terms of a step's series relative to the first ones", GRID,
        default=1e-11, rule="1e-15 <= tolerance <= 0.001", allows=_tolerable,
    )  # fmt: skip
    return table(duration, step, tolerance)


def endings(definition: Definition) -> Endings:
    """Return the possible endings of a motion."""
    events = [
        Ending(
            FIRST_EVENT + number, event.name, f"{event.name} happened", FINAL, f"it ended with {event.name}"
        )
        for number, event in enumerate(definition.ends)
    ]
    return Endings(
        Ending(0, "not_computed", "the cell has not been integrated", MISSING, "it has not been integrated"),
        Ending(RUNS_ON, RUNNING, "nothing ended it within the duration", FINAL, "nothing ended it within the duration"),
        Ending(
            DIFFERENT, UNDECIDED_END, "passes with different tolerances end in different ways, times or places",
            SENSITIVE, "it is too sensitive to its start to say how it ends",
        ),
        Ending(
            UNRESOLVED, FAILED_ENDINGS[0], "a value or a rate was not a number", FAILED,
            "a value or a rate was not a number, as for log(-1), 1/0, exp(1000) or an angle beyond 1.6e6 rad",
            "Write it in a form that has a value, such as (1 + tanh(x/2))/2 for 1/(1 + exp(-x)), or end the motion "
            "earlier with an entry of ends",
        ),
        Ending(
            GROWS, FAILED_ENDINGS[1], "steps became too short for the time", FAILED,
            "steps became too short for the time: a value or a rate goes to infinity, or the argument of a root or a "
            "logarithm, or a divisor, goes to zero",
            'End it earlier with an entry of ends, such as ends={"escaped": "abs(y) > 1e6"} or '
            'ends={"low": "y < 0.01"}, or use another unit of time',
        ),
        Ending(
            JUMPS, FAILED_ENDINGS[2], "a rate jumped", FAILED,
            "a rate did not continue the step before: it jumps, has a kink, or changed within a step",
            "Limit the step, for example with step=0.01, and smooth the jump, for example with tanh",
        ),
        Ending(
            ENDLESS, FAILED_ENDINGS[3], "a pass took more than 1e7 steps", FAILED,
            "a pass took more than 1e7 steps: the system may be stiff",
            "Give a shorter duration or a larger tolerance",
        ),
        *events,
    )  # fmt: skip


def labels(definition: Definition) -> Mapping[int, str]:
    """Return the codes and names of the labels."""
    names = {number: label.name for number, label in enumerate(definition.labels, 1)}
    return MappingProxyType({0: NO_LABEL, **names})


def stated(name: str) -> str:
    """Return the name of the variable with the stated error of a value."""
    return name + ERROR


def comment(measure: Measure) -> str:
    """Return the comment of a measure in files: where it is missing or undecided."""
    if measure.moment is None:
        return ""
    if measure.kind != "count" and measure.moment.is_of_condition:
        return f"missing where the condition never became true; {_UNDECIDED}"
    return _UNDECIDED


def variables(definition: Definition, ended: Endings) -> Mapping[str, Quantity]:
    """Return the variables of every cell of an atlas."""
    rows = [ended.quantity, STABILITY]
    if definition.labels:
        meaning = "the first label that fits at the end; undecided if none fits or the ending is undecided"
        rows.append(
            Quantity(
                "label",
                "",
                "1",
                "label of the place where the motion ends",
                DECISION,
                meaning,
                "i1",
                labels(definition),
            )
        )
    counts = [measure.name for measure in definition.measures if measure.kind == "count"]
    values = [
        (measure.name, measure.units, measure.text, comment(measure)) for measure in definition.measures
    ]
    values.append((END_TIME, definition.time_units, "time of the ending, or the duration", ""))
    values += [
        (state.name + AT_END, state.units, f"{state.name} at the end", "") for state in definition.states
    ]
    for name, units, words, description in values:
        share = 0.0 if name in counts else 1e-9
        within = Tolerance(0.0, share, "each value is within its stated error", stated(name))
        rows.append(Quantity(name, "", units, words.replace("_", " "), within, description))
    rows += [
        Quantity(stated(name), "", units, f"stated error of {name}", ERROR_GAUGE, "", "f4")
        for name, units, *_ in values
    ]
    if definition.conserved:
        words = "largest relative change of a conserved quantity from start to end"
        rows.append(Quantity("conserved_change", "", "1", words, ERROR_GAUGE, "", "f4"))
    rows += [
        Quantity("steps", "n", "1", "number of steps of all passes", STEP_COUNT, "", "i4"),
        Quantity("unproved", "", "1", "number of steps not proved free of an ending", EVENT_COUNT, "", "i4"),
    ]
    return table(*rows)
