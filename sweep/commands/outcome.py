"""What is said at the end of a run, and its exit status."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from sweep.request.spec import SweepSpec
    from sweep.runs.failures import Failures


def conclude(failures: "Failures", spec: "SweepSpec", output: Path, most: float) -> None:
    """Say what was written, and which cells failed; end with 1 if more than `most` per cent of them did."""
    print(f"eulerdisk: {output}: {spec.size} cell{'s' * (spec.size != 1)}", file=sys.stderr)
    if failures.total:
        for line in failures.describe(spec):
            print(f"eulerdisk: {line}", file=sys.stderr)
    if 100.0 * failures.total > most * spec.size:
        print(
            f"eulerdisk: more than --max-failed {most:g} % failed; the file is whole, these cells are marked in it",
            file=sys.stderr,
        )
        raise typer.Exit(1)
