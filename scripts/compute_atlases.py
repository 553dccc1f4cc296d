"""Compute the rolling, spinning and circling atlases, verify every cell, draw them and print the critical rates."""

import argparse
import sys
from pathlib import Path

from plot_regimes import save_regimes

import sweep
from sweep.checks.audit import findings
from sweep.commands.progress import reporting
from sweep.commands.report import audit_line, critical_table
from sweep.figures import plots

PRESETS = ("rolling", "spinning", "circling")


def main() -> None:
    """Write NAME.nc for every preset, boundaries.png and regimes.png into the output folder."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--output", "-o", type=Path, default=Path("atlas-out"), help="folder (default: atlas-out)"
    )
    folder = parser.parse_args().output
    folder.mkdir(parents=True, exist_ok=True)
    for name in PRESETS:
        with reporting() as progress:
            # the folder is this script's own: what an earlier run left there is replaced
            sweep.run_to_file(
                sweep.SweepSpec.preset(name),
                folder / f"{name}.nc",
                overwrite=True,
                command="scripts/atlas",
                progress=progress,
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


if __name__ == "__main__":
    try:
        main()
    except sweep.RequestError as error:
        sys.exit(f"scripts/atlas: {error}")
