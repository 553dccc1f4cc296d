"""The reason for a cell's verdict, in words."""

from collections.abc import Mapping

import numpy as np

from sweep.model.description import Request
from sweep.model.quantity import FINAL, LOST, OPEN, PROMISED, SENSITIVE, STABLE, UNDECIDED, UNSTABLE
from sweep.request.criterion import Criterion, finite_numbers
from sweep.request.expression import spelled, variables


def reason_of(
    criterion: Criterion, spec: Request, cell: Mapping[str, float], reach: float, scale: float
) -> str:
    """Return the reason for a computed cell's verdict.

    Parameters
    ----------
    criterion : Criterion
    spec : Request
    cell : mapping of str to float
        The start and the variables of the cell.
    reach, scale : float
        Its largest distance from the undisturbed value and the size of its perturbation, in the coordinate's unit.
    """
    if criterion.limits_reach:
        return _reason_by_reach(criterion, spec, cell, reach, scale)
    return (
        _reason_by_time(criterion, spec, cell)
        if criterion.predictable
        else _reason_by_expression(criterion, spec, cell)
    )


def _reason_by_reach(
    criterion: Criterion, spec: Request, cell: Mapping[str, float], reach: float, scale: float
) -> str:
    model, ending = spec.model, spec.model.endings.of(cell["ending"])
    if ending.role == LOST:
        return model.lost_in_words(spec, cell)
    coordinate = model.parameters[model.coordinate]
    far, name = coordinate.spell(reach, 6), model.coordinate.replace("_", " ")
    limit = f"the {coordinate.spell(float(criterion.allowed(np.array(scale))), 6)} of the criterion"
    if criterion.limit_text() != coordinate.spell(criterion.limit, 6):
        limit += f" ({criterion.limit_text()}, {coordinate.spell(scale, 6)})"
    if cell["stability"] == UNDECIDED and ending.role == FINAL:
        error = coordinate.spell(PROMISED * float(cell[model.error_name]), 3)
        return (
            f"the {name} leaves its steady value by {far} +- {error}, which may be more or less than {limit}"
        )
    if cell["stability"] == UNSTABLE:
        return f"the {name} left its steady value by {far}, more than {limit}"
    if cell["stability"] == STABLE:
        return (
            f"the {name} never leaves its steady value by more than {far}, at most {limit}; {ending.reason}"
        )
    return f"the {name} has left its steady value by {far}, at most {limit}, but {model.open_in_words(spec, cell)}"


def _reason_by_time(criterion: Criterion, spec: Request, cell: Mapping[str, float]) -> str:
    model, ending = spec.model, spec.model.endings.of(cell["ending"])
    time, limit = cell[model.endings.lost_time], f"the {criterion.limit_text()} of the criterion"
    if ending.role == LOST:
        orders = {UNSTABLE: "less than", UNDECIDED: "within the stated error of"}
        return f"{model.lost_name} after {time:.6g} s, {orders.get(int(cell['stability']), 'not before')} {limit}"
    if ending.role == OPEN and cell["stability"] == UNDECIDED:
        return f"before {limit} {model.open_in_words(spec, cell)}"
    lasts = ending.reason if ending.role == FINAL else model.open_in_words(spec, cell)
    return f"the motion was not lost in {limit}; {lasts}"


def _reason_by_expression(criterion: Criterion, spec: Request, cell: Mapping[str, float]) -> str:
    """Return for each comparison whether it is true, with the values."""
    model, quantities = spec.model, {**spec.model.parameters, **spec.model.cell_variables(spec)}
    ending, sentences = model.endings.of(cell["ending"]), []
    for comparison in criterion.limit.comparisons():
        values = {name: finite_numbers(cell[name]) for name in variables(comparison)}
        holds = "true" if comparison.truth(values, values)[0] else "false"
        named = (f"{name} is {spelled(quantities[name], float(each))}" for name, each in values.items())
        sentences.append(f"{comparison} is {holds}: {', '.join(named)}")
    found = "; ".join(sentences)
    if cell["stability"] == UNSTABLE:
        return found
    if ending.role == SENSITIVE:
        known = cell["stability"] == STABLE
        return f"{found}; {'this is known, although' if known else 'but'} {model.open_in_words(spec, cell)}"
    if ending.role in (FINAL, LOST) and cell["stability"] == UNDECIDED:
        return f"{found}; but a value is within twice its stated error of the limit"
    if ending.role in (FINAL, LOST):
        return f"{found}; the ending, {ending.name}, is final"
    return f"{found}; but {model.open_in_words(spec, cell)}"
