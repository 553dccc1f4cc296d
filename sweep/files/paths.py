"""Checks of the paths of files, made before anything is computed and before heavy libraries are loaded."""

import os
import shlex
from collections.abc import Mapping
from pathlib import Path

from sweep.errors import RequestError

#: Format of a figure -> the metadata that would record the date and the program, each set to None to leave it out.
FORMATS: Mapping[str, Mapping[str, None]] = {
    "png": {"Software": None},
    "pdf": {"CreationDate": None, "Producer": None, "Creator": None},
    "svg": {"Date": None, "Creator": None},
}


def check_format(path: str | Path) -> str:
    """Return the format that the name of a figure ends in: png, pdf or svg.

    Raises
    ------
    RequestError
        If the name has another ending.
    """
    ending = Path(path).suffix.lower().removeprefix(".")
    if ending not in FORMATS:
        raise RequestError(
            "not a format of figures",
            f"a figure's name ends in one of {', '.join(f'.{each}' for each in FORMATS)}",
            str(path),
            f"write {Path(path).stem or 'figure'}.png",
            str(path),
        )
    return ending


def check_atlas(path: str | Path) -> None:
    """Refuse to read an atlas that does not exist.

    Raises
    ------
    RequestError
        If the path is not that of a file.
    """
    # os.path, because a pathlib.Path raises where the folder cannot be searched, or where the name is too long
    if not os.path.isfile(path):
        raise RequestError(
            "no such file", "an atlas is a netCDF file", str(path), "check the path", str(path)
        )


def check_target(path: Path, overwrite: bool) -> None:
    """Refuse to write a file where it could not be written in the end.

    Parameters
    ----------
    path : Path
    overwrite : bool
        Whether the file may exist already.

    Raises
    ------
    RequestError
        If the folder does not exist or cannot be written, or the path is that of something other than a file, or of a
        file that must not be replaced.
    """
    where, folder = str(path), path.parent
    # os.path for the same reason as in check_atlas
    if not os.path.isdir(folder):
        raise RequestError(
            "no such folder",
            "the output's folder exists",
            str(folder),
            f"`mkdir -p {shlex.quote(str(folder))}`",
            where,
        )
    exists = os.path.exists(path)
    if exists and not os.path.isfile(path):
        raise RequestError("not a file", "the output is a file", where, "give a file name", where)
    if exists and not overwrite:
        raise RequestError(
            "the file exists", "a finished file is not replaced by accident", where, "add --overwrite", where
        )
    if not os.access(folder, os.W_OK | os.X_OK):
        raise RequestError(
            "the folder cannot be written",
            "the output's folder is writable",
            str(folder),
            "choose another",
            where,
        )


def check_apart(target: Path, *sources: Path) -> None:
    """Refuse to write the result of reading an atlas over that atlas.

    Raises
    ------
    RequestError
        If `target` is one of the files that are read.
    """
    for source in sources:
        if os.path.exists(target) and os.path.samefile(target, source):
            raise RequestError(
                "this would replace the atlas that is read",
                "what is made of an atlas is another file",
                str(target),
                "give another name",
                str(target),
            )
