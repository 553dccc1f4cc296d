"""Explain one cell of an atlas: `explain`."""

from pathlib import Path
from typing import Annotated

import typer

from sweep.commands.arguments import AtlasFile

Cell = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="[NAME=VALUE]...", help="The cell: a value for each axis, e.g. tilt=1deg.", show_default=False
    ),
]


def explain(
    atlas: AtlasFile,
    cell: Cell = None,
    *,
    plot: Annotated[
        Path | None, typer.Option(metavar="FIG", help="Draw its motion too: png, pdf or svg.")
    ] = None,
) -> None:
    """Explain the nearest cell: its numbers, a new run of it, the exact values, theory, and why the verdict.

    eulerdisk explain rolling.nc roll_rate=2.4 tilt=1deg --plot cell.png

    Exit status 1 if the run cannot be repeated within the tolerances.
    """
    from sweep.request.words import split_words
    from sweep.schema import PARAMETERS

    given = split_words(cell or [], tuple(PARAMETERS))
    if plot is not None:
        from sweep.files.paths import check_format

        check_format(plot)
        from sweep.files.paths import check_target

        check_target(plot, True)
    from sweep.checks.explain import explain as explained
    from sweep.files.reading import opened

    with opened(atlas) as dataset:
        explanation = explained(dataset, given)
    print(explanation.text)
    if plot is not None:
        from sweep.figures import cellplot, plots

        plots.save(cellplot.figure(explanation), plot)
    if not explanation.repeated:
        raise typer.Exit(1)
