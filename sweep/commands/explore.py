"""Open the explorer in the browser: the command `explore`."""

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
            help="A preset, a .toml or .py file, or an atlas .nc; if none is given, the presets of the thin disk.",
            show_default=False,
        ),
    ] = None,
    words: Words = None,
    *,
    port: Annotated[int, integer("Where the page is answered; 0 for any free port.")] = 0,
    export: Annotated[
        Path | None,
        typer.Option(
            metavar="PAGE.html", help="Write one page that computes by itself, without a server, and end."
        ),
    ] = None,
    overwrite: Overwrite = False,
    browser: Annotated[bool, typer.Option(help="Open the page in the browser.")] = True,
) -> None:
    """Look around in an atlas that is computed while you look.

    A page of this machine alone; it is answered until Ctrl-C. The address that is printed lets in who knows it.
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
    # Ctrl-C ends it well from the moment on at which the address is told
    try:
        if browser:
            explorer.open_browser()
        show(explorer.url)
        # who reads a pipe waits for the address
        sys.stdout.flush()
        say("the explorer answers at this address until Ctrl-C")
        explorer.wait()
    except KeyboardInterrupt:
        explorer.close()
