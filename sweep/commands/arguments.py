"""Arguments that several commands share."""

from pathlib import Path
from typing import Annotated

import typer

Words = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="[NAME=VALUE]...",
        help="Changes to the spec: a number, a list a,b,c or a range start:stop:count[:log], with units if you like.",
        show_default=False,
    ),
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
