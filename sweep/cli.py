"""The command `eulerdisk`: the list of its commands, and its exit statuses.

Results go to standard output, progress and messages to standard error. Exit status: 0 done; 1 a check failed, or too
many cells could not be computed; 2 the request was wrong and nothing was touched; 3 the file system refused a file;
130 or 143 interrupted. After 3, 130 and 143 the finished blocks are kept, and the same command continues. Heavy imports
are inside the commands, so that a wrong word is refused before numba or xarray is loaded.
"""

import sys
from typing import Annotated

import typer

from sweep.commands import check, inspect, run, simulate
from sweep.errors import RequestError
from sweep.foreign_settings import ignore_matplotlibrc
from sweep.platforms import check_system
from sweep.version import __version__

app = typer.Typer(
    name="eulerdisk",
    help="Stability atlases of a disk rolling without slip: how fast must it roll or spin to stay up?",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)

_COMMANDS = (
    run.run,
    run.plan,
    inspect.plot,
    inspect.info,
    inspect.boundary,
    check.verify,
    check.compare,
    check.explain,
    simulate.simulate,
    inspect.export,
    run.prepare,
    run.block,
    run.assemble,
    run.warmup,
)

for _command in _COMMANDS:
    app.command()(_command)


@app.callback(invoke_without_command=True)
def _options(
    version: Annotated[bool, typer.Option("--version", help="Print the version and exit.")] = False,
) -> None:
    if version:
        print(f"eulerdisk {__version__}")
        raise typer.Exit


def main() -> None:
    """Run the command line and exit.

    The parser ends with 2 if a command, option or argument is wrong, with 130 on Ctrl-C where nothing is kept, and
    with 1 if the reader of the output has gone, as in ``eulerdisk boundary a.nc | head``.
    """
    try:
        check_system()
        ignore_matplotlibrc()
        app(prog_name="eulerdisk")
    except RequestError as error:
        print(f"eulerdisk: {error}", file=sys.stderr)
        sys.exit(error.status)
