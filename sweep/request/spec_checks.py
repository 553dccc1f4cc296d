"""What the words of a request must be together: the order of its axes, its criterion, its steps and its size."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from sweep.errors import RequestError, shown
from sweep.model.description import Request
from sweep.model.quantity import DURATION, STEP
from sweep.request.values import words_given

#: Cells of a grid at most: their verdicts, a byte each, are in memory while the boundary is sought.
_MOST_CELLS = 10**9
#: Most steps of a cell: more take many seconds for each cell, and the kernels give such a cell up.
MOST_STEPS = 10**8


def read_axes(order: object, given: tuple[str, ...]) -> tuple[str, ...]:
    """Return the axes in the order that a request asks for; `given` is the order of its words."""
    names = order.split(",") if isinstance(order, str) else order
    if isinstance(names, Sequence) and sorted(map(str, names)) == sorted(given):
        return tuple(map(str, names))
    raise RequestError(
        f"axes holds the names given as a list or a range, each once; got {shown(order)} with "
        f"{', '.join(given) or 'no axis'}.",
        hint="Leave it out: the order given is the order of the axes.",
        where="axes",
    )


def check_criterion(spec: Request) -> None:
    """Refuse a criterion that judges by variables that the atlas of a spec does not have."""
    model, method = spec.model, spec.method
    spec.criterion.check(spec)
    needed, unknown = spec.criterion.needs(model), model.unknown_to.get(method, ())
    if without := [name for name in needed if name in unknown]:
        raise RequestError(
            f"The criterion {spec.criterion} judges by {' and '.join(without)}, of which method={method} knows no "
            "value.",
            hint=f"Use another criterion, or method={model.methods[0]}.",
            where="criterion",
        )
    if missing := [name for name in needed if name not in model.cell_variables(spec)]:
        words = [word for word, table in model.additions.items() if not table.keys().isdisjoint(missing)]
        raise RequestError(
            f"The criterion {spec.criterion} judges by {' and '.join(missing)}, which the model {model.name} does not "
            f"compute{' for this request' if words else ''}.",
            hint=f"Add {' and '.join(words)} to the request of the atlas."
            if words
            else "Use another criterion.",
            where="criterion",
        )


def check_steps(values: Mapping[str, Any], words: Mapping[str, Any]) -> None:
    """Refuse a step so short that a cell would never end; `words` has what was given for the values."""
    step, duration = values["step"], values["duration"]
    if isinstance(step, str) or duration / step <= MOST_STEPS:
        return
    raise RequestError(
        f"These are too many steps: duration / step must be at most {MOST_STEPS}; got "
        f"{words_given((DURATION, STEP), words, values)}.",
        hint="Give a longer step, a shorter duration, or step=auto.",
        where="step",
    )


def check_size(counts: Sequence[int]) -> None:
    """Refuse a grid of more cells than the search for its boundary takes."""
    if math.prod(counts) > _MOST_CELLS:
        raise RequestError(
            f"A grid has at most {_MOST_CELLS} cells; got {' x '.join(map(str, counts))} = {math.prod(counts)}.",
            hint="Lower the counts of the axes.",
            where="grid",
        )
