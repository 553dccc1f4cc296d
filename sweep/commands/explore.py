"""The command that opens the explorer in the browser: `explore`."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from sweep.commands.arguments import Overwrite, Words, integer
from sweep.commands.terminal import abandonable, say, show


def explore(
    what: Annotated[
        str | None,
        typer.Argument(
            metavar="[WHAT]",
            help="A preset, a .toml or .py file, or an atlas .nc; default: the presets of the thin disk.",
            show_default=False,
        ),
    ] = None,
    words: Words = None,
    *,
    port: Annotated[int, integer("Port of the server; 0 for any free port.")] = 0,
    export: Annotated[
        Path | None,
        typer.Option(metavar="PAGE.html", help="Write a page that works without a server, and exit."),
    ] = None,
    overwrite: Overwrite = False,
    browser: Annotated[bool, typer.Option(help="Open the page in the browser.")] = True,
) -> None:
    """Explore an atlas in the browser; it is computed while you look.

    Serves the page on this machine until Ctrl-C. Anyone on this machine with the printed address can open it.
    """
    from sweep.explorer.explorer import Explorer, subject_of_words

    subject = subject_of_words(what, words or [])
    if export is not None:
        from sweep.explorer.export import export as write

        with abandonable(export) as check:
            write(subject, export, overwrite=overwrite, check=check)
        say(f"{export}: {export.stat().st_size / 1e6:.1f} MB")
        return
    explorer = Explorer(subject, port)
    # once the address is printed, Ctrl-C ends the explorer properly
    try:
        if browser:
            explorer.open_browser()
        show(explorer.url)
        # the reader of a pipe waits for the address
        sys.stdout.flush()
        say("the explorer runs at this address until Ctrl-C")
        explorer.wait()
    except KeyboardInterrupt:
        explorer.close()
