"""The exact reduction of the disk to one degree of freedom, as a reference: extremes without time stepping."""

from typing import Any

import numpy as np
import numpy.typing as npt

from kernels.disk import arrays
from kernels.disk.exact import arrays as exact_arrays
from sweep.model.description import CellCheck, Columns, Request, Starts
from sweep.model.disk import audit
from sweep.model.disk.cell_checks import MEASURES
from sweep.model.disk.initial_conditions import computed_rates
from sweep.model.disk.tables import ENDINGS, REDUCTION
from sweep.model.kernel import Kernel
from sweep.model.quantity import Array

_MODULE = "kernels.disk.exact.extremes"
_ALONE = ("kernels.disk.exact.legendre:build_tables", f"{_MODULE}:reduce")

#: The reduction with and without the nutation period.
EXTREMES = Kernel(
    _MODULE,
    "extremes",
    (*_ALONE, "kernels.disk.exact.wide_panels:build_wide_panels", "kernels.disk.exact.chunk_periods:periods"),
    seconds=10.0,
)
EXTREMES_ALONE = Kernel(_MODULE, "extremes", _ALONE, seconds=8.0)

FALL_TIMES = Kernel(
    "kernels.disk.exact.fall_time",
    "fall_times",
    ("kernels.disk.exact.legendre:build_tables", "kernels.disk.exact.fall_time:integrate_falls"),
    seconds=2.0,
)

#: Fall times computed per call at most: a tenth of a second. They also come out of a repeated integration.
_MOST_FALLS = 20_000


class ExactReduction:
    """See `sweep.model.description.ExactReference`."""

    variables = REDUCTION
    compared = ("tilt_min", "tilt_max", "nutation_period")
    audit, sampled = audit.AUDIT, ""

    def measures(
        self, spec: Request, starts: Starts, extremes_only: bool = False
    ) -> dict[str, npt.NDArray[Any]]:
        """Return what the exact reduction says of cells, without time stepping (`kernels.disk.exact.extremes`).

        Parameters
        ----------
        spec : Request
        starts : mapping of str to array, shape (n,)
        extremes_only : bool
            Leave out the nutation period, which costs as much as all the rest or more.

        Returns
        -------
        dict of str to array, shape (n,)
            The measures and counts of the disk and `variables`; NaN or 0 where the reduction has none. A cell whose
            extremes are not known to the tolerance of the spec (on a separatrix) is unresolved. The period of a cell is
            right to 1e-9, or NaN: beside a separatrix rounding may decide more of it than that.
        """
        rows = np.stack([starts[name] for name in arrays.PARAMETERS])
        kernel = EXTREMES_ALONE if extremes_only else EXTREMES
        measures, counts = kernel.load()(rows, spec.fall_tilt, not extremes_only)
        found = dict(zip(exact_arrays.EXACT_MEASURES, measures, strict=True))
        found |= zip(exact_arrays.EXACT_COUNTS, counts, strict=True)
        vague = found["tilt_error"] > spec.tolerance
        for name in ("tilt_min", "tilt_max", "nutation_period", "tilt_error"):
            found[name][vague] = np.nan
        missing, none = np.full(vague.size, np.nan), np.zeros(vague.size, np.int32)
        return {
            **dict.fromkeys(arrays.MEASURES, missing),
            **dict.fromkeys(arrays.COUNTS, none),
            **found,
            "ending": np.where(vague, ENDINGS.code("unresolved"), found["ending"]),
        }

    def needed(self, spec: Request) -> tuple[str, ...]:
        """Return the variables of an atlas that `check` reads."""
        needed = (*MEASURES, *spec.criterion.needs(spec.model), *computed_rates(spec))
        return tuple(dict.fromkeys(needed))

    def truth(self, spec: Request, starts: Starts, first: int) -> dict[str, npt.NDArray[Any]]:
        """Return what `check` holds cells against: `measures`, and the fall times of some cells."""
        exact = self.measures(spec, starts)
        # endings are compared many times
        exact["ending"] = exact["ending"].astype(np.int8)
        if spec.method != "exact":
            exact["fall_time"] = _fall_times(spec, starts, exact)
        return exact

    def check(
        self, spec: Request, starts: Starts, stored: Columns, exact: Columns
    ) -> tuple[dict[str, npt.NDArray[Any]], list[CellCheck]]:
        """Compare stored cells with the reduction; see `sweep.model.disk.audit.check`."""
        return audit.check(spec, starts, stored, exact)

    def untimed(self, spec: Request) -> str:
        """Return what an atlas of ``method=exact`` does not know: the reduction has no time."""
        return "no duration and no fall time" if spec.method == "exact" else ""


def _fall_times(spec: Request, starts: Starts, exact: Columns) -> Array:
    """Return the fall times [s] of cells that fall, or of every k-th of them; NaN for the others."""
    fallen = np.flatnonzero(
        (exact["ending"] == ENDINGS.code("fell")) & (np.abs(starts["tilt"]) < spec.fall_tilt)
    )
    chosen = fallen[:: max(1, -(-fallen.size // _MOST_FALLS))]
    times = np.full(exact["ending"].shape, np.nan)
    if chosen.size:
        rows = np.stack([starts[name][chosen] for name in arrays.PARAMETERS])
        tilts = np.stack([exact[name][chosen] for name in arrays.EXTREME_TILTS])
        times[chosen] = FALL_TIMES.load()(rows, tilts, spec.fall_tilt)
    return times
