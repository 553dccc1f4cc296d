"""Every cell of an atlas against the exact reduction: the same starts, no time stepping, an independent way."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from sweep import cells
from sweep.agreement import NEEDED, check
from sweep.atlas import as_variable, created, declare_cells, spec_of
from sweep.blocks import Span
from sweep.errors import RequestError
from sweep.schema_exact import AUDIT, DISAGREES

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Findings:
    """An audit in numbers.

    `counts` maps each flag of the audit to its number of cells; `median`, `percentile_99` and `largest` describe
    `tilt_difference` [rad] over the cells that have one; `worst` is the coordinates of the cell with the largest
    difference, or, if there are any, of the first that disagrees.
    """

    counts: Mapping[str, int]
    median: float
    percentile_99: float
    largest: float
    largest_period: float
    worst: Mapping[str, float]
    tolerance: float

    @property
    def passed(self) -> bool:
        """Whether no cell disagrees and none is missing."""
        return not self.counts["disagrees"] and not self.counts["not_computed"]


def audit(dataset: "xr.Dataset") -> "xr.Dataset":
    """Hold every cell of an atlas against the exact extremes, period and verdict.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas, as `sweep.run` or `sweep.open_atlas` returns it.

    Returns
    -------
    xarray.Dataset
        On the dimensions of the atlas: the variables of `schema_exact.AUDIT`. A cell agrees if its extremes lie within
        the tolerance that the atlas records, its period within what that tolerance means for it, its ending and
        verdict are the exact ones, and its derived numbers follow from its extremes.

    Raises
    ------
    RequestError
        If the atlas has not the variables that are needed, or is a part.
    """
    import xarray as xr

    missing = [name for name in NEEDED if name not in dataset]
    if missing:
        raise RequestError(
            "an atlas that cannot be verified",
            f"an atlas has {', '.join(NEEDED)}",
            f"missing: {', '.join(missing)}",
            "make it again with eulerdisk run",
            str(dataset.encoding.get("source", "atlas")),
        )
    spec = spec_of(dataset)
    stored = {name: dataset[name].values.ravel() for name in NEEDED}
    found = check(spec, cells.starts(spec, Span(0, spec.size)), stored)
    coordinates = {name: coordinate for name, coordinate in dataset.coords.items() if name not in AUDIT}
    return xr.Dataset(
        {
            each.name: as_variable(each, found[each.name].reshape(spec.shape), spec)
            for each in declare_cells(spec, AUDIT, "audit")
        },
        coordinates,
        {
            **dataset.attrs,
            "title": f"Audit of: {dataset.attrs['title']}",
            "history": f"{dataset.attrs['history']}\n{created()} sweep.audit",
        },
    )


def findings(audited: "xr.Dataset") -> Findings:
    """Return an audit in numbers."""
    codes, difference = audited["audit"].values, audited["tilt_difference"].values
    flags = AUDIT["audit"].flags or {}
    known = difference[np.isfinite(difference)]
    disagreeing = np.argwhere(np.atleast_1d(codes) == DISAGREES)
    worst = {}
    if disagreeing.size or known.size:
        place = (
            disagreeing[0]
            if disagreeing.size
            else np.unravel_index(int(np.nanargmax(difference)), difference.shape)
        )
        worst = {
            str(name): float(audited[name][int(i)])
            for name, i in zip(audited["audit"].dims, place, strict=False)
        }
    period = np.abs(audited["period_difference"].values / audited["exact_period"].values)
    median, high, most = np.percentile(known, [50, 99, 100]) if known.size else (np.nan,) * 3
    return Findings(
        counts={name: int((codes == code).sum()) for code, name in flags.items()},
        median=float(median),
        percentile_99=float(high),
        largest=float(most),
        largest_period=float(np.nanmax(period)) if np.isfinite(period).any() else np.nan,
        worst=worst,
        tolerance=float(audited.attrs["tolerance"]),
    )
