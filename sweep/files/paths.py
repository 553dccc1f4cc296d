"""Checks of the paths of files, made before anything is computed and before heavy libraries are loaded."""

import errno
import os
import re
import shlex
from pathlib import Path

from sweep.atomic import try_publishing
from sweep.errors import RequestError

#: Formats of figures, which are the endings of their names.
FIGURE_FORMATS = ("png", "pdf", "svg")

#: Endings of the names of atlases, beside none. What begins with no letter is no ending: a-0.5, run.2026-11-22.
_NETCDF, _ENDING = (".nc", ".nc4", ".cdf", ".netcdf", ".h5"), re.compile(r"\.[A-Za-z][A-Za-z0-9]*")

#: Folders of the system, whose names stand for streams and devices; and the one among them that holds files.
_SYSTEM_FOLDERS, _SHARED_MEMORY = ("/proc/", "/sys/", "/dev/"), "/dev/shm/"

#: Links that are followed from one name.
_MOST_LINKS = 40


def check_format(path: str | Path) -> str:
    """Return the format that the name of a figure ends in: png, pdf or svg; other names are refused."""
    ending = Path(path).suffix.lower().removeprefix(".")
    if ending not in FIGURE_FORMATS:
        raise RequestError(
            "The ending of this name is not a format of figures; the name of a figure ends in one of "
            f"{', '.join(f'.{each}' for each in FIGURE_FORMATS)}.",
            hint=f"Write {Path(path).stem or 'figure'}.png.",
            where=str(path),
        )
    return ending


def check_atlas_name(path: Path, hint: str = "") -> None:
    """Refuse to write an atlas under a name that promises another format, as a.csv or a.png."""
    if path.suffix.lower() in _NETCDF or not _ENDING.fullmatch(path.suffix):
        return
    if not hint and path.suffix.lower().removeprefix(".") in FIGURE_FORMATS:
        hint = f"A figure is drawn of an atlas: eulerdisk plot {path.stem}.nc -o {path.name}."
    raise RequestError(
        f"An atlas is a netCDF file, and a name that ends in {path.suffix} promises another format.",
        hint=hint
        or f"Write {path.stem}.nc; a table is made of it by eulerdisk export {path.stem}.nc --to csv.",
        where=f"-o {path}",
    )


def check_table_name(path: Path, kind: str) -> None:
    """Refuse to write a table under the name of an atlas."""
    if path.suffix.lower() in _NETCDF:
        raise RequestError(
            f"With --to {kind} a table is written, and a name that ends in {path.suffix} promises netCDF.",
            hint=f"Write -o {path.stem}.{kind}, or leave --to out.",
            where=f"-o {path}",
        )


def check_atlas(path: str | Path) -> None:
    """Refuse to read an atlas that does not exist, or that is a folder or another thing than a file."""
    # os.path, because a pathlib.Path raises where the folder cannot be searched, or where the name is too long
    if os.path.isfile(path):
        return
    if os.path.isdir(path):
        wrong = "This is a folder"
    elif os.path.exists(path):
        wrong = "This is not a regular file"
    else:
        wrong = "There is no such file"
    raise RequestError(f"{wrong}; an atlas is a netCDF file.", hint="Check the path.", where=str(path))


def check_target(path: Path, overwrite: bool) -> None:
    """Refuse to write a file where it could not be written in the end, or without `overwrite` where one exists."""
    where, folder = str(path), path.parent
    # os.path for the same reason as in check_atlas
    if not os.path.isdir(folder):
        raise RequestError(
            "There is no such folder; the folder of an output must exist.",
            hint=f"Run `mkdir -p {shlex.quote(str(folder))}`, or give another output.",
            where=where,
        )
    check_name(path)
    _check_no_device(path)
    exists = os.path.exists(path)
    if exists and not os.path.isfile(path):
        raise RequestError(
            "This is not a file, and the output must be one.", hint="Give a file name.", where=where
        )
    if exists and not overwrite:
        raise RequestError(
            "Nothing is written, because the file exists; a finished file is not replaced by accident.",
            hint="To replace it, add --overwrite (in Python overwrite=True).",
            where=where,
        )
    if not os.access(folder, os.W_OK | os.X_OK):
        raise RequestError(
            "The folder cannot be written; an output needs one that can.",
            hint="Choose another folder.",
            where=where,
        )
    try:
        # what os.access does not know: a user that the file server maps to another, a folder of the kernel, ...
        try_publishing(path)
    except OSError as problem:
        # whether there is room is checked where it is known how much is needed
        if problem.errno not in (errno.ENOSPC, errno.EDQUOT):
            raise RequestError(
                f"A file of that name cannot be made in this folder: {problem.strerror}.",
                hint="Give another name or folder.",
                where=where,
            ) from problem


def _check_no_device(path: Path) -> None:
    """Refuse a name of the system, as /dev/stdout: the file behind it is kept, and its name would be replaced."""
    step = path.absolute()
    # a link to a link, as /dev/stdout -> /proc/self/fd/1 -> the file
    for _ in range(_MOST_LINKS):
        folder = f"{os.path.realpath(step.parent)}/"
        if folder.startswith(_SYSTEM_FOLDERS) and not folder.startswith(_SHARED_MEMORY):
            raise RequestError(
                "This is a name of the system, for a stream or a device, and the output must be a file.",
                hint="Give the name of a file.",
                where=str(path),
            )
        if not os.path.islink(step):
            return
        step = step.parent / os.readlink(step)


def check_name(path: Path) -> None:
    """Refuse a name that the file system does not take, or that netCDF cannot be given."""
    if path.name in ("", ".."):
        raise RequestError(
            "This is not a file, and the output must be one.", hint="Give a file name.", where=str(path)
        )
    try:
        os.fspath(path.absolute()).encode("utf-8")
        # that the folder is there is checked elsewhere
        if os.path.isdir(path.parent) or "\0" in str(path):
            os.lstat(path)
    except FileNotFoundError:
        return
    except UnicodeEncodeError:
        wrong = "The path of an output must be text in UTF-8, with all of its folders"
    except (OSError, ValueError) as problem:
        wrong = f"This cannot be the name of a file: {getattr(problem, 'strerror', None) or problem}"
    else:
        return
    raise RequestError(f"{wrong}.", hint="Give another name.", where=str(path))


def check_apart(target: Path, *sources: Path) -> None:
    """Refuse to write the result of reading a file over that file."""
    for source in sources:
        if os.path.exists(target) and os.path.samefile(target, source):
            raise RequestError(
                "The output must be another file: this would replace the file that is read.",
                hint="Give another name.",
                where=str(target),
            )
