"""Look at finished atlases: `info`, `boundary`, `plot`."""

import sys
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated

import typer

from sweep.commands.arguments import AtlasFile, Criterion
from sweep.errors import RequestError


def info(
    atlas: AtlasFile,
    *,
    partial: Annotated[
        Path | None,
        typer.Option(metavar="PART.nc", help="Write what there is of an unfinished run as an atlas."),
    ] = None,
) -> None:
    """Say in words what is in an atlas, or how far a run is that is not finished."""
    from sweep.commands.report import describe
    from sweep.files.reading import opened
    from sweep.runs.partial import describe as describe_run
    from sweep.runs.partial import unfinished, write_partial

    folder = unfinished(atlas)
    if folder is None and partial is not None:
        raise RequestError(
            "no unfinished run",
            f"--partial needs the blocks of a run, in {atlas}.run",
            str(atlas),
            "leave --partial out, or give the file that a run is to make",
            "--partial",
        )
    if folder is not None and partial is not None:
        done, cells = write_partial(folder, partial)
        print(f"eulerdisk: {partial}: {done} of {cells} cells computed", file=sys.stderr)
    elif folder is not None:
        print(describe_run(folder))
    if folder is None or atlas.is_file():
        with opened(atlas) as dataset:
            print(describe(dataset))


def boundary(
    atlas: AtlasFile,
    criterion: Criterion = None,
    refine: Annotated[
        float | None,
        typer.Option(
            metavar="WIDTH", help="Bisect it to this width, in the SI unit of each axis, e.g. 1e-9."
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", metavar="OUT.nc", help="Write the atlas with this boundary to a new file."
        ),
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace OUT.nc if it exists.")] = False,
) -> None:
    """Print the measured boundary beside the lines of theory, as a table."""
    from sweep.atlas import verdicts
    from sweep.commands.report import boundary_table
    from sweep.files.netcdf import save
    from sweep.files.paths import check_target
    from sweep.files.reading import opened

    with opened(atlas) as dataset:
        if output is not None:
            check_target(output, overwrite)
        found = dataset if criterion is None else verdicts.reclassify(dataset, criterion)
        if refine is not None:
            found = verdicts.refine(found, refine)
        if output is not None:
            save(found, output, overwrite=overwrite)
        print(boundary_table(found))


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
    from sweep.files.paths import check_atlas, check_format

    check_format(output)
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
    for atlas in atlases:
        check_atlas(atlas)
    from sweep.atlas.verdicts import reclassify
    from sweep.figures import plots, regimemap
    from sweep.files.reading import opened

    with ExitStack() as stack:
        datasets = [stack.enter_context(opened(path)) for path in atlases]
        if criterion is not None:
            datasets = [reclassify(dataset, criterion) for dataset in datasets]
        plots.save(regimemap.figure(datasets) if regimes else plots.figure(datasets, friction), output)
