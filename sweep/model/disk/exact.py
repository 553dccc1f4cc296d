"""The exact reduction of the disk to one degree of freedom, as a method and a reference without time stepping."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from kernels.bodies import arrays, shapes
from sweep.errors import counted
from sweep.model.audit import Audit, CellCheck
from sweep.model.description import Columns, Request, Starts
from sweep.model.disk.cell_checks import MEASURES, ReducedCells, cell_checks
from sweep.model.disk.initial_conditions import computed_rates
from sweep.model.disk.path import call_by_body, rows_of_disk
from sweep.model.disk.tables import REDUCTION, VARIABLES
from sweep.model.kernel import Kernel
from sweep.model.quantity import DECISION, Array, Quantity, Tolerance, Truths, table
from sweep.model.space_sample import SpaceSample, compare_with_space, is_sampled

NOT_COMPUTED, AGREES, WITHIN, MARGINAL, ATLAS_UNRESOLVED, EXACT_UNRESOLVED, INVALID = range(7)
AGREEING = (AGREES, WITHIN, MARGINAL)
EXTREMES_DIFFER, ENDING_DIFFERS, PERIOD_DIFFERS, VERDICT_DIFFERS, CONTRADICTORY, OTHER_DIFFERS = (
    DISAGREEING
) = range(7, 13)

_AUDIT_TILT = Tolerance(
    1e-8, 0.0, "it is a difference from the exact value, as large as an error of the atlas"
)

# fmt: off
_VARIABLES: Mapping[str, Quantity] = table(
    *REDUCTION.values(),
    Quantity("audit", "", "1", "comparison of the cell with the exact reduction", DECISION,
             "within: the cell ran out of time inside the exact extremes; marginal: ending or verdict differ, but they "
             "change within the tolerance; contradictory: its numbers do not follow from its own extremes; "
             "other_values_differ: a variable other than the extremes and the period is wrong", "i1",
             {
                 NOT_COMPUTED: "not_computed", AGREES: "agrees", WITHIN: "within", MARGINAL: "marginal",
                 ATLAS_UNRESOLVED: "unresolved_in_the_atlas", EXACT_UNRESOLVED: "unresolved_by_the_reduction",
                 INVALID: "invalid", EXTREMES_DIFFER: "extremes_differ", ENDING_DIFFERS: "ending_differs",
                 PERIOD_DIFFERS: "period_differs", VERDICT_DIFFERS: "verdict_differs",
                 CONTRADICTORY: "contradictory", OTHER_DIFFERS: "other_values_differ"}),
    Quantity("tilt_difference", r"\Delta\theta", "rad", "larger difference of the extreme tilts from the exact ones",
             _AUDIT_TILT, "if the cell ran out of time: distance of its extremes outside the exact ones"),
    Quantity("period_difference", r"\Delta P", "s", "nutation period minus the exact one", _AUDIT_TILT),
    Quantity("period_share", "", "1", "magnitude of period_difference over its allowed value", _AUDIT_TILT),
    Quantity("exact_tilt_min", r"\theta_{\min}", "rad", "exact smallest tilt of the motion", _AUDIT_TILT, "signed"),
    Quantity("exact_tilt_max", r"\theta_{\max}", "rad", "exact largest tilt of the motion", _AUDIT_TILT, "signed"),
    Quantity("exact_period", "P", "s", "exact nutation period", _AUDIT_TILT),
    Quantity("exact_stability", "", "1", "verdict of the criterion for the exact extremes", DECISION, "", "i1",
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
    summary="Every cell of a stability atlas compared with the exact extreme tilts and period of its motion.",
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
        `MEASURES` from the atlas, the rates that each cell computed, and other variables of the atlas.
    exact : mapping of str to array, shape (n,)
        The measures of the same starts by the exact reduction (`sweep.model.disk.exact`).

    Returns
    -------
    variables : dict of str to array, shape (n,)
        The variables of `AUDIT`.
    checks : list of CellCheck
        One or more for each variable of the cells in the atlas.
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
    variables: dict[str, npt.NDArray[Any]] = {
        "audit": code,
        "tilt_difference": cells.difference,
        "period_difference": period_difference,
        "period_share": period_share,
        "exact_tilt_min": exact["tilt_min"],
        "exact_tilt_max": exact["tilt_max"],
        "exact_period": exact["nutation_period"],
        "exact_stability": cells.exact_stability,
        **{name: exact[name] for name in REDUCTION if name in exact},
    }
    return variables, checks


def _follows(cells: ReducedCells, checks: Sequence[CellCheck]) -> Truths:
    """Return where the numbers derived from the start, the extremes and the ending are right."""
    follows: Truths = cells.verdict_follows & (
        np.isfinite(cells.stored["nutation_period"]) == cells.has_period
    )
    peak = cells.derived["peak_tilt"]
    beyond = cells.spec.model.may_be_lost(cells.spec, cells.stored, np.zeros_like(peak))
    follows &= beyond == cells.ended("fell")
    names = ("peak_tilt", "amplification", *computed_rates(cells.spec))
    for check_ in checks:
        if check_.name in names and check_.difference is not cells.nothing:
            follows &= ~check_.wrong
    return follows


def _mark_failed_cells(code: npt.NDArray[np.int8], cells: ReducedCells, follows: Truths) -> None:
    """Write the codes of cells that the atlas or the reduction could not compute.

    A cell that lacks only the period in the reduction, next to a separatrix, is not one of them: its other values are
    compared.
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


#: The extremes and periods, and the wells, of all bodies: a thin disk is a torus without a tube.
REDUCE = Kernel("kernels.reduction.cells", "reduce", seconds=6.0)
WELLS = Kernel("kernels.reduction.wells", "wells", seconds=4.0)

FALL_TIMES = Kernel("kernels.reduction.falls", "fall_times", seconds=6.0)

#: Most fall times computed per call, in a tenth of a second. Repeating the integration checks all of them anyway.
_MOST_FALLS = 20_000


def reduce_bodies(rows: Array, body: int, fall_tilt: float, timed: bool) -> dict[str, npt.NDArray[Any]]:
    """Return the measures and endings of bodies from the reduction, by name.

    Parameters
    ----------
    rows : array, shape (len(kernels.bodies.arrays.PARAMETERS), n)
    body : int
        Number of the kind of body (`kernels.bodies.shapes`).
    fall_tilt : float
        Tilt [rad] at which motions end.
    timed : bool
        Whether to compute the period.
    """
    n = rows.shape[1]
    measures, counts = np.empty((len(arrays.REDUCED), n)), np.empty((1, n), np.int32)
    call_by_body(REDUCE, rows, (float(body), float(fall_tilt), int(timed)), (measures, counts))
    return {**dict(zip(arrays.REDUCED, measures, strict=True)), "ending": counts[0]}


def count_wells(rows: Array, body: int) -> npt.NDArray[np.int64]:
    """Return the number of wells of the potential of bodies, 0 for invalid starts; arguments as for `reduce_bodies`."""
    counts = np.empty(rows.shape[1], np.int64)
    call_by_body(WELLS, rows, (float(body),), (counts,))
    return counts


class ExactReduction:
    """See `sweep.model.description.ExactReference`.

    Parameters
    ----------
    sample : SpaceSample, optional
        The sample of cells of an atlas of ``method=exact`` to compute again in space; none if not given.
    """

    variables = REDUCTION
    compared = ("tilt_min", "tilt_max", "nutation_period")
    audit = AUDIT

    def __init__(self, sample: SpaceSample | None = None) -> None:
        self._sample = sample

    @property
    def sampled(self) -> str:
        """A description of the sample that was computed in space; empty if there is none."""
        if self._sample is None or not self._sample.followed:
            return ""
        return f"{counted(self._sample.followed, 'cell')}, drawn with seed {self._sample.seed}, by DOP853 in space"

    def rows(self, spec: Request, starts: Starts) -> tuple[Array, int]:
        """Return the rows of starts (`kernels.bodies.arrays.PARAMETERS`), and the index of their kind of body."""
        return rows_of_disk(starts), shapes.TORUS

    def rigid_bodies(self, spec: Request, starts: Starts) -> dict[str, Array]:
        """Return the fields of `sweep.model.rigid_body.RigidBody` of starts."""
        one, alpha = np.ones_like(starts["alpha"]), starts["alpha"]
        none = np.zeros_like(alpha)
        return {
            "core": one, "shift": none, "edge": none, "square": one, "axial": alpha, "transverse": 0.5 * alpha,
        }  # fmt: skip

    def _with_sample(self, spec: Request, starts: Starts, first: int, exact: Columns) -> Columns:
        """Return the values of the reduction and, if the atlas was made by it, the motions of the sample in space."""
        if spec.method != "exact" or self._sample is None:
            return exact
        bounded = spec.model.endings.among(exact["ending"], "bounded")
        bodies = self.rigid_bodies(spec, starts)
        return {**exact, **self._sample.follow(starts, bodies, exact, bounded, first)}

    def measures(
        self, spec: Request, starts: Starts, extremes_only: bool = False
    ) -> dict[str, npt.NDArray[Any]]:
        """Compute cells with the exact reduction, without time stepping (`kernels.reduction`).

        Parameters
        ----------
        spec : Request
        starts : mapping of str to array, shape (n,)
        extremes_only : bool
            Skip the nutation period, which costs several times as much as the rest, and the wells.

        Returns
        -------
        dict of str to array, shape (n,)
            The measures and counts of the model and `variables`; NaN or 0 where the reduction has no value. A cell
            whose extremes are not known to the tolerance of the spec (on a separatrix) is unresolved. A period is right
            to 1e-9, or NaN: next to a separatrix rounding may change it by more.
        """
        rows, body = self.rows(spec, starts)
        columns = reduce_bodies(rows, body, spec.fall_tilt, not extremes_only)
        if "wells" in self.variables:
            # an integrated atlas has no such variable
            known = spec.method == "exact" and not extremes_only
            columns["wells"] = count_wells(rows, body) if known else np.zeros(rows.shape[1], np.int64)
        return without_vague(columns, spec)

    def with_wells(self, spec: Request, starts: Starts) -> dict[str, npt.NDArray[Any]]:
        """Return `measures` without periods, and the number of wells of the potential, 0 if unknown."""
        wells = count_wells(*self.rows(spec, starts))
        return {**self.measures(spec, starts, extremes_only=True), "wells": wells}

    def needed(self, spec: Request) -> tuple[str, ...]:
        """Return the variables of an atlas that `check` reads."""
        needed = (*MEASURES, *spec.criterion.reads(spec.model), *computed_rates(spec))
        return tuple(dict.fromkeys(needed))

    def truth(self, spec: Request, starts: Starts, first: int, stored: Columns) -> Columns:
        """Return the expected values for `check`: `measures`, fall times of some cells, and the sample in space."""
        exact = self.measures(spec, starts)
        # endings are compared many times
        exact["ending"] = exact["ending"].astype(np.int8)
        if spec.method != "exact":
            exact["fall_time"] = _fall_times(spec, starts, exact, *self.rows(spec, starts))
        return self._with_sample(spec, starts, first, exact)

    def check(
        self, spec: Request, starts: Starts, stored: Columns, exact: Columns
    ) -> tuple[dict[str, npt.NDArray[Any]], list[CellCheck]]:
        """Compare stored cells with the reduction; see `sweep.model.disk.exact.check`."""
        variables, checks = check(spec, starts, stored, exact)
        if not is_sampled(exact):
            return variables, checks
        in_space = compare_with_space(stored, exact, spec.tolerance + np.fmax(exact["tilt_error"], 0.0))
        for row in in_space:
            code = PERIOD_DIFFERS if row.name == "nutation_period" else EXTREMES_DIFFER
            variables["audit"][row.wrong & np.isin(variables["audit"], AGREEING)] = code
        return variables, [*checks, *in_space]

    def untimed(self, spec: Request) -> str:
        """Return which variables an atlas of ``method=exact`` lacks: the reduction has no time."""
        return "no duration and no fall time" if spec.method == "exact" else ""


def without_vague(columns: Columns, spec: Request) -> dict[str, npt.NDArray[Any]]:
    """Return the values of the reduction; cells that are not known to the tolerance of a spec become unresolved.

    Parameters
    ----------
    columns : mapping of str to array, shape (n,)
        Measures and ``ending`` from the reduction; vague cells become NaN in place. Other measures of the model become
        NaN, other counts 0.
    spec : Request
    """
    vague = columns["tilt_error"] > spec.tolerance
    # no number is better known than its last bit
    last_bit = np.finfo(float).eps * np.fmax(np.abs(columns["tilt_min"]), np.abs(columns["tilt_max"]))
    np.copyto(columns["tilt_error"], last_bit, where=last_bit > columns["tilt_error"])
    for name in ("tilt_min", "tilt_max", "nutation_period", "tilt_error"):
        columns[name][vague] = np.nan
    missing, none = np.full(vague.size, np.nan), np.zeros(vague.size, np.int32)
    return {
        **dict.fromkeys(spec.model.measures, missing),
        **dict.fromkeys(spec.model.counts, none),
        **columns,
        "ending": np.where(vague, spec.model.endings.code("unresolved"), columns["ending"]),
    }


def _fall_times(spec: Request, starts: Starts, exact: Columns, rows: Array, kind: int) -> Array:
    """Return the fall times [s] of the cells that fall, or of every k-th of them; NaN for the others.

    Parameters
    ----------
    spec : Request
    starts, exact : mapping of str to array, shape (n,)
        The starts, and their values from the reduction.
    rows, kind
        As from `ExactReduction.rows`.
    """
    fallen = np.flatnonzero(
        spec.model.endings.among(exact["ending"], "fell") & (np.abs(starts["tilt"]) < spec.fall_tilt)
    )
    chosen = fallen[:: max(1, -(-fallen.size // _MOST_FALLS))]
    times = np.full(exact["ending"].shape, np.nan)
    if chosen.size:
        chosen_times = np.empty(chosen.size)
        chosen_rows = np.ascontiguousarray(rows[:, chosen])
        call_by_body(FALL_TIMES, chosen_rows, (float(kind), float(spec.fall_tilt)), (chosen_times,))
        times[chosen] = chosen_times
    return times
