"""Compare cells of an atlas with the exact reduction, which has the same starts and no time stepping."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.model.description import Audit, Columns, Request, Starts
from sweep.model.disk.initial_conditions import computed_rate
from sweep.model.disk.tables import ENDINGS, REDUCTION, VARIABLES
from sweep.model.quantity import DECISION, UNDECIDED, Array, Quantity, Tolerance, Truths, table

#: Variables of an atlas that the audit reads.
MEASURES = ("ending", "stability", "tilt_min", "tilt_max", "peak_tilt", "amplification", "nutation_period")

NOT_COMPUTED, AGREES, WITHIN, MARGINAL, ATLAS_UNRESOLVED, EXACT_UNRESOLVED, INVALID = range(7)
AGREEING = (AGREES, WITHIN, MARGINAL)
EXTREMES_DIFFER, ENDING_DIFFERS, PERIOD_DIFFERS, VERDICT_DIFFERS, CONTRADICTORY = DISAGREEING = range(7, 12)

_AUDIT_TILT = Tolerance(1e-8, 0.0, "a difference from the exact value is as large as the error it measures")

# fmt: off
_VARIABLES: Mapping[str, Quantity] = table(
    *REDUCTION.values(),
    Quantity("audit", "", "1", "the cell of the atlas against the exact reduction", DECISION,
             "within: time ended the run inside the exact extremes; marginal: ending or verdict differ, but within the "
             "tolerance of where they change; contradictory: its numbers do not follow from its own extremes", "i1",
             {
                 NOT_COMPUTED: "not_computed", AGREES: "agrees", WITHIN: "within", MARGINAL: "marginal",
                 ATLAS_UNRESOLVED: "unresolved_in_the_atlas", EXACT_UNRESOLVED: "unresolved_by_the_reduction",
                 INVALID: "invalid", EXTREMES_DIFFER: "extremes_differ", ENDING_DIFFERS: "ending_differs",
                 PERIOD_DIFFERS: "period_differs", VERDICT_DIFFERS: "verdict_differs",
                 CONTRADICTORY: "contradictory"}),
    Quantity("tilt_difference", r"\Delta\theta", "rad", "larger difference of the extreme tilts from the exact ones",
             _AUDIT_TILT, "of a run that time ended: how far its extremes lie beyond the exact ones"),
    Quantity("period_difference", r"\Delta P", "s", "nutation period minus the exact one", _AUDIT_TILT),
    Quantity("period_share", "", "1", "magnitude of period_difference over what the tolerance allows", _AUDIT_TILT),
    Quantity("exact_tilt_min", r"\theta_{\min}", "rad", "exact smallest tilt of the motion", _AUDIT_TILT, "signed"),
    Quantity("exact_tilt_max", r"\theta_{\max}", "rad", "exact largest tilt of the motion", _AUDIT_TILT, "signed"),
    Quantity("exact_period", "P", "s", "exact nutation period", _AUDIT_TILT),
    Quantity("exact_stability", "", "1", "verdict of the criterion on the exact extremes", DECISION, "", "i1",
             VARIABLES["stability"].flags),
)
# fmt: on

AUDIT = Audit(
    variables=_VARIABLES,
    agreeing=AGREEING,
    disagreeing=tuple(DISAGREEING),
    missing=NOT_COMPUTED,
    ended_by_time=WITHIN,
    difference="tilt_difference",
    period=("period_difference", "exact_period", "period_share"),
)

#: An error of an extreme tilt changes the period by about its ratio to the width of the swing, and near a saddle by its
#: ratio to the separatrix. RK4 also keeps time less well than energy.
#: Measured over 33000 random motions at tolerances from 1e-10 to 1e-2: at most 0.21 of what these allow.
_PERIOD_FACTOR, _PERIOD_FLOOR = 2.0, 3e-6

#: Both turning points are passed within one period; the rest allows for the error of the period.
_MOST_PERIODS = 1.01

#: Differences of logarithms and square roots between processors: relative, and absolute in a tilt [rad].
_ROUNDING, _TILT_ROUNDING = 1e-12, 1e-15


def check(spec: Request, starts: Starts, stored: Columns, exact: Columns) -> dict[str, npt.NDArray[Any]]:
    """Compare stored cells with the exact reduction.

    Parameters
    ----------
    spec : Request
    starts : mapping of str to array, shape (n,)
    stored : mapping of str to array, shape (n,)
        `MEASURES` as the atlas has them, and the rate that each cell computed, if there is one.
    exact : mapping of str to array, shape (n,)
        The measures of the same starts by the exact reduction (`sweep.model.disk.exact`).

    Returns
    -------
    dict of str to array, shape (n,)
        The variables of `AUDIT`.
    """
    model, scale = spec.model, spec.model.perturbation(spec, starts)
    stored_reach, exact_reach = model.reach(spec, starts, stored), model.reach(spec, starts, exact)
    exact_stability = _verdict(spec, exact, exact_reach, scale)
    allowed = spec.tolerance + np.nan_to_num(exact["tilt_error"])
    difference = _tilt_difference(spec, stored, exact, allowed)
    period_difference = stored["nutation_period"] - exact["nutation_period"]
    period_share = np.abs(period_difference) / _period_allowance(exact, allowed)
    at_rest = _at_rest(stored, exact, allowed)
    marginal = _margin(spec, exact, exact_reach, scale) <= allowed
    follows = _follows(spec, starts, stored, stored_reach, scale)
    same_ending = at_rest | _endings_agree(spec, stored, exact)
    same_verdict = at_rest | _verdicts_agree(stored, exact_stability) | (not _decidable(spec))
    # each line overrides those before it
    code = np.where(stored["ending"] == ENDINGS.code("horizon"), WITHIN, AGREES)
    code = np.where(marginal & ~(same_ending & same_verdict), MARGINAL, code)
    code = np.where(follows, code, CONTRADICTORY)
    code = np.where(marginal | same_verdict, code, VERDICT_DIFFERS)
    code = np.where(period_share > 1.0, PERIOD_DIFFERS, code)
    code = np.where(marginal | same_ending, code, ENDING_DIFFERS)
    # written so that NaN differs
    code = np.where(difference <= allowed, code, EXTREMES_DIFFER)
    return {
        "audit": _with_failed_cells(code, stored, exact, follows).astype(np.int8),
        "tilt_difference": difference,
        "period_difference": period_difference,
        "period_share": period_share,
        "exact_tilt_min": exact["tilt_min"],
        "exact_tilt_max": exact["tilt_max"],
        "exact_period": exact["nutation_period"],
        "exact_stability": exact_stability,
        "wells": exact["wells"],
        "separatrix": exact["separatrix"],
    }


def _tilt_difference(spec: Request, stored: Columns, exact: Columns, allowed: Array) -> Array:
    """Return the larger difference [rad] of the two extremes.

    A run that time ended need only lie inside the exact extremes. Where a peak is within the tolerance of fall_tilt,
    the atlas or the reduction may end with a fall and hold only the extremes before it: then the extremes of one need
    only lie inside those of the other.
    """
    low, high = stored["tilt_min"] - exact["tilt_min"], stored["tilt_max"] - exact["tilt_max"]
    inside = np.maximum(0.0, np.maximum(-low, high))
    around = np.maximum(0.0, np.maximum(low, -high))
    ends = np.abs([each[name] for each in (stored, exact) for name in ("tilt_min", "tilt_max")])
    grazes = np.any((ends < spec.fall_tilt) & (ends >= spec.fall_tilt - allowed), axis=0)
    grazes &= _fell(stored) | _fell(exact)
    whole = np.maximum(np.abs(low), np.abs(high))
    partial = np.where(grazes, np.minimum(inside, around), whole)
    difference: Array = np.where(stored["ending"] == ENDINGS.code("horizon"), inside, partial)
    return difference


def _period_allowance(exact: Columns, allowed: Array) -> Array:
    """Return how far [s] a period may be from the exact one."""
    width = exact["tilt_max"] - exact["tilt_min"]
    with np.errstate(divide="ignore"):
        lingering = np.nan_to_num(1.0 / np.abs(exact["separatrix"]), nan=0.0, posinf=np.inf)
        share = _PERIOD_FLOOR + _PERIOD_FACTOR * allowed * (1.0 + 1.0 / width + lingering)
    allowance: Array = share * exact["nutation_period"]
    return allowance


def _follows(spec: Request, starts: Starts, stored: Columns, reach: Array, scale: Array) -> Truths:
    """Return where all values that follow from the start, the extremes and the ending do follow from them."""
    derived = _derived(stored, reach, scale)
    peak, amplification = derived["peak_tilt"], derived["amplification"]
    with np.errstate(divide="ignore", invalid="ignore"):
        rounding = _ROUNDING * amplification + _TILT_ROUNDING / scale
    verdict = stored["stability"] == _verdict(spec, stored, reach, scale)
    follows: Truths = (
        _same(stored["peak_tilt"], peak, 0.0)
        & _same(stored["amplification"], amplification, rounding)
        & (verdict | (np.abs(reach - np.nan_to_num(spec.criterion.allowed(scale))) <= _TILT_ROUNDING))
        & (np.isfinite(stored["nutation_period"]) == (stored["ending"] == ENDINGS.code("bounded")))
        & ((peak >= spec.fall_tilt) == _fell(stored))
    )
    if (name := computed_rate(spec)) is not None:
        rate = np.where(np.isfinite(starts[name]), starts[name], np.nan)
        follows &= _same(stored[name], rate, _ROUNDING * np.abs(rate))
    return follows


def _margin(spec: Request, exact: Columns, reach: Array, scale: Array) -> Array:
    """Return how near [rad] the motion comes to where its verdict or its ending would change.

    Zero for a fall, for which the reduction has no turning point: an atlas with another ending must agree in its
    extremes, which are then within the tolerance of fall_tilt.
    """
    peak = np.maximum(np.abs(exact["tilt_max"]), np.abs(exact["tilt_min"]))
    limit = np.nan_to_num(spec.criterion.allowed(scale))
    return np.asarray(np.minimum(np.abs(reach - limit), np.abs(peak - spec.fall_tilt)))


def _endings_agree(spec: Request, stored: Columns, exact: Columns) -> Truths:
    """Return where endings are the same, or time may have ended the run first."""
    too_long = spec.duration > _MOST_PERIODS * exact["nutation_period"]
    open_ = (stored["ending"] == ENDINGS.code("horizon")) & ~too_long
    agree: Truths = open_ | (stored["ending"] == exact["ending"])
    return agree


def _verdicts_agree(stored: Columns, exact: npt.NDArray[Any]) -> Truths:
    """Return where verdicts are the same, or a run that time ended is undecided."""
    open_ = (stored["ending"] == ENDINGS.code("horizon")) & (stored["stability"] == UNDECIDED)
    agree: Truths = open_ | (stored["stability"] == exact)
    return agree


def _at_rest(stored: Columns, exact: Columns, allowed: Array) -> Truths:
    """Return where the swing is within the tolerance, so that it may count as bounded or as steady."""
    either = (ENDINGS.code("bounded"), ENDINGS.code("steady"))
    both = np.isin(stored["ending"], either) & np.isin(exact["ending"], either)
    found: Truths = both & (exact["tilt_max"] - exact["tilt_min"] <= allowed)
    return found


def _with_failed_cells(
    code: npt.NDArray[Any], stored: Columns, exact: Columns, follows: Truths
) -> npt.NDArray[Any]:
    """Return the codes with those of cells that the atlas or the reduction could not compute."""
    no_period = (exact["ending"] == ENDINGS.code("bounded")) & np.isnan(exact["nutation_period"])
    impossible, refused = (
        exact["ending"] == ENDINGS.code("invalid"),
        stored["ending"] == ENDINGS.code("invalid"),
    )
    for cells_apart, name in (
        ((exact["ending"] == ENDINGS.code("unresolved")) | no_period, EXACT_UNRESOLVED),
        (stored["ending"] == ENDINGS.code("unresolved"), ATLAS_UNRESOLVED),
        (impossible & refused, INVALID),
    ):
        code = np.where(cells_apart, np.where(follows, name, CONTRADICTORY), code)
    code = np.where(impossible != refused, ENDING_DIFFERS, code)
    return np.where(stored["ending"] == ENDINGS.code("not_computed"), NOT_COMPUTED, code)


def _verdict(spec: Request, measured: Columns, reach: Array, scale: Array) -> npt.NDArray[np.int8]:
    given = {**measured, **_derived(measured, reach, scale)}
    verdict: npt.NDArray[np.int8] = spec.criterion.verdict(ENDINGS, given, reach, scale)
    return verdict


def _derived(measured: Columns, reach: Array, scale: Array) -> Columns:
    """Variables that follow from the extremes."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return {
            "peak_tilt": np.maximum(np.abs(measured["tilt_min"]), np.abs(measured["tilt_max"])),
            "amplification": np.where(scale > 0.0, reach / scale, np.nan),
        }


def _decidable(spec: Request) -> bool:
    """Whether the reduction knows all that the criterion needs: it has no time, so neither duration nor fall_time."""
    return set(spec.criterion.needs(spec.model)) <= set(MEASURES)


def _fell(measured: Columns) -> Truths:
    fell: Truths = measured["ending"] == ENDINGS.code("fell")
    return fell


def _same(one: Array, other: Array, within: Array | float) -> Truths:
    same: Truths = (np.abs(one - other) <= within) | (one == other) | (np.isnan(one) & np.isnan(other))
    return same
