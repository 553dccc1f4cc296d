"""Where a run keeps its blocks: the names of its folder and of its manifest. Nothing is loaded to know them."""

import os
from pathlib import Path

#: Suffix of the name of the folder, after the name of the output.
SUFFIX = ".run"

#: Name of the manifest in the folder of a run.
MANIFEST = "manifest.json"

#: Name of the file in that folder with the values of a table of starts, little-endian doubles.
STARTS = "starts.bin"


def resolved(path: str | Path) -> Path:
    """Return where a file will be: a symbolic link is followed, so that two names of one output share one lock."""
    return Path(os.path.realpath(path)) if os.path.islink(path) else Path(path)


def directory_of(path: Path) -> Path:
    """Return the folder of the run that makes a file."""
    return path.parent / (path.name + SUFFIX)


def unfinished(path: Path) -> Path | None:
    """Return the folder of the unfinished run that makes a file, or that is given itself; None if there is none."""
    for folder in (path, directory_of(path)):
        if os.path.isfile(folder / MANIFEST):
            return folder
    return None
