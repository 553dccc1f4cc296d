"""Cells of an atlas held against the exact reduction: the same starts, no time stepping, an independent way."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from sweep.model.description import Audit, Columns, Starts
from sweep.model.disk.initial_conditions import computed_rate, perturbation, steady_tilt
from sweep.model.disk.tables import ENDINGS, REDUCTION, VARIABLES
from sweep.model.quantity import DECISION, UNDECIDED, Array, Quantity, Tolerance, Truths, table

if TYPE_CHECKING:
    from sweep.request.spec import SweepSpec

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

#: What an extreme tilt may be off by changes the period by about the same share of the width of the swing, and the
#: passage of a saddle by that over the separatrix. RK4 also keeps time less well than energy.
#: Measured over 33000 random motions at tolerances from 1e-10 to 1e-2: at most 0.21 of what these allow.
_PERIOD_FACTOR, _PERIOD_FLOOR = 2.0, 3e-6

#: Both turning points are passed within one period; the rest is for its error.
_MOST_PERIODS = 1.01

#: What another machine's logarithms and square roots may change: relative in what is computed, absolute in a tilt.
_ROUNDING, _TILT_ROUNDING = 1e-12, 1e-15


def check(spec: "SweepSpec", starts: Starts, stored: Columns, exact: Columns) -> dict[str, npt.NDArray[Any]]:
    """Hold stored cells against the exact reduction.

    Parameters
    ----------
    spec : SweepSpec
    starts : mapping of str to array, shape (n,)
    stored : mapping of str to array, shape (n,)
        `MEASURES` as the atlas has them, and the rate that each cell computed, if there is one.
    exact : mapping of str to array, shape (n,)
        What the exact reduction says of the same starts (`sweep.model.disk.exact`).

    Returns
    -------
    dict of str to array, shape (n,)
        The variables of `AUDIT`.
    """
    steady, scale = steady_tilt(spec, starts), perturbation(spec, starts)
    exact_stability = _verdict(spec, exact, steady, scale)
    allowed = spec.tolerance + np.nan_to_num(exact["tilt_error"])
    difference = _tilt_difference(spec, stored, exact, allowed)
    period_difference = stored["nutation_period"] - exact["nutation_period"]
    period_share = np.abs(period_difference) / _period_allowance(exact, allowed)
    calm = _calm(stored, exact, allowed)
    marginal = _margin(spec, exact, steady, scale) <= allowed
    follows = _follows(spec, starts, stored, steady, scale)
    same_ending = calm | _endings_agree(spec, stored, exact)
    same_verdict = calm | _verdicts_agree(stored, exact_stability)
    # each line overrules those before it
    code = np.where(stored["ending"] == ENDINGS.code("horizon"), WITHIN, AGREES)
    code = np.where(marginal & ~(same_ending & same_verdict), MARGINAL, code)
    code = np.where(follows, code, CONTRADICTORY)
    code = np.where(marginal | same_verdict, code, VERDICT_DIFFERS)
    code = np.where(period_share > 1.0, PERIOD_DIFFERS, code)
    code = np.where(marginal | same_ending, code, ENDING_DIFFERS)
    # a difference that is no number is no agreement
    code = np.where(difference <= allowed, code, EXTREMES_DIFFER)
    return {
        "audit": _set_apart(code, stored, exact, follows).astype(np.int8),
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


def _tilt_difference(spec: "SweepSpec", stored: Columns, exact: Columns, allowed: Array) -> Array:
    """Larger difference of the two extremes.

    A run that time ended need only lie inside the exact extremes. Where the motion grazes fall_tilt one of the two
    may say that it fell, and so show only what came before: then one need only lie inside the other.
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
    """How far [s] a period may be from the exact one."""
    width = exact["tilt_max"] - exact["tilt_min"]
    with np.errstate(divide="ignore"):
        lingering = np.nan_to_num(1.0 / np.abs(exact["separatrix"]), nan=0.0, posinf=np.inf)
        share = _PERIOD_FLOOR + _PERIOD_FACTOR * allowed * (1.0 + 1.0 / width + lingering)
    allowance: Array = share * exact["nutation_period"]
    return allowance


def _follows(spec: "SweepSpec", starts: Starts, stored: Columns, steady: Array, scale: Array) -> Truths:
    """Whether the numbers that follow from the start, the extremes and the ending do follow from them."""
    peak, reach = np.maximum(np.abs(stored["tilt_min"]), np.abs(stored["tilt_max"])), _reach(stored, steady)
    with np.errstate(divide="ignore", invalid="ignore"):
        amplification = np.where(scale > 0.0, reach / scale, np.nan)
        rounding = _ROUNDING * amplification + _TILT_ROUNDING / scale
    verdict = stored["stability"] == _verdict(spec, stored, steady, scale)
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


def _margin(spec: "SweepSpec", exact: Columns, steady: Array, scale: Array) -> Array:
    """How near [rad] the motion comes to where its verdict or its ending would change.

    Zero for a fall, of which the reduction knows no turning point: an atlas that says otherwise has to agree in its
    extremes, and these then are within the tolerance of fall_tilt.
    """
    peak = np.maximum(np.abs(exact["tilt_max"]), np.abs(exact["tilt_min"]))
    margin: Array = np.minimum(
        np.abs(_reach(exact, steady) - np.nan_to_num(spec.criterion.allowed(scale))),
        np.abs(peak - spec.fall_tilt),
    )
    return margin


def _endings_agree(spec: "SweepSpec", stored: Columns, exact: Columns) -> Truths:
    """Whether endings are the same, or time may have ended the run before."""
    too_long = spec.duration > _MOST_PERIODS * exact["nutation_period"]
    open_ = (stored["ending"] == ENDINGS.code("horizon")) & ~too_long
    agree: Truths = open_ | (stored["ending"] == exact["ending"])
    return agree


def _verdicts_agree(stored: Columns, exact: npt.NDArray[Any]) -> Truths:
    """Whether verdicts are the same, or a run that time ended leaves open what the reduction decides."""
    open_ = (stored["ending"] == ENDINGS.code("horizon")) & (stored["stability"] == UNDECIDED)
    agree: Truths = open_ | (stored["stability"] == exact)
    return agree


def _calm(stored: Columns, exact: Columns, allowed: Array) -> Truths:
    """Whether a motion within the tolerance of rest is taken for steady by one of the two."""
    calm = (ENDINGS.code("bounded"), ENDINGS.code("steady"))
    both = np.isin(stored["ending"], calm) & np.isin(exact["ending"], calm)
    found: Truths = both & (exact["tilt_max"] - exact["tilt_min"] <= allowed)
    return found


def _set_apart(code: npt.NDArray[Any], stored: Columns, exact: Columns, follows: Truths) -> npt.NDArray[Any]:
    """Cells that one of the two has nothing to say of."""
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


def _verdict(spec: "SweepSpec", measured: Columns, steady: Array, scale: Array) -> npt.NDArray[np.int8]:
    return spec.criterion.verdict(ENDINGS, measured, _reach(measured, steady), scale)


def _reach(measured: Columns, steady: Array) -> Array:
    reach: Array = np.maximum(np.abs(measured["tilt_max"] - steady), np.abs(measured["tilt_min"] - steady))
    return reach


def _fell(measured: Columns) -> Truths:
    fell: Truths = measured["ending"] == ENDINGS.code("fell")
    return fell


def _same(one: Array, other: Array, within: Array | float) -> Truths:
    same: Truths = (np.abs(one - other) <= within) | (one == other) | (np.isnan(one) & np.isnan(other))
    return same
