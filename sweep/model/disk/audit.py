"""Compare cells of an atlas with the exact reduction, which has the same starts and no time stepping."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.model.description import Audit, CellCheck, Columns, Request, Starts
from sweep.model.disk.cell_checks import Facts, cell_checks, ended, same
from sweep.model.disk.initial_conditions import computed_rates
from sweep.model.disk.tables import ENDINGS, REDUCTION, VARIABLES
from sweep.model.quantity import DECISION, UNDECIDED, Array, Quantity, Tolerance, Truths, table
from sweep.model.stated_error import stated_error

#: Variables of an atlas that the audit reads.
MEASURES = ("ending", "stability", "tilt_min", "tilt_max", "peak_tilt", "amplification", "nutation_period")

NOT_COMPUTED, AGREES, WITHIN, MARGINAL, ATLAS_UNRESOLVED, EXACT_UNRESOLVED, INVALID = range(7)
AGREEING = (AGREES, WITHIN, MARGINAL)
EXTREMES_DIFFER, ENDING_DIFFERS, PERIOD_DIFFERS, VERDICT_DIFFERS, CONTRADICTORY, OTHER_DIFFERS = (
    DISAGREEING
) = range(7, 13)

_AUDIT_TILT = Tolerance(1e-8, 0.0, "a difference from the exact value is as large as the error it measures")

# fmt: off
_VARIABLES: Mapping[str, Quantity] = table(
    *REDUCTION.values(),
    Quantity("audit", "", "1", "the cell of the atlas against the exact reduction", DECISION,
             "within: time ended the run inside the exact extremes; marginal: ending or verdict differ, but within the "
             "tolerance of where they change; contradictory: its numbers do not follow from its own extremes; "
             "other_values_differ: a variable beside the extremes and the period is wrong", "i1",
             {
                 NOT_COMPUTED: "not_computed", AGREES: "agrees", WITHIN: "within", MARGINAL: "marginal",
                 ATLAS_UNRESOLVED: "unresolved_in_the_atlas", EXACT_UNRESOLVED: "unresolved_by_the_reduction",
                 INVALID: "invalid", EXTREMES_DIFFER: "extremes_differ", ENDING_DIFFERS: "ending_differs",
                 PERIOD_DIFFERS: "period_differs", VERDICT_DIFFERS: "verdict_differs",
                 CONTRADICTORY: "contradictory", OTHER_DIFFERS: "other_values_differ"}),
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
    other=OTHER_DIFFERS,
    difference="tilt_difference",
    units="rad",
    told="tilts        the extremes differ from the exact ones by",
    summary="Every cell of a stability atlas held against the exact extreme tilts and period of its motion.",
    ended_by_time=WITHIN,
    period=("period_difference", "exact_period", "period_share"),
)

#: An error of an extreme tilt changes the period by about its ratio to the width of the swing, and near a saddle by its
#: ratio to the separatrix.
_PERIOD_FACTOR = 2.0

#: RK4 keeps time less well than energy: by a multiple of the tolerance that chose the step, and by at most the last
#: where the step was given. See the comment in `_period_allowance` for what was measured.
_PERIOD_ROUNDING, _PERIOD_TOLERANCE, _PERIOD_GIVEN_STEP = 1e-9, 10.0, 3e-6

#: Both turning points are passed within one period; the rest allows for the error of the period.
_MOST_PERIODS = 1.01

#: Differences of logarithms and square roots between processors: relative, and absolute in a tilt [rad].
_ROUNDING, _TILT_ROUNDING = 1e-12, 1e-15


def check(
    spec: Request, starts: Starts, stored: Columns, exact: Columns
) -> tuple[dict[str, npt.NDArray[Any]], list[CellCheck]]:
    """Compare stored cells with the exact reduction.

    Parameters
    ----------
    spec : Request
    starts : mapping of str to array, shape (n,)
    stored : mapping of str to array, shape (n,)
        `MEASURES` as the atlas has them, the rate that each cell computed, if there is one, and what else it holds.
    exact : mapping of str to array, shape (n,)
        The measures of the same starts by the exact reduction (`sweep.model.disk.exact`).

    Returns
    -------
    variables : dict of str to array, shape (n,)
        The variables of `AUDIT`.
    checks : list of CellCheck
        One or more of each variable that the atlas holds of its cells.
    """
    model, scale = spec.model, spec.model.perturbation(spec, starts)
    stored_reach, exact_reach = model.reach(spec, starts, stored), model.reach(spec, starts, exact)
    derived = {**_rederived(spec, starts, stored), **_derived(stored, stored_reach, scale)}
    rounding = _rounding(derived["amplification"], scale)
    exact_stability = _exact_verdict(spec, starts, exact, exact_reach, scale)
    allowed = spec.tolerance + np.fmax(exact["tilt_error"], 0.0)
    low, high = _tilt_differences(spec, stored, exact, allowed)
    difference = np.maximum(low, high)
    period_difference = stored["nutation_period"] - exact["nutation_period"]
    period_allowed = _period_allowance(spec, exact, difference)
    period_share = np.abs(period_difference) / period_allowed
    at_rest = _at_rest(stored, exact, allowed)
    verdict_follows = _verdict_follows(spec, starts, stored, derived, stored_reach, scale, rounding)
    has_period = _has_period(spec, stored, exact)
    follows = verdict_follows & _numbers_follow(spec, starts, stored, derived, rounding, has_period)
    same_ending = at_rest | _endings_agree(spec, stored, exact)
    same_verdict = at_rest | _verdicts_agree(spec, stored, exact, exact_stability) | (not _decidable(spec))
    marginal = np.zeros(scale.shape, bool)
    if not (same_ending & same_verdict).all():
        marginal = _near_fall(spec, exact) <= allowed
        marginal |= _near_edge(spec, starts, exact, exact_reach, scale, allowed, period_allowed)
    ending_right, verdict_right = marginal | same_ending, marginal | same_verdict
    code = np.full(scale.shape, AGREES, np.int8)
    # each line overrides those before it
    code[stored["ending"] == ENDINGS.code("horizon")] = WITHIN
    code[marginal & ~(same_ending & same_verdict)] = MARGINAL
    code[~follows] = CONTRADICTORY
    code[~verdict_right] = VERDICT_DIFFERS
    code[period_share > 1.0] = PERIOD_DIFFERS
    code[~ending_right] = ENDING_DIFFERS
    # written so that NaN differs
    code[~(difference <= allowed)] = EXTREMES_DIFFER
    _mark_failed_cells(code, stored, exact, follows)
    variables = {
        "audit": code,
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
    facts = Facts(
        stored=stored,
        exact=exact,
        low=low,
        high=high,
        allowed=allowed,
        period_allowed=period_allowed,
        ending_right=ending_right,
        verdict_right=verdict_right,
        verdict_follows=verdict_follows,
        has_period=has_period,
        decidable=_decidable(spec),
        derived=derived,
        rounding=rounding,
    )
    return variables, cell_checks(spec, starts, facts)


def _tilt_differences(spec: Request, stored: Columns, exact: Columns, allowed: Array) -> tuple[Array, Array]:
    """Return the differences [rad] of the smallest and of the largest tilt.

    A run that time ended need only lie inside the exact extremes. Where a peak is within the tolerance of fall_tilt,
    the atlas or the reduction may end with a fall and hold only the extremes before it: then the extremes of one need
    only lie inside those of the other.
    """
    low, high = stored["tilt_min"] - exact["tilt_min"], stored["tilt_max"] - exact["tilt_max"]
    least, greatest = np.abs(low), np.abs(high)
    fell, open_ = _fell(stored) | _fell(exact), ended(stored, "horizon")
    if fell.any():
        ends = np.abs([each[name] for each in (stored, exact) for name in ("tilt_min", "tilt_max")])
        grazes = fell & np.any((ends < spec.fall_tilt) & (ends >= spec.fall_tilt - allowed), axis=0)
        inside = np.maximum(0.0, np.stack((-low, high)))
        around = np.maximum(0.0, np.stack((low, -high)))
        nested = np.where(inside.max(0) <= around.max(0), inside, around)
        least, greatest = np.where(grazes, nested, (least, greatest))
    if open_.any():
        least = np.where(open_, np.maximum(0.0, -low), least)
        greatest = np.where(open_, np.maximum(0.0, high), greatest)
    return least, greatest


def _period_allowance(spec: Request, exact: Columns, difference: Array) -> Array:
    """Return how far [s] a period may be from the exact one, whose extremes are `difference` [rad] from the stored.

    Measured over 150000 random motions with rates over six decades, at tolerances from 1e-10 to 1e-2 and a step of the
    engine's own: the period is off by at most 2.7 times the tolerance, relative, where its extremes allow no more.
    """
    width, own_step = exact["tilt_max"] - exact["tilt_min"], isinstance(spec.step, str)
    with np.errstate(divide="ignore", invalid="ignore"):
        # without a second well there is no saddle to linger at
        lingering = np.fmax(1.0 / np.abs(exact["separatrix"]), 0.0)
        # a given step keeps the tolerance of the extremes, and the time of a small swing no better than that
        apart = np.minimum(np.fmax(difference, 0.0), spec.tolerance) if own_step else spec.tolerance
        error = apart + np.fmax(exact["tilt_error"], 0.0) + _TILT_ROUNDING
        share = _PERIOD_FACTOR * error * (1.0 + 1.0 / width + lingering)
    time = _PERIOD_ROUNDING + _PERIOD_TOLERANCE * spec.tolerance
    if not own_step:
        time = max(time, _PERIOD_GIVEN_STEP)
    allowance: Array = (time + share) * exact["nutation_period"]
    return allowance


def _numbers_follow(
    spec: Request, starts: Starts, stored: Columns, derived: Columns, rounding: Array, has_period: Truths
) -> Truths:
    """Return where all numbers that follow from the start, the extremes and the ending do follow from them."""
    peak, fell = derived["peak_tilt"], _fell(stored)
    follows: Truths = (
        same(stored["peak_tilt"], peak, 0.0)
        & same(stored["amplification"], derived["amplification"], rounding)
        & (np.isfinite(stored["nutation_period"]) == has_period)
        & ((peak >= spec.fall_tilt) == fell)
    )
    for name in computed_rates(spec):
        rate = np.where(np.isfinite(starts[name]), starts[name], np.nan)
        follows &= same(stored[name], rate, _ROUNDING * np.abs(rate))
    return follows


def _has_period(spec: Request, stored: Columns, exact: Columns) -> Truths:
    """Return which cells have to have a period: of ``method=exact`` those of which the reduction has one."""
    bounded = ended(stored, "bounded")
    if spec.method != "exact":
        return bounded
    return np.asarray(bounded & ~(ended(exact, "bounded") & np.isnan(exact["nutation_period"])))


def _rounding(amplification: Array, scale: Array) -> Array:
    """Return by how much an amplification may differ between processors."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return _ROUNDING * amplification + _TILT_ROUNDING / scale


def _verdict_follows(
    spec: Request,
    starts: Starts,
    stored: Columns,
    derived: Columns,
    reach: Array,
    scale: Array,
    rounding: Array,
) -> Truths:
    """Return where the stored verdict is that of the criterion on the stored values, or lies on its edge."""
    follows: Truths = stored["stability"] == _verdict(spec, starts, stored, derived, reach, scale)
    if follows.all():
        return follows
    on_edge = spec.criterion.on_edge(
        spec,
        starts,
        [{**stored, **derived}],
        lambda name: rounding if name == "amplification" else _TILT_ROUNDING,
    )
    legal = np.isin(stored["stability"], list(VARIABLES["stability"].flags or ()))
    return np.asarray(follows | (on_edge & legal))


def _near_fall(spec: Request, exact: Columns) -> Array:
    """Return how near [rad] the motion comes to where its ending would change.

    Zero for a fall, for which the reduction has no turning point: an atlas with another ending must agree in its
    extremes, which are then within the tolerance of fall_tilt.
    """
    peak = np.maximum(np.abs(exact["tilt_max"]), np.abs(exact["tilt_min"]))
    return np.asarray(np.abs(peak - spec.fall_tilt))


def _near_edge(
    spec: Request,
    starts: Starts,
    exact: Columns,
    reach: Array,
    scale: Array,
    allowed: Array,
    period_allowed: Array,
) -> Truths:
    """Return where the verdict changes within what is allowed of the extremes [rad] and of the period [s]."""
    if not _decidable(spec) and not spec.criterion.limits_reach:
        return np.zeros(scale.shape, bool)
    columns = {**exact, **_derived(exact, reach, scale)}

    def error(name: str) -> Array:
        if name == "nutation_period":
            return period_allowed
        return stated_error({**VARIABLES, **REDUCTION}[name], spec, starts, columns, allowed)

    found: Truths = spec.criterion.on_edge(spec, starts, [columns], error)
    return found


def _endings_agree(spec: Request, stored: Columns, exact: Columns) -> Truths:
    """Return where endings are the same, or time may have ended the run first."""
    agree: Truths = stored["ending"] == exact["ending"]
    open_ = ended(stored, "horizon")
    if open_.any():
        too_long = spec.duration > _MOST_PERIODS * exact["nutation_period"]
        agree |= open_ & ~too_long
    return agree


def _verdicts_agree(
    spec: Request, stored: Columns, exact: Columns, exact_stability: npt.NDArray[Any]
) -> Truths:
    """Return where verdicts are the same, or the atlas has none that the reduction could give.

    A run that time ended may be undecided; by a criterion that does not limit the reach, its verdict is only that of
    what was measured until then. Beside a separatrix the reduction may lack the period that a criterion judges by.
    """
    agree: Truths = stored["stability"] == exact_stability
    open_ = ended(stored, "horizon")
    if spec.criterion.limits_reach:
        return np.asarray(agree | (open_ & (stored["stability"] == UNDECIDED)))
    if "nutation_period" in spec.criterion.needs(spec.model):
        open_ |= ended(exact, "bounded") & np.isnan(exact["nutation_period"])
    return np.asarray(agree | open_)


def _at_rest(stored: Columns, exact: Columns, allowed: Array) -> Truths:
    """Return where the swing is within the tolerance, so that it may count as bounded or as steady."""
    both = ended(stored, "bounded", "steady") & ended(exact, "bounded", "steady")
    found: Truths = both & (exact["tilt_max"] - exact["tilt_min"] <= allowed)
    return found


def _mark_failed_cells(code: npt.NDArray[np.int8], stored: Columns, exact: Columns, follows: Truths) -> None:
    """Write the codes of cells that the atlas or the reduction could not compute.

    A cell of which the reduction lacks only the period, beside a separatrix, is none of them: all else is held.
    """
    impossible, refused = ended(exact, "invalid"), ended(stored, "invalid")
    for cells_apart, name in (
        (ended(exact, "unresolved"), EXACT_UNRESOLVED),
        (ended(stored, "unresolved"), ATLAS_UNRESOLVED),
        (impossible & refused, INVALID),
    ):
        if cells_apart.any():
            code[cells_apart] = np.where(follows[cells_apart], name, CONTRADICTORY)
    code[impossible != refused] = ENDING_DIFFERS
    code[ended(stored, "not_computed")] = NOT_COMPUTED


def _verdict(
    spec: Request, starts: Starts, measured: Columns, derived: Columns, reach: Array, scale: Array
) -> npt.NDArray[np.int8]:
    """Return the verdict of the criterion on measures, on what follows from them (`_derived`), and on the starts."""
    columns = {**starts, **measured, **derived}
    verdict: npt.NDArray[np.int8] = spec.criterion.verdict(ENDINGS, columns, reach, scale)
    return verdict


def _exact_verdict(
    spec: Request, starts: Starts, exact: Columns, reach: Array, scale: Array
) -> npt.NDArray[np.int8]:
    """Return the verdict of the criterion on the exact values; undecided where the reduction does not know them."""
    if not _decidable(spec) and not spec.criterion.limits_reach:
        return np.full(scale.shape, UNDECIDED, np.int8)
    needed = {"peak_tilt", "amplification"}.intersection(spec.criterion.needs(spec.model))
    return _verdict(spec, starts, exact, _derived(exact, reach, scale) if needed else {}, reach, scale)


def _rederived(spec: Request, starts: Starts, stored: Columns) -> Columns:
    """Return what the model derives from stored measures; one that an older atlas does not hold is missing."""
    model = spec.model
    missing = np.full(len(stored["ending"]), np.nan)
    return model.derive(starts, {**dict.fromkeys((*model.measures, *model.counts), missing), **stored})


def _derived(measured: Columns, reach: Array, scale: Array) -> Columns:
    """Variables that follow from the extremes."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return {
            "peak_tilt": np.maximum(np.abs(measured["tilt_min"]), np.abs(measured["tilt_max"])),
            "amplification": np.where(scale > 0.0, reach / scale, np.nan),
        }


def _decidable(spec: Request) -> bool:
    """Whether the reduction knows all that the criterion needs: it has no time, so neither duration nor fall_time."""
    return set(spec.criterion.needs(spec.model)) <= {*MEASURES, *REDUCTION}


def _fell(measured: Columns) -> Truths:
    return ended(measured, "fell")
