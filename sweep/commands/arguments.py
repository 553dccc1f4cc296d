"""Arguments that several commands share."""

from pathlib import Path
from typing import Annotated

import typer

from sweep.errors import RequestError

Words = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="[NAME=VALUE]...",
        help="Changes to the spec: a number, a list a,b,c or a range start:stop:count[:log], with units if you like.",
        show_default=False,
    ),
]
Spec = Annotated[
    str, typer.Argument(metavar="SPEC", help="A preset (rolling, spinning, circling) or a .toml file.")
]
OptionalSpec = Annotated[
    str | None,
    typer.Argument(
        metavar="SPEC",
        help="A preset (rolling, spinning, circling) or a .toml file; none with --from.",
        show_default=False,
    ),
]
AtlasFile = Annotated[Path, typer.Argument(metavar="ATLAS.nc", help="A file made by eulerdisk run.")]
Criterion = Annotated[
    str | None, typer.Option(help="Take the verdicts of another criterion, e.g. departure:2deg.")
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace OUT.nc if it exists.")]
Threads = Annotated[int | None, typer.Option(help="Threads; all that may be used, if not given.")]
BlockCells = Annotated[
    int | None,
    typer.Option(help="Cells per block, the most that a crash costs; about a second of work, if not given."),
]


def _percent(most: float) -> float:
    if not 0.0 <= most <= 100.0:
        raise RequestError(
            "not a share of the cells",
            "0 <= --max-failed <= 100",
            f"{most:g}",
            "--max-failed 5",
            "--max-failed",
        )
    return most


MaxFailed = Annotated[
    float,
    typer.Option(
        metavar="PERCENT",
        help="More unresolved or invalid cells than this end with status 1.",
        callback=_percent,
    ),
]
