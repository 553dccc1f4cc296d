"""The exact reduction of the disk to one degree of freedom, as a reference: extremes without time stepping."""

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
    """Return where all numbers that follow from the start, the extremes and the ending do follow from them."""
    follows: Truths = cells.verdict_follows & (
        np.isfinite(cells.stored["nutation_period"]) == cells.has_period
    )
    peak = cells.derived["peak_tilt"]
    beyond = cells.spec.model.may_be_lost(cells.spec, cells.stored, np.zeros_like(peak))
    follows &= beyond == cells.ended("fell")
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


#: Extremes and periods, and wells, of any body: a thin disk is a torus without a tube.
REDUCE = Kernel("kernels.reduction.cells", "reduce", seconds=6.0)
WELLS = Kernel("kernels.reduction.wells", "wells", seconds=4.0)

FALL_TIMES = Kernel("kernels.reduction.falls", "fall_times", seconds=6.0)

#: Fall times computed per call at most: a tenth of a second. They also come out of a repeated integration.
_MOST_FALLS = 20_000


def reduce_bodies(rows: Array, body: int, fall_tilt: float, timed: bool) -> dict[str, npt.NDArray[Any]]:
    """Return what the reduction measures of bodies, and their endings, by name.

    Parameters
    ----------
    rows : array, shape (len(kernels.bodies.arrays.PARAMETERS), n)
    body : int
        Its number (`kernels.bodies.shapes`).
    fall_tilt : float
        Tilt [rad] at which motions end.
    timed : bool
        Whether the period is wanted.
    """
    n = rows.shape[1]
    measures, counts = np.empty((len(arrays.REDUCED), n)), np.empty((1, n), np.int32)
    call_by_body(REDUCE, rows, (float(body), float(fall_tilt), int(timed)), (measures, counts))
    return {**dict(zip(arrays.REDUCED, measures, strict=True)), "ending": counts[0]}


def count_wells(rows: Array, body: int) -> npt.NDArray[np.int64]:
    """Return how many wells the potentials of bodies have, 0 where there is no such start; as `reduce_bodies`."""
    counts = np.empty(rows.shape[1], np.int64)
    call_by_body(WELLS, rows, (float(body),), (counts,))
    return counts


class ExactReduction:
    """See `sweep.model.description.ExactReference`.

    Parameters
    ----------
    sample : SpaceSample, optional
        Which cells of an atlas of ``method=exact`` are followed in space; none if not given.
    """

    variables = REDUCTION
    compared = ("tilt_min", "tilt_max", "nutation_period")
    audit = AUDIT

    def __init__(self, sample: SpaceSample | None = None) -> None:
        self._sample = sample

    @property
    def sampled(self) -> str:
        """Which cells were followed in space."""
        if self._sample is None or not self._sample.followed:
            return ""
        return f"{counted(self._sample.followed, 'cell')}, drawn with seed {self._sample.seed}, by DOP853 in space"

    def rows(self, spec: Request, starts: Starts) -> tuple[Array, int]:
        """Return the rows of starts (`kernels.bodies.arrays.PARAMETERS`), and the number of their body."""
        return rows_of_disk(starts), shapes.TORUS

    def rigid_bodies(self, spec: Request, starts: Starts) -> dict[str, Array]:
        """Return the fields of `sweep.model.rigid_body.RigidBody` of starts."""
        one, alpha = np.ones_like(starts["alpha"]), starts["alpha"]
        none = np.zeros_like(alpha)
        return {
            "core": one, "shift": none, "edge": none, "square": one, "axial": alpha, "transverse": 0.5 * alpha,
        }  # fmt: skip

    def _with_sample(self, spec: Request, starts: Starts, first: int, exact: Columns) -> Columns:
        """Return what the reduction says, and the motions of a sample in space if the atlas came from it."""
        if spec.method != "exact" or self._sample is None:
            return exact
        bounded = spec.model.endings.among(exact["ending"], "bounded")
        bodies = self.rigid_bodies(spec, starts)
        return {**exact, **self._sample.follow(starts, bodies, exact, bounded, first)}

    def measures(
        self, spec: Request, starts: Starts, extremes_only: bool = False
    ) -> dict[str, npt.NDArray[Any]]:
        """Return what the exact reduction says of cells, without time stepping (`kernels.reduction`).

        Parameters
        ----------
        spec : Request
        starts : mapping of str to array, shape (n,)
        extremes_only : bool
            Leave out the nutation period, which costs several times as much as the rest, and the wells.

        Returns
        -------
        dict of str to array, shape (n,)
            The measures and counts of the model and `variables`; NaN or 0 where the reduction has none. A cell whose
            extremes are not known to the tolerance of the spec (on a separatrix) is unresolved. The period of a cell is
            right to 1e-9, or NaN: beside a separatrix rounding may decide more of it than that.
        """
        rows, body = self.rows(spec, starts)
        found = reduce_bodies(rows, body, spec.fall_tilt, not extremes_only)
        if "wells" in self.variables:
            # an integrated atlas does not hold them
            known = spec.method == "exact" and not extremes_only
            found["wells"] = count_wells(rows, body) if known else np.zeros(rows.shape[1], np.int64)
        return without_vague(found, spec)

    def with_wells(self, spec: Request, starts: Starts) -> dict[str, npt.NDArray[Any]]:
        """Return `measures` without periods, and how many wells the potential has, 0 if unknown."""
        wells = count_wells(*self.rows(spec, starts))
        return {**self.measures(spec, starts, extremes_only=True), "wells": wells}

    def needed(self, spec: Request) -> tuple[str, ...]:
        """Return the variables of an atlas that `check` reads."""
        needed = (*MEASURES, *spec.criterion.reads(spec.model), *computed_rates(spec))
        return tuple(dict.fromkeys(needed))

    def truth(self, spec: Request, starts: Starts, first: int, stored: Columns) -> Columns:
        """Return what `check` holds cells against: `measures`, the fall times of some cells, and a sample in space."""
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
        """Return what an atlas of ``method=exact`` does not know: the reduction has no time."""
        return "no duration and no fall time" if spec.method == "exact" else ""


def without_vague(found: Columns, spec: Request) -> dict[str, npt.NDArray[Any]]:
    """Return what the reduction has found, where it is known to the tolerance of a spec; other cells are unresolved.

    Parameters
    ----------
    found : mapping of str to array, shape (n,)
        Its measures and ``ending``; those of vague cells become NaN in place. Measures and counts of the model that are
        not among them are NaN and 0.
    spec : Request
    """
    vague = found["tilt_error"] > spec.tolerance
    # no number is better known than its last bit
    last_bit = np.finfo(float).eps * np.fmax(np.abs(found["tilt_min"]), np.abs(found["tilt_max"]))
    np.copyto(found["tilt_error"], last_bit, where=last_bit > found["tilt_error"])
    for name in ("tilt_min", "tilt_max", "nutation_period", "tilt_error"):
        found[name][vague] = np.nan
    missing, none = np.full(vague.size, np.nan), np.zeros(vague.size, np.int32)
    return {
        **dict.fromkeys(spec.model.measures, missing),
        **dict.fromkeys(spec.model.counts, none),
        **found,
        "ending": np.where(vague, spec.model.endings.code("unresolved"), found["ending"]),
    }


def _fall_times(spec: Request, starts: Starts, exact: Columns, rows: Array, kind: int) -> Array:
    """Return the fall times [s] of cells that fall, or of every k-th of them; NaN for the others.

    Parameters
    ----------
    spec : Request
    starts, exact : mapping of str to array, shape (n,)
        The starts, and what the reduction says of them.
    rows, kind
        As of `ExactReduction.rows`.
    """
    fallen = np.flatnonzero(
        spec.model.endings.among(exact["ending"], "fell") & (np.abs(starts["tilt"]) < spec.fall_tilt)
    )
    chosen = fallen[:: max(1, -(-fallen.size // _MOST_FALLS))]
    times = np.full(exact["ending"].shape, np.nan)
    if chosen.size:
        found = np.empty(chosen.size)
        few = np.ascontiguousarray(rows[:, chosen])
        call_by_body(FALL_TIMES, few, (float(kind), float(spec.fall_tilt)), (found,))
        times[chosen] = found
    return times
