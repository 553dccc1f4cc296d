"""Atlases read from netCDF files: opened lazily, refused with the reason."""

import contextlib
import math
import os
import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sweep.atlas.cf_metadata import FORMAT
from sweep.atlas.dataset import place_of, require, spec_named
from sweep.atlas.selection import as_atlas, require_atlas
from sweep.atlas.structure import check_structure, known_names, strangers
from sweep.engine.grid import chunks
from sweep.errors import LeftOutWarning, RequestError, as_path, printable, shown
from sweep.files.one_thread import netcdf_to_itself
from sweep.files.paths import check_atlas

if TYPE_CHECKING:
    import xarray as xr


#: Values over file, in bytes, at most: deflate packs no more than 1032 bytes into one.
_MOST_PACKED = 1032

#: The attribute that makes a file one of a motion.
_MOTION = "eulerdisk_trajectory_format"

#: Bytes of chunks that netCDF keeps of each variable: one of those that are read one after the other. With the 16 MB to
#: 64 MB of its own `compare` of 1e7 cells took 790 MB in place of 230.
_KEPT_CHUNKS = 2**20


def open_atlas(path: str | Path, *, indexed: bool = True) -> "xr.Dataset":
    """Open an atlas; values are read when they are used. Close it, or use it in a ``with`` statement.

    Variables that another program has added are kept if they are numbers on the grid of the cells. Others are left
    out, with a warning.

    Parameters
    ----------
    path : str or Path
    indexed : bool
        Whether cells can be selected by their coordinates: for that xarray holds every axis in memory.

    Raises
    ------
    RequestError
        If the file is missing, is not netCDF, is not an atlas, or has a newer format than this version knows.
    """
    path = as_path(path)
    check_atlas(path)
    import xarray as xr

    with _netcdf_errors(path), _small_chunk_cache():
        unread = _unread_variables(path)
        with netcdf_to_itself(by_xarray=True):
            stored = xr.open_dataset(
                path.absolute(),
                engine="netcdf4",
                decode_times=False,
                drop_variables=[*unread],
                create_default_indexes=False,
            )
    try:
        with damage_named(stored):
            left_out = _check(stored, path, unread)
            found = _as_atlas(stored.drop_vars([*(left_out.keys() - unread)]), path)
            if indexed:
                for name in found.dims:
                    found = found.set_xindex(str(name)) if name in found.coords else found
    except BaseException:
        stored.close()
        raise
    _tell(path, left_out)
    found.set_close(stored.close)
    return found


@contextlib.contextmanager
def opened_motion(path: Path) -> "Iterator[xr.Dataset]":
    """Open the file of a motion, which is closed behind it; an error on a damaged variable names that.

    Raises
    ------
    RequestError
        If the file is missing, or is not readable.
    """
    check_atlas(path)
    import xarray as xr

    with _netcdf_errors(path):
        unread = _unread_variables(path)
        with netcdf_to_itself(by_xarray=True):
            dataset = xr.open_dataset(
                path.absolute(), engine="netcdf4", decode_times=False, drop_variables=unread
            )
    with dataset, damage_named(dataset):
        yield dataset


#: With what files of netCDF begin.
_NETCDF = (b"\x89HDF", b"CDF")


def holds_motion(path: Path) -> bool:
    """Return whether a file is that of a motion; not of what cannot be read, which `open_atlas` refuses."""
    if not os.path.isfile(path):
        return False
    with contextlib.suppress(OSError), open(path, "rb") as file:
        # the library is slow to load
        if not file.read(4).startswith(_NETCDF):
            return False
    import netCDF4

    try:
        with netcdf_to_itself(), netCDF4.Dataset(path.absolute()) as file:
            return _MOTION in file.ncattrs()
    except Exception:
        # only the library works here: see `_netcdf_errors`
        return False


@contextlib.contextmanager
def atlas_of(given: "xr.Dataset | str | os.PathLike[str]") -> "Iterator[xr.Dataset]":
    """Yield an atlas, or the one in a file, which is closed behind it.

    Raises
    ------
    RequestError
        If it is neither; as from `open_atlas`.
    """
    if isinstance(given, (str, os.PathLike)):
        with open_atlas(Path(given)) as opened:
            yield opened
    else:
        require_atlas(given)
        yield given


@contextlib.contextmanager
def _small_chunk_cache() -> Iterator[None]:
    """Let netCDF keep few chunks of the files that are opened meanwhile."""
    import netCDF4

    before = netCDF4.get_chunk_cache()
    netCDF4.set_chunk_cache(_KEPT_CHUNKS)
    try:
        yield
    finally:
        netCDF4.set_chunk_cache(*before)


def _unread_variables(path: Path) -> list[str]:
    """Return the variables of a file that are neither numbers nor characters, which xarray may not open.

    Raises
    ------
    RequestError
        If a variable has more values than the bytes of the file can hold: a few bytes can declare 2**40 cells, for
        which reading them would ask for memory.
    OSError, RuntimeError and other errors of netCDF
        If the file cannot be read.
    """
    import netCDF4

    unread, room = [], path.stat().st_size * _MOST_PACKED + 2**20
    with netcdf_to_itself(), netCDF4.Dataset(path.absolute()) as file:
        for name, variable in file.variables.items():
            kind = variable.datatype
            if not isinstance(kind, np.dtype) or kind.kind not in "iufS":
                unread.append(name)
                continue
            room -= math.prod(variable.shape) * kind.itemsize
            if room < 0:
                raise no_atlas(
                    path, f"{shown(name)} has more values than its bytes can hold, of shape {variable.shape}"
                )
    return unread


def _as_atlas(dataset: "xr.Dataset", path: Path) -> "xr.Dataset":
    """Return a dataset whose coordinates are those of its atlas.

    The attribute `coordinates` of any variable may have made another one of them a coordinate.
    """
    wrong = [name for name in dataset.coords if name not in spec_named(dataset).quantities]
    if stray := sorted({*map(str, wrong)} & {*map(str, dataset.dims)}):
        raise no_atlas(path, f"{shown(stray[0])} is a coordinate that no atlas has")
    return dataset.reset_coords(wrong) if wrong else dataset


@contextlib.contextmanager
def opened(path: Path, *, indexed: bool = True) -> Iterator["xr.Dataset"]:
    """Open an atlas as `open_atlas` does; if the ``with`` block fails on a damaged variable, the error names it.

    A file that holds a selection from an atlas is an atlas of its own (`sweep.atlas.selection.as_atlas`).
    """
    with open_atlas(path, indexed=indexed) as dataset, damage_named(dataset):
        yield as_atlas(dataset, trusting=True)


def loaded(dataset: "xr.Dataset") -> "xr.Dataset":
    """Return a dataset whose values are in memory; a RequestError names the variables that cannot be read."""
    with damage_named(dataset):
        return dataset.load()


@contextlib.contextmanager
def damage_named(dataset: "xr.Dataset") -> Iterator[None]:
    """Turn an error within into a RequestError that names the variables of the atlas that cannot be read, if any."""
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


def _can_be_read(variable: "xr.DataArray | xr.Variable") -> bool:
    try:
        # not `values`, which would be kept in memory
        for _, places in chunks(variable.shape):
            np.asarray(variable[places])
    except Exception:
        # only the libraries work here: see `_netcdf_errors`
        return False
    return True


@contextlib.contextmanager
def _netcdf_errors(path: Path) -> Iterator[None]:
    """Turn an error of the libraries into a refusal, and ignore their warnings, which hold names of the file.

    Of a damaged file they raise all kinds of errors: AttributeError, KeyError, IndexError, MemoryError.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except RequestError:
        raise
    except Exception as problem:
        raise RequestError(
            f"This is not a readable netCDF file, and an atlas is a netCDF-4 file, whole; got {path.stat().st_size} "
            f"bytes: {shown(str(problem))}.",
            hint="Make it again with eulerdisk run.",
            where=str(path),
        ) from problem


def _check(file: "xr.Dataset", path: Path, unread: Sequence[str]) -> dict[str, str]:
    """Refuse an open file that is no atlas; return the variables that cannot stand in one, and why."""
    if _MOTION in file.attrs:
        raise MotionGivenError(path)
    known = file.attrs.get("eulerdisk_format")
    try:
        version = int(str(known) if "sweep_spec" in file.attrs else "")
    except (TypeError, ValueError):
        raise RequestError(
            "This is not a stability atlas, which has the attributes eulerdisk_format, a number, and sweep_spec; got a "
            f"netCDF file titled {shown(str(file.attrs.get('title', '(no title)')))!r}.",
            hint="Give a file made by eulerdisk run.",
            where=str(path),
        ) from None
    if version > FORMAT:
        raise RequestError(
            f"The atlas is newer than this program, which reads formats up to {FORMAT}; got format {version}.",
            hint="Update eulerdisk.",
            where=str(path),
        )
    spec = spec_named(file)
    if spec.criterion.kind == "function":
        raise no_atlas(path, f"it states the {spec.criterion}, which judged an atlas in memory")
    names = known_names(spec)
    if mistyped := sorted(names.intersection(unread)):
        raise no_atlas(path, f"{mistyped[0]} is of a type that no atlas has")
    require(file, ("ending", "stability", *spec.model.extremes), str(path))
    left_out = dict.fromkeys(unread, "is neither a number nor text") | strangers(file, spec)
    check_structure(file[[name for name in file.variables if name in names]], spec, str(path))
    return left_out


def _tell(path: Path, left_out: dict[str, str]) -> None:
    """Warn of variables that are left out."""
    if left_out:
        name, problem = next(iter(left_out.items()))
        more = f", and {len(left_out) - 1} more" if len(left_out) > 1 else ""
        warnings.warn(
            printable(f"{path}: no part of an atlas, and left out: {shown(name)}, which {problem}{more}"),
            LeftOutWarning,
            stacklevel=3,
        )


def no_atlas(path: Path, reason: str) -> RequestError:
    """Return the error of a file that is read and is no atlas."""
    return RequestError(
        f"This file is no stability atlas, or a damaged one: {reason}.",
        hint="Give a file made by eulerdisk run.",
        where=str(path),
    )


class MotionGivenError(RequestError):
    """A file of one motion, given where an atlas is needed."""

    def __init__(self, path: Path) -> None:
        super().__init__(
            "This file holds one motion in time, which eulerdisk simulate has made, and no stability atlas.",
            hint="Give a file made by eulerdisk run; info, plot and export take a motion too.",
            where=str(path),
        )
