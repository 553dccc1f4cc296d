"""A table of the critical rates that atlases have measured, with the analytic limits."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from kernels.disk.steady import critical_precession_rate_squared, critical_roll_rate_squared
from sweep.atlas.cf_metadata import edge_names
from sweep.atlas.dataset import spec_of

if TYPE_CHECKING:
    import xarray as xr


def critical_table(datasets: "Sequence[xr.Dataset]") -> str:
    """Return rate^2 R/g at the boundary, at the smallest tilt that has one: measured, predicted, and the limit.

    The limit is that of vanishing perturbation and vanishing tilt: 1/[2(1+alpha)] for the roll rate, 2/(2+alpha) for
    the precession rate.
    """
    rows = [["atlas", "at tilt", "rate^2 R/g of", "measured", "predicted by", "", "analytic limit"]]
    for dataset in datasets:
        for axis in ("roll_rate", "precession_rate"):
            rows += _rows(dataset, axis)
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows
    )


def _rows(dataset: "xr.Dataset", axis: str) -> Iterator[list[str]]:
    names = edge_names(axis)
    if names[0] not in dataset or dataset[names[0]].dims != ("tilt",):
        return
    known = np.flatnonzero(np.isfinite(dataset[names[0]].values))
    if not known.size:
        return
    row = {"tilt": int(known[0])}
    rate, halfwidth, predicted = (float(dataset[name][row]) for name in names[:3])
    unit_squared = float(dataset["radius"]) / float(dataset["gravity"])
    alpha = float(dataset["alpha"])
    limit = (
        critical_roll_rate_squared(alpha, 1.0, 1.0)
        if axis == "roll_rate"
        else critical_precession_rate_squared(alpha, 1.0, 1.0)
    )
    yield [
        dataset.attrs["title"].split(":")[0],
        f"{np.degrees(float(dataset['tilt'][row])):.3g} deg",
        axis,
        f"{rate**2 * unit_squared:.5f} +- {2.0 * rate * halfwidth * unit_squared:.5f}",
        str(spec_of(dataset).criterion),
        f"{predicted**2 * unit_squared:.5f}",
        f"{limit:.5f}",
    ]
