"""The words that select a part of an atlas on the command line: ``plot three-axes.nc alpha=0.5``."""

import contextlib
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sweep.commands.terminal import say
from sweep.errors import RequestError

if TYPE_CHECKING:
    import xarray as xr

PART_HELP = (
    "NAME=VALUE selects a part: the nearest value of an axis, a list of values, or all values in START:STOP, "
    "e.g. alpha=0.5 tilt=1deg:3deg."
)

Part = Annotated[list[str] | None, typer.Argument(metavar="NAME=VALUE", help=PART_HELP, show_default=False)]


@contextlib.contextmanager
def opened_part(path: Path, words: Sequence[str] | None) -> Iterator["xr.Dataset"]:
    """Open an atlas, or the part selected by words ``NAME=VALUE``; report values that differ from the request."""
    from sweep.files.reading import opened
    from sweep.request.words import pairs

    selection = pairs(words or [])
    with opened(path) as dataset:
        if not selection:
            yield dataset
            return
        from sweep.atlas.parts import part_of

        part, notes = part_of(dataset, selection)
        for note in notes:
            say(note)
        yield part


def files_and_words(arguments: Sequence[str]) -> tuple[list[Path], list[str]]:
    """Split arguments into files and words ``NAME=VALUE``; an existing file may look like such a word.

    Raises
    ------
    RequestError
        If there is no file.
    """
    words = [word for word in arguments if "=" in word and not os.path.exists(word)]
    files = [Path(word) for word in arguments if word not in words]
    if not files:
        raise RequestError(
            f"NAME=VALUE selects a part of an atlas, and no atlas was given; got only {' '.join(words)}.",
            "Name a file before the words, as in: plot three-axes.nc alpha=0.5 -o slice.png.",
        )
    return files, words
