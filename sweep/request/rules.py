"""What the values of a request must keep to together: each check refuses a spec, none changes it."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from sweep.errors import RequestError
from sweep.request.axes import Range, Values
from sweep.schema import STEADY_PRECESSION, STEADY_ROLL

#: Beyond this no disk holds the atlas.
_MOST_CELLS = 2**40
#: More steps than this take a cell many seconds, and a run for ever; the kernels give such a cell up.
_MOST_STEPS = 10**8


def check_circling(values: Mapping[str, Any]) -> None:
    """Refuse steady rates that do not follow from the others."""
    rate = values["precession_rate"]
    if rate in STEADY_PRECESSION:
        _check_steady_precession(values)
        return
    if values["roll_rate"] != STEADY_ROLL or (
        rate.ends().any() if isinstance(rate, Range | Values) else rate
    ):
        return
    raise RequestError(
        "no roll rate keeps the tilt constant without precession",
        "roll_rate=steady needs a precession_rate other than 0",
        f"roll_rate=steady precession_rate={rate}",
        "give a precession_rate, as in precession_rate=0.05:5:400, or a number for roll_rate",
        "precession_rate",
    )


def _check_steady_precession(values: Mapping[str, Any]) -> None:
    if values["roll_rate"] != STEADY_ROLL:
        return
    raise RequestError(
        "two steady rates say nothing",
        "one of roll_rate and precession_rate is steady, the other is given",
        f"roll_rate=steady precession_rate={values['precession_rate']}",
        "give a number, a list or a range for one of them, as in roll_rate=-8:8:400",
        "precession_rate",
    )


def check_steps(values: Mapping[str, Any]) -> None:
    """Refuse a step so short that a cell would never end."""
    step, duration = values["step"], values["duration"]
    if isinstance(step, str) or duration / step <= _MOST_STEPS:
        return
    raise RequestError(
        "too many steps",
        f"duration / step <= {_MOST_STEPS}",
        f"duration={duration!r} step={step!r}",
        "give a longer step, a shorter duration, or step=auto",
        "step",
    )


def check_size(counts: Sequence[int]) -> None:
    """Refuse a grid of more cells than any disk holds."""
    if math.prod(counts) > _MOST_CELLS:
        raise RequestError(
            "too many cells",
            f"a grid has at most {_MOST_CELLS} cells",
            f"{' x '.join(map(str, counts))} = {math.prod(counts)} cells",
            "lower the counts of the axes",
            "grid",
        )
