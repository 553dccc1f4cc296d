"""Compute the rolling, spinning and circling atlases, verify every cell, draw them and print the critical rates."""

import argparse
import sys
from pathlib import Path

import typer
from critical_rates import critical_table
from plot_regimes import save_regimes

import sweep
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
            # the folder is this script's own: what an earlier run left there is replaced
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
    """Make the output folder if it is not there.

    Raises
    ------
    RequestError
        If it cannot be made, or is a file.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise sweep.RequestError(
            f"The output must be a folder, or a folder that can be made; {problem.strerror or problem}.",
            hint="Give another name, as in: scripts/atlas -o atlas-out.",
            where=str(folder),
        ) from problem


if __name__ == "__main__":
    try:
        main()
    except sweep.RequestError as error:
        print(f"scripts/atlas: {error}", file=sys.stderr)
        sys.exit(error.status)
    except typer.Exit as end:
        sys.exit(end.exit_code)
    except KeyboardInterrupt:
        print("scripts/atlas: interrupted; the files that were written are whole", file=sys.stderr)
        sys.exit(130)
