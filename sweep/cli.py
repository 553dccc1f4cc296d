"""The command `eulerdisk`: the only place that prints and sets exit codes.

Results go to standard output, progress and messages to standard error. Exit status: 0 done; 2 the request was wrong and
nothing was touched; 130 or 143 interrupted. Everything heavy is imported inside the commands: a wrong word is
refused before numba or xarray is loaded.
"""

import shlex
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Annotated, NoReturn

import typer

from sweep.errors import RequestError

app = typer.Typer(
    name="eulerdisk",
    help="Stability atlases of a disk rolling without slip: how fast must it roll or spin to stay up?",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)

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
AtlasFile = Annotated[Path, typer.Argument(metavar="ATLAS.nc", help="A file made by eulerdisk run.")]


class _Stopped(BaseException):
    """A signal asked the run to end."""


@app.callback(invoke_without_command=True)
def _options(
    version: Annotated[bool, typer.Option("--version", help="Print the version and exit.")] = False,
) -> None:
    if version:
        import sweep

        print(f"eulerdisk {sweep.__version__}")
        raise typer.Exit


@app.command()
def run(
    spec: Spec,
    words: Words = None,
    *,
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="OUT.nc", help="The netCDF file to write.")
    ],
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace OUT.nc if it exists.")] = False,
    threads: Annotated[int | None, typer.Option(help="Threads; all that may be used, if not given.")] = None,
) -> None:
    """Compute an atlas and write it to one netCDF file.

    eulerdisk run rolling roll_rate=0.5:6:400 tilt=0.01deg:20deg:300:log -o rolling.nc
    """
    from sweep.spec import SweepSpec

    request = SweepSpec.from_words(spec, words or [])
    from sweep.progress import reporting
    from sweep.store import run_to_file

    command = shlex.join(["eulerdisk", *sys.argv[1:]])
    with _stoppable(output) as check, reporting() as progress:

        def after_block(done: int, size: int) -> None:
            check()
            progress(done, size)

        run_to_file(
            request, output, overwrite=overwrite, threads=threads, command=command, progress=after_block
        )
    print(f"eulerdisk: {output}: {request.size} cells", file=sys.stderr)


@app.command()
def plot(
    atlases: Annotated[list[Path], typer.Argument(metavar="ATLAS.nc...", help="One panel each.")],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FIG", help="png, pdf or svg.")],
    criterion: Annotated[
        str | None, typer.Option(help="Draw the verdicts of another criterion, e.g. departure:2deg.")
    ] = None,
) -> None:
    """Draw stability maps: measured boundary, analytic line, and what the criterion predicts."""
    from sweep import plots
    from sweep.store import open_atlas
    from sweep.verdicts import reclassify

    plots.check_format(output)
    datasets = [open_atlas(path) for path in atlases]
    if criterion is not None:
        datasets = [reclassify(dataset, criterion) for dataset in datasets]
    plots.save(plots.figure(datasets), output)


@app.command()
def info(atlas: AtlasFile) -> None:
    """Say in words what is in an atlas."""
    from sweep.report import describe
    from sweep.store import open_atlas

    with open_atlas(atlas) as dataset:
        print(describe(dataset))


@app.command()
def boundary(
    atlas: AtlasFile,
    criterion: Annotated[
        str | None, typer.Option(help="Use another criterion than the atlas was made with.")
    ] = None,
) -> None:
    """Print the measured boundary beside the lines of theory, as a table."""
    from sweep.report import boundary_table
    from sweep.store import open_atlas
    from sweep.verdicts import reclassify

    with open_atlas(atlas) as dataset:
        print(boundary_table(dataset if criterion is None else reclassify(dataset, criterion)))


def main() -> NoReturn:
    """Run the command line and exit."""
    try:
        app()
    except RequestError as error:
        print(f"eulerdisk: {error}", file=sys.stderr)
        sys.exit(2)
    except BrokenPipeError:
        # the reader of our output has gone, e.g. `| head`; nobody is left to tell
        sys.stderr.close()
        sys.exit(1)
    sys.exit(0)


@contextmanager
def _stoppable(output: Path) -> Iterator[Callable[[], None]]:
    """Turn Ctrl-C and SIGTERM into a message and an exit status.

    Gives what is to be called after each block: it ends the run if a signal has come. An exception out of a signal
    handler can get lost in a callback of the compiler, so that only a second signal raises one.
    """
    arrived: list[int] = []

    def check() -> None:
        if arrived:
            raise _Stopped

    def stop(number: int, _frame: FrameType | None) -> None:
        check()
        arrived.append(number)

    before = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield check
    except _Stopped:
        print(f"eulerdisk: interrupted; {output} was not written, nothing is left behind.", file=sys.stderr)
        raise typer.Exit(128 + arrived[0]) from None
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
