"""Look at finished atlases: `info`, `boundary`, `plot`."""

from contextlib import ExitStack
from pathlib import Path
from typing import Annotated

import typer

from sweep.commands.arguments import AtlasFile, Criterion


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
) -> None:
    """Draw stability maps: measured boundary, analytic line, and what the criterion predicts."""
    from sweep.filenames import check_atlas, check_format

    check_format(output)
    for atlas in atlases:
        check_atlas(atlas)
    from sweep import plots
    from sweep.store import open_atlas
    from sweep.verdicts import reclassify

    with ExitStack() as opened:
        datasets = [opened.enter_context(open_atlas(path)) for path in atlases]
        if criterion is not None:
            datasets = [reclassify(dataset, criterion) for dataset in datasets]
        plots.save(plots.figure(datasets), output)
