"""The commands that show finished atlases: `info`, `boundary`, `plot` and `export`."""

from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sweep.commands.arguments import (
    AtlasFile,
    Camera,
    Criterion,
    Fps,
    Overwrite,
    Size,
    Speed,
    integer,
    number,
    real,
    width,
)
from sweep.commands.part import PART_HELP, Part, files_and_words, opened_part
from sweep.commands.terminal import say, show
from sweep.errors import RequestError, counted, shown

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from sweep.figures.look import Look

#: Formats in which `boundary` prints for programs.
_TABLES = ("csv", "json")


def info(
    atlas: AtlasFile,
    *,
    partial: Annotated[
        Path | None,
        typer.Option(metavar="PART.nc", help="Write the finished blocks of an unfinished run as an atlas."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON in SI units instead of text.")] = False,
) -> None:
    """Describe an atlas, or the progress of an unfinished run."""
    from sweep.runs.folder import unfinished

    folder = unfinished(atlas)
    if folder is not None and as_json:
        raise RequestError(
            "--json describes finished atlases; this run is not finished.",
            f"Finish it, or leave --json out: eulerdisk info {atlas}.",
            str(atlas),
        )
    if folder is None and partial is not None:
        raise RequestError(
            f"--partial writes the finished blocks of a run in {atlas}.run; there is no unfinished run.",
            "Leave --partial out, or give the output file of an unfinished run.",
            str(atlas),
        )
    if folder is not None:
        _show_run(folder, partial)
    if folder is None or atlas.is_file():
        from sweep.files.reading import MotionGivenError

        try:
            _show_atlas(atlas, as_json)
        except MotionGivenError:
            if as_json:
                raise
            from sweep.commands.report import describe_motion

            show(describe_motion(atlas))


def _show_atlas(atlas: Path, as_json: bool) -> None:
    """Describe an atlas, as text or as JSON."""
    from sweep.commands.report import describe
    from sweep.files.reading import opened

    with opened(atlas, indexed=False) as file:
        if as_json:
            from sweep.commands.summary import as_json as to_json
            from sweep.commands.summary import summary

            show(to_json(summary(file)))
            return
        show(describe(file))
        _warn(file)


def _show_run(folder: Path, partial: Path | None) -> None:
    """Describe the progress of an unfinished run, or write its finished blocks as an atlas."""
    from sweep.runs.partial import describe, write_partial

    if partial is not None:
        from sweep.files.paths import check_atlas_name

        check_atlas_name(partial)
        done, cells = write_partial(folder, partial)
        say(f"{partial}: {counted(done, 'cell', cells)} computed")
    else:
        show(describe(folder))


def _warn(file: "xr.Dataset") -> None:
    """Warn if the range of a control misses the predicted boundary."""
    from sweep.atlas.dataset import spec_of
    from sweep.atlas.outlook import one_sided

    for warning in one_sided(spec_of(file), file):
        say(f"warning: {warning}")


def boundary(
    atlas: AtlasFile,
    words: Part = None,
    criterion: Criterion = None,
    refine: Annotated[
        float | None,
        typer.Option(
            parser=width,
            metavar="WIDTH",
            help="Bisect the boundary to this width, in the SI unit of each axis, e.g. 1e-9.",
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="OUT",
            help="Write the atlas with this boundary to a new .nc file. With --to, write the table instead.",
        ),
    ] = None,
    overwrite: Overwrite = False,
    kind: Annotated[
        str | None,
        typer.Option(
            "--to", metavar="FORMAT", help="Print it as csv or json in SI units, or write it with -o."
        ),
    ] = None,
) -> None:
    """Print a table of the measured boundary next to the theoretical lines.

    NAME=VALUE restricts it to a part of the atlas.

    eulerdisk boundary three-axes.nc alpha=0.5 tilt=1deg:3deg

    eulerdisk boundary rolling.nc --to csv -o boundary.csv
    """
    if kind not in (None, *_TABLES):
        raise RequestError(
            f"A boundary is printed as {' or '.join(_TABLES)}; got {shown(kind)}.",
            "Write --to csv, or leave it out.",
            "--to",
        )
    from sweep.files.paths import check_apart, check_atlas, check_target
    from sweep.files.reading import opened

    if output is not None:
        _check_output(output, kind)
        check_atlas(atlas)
        check_target(output, overwrite)
        check_apart(output, atlas)
    if criterion is None and refine is None and output is None and not words:
        with opened(atlas, indexed=False) as file:
            show(_boundary_text(file, kind))
        return
    from sweep.atlas.reclassify import reclassify
    from sweep.atlas.reclassify import refine as refined
    from sweep.files.netcdf import save
    from sweep.files.publish import published
    from sweep.request.words import pairs

    with opened_part(atlas, words) as dataset:
        part = dataset if criterion is None else reclassify(dataset, criterion)
        if refine is not None:
            part = refined(part, refine)
        text = _boundary_text(part, kind, pairs(words or []))
        if output is not None and kind is not None:
            with published(output) as unfinished:
                unfinished.write_text(f"{text}\n", encoding="utf-8")
            return
        if output is not None:
            save(part, output, overwrite=overwrite)
        show(text)


def _check_output(output: Path, kind: str | None) -> None:
    """Refuse an output name of `boundary` whose ending does not fit the format."""
    from sweep.files.paths import FIGURE_FORMATS, check_atlas_name, check_table_name

    if kind is not None:
        check_table_name(output, kind)
        return
    ending = output.suffix.lower().removeprefix(".")
    table = ending if ending in _TABLES else "csv"
    hint = f"Write -o {output.stem}.nc; for the table, --to {table} -o {output.stem}.{table}."
    check_atlas_name(output, "" if ending in FIGURE_FORMATS else hint)


def _boundary_text(atlas: "xr.Dataset", kind: str | None, asked: Iterable[str] = ()) -> str:
    """Return the boundary as a table to read, in the words `asked` for, or in a format for programs."""
    if kind is None:
        from sweep.commands.report import boundary_table

        return boundary_table(atlas, asked)
    if kind == "json":
        from sweep.commands.summary import as_json
        from sweep.commands.summary import boundary as plain

        return as_json(plain(atlas))
    from sweep.atlas.boundary_rows import as_csv, boundary_rows, curve_rows

    return as_csv(boundary_rows(atlas) or curve_rows(atlas)).rstrip("\n")


def plot(
    atlases: Annotated[
        list[str],
        typer.Argument(
            metavar="ATLAS.nc [NAME=VALUE]",
            help=f"Atlases, one panel each; or the file of one motion. {PART_HELP}",
        ),
    ],
    output: Annotated[
        Path,
        typer.Option(
            "--output",
            "-o",
            metavar="FIG",
            help="The figure: png, pdf or svg; for a motion also a film, gif or mp4. An existing file is replaced.",
        ),
    ],
    criterion: Criterion = None,
    friction: Annotated[
        float | None, real("Hatch the cells that need a larger friction coefficient to roll without slip.")
    ] = None,
    regimes: Annotated[
        bool,
        typer.Option(
            "--regimes",
            help="Draw instead the number of wells of the potential, and which motions cross the upright position.",
        ),
    ] = False,
    losses: Annotated[
        bool,
        typer.Option(
            "--losses",
            help="Draw instead how long a disk with losses stays aloft, and which law took most of its energy.",
        ),
    ] = False,
    rate: Annotated[
        str | None,
        typer.Option(
            metavar="WORD",
            help="Scale of rate axes: linear, squared, scaled (units of sqrt(g/R)) or speed (rate times radius).",
        ),
    ] = None,
    quantity: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Draw this variable instead of the peak, e.g. fall_time."),
    ] = None,
    contours: Annotated[
        str | None,
        typer.Option(
            metavar="LEVELS", help="Draw contours of the quantity at these values, e.g. 5deg,20deg, or auto."
        ),
    ] = None,
    family: Annotated[
        bool,
        typer.Option("--family", help="Draw an atlas of more than two axes as a family of boundary curves."),
    ] = False,
    bare: Annotated[
        bool,
        typer.Option(
            "--bare", help="Draw no title and no caption, and a short legend; print the text instead."
        ),
    ] = False,
    without: Annotated[
        str | None,
        typer.Option(
            metavar="PARTS", help="Leave out any of title, caption, legend, strip and bar, e.g. strip,bar."
        ),
    ] = None,
    width: Annotated[
        str | None, typer.Option(metavar="LENGTH", help="Width of the figure, e.g. 86mm.")
    ] = None,
    height: Annotated[
        str | None, typer.Option(metavar="LENGTH", help="Height of the figure, e.g. 70mm.")
    ] = None,
    font_size: Annotated[
        float | None, typer.Option(parser=number, metavar="POINTS", help="Font size; default: 8.")
    ] = None,
    dpi: Annotated[int | None, integer("Dots per inch; default: 200.")] = None,
    speed: Speed = None,
    fps: Fps = None,
    size: Size = None,
    camera: Camera = None,
) -> None:
    """Draw stability maps: the measured boundary, the analytic line, and the boundary that the criterion predicts.

    An atlas of more than two axes becomes one map for each value of the other axes. To draw only a part of it:
    eulerdisk plot three-axes.nc alpha=0.5 -o slice.png

    The file of a motion is drawn as by simulate --plot, or filmed as by simulate --animate:
    eulerdisk plot path.nc -o path.png; eulerdisk plot path.nc -o path.gif --speed 0.1
    """
    from sweep.commands.saved_motion import FILMS, plot_motion
    from sweep.files.paths import check_atlas, check_format
    from sweep.files.reading import holds_motion

    film = {"speed": speed, "fps": fps, "size": size, "camera": camera}
    is_film = output.suffix.lower() in FILMS
    if not is_film:
        check_format(output)
    paths, words = files_and_words(atlases)
    if any(holds_motion(path) for path in paths):
        of_atlases = {
            "--criterion": criterion, "--friction": friction, "--regimes": regimes, "--losses": losses,
            "--rate": rate, "--quantity": quantity, "--contours": contours, "--family": family, "--bare": bare,
            "--without": without, "--width": width, "--height": height, "--font-size": font_size,
        }  # fmt: skip
        plot_motion(paths, words, output, dpi=dpi, film_options=film, others=of_atlases)
        return
    if is_film or any(value is not None for value in film.values()):
        _refuse_film(output, film, paths)
    from sweep.figures.look import Look, check_friction

    check_friction(friction)
    others = {
        "--criterion": criterion, "--friction": friction, "--quantity": quantity, "--contours": contours,
        "--family": family or None,
    }  # fmt: skip
    clashing = [name for name, value in others.items() if value is not None]
    draw = "regimes" if regimes else "losses" if losses else ""
    clashing += ["--losses"] if regimes and losses else []
    if draw and clashing:
        content = "kinds of motion" if regimes else "times and losses"
        raise RequestError(
            f"--{draw} draws {content}, which do not depend on a criterion or on friction, and no other quantity; "
            f"got --{draw} with {' and '.join(clashing)}.",
            f"Leave {' and '.join(clashing)} out.",
        )
    look = Look.read(
        rate=rate, quantity=quantity, contours=contours, width=width, height=height, font_size=font_size, dpi=dpi,
        family=family, bare=bare, without=without,
    )  # fmt: skip
    for atlas in paths:
        check_atlas(atlas)
    from sweep.figures import plots
    from sweep.files.reading import opened

    with ExitStack() as stack:
        if criterion is None and friction is None and not draw and not words:
            drawn = plots.figure(
                [stack.enter_context(opened(path, indexed=False)) for path in paths], look=look
            )
            _save(drawn, output, look)
            return
        datasets = [stack.enter_context(opened_part(path, words)) for path in paths]
        if criterion is not None:
            from sweep.atlas.reclassify import reclassify

            datasets = [reclassify(dataset, criterion) for dataset in datasets]
        drawn = getattr(plots, draw)(datasets, look) if draw else plots.figure(datasets, friction, look)
        _save(drawn, output, look)


def _refuse_film(output: Path, film: Mapping[str, object], paths: Sequence[Path]) -> None:
    """Refuse a film of an atlas, and its options."""
    options = " ".join(f"--{name} {shown(value)}" for name, value in film.items() if value is not None)
    stem = output.stem or "motion"
    words = " ".join([f"-o {output}", *([options] if options else [])])
    without = f" without {options}" if options else ""
    raise RequestError(
        f"A film shows one motion, and {paths[0]} contains no motion; got {words}.",
        f"Write -o {stem}.png{without}. To film the motion of a cell: eulerdisk simulate --from {paths[0]}.",
    )


def _save(drawn: "Figure", output: Path, look: "Look") -> None:
    """Write a figure, and print its text if the figure leaves out the title, caption or legend."""
    from sweep.figures import plots

    plots.save(drawn, output, look.dpi)
    if look.without & {"title", "caption", "legend"}:
        show(str(drawn.get_label()))


def export(
    atlas: AtlasFile,
    words: Part = None,
    *,
    kind: Annotated[str, typer.Option("--to", metavar="FORMAT", help="csv, parquet or zarr.")],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="OUT", help="The file to write; default: next to the atlas."),
    ] = None,
    overwrite: Overwrite = False,
) -> None:
    """Export an atlas in SI units as a table of its cells (csv, parquet) or as zarr, and list the files written.

    A motion is exported as a table of its samples.

    With csv, the boundary goes to OUT.boundary.csv, if the atlas has one: a line for each row of the grid, or for each
    point of its curves. To export only the boundary: eulerdisk boundary ATLAS.nc --to csv -o OUT.csv.
    """
    from sweep.commands.saved_motion import export_motion
    from sweep.files.export import boundary_file
    from sweep.files.export import export as exported
    from sweep.files.paths import check_apart
    from sweep.files.reading import holds_motion

    target = output or atlas.with_suffix(f".{kind}")
    if holds_motion(atlas):
        export_motion(atlas, words, target, kind, overwrite)
        return
    with opened_part(atlas, words) as dataset:
        check_apart(target, atlas)
        check_apart(boundary_file(target), atlas)
        cells, *boundary_files = exported(dataset, target, kind, overwrite=overwrite)
        size = dataset["ending"].size
    say(f"{cells}: {counted(size, 'cell')}")
    for path in boundary_files:
        say(f"{path}: the boundary")
