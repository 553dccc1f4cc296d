"""Open the explorer in the browser: the command `explore`."""

from typing import Annotated

import typer

from sweep.commands.arguments import Words, whole_number
from sweep.commands.terminal import say


def explore(
    what: Annotated[
        str | None,
        typer.Argument(
            metavar="[WHAT]",
            help="A preset, a .toml file or an atlas .nc; all presets if none is given.",
            show_default=False,
        ),
    ] = None,
    words: Words = None,
    *,
    port: Annotated[
        int,
        typer.Option(
            parser=whole_number, metavar="INTEGER", help="Where the page is answered; 0 for any free port."
        ),
    ] = 0,
    browser: Annotated[bool, typer.Option(help="Open the page in the browser.")] = True,
) -> None:
    """Look around in an atlas that is computed while you look.

    A page of this machine alone; it is answered until Ctrl-C. The address that is printed lets in who knows it.
    """
    from sweep.explorer.explorer import Explorer
    from sweep.explorer.subject import subject_of_words

    explorer = Explorer(subject_of_words(what, words or []), port)
    if browser:
        explorer.open_browser()
    print(explorer.url, flush=True)
    say("the explorer answers at this address until Ctrl-C")
    try:
        explorer.wait()
    except KeyboardInterrupt:
        explorer.close()
