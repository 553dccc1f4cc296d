"""The command `eulerdisk`: the list of its commands, and its exit statuses.

Results go to standard output, progress and messages to standard error. Exit status: 0 done; 1 a check failed, or too
many cells could not be computed; 2 the request was wrong and nothing was touched; 3 the system refused a file, the
output or memory; 70 a defect of the program, please report it; 130 or 143 interrupted. After 3, 70, 130 and 143 the
finished blocks are kept, and the same command continues. The commands do the slow imports, so that a wrong word is
refused before numba or xarray is loaded.
"""

import os
import signal
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext, suppress
from importlib import import_module
from types import FrameType
from typing import TYPE_CHECKING, Annotated

from sweep.version import __version__

# Nothing else is imported here: on a busy machine that takes seconds, during which Ctrl-C is not handled yet.
if TYPE_CHECKING:
    from typer import Typer

_HELP = (
    "Compute stability atlases of rolling disks, other bodies and your own systems: how fast to stay up?\n\n"
    "Exit status: 0 done; 1 a check failed, or too many cells could not be computed; 2 the request was wrong, nothing "
    "was touched; 3 the system refused a file, the output or memory; 70 a defect of the program, please report it; "
    "130, 143 interrupted."
)

#: The commands in the order of --help, each with its module and its line there. The function has the command's name.
_COMMANDS = {
    "run": ("run", "Compute an atlas and write it to one netCDF file."),
    "plan": ("run", "Estimate the cost of a run: cells, blocks, time, memory, disk."),
    "batch": ("batch", "Compute many sweeps, check each, and print a table."),
    "plot": ("inspect", "Draw stability maps with the measured and analytic boundary."),
    "info": ("inspect", "Describe an atlas, or the progress of an unfinished run."),
    "boundary": ("inspect", "Print the measured boundary next to the theoretical lines."),
    "verify": ("check", "Check an atlas against the reference of its model."),
    "compare": ("check", "Check an atlas against a trusted one."),
    "explain": ("check", "Explain one cell: its numbers, and the reason for its verdict."),
    "explore": ("explore", "Explore an atlas in the browser; it is computed while you look."),
    "simulate": ("simulate", "Compute one motion in time: its path, losses and forces."),
    "export": ("inspect", "Write an atlas as tables (csv, parquet) or as zarr."),
    "prepare": ("run", "Create the folder of a run without computing a cell."),
    "block": ("run", "Compute one part of a prepared run."),
    "assemble": ("run", "Write the atlas of a run whose blocks are all computed."),
    "warmup": ("warmup", "Compile the kernels into the cache."),
}


def parser(words: Sequence[str]) -> "Typer":
    """Return the parser of a command line: with the command named by its first word, otherwise with all commands.

    Building all commands takes as long as reading a small file.
    """
    import typer

    def options(
        version: Annotated[bool, typer.Option("--version", help="Print the version and exit.")] = False,
    ) -> None:
        if version:
            print(f"eulerdisk {__version__}")
            raise typer.Exit

    app = typer.Typer(
        name="eulerdisk",
        help=_HELP,
        no_args_is_help=True,
        add_completion=False,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
    )
    app.callback(invoke_without_command=True)(options)
    for name in words[:1] if words and words[0] in _COMMANDS else _COMMANDS:
        module, line = _COMMANDS[name]
        app.command(short_help=line)(getattr(import_module(f"sweep.commands.{module}"), name))
    return app


def _check_command(words: Sequence[str]) -> None:
    """Refuse a first word that is not a command, and suggest the command that was probably meant.

    Raises
    ------
    RequestError
    """
    if not words or words[0].startswith("-") or words[0] in _COMMANDS:
        return
    from sweep.errors import RequestError, shown
    from sweep.request.suggestions import nearest_word

    about = [word for word in words[1:2] if word in _COMMANDS]
    instead = {"help": ["eulerdisk", *about, "--help"], "version": ["eulerdisk", "--version"]}
    word = shown(words[0])
    meant = nearest_word(words[0], (*_COMMANDS, *instead))
    hint = f"Did you mean {meant}? " * bool(meant) + "eulerdisk --help describes them."
    if meant in instead:
        hint = f"Write {' '.join(instead[meant])}."
    raise RequestError(f"There is no command {word!r}; commands are {', '.join(_COMMANDS)}.", hint, word)


@contextmanager
def _ended_by_interrupts() -> Iterator[None]:
    """End the process on Ctrl-C at once and without a traceback, as long as there is nothing to clean up.

    Otherwise Python would raise an exception in the middle of an import, where no code catches it.
    """
    if signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        # a shell makes a program in the background ignore Ctrl-C
        yield
        return
    with suppress(ValueError):
        # ValueError: this is not the main thread, and receives no signals
        signal.signal(signal.SIGINT, _end)
    try:
        yield
    finally:
        with suppress(ValueError):
            signal.signal(signal.SIGINT, signal.default_int_handler)


def _end(number: int, _frame: FrameType | None) -> None:
    with suppress(OSError):
        os.write(2, b"eulerdisk: interrupted; no unfinished file was written.\n")
    os._exit(128 + number)


def main() -> None:
    """Run the command line and exit.

    The parser exits with 2 if a command, option or argument is wrong, with 130 on Ctrl-C if nothing is kept, and with
    1 if the reader of the output has gone, as in ``eulerdisk boundary a.nc | head``.
    """
    with _ended_by_interrupts():
        import typer  # noqa: F401  # takes most of the time before the words are read

        from sweep import platforms  # noqa: F401
        from sweep.commands import process

        process.open_streams()
    # figures need no window, and importing matplotlib fails if this names an unknown backend
    os.environ.pop("MPLBACKEND", None)
    sys.exit(process.exit_status(_run))


def _run() -> None:
    from sweep.commands import process
    from sweep.commands.terminal import ended_while_compiling, say
    from sweep.notices import listen
    from sweep.platforms import check_memory, check_system

    check_system()
    # help needs hardly any memory
    if "--help" not in sys.argv and len(sys.argv) > 1:
        check_memory()
    process.tell_warnings()
    listen(say)
    # NumPy warns about absurd values in a damaged file; where warnings are errors, as in the tests, they stay errors
    warnings.filterwarnings("ignore", category=RuntimeWarning, append=True)
    _check_command(sys.argv[1:])
    # the explorer handles signals itself
    with nullcontext() if sys.argv[1:2] == ["explore"] else ended_while_compiling():
        parser(sys.argv[1:])(prog_name="eulerdisk")
