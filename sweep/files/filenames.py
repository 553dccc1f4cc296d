"""What can be said of a file by its name, before the libraries are loaded that read or draw it."""

import os
from collections.abc import Mapping
from pathlib import Path

from sweep.errors import RequestError

#: Ending of a figure -> what a file of that kind would otherwise say about the day and the program that wrote it.
FORMATS: Mapping[str, Mapping[str, None]] = {
    "png": {"Software": None},
    "pdf": {"CreationDate": None, "Producer": None, "Creator": None},
    "svg": {"Date": None, "Creator": None},
}


def check_format(path: str | Path) -> str:
    """Return the format that a figure's name asks for: png, pdf or svg.

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
    """Refuse an atlas that is not there.

    Raises
    ------
    RequestError
        If it is not a file.
    """
    if not os.path.isfile(path):
        raise RequestError(
            "no such file", "an atlas is a netCDF file", str(path), "check the path", str(path)
        )
