"""The words that pick a part of an atlas on the command line: ``plot three-axes.nc alpha=0.5``."""

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
    "NAME=VALUE takes a part: the nearest value of an axis, a list of them, or all from START:STOP, as in alpha=0.5 "
    "tilt=1deg:3deg."
)

Part = Annotated[list[str] | None, typer.Argument(metavar="NAME=VALUE", help=PART_HELP, show_default=False)]


@contextlib.contextmanager
def opened_part(path: Path, words: Sequence[str] | None) -> Iterator["xr.Dataset"]:
    """Open an atlas, or the part of it that words ``NAME=VALUE`` pick; say which values are not those asked for."""
    from sweep.files.reading import opened
    from sweep.request.words import pairs

    given = pairs(words or [])
    with opened(path) as dataset:
        if not given:
            yield dataset
            return
        from sweep.atlas.parts import part_of

        part, notes = part_of(dataset, given)
        for note in notes:
            say(note)
        yield part


def files_and_words(arguments: Sequence[str]) -> tuple[list[Path], list[str]]:
    """Return the files among arguments, and the words ``NAME=VALUE``; a file may have that form too.

    Raises
    ------
    RequestError
        If there is no file.
    """
    words = [each for each in arguments if "=" in each and not os.path.exists(each)]
    files = [Path(each) for each in arguments if each not in words]
    if not files:
        raise RequestError(
            f"An atlas is needed to take a part from; got {' '.join(words)} alone.",
            "Name a file before the words, as in: plot three-axes.nc alpha=0.5 -o slice.png.",
        )
    return files, words
