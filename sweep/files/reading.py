"""Atlases read from netCDF files: opened lazily, refused with the reason."""

import contextlib
import math
import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import numpy as np

from sweep.atlas.cf_metadata import FORMAT
from sweep.atlas.dataset import place_of, require, spec_named
from sweep.atlas.structure import check_structure, known_names, strangers
from sweep.errors import LeftOutWarning, RequestError, printable, shown
from sweep.files.paths import check_atlas
from sweep.files.trial import check_opens

if TYPE_CHECKING:
    import xarray as xr

#: Values over file, in bytes, at most: deflate packs no more than 1032 bytes into one.
_MOST_PACKED = 1032


def open_atlas(path: str | Path) -> "xr.Dataset":
    """Open an atlas; values are read when they are used. Close it, or use it in a ``with`` statement.

    Variables that another program has added are kept if they are numbers on the grid of the cells. Others are left
    out, with a `LeftOutWarning`.

    Raises
    ------
    RequestError
        If the file is missing, is not netCDF, is not an atlas, or has a newer format than this version knows.
    """
    path = Path(path)
    check_atlas(path)
    import xarray as xr

    # Only the libraries work here, and of a damaged file they raise all kinds of errors: AttributeError, KeyError,
    # IndexError, MemoryError. Their warnings hold names from the file.
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            check_opens(path.absolute())
            unread = check_claims(path)
            dataset = xr.open_dataset(
                path.absolute(), engine="netcdf4", decode_times=False, drop_variables=unread
            )
    except RequestError:
        raise
    except Exception as problem:
        raise RequestError(
            f"This is not a readable netCDF file, and an atlas is a netCDF-4 file, whole; got {path.stat().st_size} "
            f"bytes: {shown(str(problem))}.",
            hint="Make it again with eulerdisk run.",
            where=str(path),
        ) from problem
    try:
        return _as_atlas(dataset, path, unread)
    except BaseException:
        dataset.close()
        raise


def check_claims(path: Path) -> list[str]:
    """Refuse a netCDF file whose variables have more values than its bytes can hold.

    A few bytes can declare 2**40 cells, for which reading them would ask for memory.

    Returns
    -------
    list of str
        The variables that are neither numbers nor characters, of which this is not known.

    Raises
    ------
    RequestError
    OSError, RuntimeError and other errors of netCDF
        If the file cannot be read.
    """
    import netCDF4

    room, others = path.stat().st_size * _MOST_PACKED + 2**20, []
    with netCDF4.Dataset(path.absolute()) as file:
        for name, variable in file.variables.items():
            kind = variable.datatype
            if not isinstance(kind, np.dtype) or kind.kind not in "iufS":
                others.append(name)
                continue
            room -= math.prod(variable.shape) * kind.itemsize
            if room < 0:
                _refuse(
                    path, f"{shown(name)} has more values than its bytes can hold, of shape {variable.shape}"
                )
    return others


def _refuse(path: Path, reason: str) -> NoReturn:
    raise RequestError(
        f"This file is no stability atlas, or a damaged one: {reason}.",
        hint="Give a file made by eulerdisk run.",
        where=str(path),
    )


@contextlib.contextmanager
def opened(path: Path) -> Iterator["xr.Dataset"]:
    """Open an atlas as `open_atlas` does; if the ``with`` block fails on a damaged variable, the error names it."""
    with open_atlas(path) as dataset, damage_named(dataset):
        yield dataset


def loaded(dataset: "xr.Dataset") -> "xr.Dataset":
    """Return a dataset whose values are in memory; a RequestError names the variables that cannot be read."""
    with damage_named(dataset):
        return dataset.load()


@contextlib.contextmanager
def damage_named(dataset: "xr.Dataset") -> Iterator[None]:
    """Turn an error within into a RequestError that names the variables of the dataset that cannot be read, if any."""
    try:
        yield
    except RequestError:
        raise
    except Exception as problem:
        # several files may be read, or the defect be ours: the error belongs to this file only if it is damaged
        damaged = [str(name) for name, variable in dataset.variables.items() if not _can_be_read(variable)]
        if not damaged:
            raise
        raise RequestError(
            f"The file is damaged: {', '.join(damaged)} cannot be read ({shown(str(problem))}).",
            hint="Make it again with eulerdisk run, or take a copy that is whole.",
            where=place_of(dataset),
        ) from problem


def _can_be_read(variable: "xr.Variable") -> bool:
    try:
        variable.copy(deep=False).load()
    except Exception:
        # only the libraries work here: see `open_atlas`
        return False
    return True


def _as_atlas(dataset: "xr.Dataset", path: Path, unread: Sequence[str]) -> "xr.Dataset":
    """Return a dataset that was read from a file, but for some variables, as an atlas.

    A RequestError says why it is none.
    """
    known = dataset.attrs.get("eulerdisk_format")
    try:
        version = int(str(known) if "sweep_spec" in dataset.attrs else "")
    except (TypeError, ValueError):
        raise RequestError(
            "This is not a stability atlas, which has the attributes eulerdisk_format, a number, and sweep_spec; got a "
            f"netCDF file titled {shown(str(dataset.attrs.get('title', '(no title)')))!r}.",
            hint="Give a file made by eulerdisk run.",
            where=str(path),
        ) from None
    if version > FORMAT:
        raise RequestError(
            f"The atlas is newer than this program, which reads formats up to {FORMAT}; got format {version}.",
            hint="Update eulerdisk.",
            where=str(path),
        )
    spec = spec_named(dataset)
    if mistyped := sorted(known_names(spec).intersection(unread)):
        _refuse(path, f"{mistyped[0]} is of a type that no atlas has")
    require(dataset, ("ending", "stability", *spec.model.extremes), str(path))
    left_out = dict.fromkeys(unread, "is neither a number nor text") | strangers(dataset, spec)
    found = dataset.drop_vars([name for name in left_out if name in dataset.variables])
    check_structure(found, spec, str(path))
    # the attribute `coordinates` of any variable may have made another one of them a coordinate
    wrong = [name for name in found.coords if name not in spec.model.parameters]
    if indexed := sorted({*map(str, wrong)} & {*map(str, found.dims)}):
        _refuse(path, f"{shown(indexed[0])} is a coordinate that no atlas has")
    if left_out:
        name, problem = next(iter(left_out.items()))
        more = f", and {len(left_out) - 1} more" if len(left_out) > 1 else ""
        warnings.warn(
            printable(f"{path}: no part of an atlas, and left out: {shown(name)}, which {problem}{more}"),
            LeftOutWarning,
            stacklevel=3,
        )
    if not wrong and not left_out:
        return dataset
    found = found.reset_coords(wrong)
    found.set_close(dataset.close)
    return found
