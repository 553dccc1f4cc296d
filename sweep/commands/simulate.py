"""Compute one motion in time: `simulate`."""

import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer

from sweep.commands.arguments import Output, Overwrite
from sweep.commands.terminal import abandonable, reporting, say
from sweep.errors import RequestError


def simulate(
    words: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="NAME=VALUE",
            help="Initial conditions and settings of the integration: one number each, with a unit if you like.",
            show_default=False,
        ),
    ] = None,
    *,
    output: Output,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="FIG", help="Also draw it: png, pdf or svg.")
    ] = None,
    animate: Annotated[
        Path | None, typer.Option("--animate", metavar="FILM", help="Also film it: mp4 or gif.")
    ] = None,
    overwrite: Overwrite = False,
) -> None:
    """Compute one motion: its path, invariants and contact forces in time.

    eulerdisk simulate tilt_rate=0.01 roll_rate=2 duration=10s -o path.nc --plot path.png
    """
    from sweep.motion.request import TrajectorySpec

    request = TrajectorySpec.from_words(words or [])
    _check_outputs(output, plot, animate, overwrite)
    from sweep.files.netcdf import save
    from sweep.motion.trajectory import simulate as compute

    dataset = compute(request, command=shlex.join(["eulerdisk", *sys.argv[1:]]))
    if animate is not None:
        from sweep.figures.disk import animation

        with abandonable(animate) as check, reporting(what="frames") as progress:

            def after_frame(done: int, count: int) -> None:
                check()
                progress(done, count)

            animation.save(dataset, animate, after_frame)
    if plot is not None:
        from sweep.figures import plots
        from sweep.figures.disk import motion_plots

        plots.save(motion_plots.figure(dataset), plot)
    save(dataset, output, overwrite=overwrite)
    fell = f", fell at {float(dataset['fall_time']):.6g} s" if dataset["fall_time"].notnull() else ""
    say(f"{output}: {dataset['tilt'].size} samples{fell}")


def _check_outputs(output: Path, plot: Path | None, animate: Path | None, overwrite: bool) -> None:
    """Refuse every file that could not be written, before anything is computed."""
    from sweep.files.paths import check_target

    if output.suffix.lower() != ".nc":
        raise RequestError(
            "A motion is written to a netCDF file, .nc (--plot writes .png, .pdf, .svg; --animate writes .mp4, .gif); "
            f"got -o {output}.",
            f"Write -o {output.stem or 'path'}.nc.",
        )
    if plot is not None:
        from sweep.files.paths import check_format

        check_format(plot)
    if animate is not None:
        from sweep.figures.disk.animation import check_format as check_film

        check_film(animate)
    for path in (output, plot, animate):
        if path is not None:
            check_target(path, overwrite)
