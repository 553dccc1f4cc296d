"""Why a cell got its verdict, in words."""

from collections.abc import Iterator, Mapping

import numpy as np

from sweep.atlas import theory
from sweep.engine import cells
from sweep.request.spec import SweepSpec
from sweep.schema import PARAMETERS, STABLE, UNSTABLE, VARIABLES


def why(spec: SweepSpec, start: Mapping[str, float], stored: Mapping[str, float]) -> Iterator[str]:
    """Yield the lines that lead from a cell's measures to its verdict.

    Parameters
    ----------
    spec : SweepSpec
    start, stored : mapping of str to float
        Parameters and measures of the cell, in SI.
    """
    endings, verdicts = (VARIABLES[name].flags or {} for name in ("ending", "stability"))
    ending, verdict = endings[int(stored["ending"])], int(stored["stability"])
    yield f"verdict     {verdicts[verdict]} by {spec.criterion}"
    yield f"because     {_reason(spec, start, stored, ending, verdict)}"


def _reason(
    spec: SweepSpec, start: Mapping[str, float], stored: Mapping[str, float], ending: str, verdict: int
) -> str:
    if ending == "fell":
        time = f" after {stored['fall_time']:.6g} s" if np.isfinite(stored["fall_time"]) else ""
        return f"the tilt reached fall_tilt, {_angle(spec.fall_tilt)}{time}, and a fall is unstable by any criterion"
    if ending not in ("bounded", "horizon"):
        return _NO_VERDICT[ending]
    reach, _, limit = reach_of(spec, start, stored)
    allowed = _allowed(spec, start, limit)
    if verdict == UNSTABLE:
        return f"the tilt left its steady value by {_angle(reach)}, more than {allowed}"
    if verdict == STABLE:
        return (
            f"the tilt never leaves its steady value by more than {_angle(reach)}, at most {allowed}; "
            "both turning points were passed, so that this holds for all time"
        )
    return (
        f"the tilt has left its steady value by {_angle(reach)}, at most {allowed}, but the duration of "
        f"{spec.duration:g} s was over before both turning points were passed: it may yet go further"
    )


#: ending -> why it leaves the stability undecided.
_NO_VERDICT = {
    "steady": "it is an exact steady motion and nothing disturbs it: whether it is stable cannot be measured from it",
    "unresolved": "the error of the integration stayed over the tolerance even at the smallest step",
    "invalid": "there is no such start: nothing was integrated",
    "not_computed": "the cell has not been integrated",
}


def reach_of(
    spec: SweepSpec, start: Mapping[str, float], stored: Mapping[str, float]
) -> tuple[float, float, float]:
    """Return how far the tilt left its steady value, that steady value, and the criterion's limit, all [rad]."""
    given = {name: np.array([value]) for name, value in start.items()}
    steady = float(cells.steady_tilt(spec, given)[0])
    reach = max(abs(stored["tilt_max"] - steady), abs(stored["tilt_min"] - steady))
    return reach, steady, float(theory.limit(spec, given)[0])


def _allowed(spec: SweepSpec, start: Mapping[str, float], limit: float) -> str:
    if spec.criterion.kind == "departure":
        return f"the {_angle(limit)} of the criterion"
    scale = limit / spec.criterion.limit
    return f"the {_angle(limit)} of the criterion ({spec.criterion.limit:g} times the perturbation, {_angle(scale)})"


def _angle(value: float) -> str:
    return PARAMETERS["tilt"].spell(value, 6)
