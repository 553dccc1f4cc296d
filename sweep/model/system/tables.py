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
from sweep.model.system.definition import Declared, Definition

#: Name of the ending of a motion that nothing ends, and of that of cells whose two passes differ.
RUNNING, UNDECIDED_END = "runs_on", "sensitive"

#: Names of the endings that every system has, and of the label of a motion that has none.
FAILED_ENDINGS = ("unresolved", "unresolved_growth", "unresolved_jump", "unresolved_steps")
OWN_ENDINGS, NO_LABEL = ("not_computed", RUNNING, UNDECIDED_END, *FAILED_ENDINGS), "undecided"

#: End of the name of the stated error of a value, and of that of a state at the end.
ERROR, AT_END = "_error", "_end"

#: States of a body along whose starts a boundary is sought.
_RATES = ("precession_rate", "roll_rate")

#: Variables for the time and place of the ending.
END_TIME = "end_time"


def parameters(definition: Definition) -> Mapping[str, Input]:
    """Return the starts of the states and the parameters; a boundary is sought along the parameters.

    Of a body it is sought along its rates about axis and vertical, too, as of other bodies.
    """
    rates = _RATES if definition.meridian is not None else ()
    states = [_input(each, f"{each.name} at the start", each.name in rates) for each in definition.states]
    return table(*states, *(_input(each, each.name, True) for each in definition.parameters))


def _input(declared: Declared, long_name: str, control: bool) -> Input:
    words = long_name.replace("_", " ")
    return Input(declared.name, "", declared.units, words, GRID, default=declared.default, control=control)


def _tolerable(values: Array) -> Truths:
    return np.asarray((values >= 1e-15) & (values <= 1e-3))


def settings(definition: Definition) -> Mapping[str, Input]:
    """Return how long a motion is followed, its longest step, and how closely."""
    units = definition.time_units
    duration = Input(
        "duration", "t", units, "time for which a motion is followed", GRID,
        default=definition.duration, rule=DURATION.rule, allows=positive,
    )  # fmt: skip
    step = Input(
        "step", "h", units, "longest step", GRID,
        default="auto", rule=STEP.rule, allows=positive, words=STEP.words,
    )  # fmt: skip
    tolerance = Input(
        "tolerance", r"\epsilon", "1", "size of the last terms of a step's series beside its first ones", GRID,
        default=1e-11, rule="1e-15 <= tolerance <= 0.001", allows=_tolerable,
    )  # fmt: skip
    return table(duration, step, tolerance)


def endings(definition: Definition) -> Endings:
    """Return how a motion can end."""
    events = [
        Ending(FIRST_EVENT + number, each.name, f"{each.name} happened", FINAL, f"it ended with {each.name}")
        for number, each in enumerate(definition.ends)
    ]
    return Endings(
        Ending(0, "not_computed", "the cell has not been integrated", MISSING, "it has not been integrated"),
        Ending(RUNS_ON, RUNNING, "nothing ended it within the duration", FINAL, "nothing ended it within the duration"),
        Ending(
            DIFFERENT, UNDECIDED_END, "passes with different tolerances end in different ways, times or places",
            SENSITIVE, "it is too sensitive to its start to say how it ends",
        ),
        Ending(
            UNRESOLVED, FAILED_ENDINGS[0], "a value or a rate became no number", FAILED,
            "a value or a rate became no number, as of log(-1), 1/0, exp(1000) or an angle beyond 1.6e6 rad",
            "Write it so that it has a value, as (1 + tanh(x/2))/2 for 1/(1 + exp(-x)), or end the motion before with "
            "an entry of ends",
        ),
        Ending(
            GROWS, FAILED_ENDINGS[1], "steps became too short for the time", FAILED,
            "steps became too short for the time: a value or a rate goes to infinity, or a root, a logarithm or a "
            "divisor to zero",
            'End it before with an entry of ends, as in ends={"escaped": "abs(y) > 1e6"} or ends={"low": "y < 0.01"}, '
            "or take another unit of time",
        ),
        Ending(
            JUMPS, FAILED_ENDINGS[2], "a rate jumped", FAILED,
            "a rate was not what the step before led to: it jumps, has a kink, or changed within a step",
            "Give a longest step, as in step=0.01, and smooth what jumps, as with tanh",
        ),
        Ending(
            ENDLESS, FAILED_ENDINGS[3], "a pass took more than 1e7 steps", FAILED,
            "a pass took more than 1e7 steps, as of a stiff system",
            "Give a shorter duration or a larger tolerance",
        ),
        *events,
    )  # fmt: skip


def labels(definition: Definition) -> Mapping[int, str]:
    """Return the codes of where a motion is at its end."""
    named = {number: each.name for number, each in enumerate(definition.labels, 1)}
    return MappingProxyType({0: NO_LABEL, **named})


def stated(name: str) -> str:
    """Return the name of the variable with the error that a cell states of a value."""
    return name + ERROR


def variables(definition: Definition, ended: Endings) -> Mapping[str, Quantity]:
    """Return what an atlas holds of every cell."""
    rows = [ended.quantity, STABILITY]
    if definition.labels:
        meaning = "the first label that fits at the end; undecided where the ending is, or where none fits"
        rows.append(
            Quantity(
                "label",
                "",
                "1",
                "where the motion is at its end",
                DECISION,
                meaning,
                "i1",
                labels(definition),
            )
        )
    values = [(each.name, each.units, each.text) for each in definition.measures]
    values.append((END_TIME, definition.time_units, "time of the ending, or the duration"))
    values += [(each.name + AT_END, each.units, f"{each.name} at the end") for each in definition.states]
    for name, units, words in values:
        within = Tolerance(0.0, 1e-9, "each value is within its stated error", stated(name))
        rows.append(Quantity(name, "", units, words.replace("_", " "), within))
    rows += [
        Quantity(stated(name), "", units, f"stated error of {name}", ERROR_GAUGE, "", "f4")
        for name, units, _ in values
    ]
    if definition.conserved:
        words = "largest relative change of what is conserved, from start to end"
        rows.append(Quantity("conserved_change", "", "1", words, ERROR_GAUGE, "", "f4"))
    rows += [
        Quantity("steps", "n", "1", "steps of all passes", STEP_COUNT, "", "i4"),
        Quantity("unproved", "", "1", "steps that were not proved free of an ending", EVENT_COUNT, "", "i4"),
    ]
    return table(*rows)
