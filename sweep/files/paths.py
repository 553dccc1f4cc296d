"""Checks of file paths, made before any computation and before heavy libraries are loaded."""

import errno
import os
import re
import shlex
from pathlib import Path

from sweep.atomic import try_publishing
from sweep.errors import RequestError

#: Formats of figures, which are also the endings of their names.
FIGURE_FORMATS = ("png", "pdf", "svg")

#: Endings of atlas names, which may also have none. An ending begins with a letter, unlike in a-0.5, run.2026-11-22.
_NETCDF, _ENDING = (".nc", ".nc4", ".cdf", ".netcdf", ".h5"), re.compile(r"\.[A-Za-z][A-Za-z0-9]*")

#: System folders, whose names stand for streams and devices; and the only one of them for files.
_SYSTEM_FOLDERS, _SHARED_MEMORY = ("/proc/", "/sys/", "/dev/"), "/dev/shm/"

#: Largest number of links to follow from one name.
_MOST_LINKS = 40


def check_format(path: str | Path) -> str:
    """Return the format of a figure from the ending of its name: png, pdf or svg; refuse other names."""
    ending = Path(path).suffix.lower().removeprefix(".")
    if ending not in FIGURE_FORMATS:
        raise RequestError(
            "This name does not end in a figure format; a figure is one of "
            f"{', '.join(f'.{each}' for each in FIGURE_FORMATS)}.",
            hint=f"Write {Path(path).stem or 'figure'}.png.",
            where=str(path),
        )
    return ending


def check_atlas_name(path: Path, hint: str = "") -> None:
    """Refuse to write an atlas under a name that promises another format, such as a.csv or a.png."""
    if path.suffix.lower() in _NETCDF or not _ENDING.fullmatch(path.suffix):
        return
    if not hint and path.suffix.lower().removeprefix(".") in FIGURE_FORMATS:
        hint = f"To draw a figure of an atlas: eulerdisk plot {path.stem}.nc -o {path.name}."
    raise RequestError(
        f"An atlas is a netCDF file, but a name that ends in {path.suffix} promises another format.",
        hint=hint or f"Write {path.stem}.nc. To get a table: eulerdisk export {path.stem}.nc --to csv.",
        where=f"-o {path}",
    )


def check_table_name(path: Path, kind: str) -> None:
    """Refuse to write a table under the name of an atlas."""
    if path.suffix.lower() in _NETCDF:
        raise RequestError(
            f"--to {kind} writes a table, but a name that ends in {path.suffix} promises netCDF.",
            hint=f"Write -o {path.stem}.{kind}, or omit --to.",
            where=f"-o {path}",
        )


def check_atlas(path: str | Path) -> None:
    """Refuse to read an atlas that does not exist or is not a regular file."""
    # os.path, because pathlib raises if the folder cannot be searched or the name is too long
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
    """Refuse a path that could not be written later, or that exists if `overwrite` is false."""
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
            "The output must be a file; this is not one.", hint="Give a file name.", where=where
        )
    if exists and not overwrite:
        raise RequestError(
            "Nothing was written, because the file exists; a finished file is not replaced by accident.",
            hint="To replace it, add --overwrite (in Python overwrite=True).",
            where=where,
        )
    if not os.access(folder, os.W_OK | os.X_OK):
        raise RequestError(
            "The folder of the output is not writable.",
            hint="Choose another folder.",
            where=where,
        )
    try:
        # os.access misses some cases: users mapped to others by the file server, folders of the kernel, ...
        try_publishing(path)
    except OSError as problem:
        # room is checked later, when the needed size is known
        if problem.errno not in (errno.ENOSPC, errno.EDQUOT):
            raise RequestError(
                f"A file of that name cannot be created in this folder: {problem.strerror}.",
                hint="Give another name or folder.",
                where=where,
            ) from problem


def _check_no_device(path: Path) -> None:
    """Refuse a system name such as /dev/stdout: publishing would replace the name, not the file behind it."""
    step = path.absolute()
    # links may be chained: /dev/stdout -> /proc/self/fd/1 -> the file
    for _ in range(_MOST_LINKS):
        folder = f"{os.path.realpath(step.parent)}/"
        if folder.startswith(_SYSTEM_FOLDERS) and not folder.startswith(_SHARED_MEMORY):
            raise RequestError(
                "The output must be a file; this is a system name for a stream or a device.",
                hint="Give the name of a file.",
                where=str(path),
            )
        if not os.path.islink(step):
            return
        step = step.parent / os.readlink(step)


def check_name(path: Path) -> None:
    """Refuse a name that the file system or netCDF does not accept."""
    if path.name in ("", ".."):
        raise RequestError(
            "The output must be a file; this is not one.", hint="Give a file name.", where=str(path)
        )
    try:
        os.fspath(path.absolute()).encode("utf-8")
        # whether the folder exists is checked elsewhere
        if os.path.isdir(path.parent) or "\0" in str(path):
            os.lstat(path)
    except FileNotFoundError:
        return
    except UnicodeEncodeError:
        wrong = "The whole path of an output, including its folders, must be UTF-8 text"
    except (OSError, ValueError) as problem:
        wrong = f"This is not a valid file name: {getattr(problem, 'strerror', None) or problem}"
    else:
        return
    raise RequestError(f"{wrong}.", hint="Give another name.", where=str(path))


def check_apart(target: Path, *sources: Path) -> None:
    """Refuse to write an output over one of its input files."""
    for source in sources:
        if os.path.exists(target) and os.path.samefile(target, source):
            raise RequestError(
                "The output must be another file: it would replace the input.",
                hint="Give another name.",
                where=str(target),
            )
