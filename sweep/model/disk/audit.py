"""Compare cells of an atlas with the exact reduction, which has the same starts and no time stepping."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.model.description import Audit, CellCheck, Columns, Request, Starts
from sweep.model.disk.cell_checks import ReducedCells, cell_checks
from sweep.model.disk.initial_conditions import computed_rates
from sweep.model.disk.tables import REDUCTION, VARIABLES
from sweep.model.quantity import DECISION, Quantity, Tolerance, Truths, table

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
    cells = ReducedCells(spec, starts, stored, exact)
    period_difference = stored["nutation_period"] - exact["nutation_period"]
    period_share = np.abs(period_difference) / cells.period_allowed
    checks = cell_checks(cells)
    follows = _follows(cells, checks)
    code = np.full(cells.every.shape, AGREES, np.int8)
    # each line overrides those before it
    code[cells.ended("horizon")] = WITHIN
    code[cells.marginal & ~(cells.same_ending & cells.same_verdict)] = MARGINAL
    code[~follows] = CONTRADICTORY
    code[~cells.verdict_right] = VERDICT_DIFFERS
    code[period_share > 1.0] = PERIOD_DIFFERS
    code[~cells.ending_right] = ENDING_DIFFERS
    # written so that NaN differs
    code[~(cells.difference <= cells.allowed)] = EXTREMES_DIFFER
    _mark_failed_cells(code, cells, follows)
    variables = {
        "audit": code,
        "tilt_difference": cells.difference,
        "period_difference": period_difference,
        "period_share": period_share,
        "exact_tilt_min": exact["tilt_min"],
        "exact_tilt_max": exact["tilt_max"],
        "exact_period": exact["nutation_period"],
        "exact_stability": cells.exact_stability,
        "wells": exact["wells"],
        "separatrix": exact["separatrix"],
    }
    return variables, checks


def _follows(cells: ReducedCells, checks: Sequence[CellCheck]) -> Truths:
    """Return where all numbers that follow from the start, the extremes and the ending do follow from them."""
    follows: Truths = cells.verdict_follows & (
        np.isfinite(cells.stored["nutation_period"]) == cells.has_period
    )
    follows &= (cells.derived["peak_tilt"] >= cells.spec.fall_tilt) == cells.ended("fell")
    names = ("peak_tilt", "amplification", *computed_rates(cells.spec))
    for each in checks:
        if each.name in names and each.difference is not cells.nothing:
            follows &= ~each.wrong
    return follows


def _mark_failed_cells(code: npt.NDArray[np.int8], cells: ReducedCells, follows: Truths) -> None:
    """Write the codes of cells that the atlas or the reduction could not compute.

    A cell of which the reduction lacks only the period, beside a separatrix, is none of them: all else is held.
    """
    impossible, refused = cells.exact_ended("invalid"), cells.ended("invalid")
    for cells_apart, name in (
        (cells.exact_ended("unresolved"), EXACT_UNRESOLVED),
        (cells.ended("unresolved"), ATLAS_UNRESOLVED),
        (impossible & refused, INVALID),
    ):
        if cells_apart.any():
            code[cells_apart] = np.where(follows[cells_apart], name, CONTRADICTORY)
    code[impossible != refused] = ENDING_DIFFERS
    code[cells.ended("not_computed")] = NOT_COMPUTED
