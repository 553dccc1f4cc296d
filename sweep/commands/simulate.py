"""The command that computes one motion in time: `simulate`."""

import math
import shlex
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sweep.commands.arguments import Camera, Fps, Output, Overwrite, Size, Speed
from sweep.commands.terminal import abandonable, reporting, say
from sweep.errors import RequestError, counted, shown

if TYPE_CHECKING:
    import xarray as xr

    from sweep.figures.disk.film_options import FilmOptions
    from sweep.motion.request import MotionRequest


def simulate(
    words: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[SPEC] NAME=VALUE",
            help="Optionally a preset, a .toml file, or a .py file with a system; then initial conditions, losses and "
            "settings, one number each.",
            show_default=False,
        ),
    ] = None,
    *,
    source: Annotated[
        Path | None,
        typer.Option(
            "--from",
            metavar="ATLAS.nc",
            help="Follow a cell of this atlas: the one nearest to the values given for its axes.",
        ),
    ] = None,
    output: Output,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="FIG", help="Also draw the motion: png, pdf or svg.")
    ] = None,
    animate: Annotated[
        Path | None, typer.Option("--animate", metavar="FILM", help="Also film the motion: mp4 or gif.")
    ] = None,
    speed: Speed = None,
    fps: Fps = None,
    size: Size = None,
    camera: Camera = None,
    overwrite: Overwrite = False,
) -> None:
    """Compute one motion in time: its path, invariants, losses and contact forces.

    eulerdisk simulate tilt_rate=0.01 roll_rate=2 duration=10s -o path.nc --plot path.png

    eulerdisk simulate toy tilt=80deg -o stop.nc --plot stop.png --animate stop.mp4

    eulerdisk simulate --from rolling.nc roll_rate=2.4 tilt=1deg -o path.nc

    eulerdisk simulate kapitza shake=80 -o path.nc --plot path.png

    A cell of an atlas is followed for three nutation periods, unless a duration is given; other words change its
    start, disk or settings.

    Rates can be given in units of sqrt(gravity/radius), as in scaled_roll_rate=0.5, and roll_rate as speed=15cm/s.
    """
    film = read_film(animate, speed=speed, fps=fps, size=size, camera=camera)
    request = _request(words or [], source)
    _check_outputs(output, plot, animate, overwrite, source)
    from sweep.files.netcdf import save
    from sweep.motion.sampling import check_filmed, end_of, peaks_of
    from sweep.motion.trajectory import simulate as compute

    if animate is not None:
        check_filmed(request.kind, f"Draw it: --plot {animate.stem}.png instead of --animate.")
    dataset = compute(request, command=shlex.join(["eulerdisk", *sys.argv[1:]]))
    if animate is not None and film is not None:
        save_film(dataset, animate, film)
    if plot is not None:
        from sweep.figures import plots

        plots.save(plots.motion_figure(dataset), plot)
    save(dataset, output, overwrite=overwrite)
    parts = [
        counted(dataset["elapsed_time"].size, "sample"),
        *(f"{name} {value}" for name, value in peaks_of(dataset)),
    ]
    say(f"{output}: {', '.join((*parts, end_of(dataset) or _not_yet(dataset)))}")
    _say_impossible(dataset)


def read_film(animate: Path | None, **given: object) -> "FilmOptions | None":
    """Read the options of a film; None if no film is asked for. Options without a film are refused."""
    options = [f"--{name} {shown(value)}" for name, value in given.items() if value is not None]
    if animate is None:
        if options:
            raise RequestError(
                f"Only a film has a speed, fps, a size and a camera; got {' '.join(options)} without --animate.",
                "Add --animate disk.gif.",
            )
        return None
    from sweep.figures.disk.film_options import FilmOptions

    return FilmOptions.read(animate, **given)


def save_film(dataset: "xr.Dataset", path: Path, film: "FilmOptions") -> None:
    """Write a film, and report its length and speed."""
    from sweep.figures.disk import animation

    with abandonable(path) as check, reporting(what="frames") as progress:

        def report_frame(done: int, count: int) -> None:
            check()
            progress(done, count)

        saved = animation.save(dataset, path, film, report_frame)
    say(f"{path}: {saved.words()}")


def _not_yet(dataset: "xr.Dataset") -> str:
    """Return the words for a motion without an ending, with a longer duration if its kind comes to an end."""
    from sweep.motion.sampling import kind_of
    from sweep.motion.tables import TIME

    kind = kind_of(dataset)
    length = float(dataset[TIME.name][-1])
    more = f"; add duration={10.0 * length:.3g}s to see its end" if kind.stops else ""
    return (
        f"{'still moving' if kind.largest_tilt else 'still running'} after {kind.time.spell(length, 6)}{more}"
    )


def _say_impossible(dataset: "xr.Dataset") -> None:
    """Report when the disk would slip or lift off: from then on, the file is not the motion of a real disk."""
    from sweep.motion.contact import rolling_limit
    from sweep.motion.sampling import kind_of

    kind = kind_of(dataset)
    if not kind.largest_tilt:
        return
    limit = rolling_limit(dataset)
    if limit.time < math.inf:
        say(f"rolling becomes impossible: the {kind.called} {limit.words(0.0, float(dataset['friction']))}")


def _request(words: Sequence[str], source: Path | None) -> "MotionRequest":
    """Return the request for a motion. For a cell of an atlas, report its values that differ from the words."""
    from sweep.motion.origin import is_preset
    from sweep.motion.request import MotionRequest
    from sweep.request.words import pairs

    preset = words[0] if words and is_preset(words[0]) else ""
    if source is None and not preset:
        return MotionRequest.from_words(words)
    if source is None:
        return _request_of_preset(preset, pairs(words[1:]))
    if preset:
        raise RequestError(
            f"A motion starts from a preset or from a cell of an atlas; got {preset} and --from {source}.",
            "Leave one of them out.",
        )
    from sweep.files.reading import opened

    with opened(source, indexed=False) as atlas:
        request, taken = _request_of_cell(atlas, pairs(words))
    if taken:
        say(f"{source}: the nearest cell is the one at {taken}")
    return request


def _request_of_preset(preset: str, given: Mapping[str, str]) -> "MotionRequest":
    """Return the request for the motion of a preset, and report the values of its start that were not given."""
    from sweep.model.disk.tables import WOBBLE
    from sweep.motion.origin import request_of_preset
    from sweep.request.spec import SweepSpec
    from sweep.request.spec_file import kept_mass
    from sweep.request.values import as_written

    request = request_of_preset(preset, given)
    if kept := kept_mass(preset, given):
        say(kept)
    model = request.kind.model
    if model.text:
        axes = [name for name in SweepSpec.read(preset).axes if name not in given]
        values = [f"{name}={as_written(getattr(request, name), model.parameters[name])}" for name in axes]
        if values:
            say(f"{preset}: values not given, taken from the system: {' '.join(values)}")
        return request
    if request.precession_rate == WOBBLE and "precession_rate" not in given:
        say(f"{preset}: the rates are the wobble's at this tilt, precession_rate={WOBBLE} roll_rate={WOBBLE}")
    return request


def _request_of_cell(atlas: "xr.Dataset", given: Mapping[str, str]) -> tuple["MotionRequest", str]:
    """Return the request for the motion of the nearest cell, and its values that differ from those given."""
    from sweep.atlas.dataset import spec_of
    from sweep.atlas.parts import nearest_cell, other_values
    from sweep.motion.origin import cell_and_changes, request_of_cell

    spec = spec_of(atlas)
    cell, changes = cell_and_changes(spec, given)
    place = nearest_cell(spec, cell)
    return request_of_cell(atlas, place, changes), other_values(spec, place, cell)


def command_of_motion(atlas: "xr.Dataset", path: Path, words: Sequence[str]) -> str:
    """Return the command line that follows a cell of an atlas; empty if the cell has no motion."""
    from sweep.request.words import pairs

    try:
        _request_of_cell(atlas, pairs(words))
    except RequestError:
        return ""
    return shlex.join(["eulerdisk", "simulate", "--from", str(path), *words, "-o", "path.nc"])


def _check_outputs(
    output: Path, plot: Path | None, animate: Path | None, overwrite: bool, source: Path | None
) -> None:
    """Refuse, before anything is computed, an output that cannot be written or is the atlas that is read."""
    from sweep.files.paths import check_apart, check_target

    if output.suffix.lower() != ".nc":
        raise RequestError(
            "A motion is written to a netCDF file, .nc (--plot writes .png, .pdf, .svg; --animate writes .mp4, .gif); "
            f"got -o {output}.",
            f"Write -o {output.stem or 'path'}.nc.",
        )
    if plot is not None:
        from sweep.files.paths import check_format

        check_format(plot)
    for path in (output, plot, animate):
        if path is not None:
            check_target(path, overwrite)
            check_apart(path, *([] if source is None else [source]))
