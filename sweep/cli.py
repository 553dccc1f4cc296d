"""The command `eulerdisk`: what its commands are, and how a run of it ends.

Results go to standard output, progress and messages to standard error. Exit status: 0 done; 1 a check failed, or too
many cells could not be computed; 2 the request was wrong and nothing was touched; 3 the file system took no more;
130 or 143 interrupted. After 3, 130 and 143 what is computed is kept, and the same command goes on. Everything heavy is
imported inside the commands: a wrong word is refused before numba or xarray is loaded.
"""

import sys
from typing import Annotated, NoReturn

import typer

from sweep.commands import check, compute, convert, look, motion, parts, planning, verify, warm
from sweep.commands.explain import explain
from sweep.commands.usage import Commands, UsageError, refuse
from sweep.errors import RequestError
from sweep.version import __version__

app = typer.Typer(
    name="eulerdisk",
    cls=Commands,
    help="Stability atlases of a disk rolling without slip: how fast must it roll or spin to stay up?",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)

_COMMANDS = (
    compute.run,
    planning.plan,
    look.plot,
    look.info,
    look.boundary,
    verify.verify,
    check.compare,
    explain,
    motion.simulate,
    convert.export,
    parts.prepare,
    parts.block,
    parts.assemble,
    warm.warmup,
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


def main() -> NoReturn:
    """Run the command line and exit."""
    try:
        try:
            # not standalone: the parser would print its errors in words of its own
            status = app(standalone_mode=False, prog_name="eulerdisk")
        except UsageError as error:
            refuse(error)
    except RequestError as error:
        print(f"eulerdisk: {error}", file=sys.stderr)
        sys.exit(error.status)
    except BrokenPipeError:
        # the reader of our output has gone, e.g. `| head`; nobody is left to tell
        sys.stderr.close()
        sys.exit(1)
    except typer.Abort:
        # Ctrl-C where nothing is kept; some versions of typer return 130 for it
        sys.exit(130)
    sys.exit(status or 0)
