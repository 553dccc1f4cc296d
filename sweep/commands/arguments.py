"""Arguments shared by several commands, and the spec they describe."""

import contextlib
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sweep.commands.terminal import say
from sweep.errors import RequestError, shown
from sweep.notices import listen

if TYPE_CHECKING:
    from sweep.request.spec import SweepSpec


def _percentage(value: float) -> float:
    # typer's min and max would accept nan
    if not 0.0 <= value <= 100.0:
        raise typer.BadParameter(f"must be a percentage from 0 to 100; got {value:g}. Write --max-failed 5.")
    return value


def _mute_notices(quiet: bool) -> bool:
    if quiet:
        listen(None)
    return quiet


def whole_number(text: str) -> int:
    """Parse a whole number written in ASCII digits; `int` would accept the digits of every script."""
    if re.fullmatch(r"[+-]?[0-9]{1,18}", str(text)):
        return int(text)
    raise typer.BadParameter(f"{shown(text)!r} is not a valid integer.")


def seed_number(text: str) -> int:
    """Parse a seed, a whole number of 0 or more."""
    seed = whole_number(text)
    if seed < 0:
        raise typer.BadParameter(f"a seed must be 0 or more; got {seed}.")
    return seed


def number(text: str) -> float:
    """Parse a number written in ASCII digits, ``nan`` and ``inf`` included; `float` would accept every script."""
    with contextlib.suppress(ValueError):
        if str(text).isascii() and "_" not in str(text):
            return float(text)
    raise typer.BadParameter(f"{shown(text)!r} is not a valid float.")


def width(text: str) -> float:
    """Parse the width of a bracket: a number without a unit, since it applies to axes of different units."""
    try:
        return number(text)
    except typer.BadParameter:
        # a number with a unit: digits, then a letter other than the exponent's
        if not re.match(r"[+-]?\.?[0-9].*[^\W\d_eE]", str(text)):
            raise
    raise typer.BadParameter(
        f"a width is a number without a unit, in the SI unit of each axis (rad, rad/s, m); got {shown(text)!r}. "
        "Write --refine 1e-6."
    )


def integer(text: str, *names: str) -> Any:
    """Return a typer option for a whole number, with its help text."""
    return typer.Option(*names, parser=whole_number, metavar="INTEGER", help=text)


def real(text: str, *names: str) -> Any:
    """Return a typer option for a number, with its help text."""
    return typer.Option(*names, parser=number, metavar="FLOAT", help=text)


Words = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="NAME=VALUE",
        help="Changes to the spec: a number, a list a,b,c or a range start:stop:count[:log]; units are optional. "
        "With samples=COUNT also a distribution: uniform:LOW:HIGH, loguniform:LOW:HIGH or normal:MEAN:DEVIATION.",
        show_default=False,
    ),
]
Starts = Annotated[
    Path | None,
    typer.Option(
        metavar="TABLE.csv",
        help="Compute the starts in this table, one per row; its columns are parameters, headed like tilt [deg].",
    ),
]
Spec = Annotated[
    str,
    typer.Argument(
        metavar="SPEC",
        help="A preset (rolling, spinning, circling; toy, coin with losses; torus, egg, thick_coin, true_edge; "
        "henon_heiles, kapitza and other systems), or a .toml or .py file.",
    ),
]
OptionalSpec = Annotated[
    str | None,
    typer.Argument(
        metavar="SPEC",
        help="A preset (rolling, spinning, circling; toy, coin with losses; torus, egg, thick_coin, true_edge; "
        "henon_heiles, kapitza and other systems), or a .toml or .py file; omit it with --from.",
        show_default=False,
    ),
]
AtlasFile = Annotated[Path, typer.Argument(metavar="ATLAS.nc", help="An atlas written by eulerdisk run.")]
Output = Annotated[Path, typer.Option("--output", "-o", metavar="OUT.nc", help="The netCDF file to write.")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace output files that already exist.")]
Criterion = Annotated[
    str | None,
    typer.Option(
        help="Use another stability criterion, e.g. departure:2deg or 'peak_tilt > 10deg or fall_time < 2s'."
    ),
]
Threads = Annotated[int | None, integer("Number of threads; default: all available.")]
Quiet = Annotated[
    bool,
    typer.Option("--quiet", "-q", callback=_mute_notices, help="Report only problems."),
]
BlockCells = Annotated[
    int | None,
    integer("Cells per block; a crash loses at most the current block. Default: about a second of work."),
]
MaxFailed = Annotated[
    float,
    typer.Option(
        parser=number,
        metavar="PERCENT",
        help="Exit with status 1 if more than this percentage of the cells is unresolved or invalid.",
        callback=_percentage,
    ),
]
Speed = Annotated[
    float | None,
    real("Speed of the film: 0.1 is ten times slower than the motion. Default: it plays for a few seconds."),
]
Fps = Annotated[int | None, integer("Frames per second of the film; default: 25.")]
Size = Annotated[
    str | None, typer.Option(metavar="WIDTHxHEIGHT", help="Size of the film in pixels; default: 640x480.")
]
Camera = Annotated[
    str | None,
    typer.Option(
        metavar="CAMERA",
        help="Camera of the film: fixed (shows the whole motion), follow (moves with the disk), top (from above).",
    ),
]


def with_starts(words: Sequence[str] | None, starts: Path | None) -> list[str]:
    """Return the words of a request, with the option ``--starts`` appended as a word."""
    return [*(words or []), *([f"starts={starts}"] if starts is not None else [])]


def read_request(spec: str | None, words: Sequence[str], source: Path | None) -> "SweepSpec":
    """Return the spec that the command line describes.

    Parameters
    ----------
    spec : str or None
        A preset or a file; with `source`, the first change, if any.
    words : sequence of str
        Changes, ``NAME=VALUE``.
    source : Path or None
        An atlas whose run is repeated.
    """
    from sweep.request.spec import SweepSpec
    from sweep.request.spec_file import kept_mass
    from sweep.request.words import changes_in, pairs

    if source is None:
        if spec is None:
            raise RequestError(
                "A run needs a SPEC, or --from with an atlas; got neither.",
                "Name a preset, as in: eulerdisk run rolling -o rolling.nc.",
            )
        request = SweepSpec.from_words(spec, words)
        if kept := kept_mass(spec, pairs(words)):
            say(kept)
        return request
    if spec is not None and "=" not in spec:
        raise RequestError(
            f"A run takes a SPEC or --from, not both; got {spec} and --from {source}.",
            "Leave one of them out.",
        )
    from sweep.atlas.dataset import spec_of
    from sweep.engine.compute import arithmetic_hash
    from sweep.files.reading import opened

    with opened(source) as dataset:
        made_from = spec_of(dataset)
        kernel_hash = dataset.attrs.get("kernel_hash")
    if kernel_hash != arithmetic_hash(made_from):
        say(
            f"{source} was computed with different kernels, so the last digits may differ; eulerdisk compare checks "
            "whether that matters"
        )
    all_words = [spec, *words] if spec else words
    changes = changes_in(all_words, made_from.model)
    return made_from.replace(**changes)
