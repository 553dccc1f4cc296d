"""Look at finished atlases: `info`, `boundary`, `plot`."""

from contextlib import ExitStack
from pathlib import Path
from typing import Annotated

import typer

from sweep.commands.arguments import AtlasFile, Criterion
from sweep.errors import RequestError


def info(atlas: AtlasFile) -> None:
    """Say in words what is in an atlas."""
    from sweep.report import describe
    from sweep.store import open_atlas

    with open_atlas(atlas) as dataset:
        print(describe(dataset))


def boundary(
    atlas: AtlasFile,
    criterion: Criterion = None,
) -> None:
    """Print the measured boundary beside the lines of theory, as a table."""
    from sweep.report import boundary_table
    from sweep.store import open_atlas
    from sweep.verdicts import reclassify

    with open_atlas(atlas) as dataset:
        print(boundary_table(dataset if criterion is None else reclassify(dataset, criterion)))


def plot(
    atlases: Annotated[list[Path], typer.Argument(metavar="ATLAS.nc...", help="One panel each.")],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FIG", help="png, pdf or svg.")],
    criterion: Criterion = None,
    friction: Annotated[
        float | None,
        typer.Option(help="Hatch where rolling without slip needs a larger friction coefficient."),
    ] = None,
    regimes: Annotated[
        bool,
        typer.Option(
            "--regimes", help="Draw instead how many wells the potential has, and who crosses upright."
        ),
    ] = False,
) -> None:
    """Draw stability maps: measured boundary, analytic line, and what the criterion predicts."""
    from sweep import plots, regimemap
    from sweep.store import open_atlas
    from sweep.verdicts import reclassify

    plots.check_format(output)
    if friction is not None and not friction > 0.0:
        raise RequestError(
            "not a friction coefficient", "friction > 0", f"{friction:g}", "give one, as in --friction 0.5"
        )
    if regimes and not (criterion is None and friction is None):
        raise RequestError(
            "regimes know neither a criterion nor friction",
            "--regimes draws what the motion is, whatever counts as unstable",
            "--regimes with --criterion or --friction",
            "leave the others out",
        )
    with ExitStack() as opened:
        datasets = [opened.enter_context(open_atlas(path)) for path in atlases]
        if criterion is not None:
            datasets = [reclassify(dataset, criterion) for dataset in datasets]
        plots.save(regimemap.figure(datasets) if regimes else plots.figure(datasets, friction), output)
