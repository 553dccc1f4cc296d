"""Compute the rolling, spinning and circling atlases, verify every cell, draw them and print the critical rates."""

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import typer
import xarray as xr
from plot_regimes import save_regimes

import sweep
from kernels.disk.steady import critical_precession_rate_squared, critical_roll_rate_squared
from sweep.atlas.cf_metadata import edge_names
from sweep.atlas.dataset import spec_of
from sweep.checks.verify import findings
from sweep.commands.audit_report import audit_line
from sweep.commands.terminal import stoppable
from sweep.figures import plots
from sweep.progress.display import showing

PRESETS = ("rolling", "spinning", "circling")


def main() -> None:
    """Write NAME.nc for every preset, boundaries.png and regimes.png into the output folder."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--output", "-o", type=Path, default=Path("atlas-out"), help="folder (default: atlas-out)"
    )
    folder = parser.parse_args().output
    make(folder)
    for name in PRESETS:
        with stoppable("scripts/atlas") as stopping, showing() as progress:
            # the folder belongs to this script: replace the results of an earlier run
            sweep.run_to_file(
                sweep.SweepSpec.preset(name),
                folder / f"{name}.nc",
                overwrite=True,
                command="scripts/atlas",
                progress=progress,
                stopping=stopping,
            )
    datasets = [sweep.open_atlas(folder / f"{name}.nc") for name in PRESETS]
    plots.save(plots.figure(datasets), folder / "boundaries.png")
    save_regimes(folder / "regimes.png")
    audits = [findings(sweep.verify(dataset)) for dataset in datasets]
    print(critical_table(datasets))
    for name, found in zip(PRESETS, audits, strict=True):
        print(f"{name}.nc".ljust(13) + audit_line(found))
    print(
        f"\nwritten to {folder}/: {', '.join(f'{name}.nc' for name in PRESETS)}, boundaries.png, regimes.png"
    )
    if not all(found.passed for found in audits):
        sys.exit(1)


def make(folder: Path) -> None:
    """Create the output folder if it does not exist.

    Raises
    ------
    RequestError
        If it cannot be created, or is a file.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise sweep.RequestError(
            f"The output must be a folder, or a path where one can be created; {problem.strerror or problem}.",
            hint="Give another name, as in: scripts/atlas -o atlas-out.",
            where=str(folder),
        ) from problem


def critical_table(datasets: Sequence[xr.Dataset]) -> str:
    """Return rate^2 R/g at the boundary, at the smallest tilt that has one: measured, predicted, and the limit.

    The limit is for vanishing perturbation and vanishing tilt: 1/[2(1+alpha)] for the roll rate, 2/(2+alpha) for the
    precession rate.
    """
    rows = [["atlas", "at tilt", "rate^2 R/g of", "measured", "predicted by", "", "analytic limit"]]
    for dataset in datasets:
        for axis in ("roll_rate", "precession_rate"):
            rows += _rows(dataset, axis)
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows
    )


def _rows(dataset: xr.Dataset, axis: str) -> Iterator[list[str]]:
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


if __name__ == "__main__":
    try:
        main()
    except sweep.RequestError as error:
        print(f"scripts/atlas: {error}", file=sys.stderr)
        sys.exit(error.status)
    except typer.Exit as end:
        sys.exit(end.exit_code)
    except KeyboardInterrupt:
        print("scripts/atlas: interrupted; all written files are complete", file=sys.stderr)
        sys.exit(130)
