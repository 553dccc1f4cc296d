"""Reading atlases from netCDF files, lazily; damaged and foreign files are refused with the reason."""

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


#: Largest ratio of the bytes of the values to the bytes of the file: deflate packs at most 1032 bytes into one.
_MOST_PACKED = 1032

#: The attribute that marks the file of a motion.
_MOTION = "eulerdisk_trajectory_format"

#: Chunk cache of netCDF for each variable [bytes]: one chunk, since chunks are read in order. With netCDF's default of
#: 16 MB to 64 MB, `compare` of 1e7 cells took 790 MB instead of 230 MB.
_KEPT_CHUNKS = 2**20


def open_atlas(path: str | Path, *, indexed: bool = True) -> "xr.Dataset":
    """Open an atlas lazily: values are read when used. Close it, or use it in a ``with`` statement.

    Variables added by another program are kept if they are numbers on the grid of the cells. Other variables are
    dropped with a warning.

    Parameters
    ----------
    path : str or Path
    indexed : bool
        Whether cells can be selected by their coordinates. If so, xarray keeps every axis in memory.

    Raises
    ------
    RequestError
        If the file is missing, is not netCDF, is not an atlas, or has a format newer than this version.
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
    _warn_dropped(path, left_out)
    found.set_close(stored.close)
    return found


@contextlib.contextmanager
def opened_motion(path: Path) -> "Iterator[xr.Dataset]":
    """Open the file of a motion and close it at the end; an error on a damaged variable names the variable.

    Raises
    ------
    RequestError
        If the file is missing or unreadable.
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


#: First bytes of netCDF files.
_NETCDF = (b"\x89HDF", b"CDF")


def holds_motion(path: Path) -> bool:
    """Return whether a file holds a motion; False for unreadable files, which `open_atlas` refuses."""
    if not os.path.isfile(path):
        return False
    with contextlib.suppress(OSError), open(path, "rb") as file:
        # checked first, because the library is slow to load
        if not file.read(4).startswith(_NETCDF):
            return False
    import netCDF4

    try:
        with netcdf_to_itself(), netCDF4.Dataset(path.absolute()) as file:
            return _MOTION in file.ncattrs()
    except Exception:
        # every error here comes from the library: see `_netcdf_errors`
        return False


@contextlib.contextmanager
def atlas_of(given: "xr.Dataset | str | os.PathLike[str]") -> "Iterator[xr.Dataset]":
    """Yield the given atlas, or open the given file and close it at the end.

    Raises
    ------
    RequestError
        If it is neither an atlas nor a file; also as `open_atlas`.
    """
    if isinstance(given, (str, os.PathLike)):
        with open_atlas(Path(given)) as opened:
            yield opened
    else:
        require_atlas(given)
        yield given


@contextlib.contextmanager
def _small_chunk_cache() -> Iterator[None]:
    """Reduce the chunk cache of files that are opened in the ``with`` block."""
    import netCDF4

    before = netCDF4.get_chunk_cache()
    netCDF4.set_chunk_cache(_KEPT_CHUNKS)
    try:
        yield
    finally:
        netCDF4.set_chunk_cache(*before)


def _unread_variables(path: Path) -> list[str]:
    """Return the variables of a file that are neither numbers nor characters; xarray may fail to open them.

    Raises
    ------
    RequestError
        If the variables have more values than the bytes of the file can hold. A few bytes can declare 2**40 cells, and
        reading them would need that much memory.
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
    """Return a dataset whose coordinates are the coordinates of its atlas.

    The attribute `coordinates` of a variable may have turned other variables into coordinates.
    """
    wrong = [name for name in dataset.coords if name not in spec_named(dataset).quantities]
    if stray := sorted({*map(str, wrong)} & {*map(str, dataset.dims)}):
        raise no_atlas(path, f"{shown(stray[0])} is a coordinate that no atlas has")
    return dataset.reset_coords(wrong) if wrong else dataset


@contextlib.contextmanager
def opened(path: Path, *, indexed: bool = True) -> Iterator["xr.Dataset"]:
    """Open an atlas as `open_atlas` does; if the ``with`` block fails on a damaged variable, the error names it.

    A file with a selection from an atlas becomes a complete atlas (`sweep.atlas.selection.as_atlas`).
    """
    with open_atlas(path, indexed=indexed) as dataset, damage_named(dataset):
        yield as_atlas(dataset, trusting=True)


def loaded(dataset: "xr.Dataset") -> "xr.Dataset":
    """Return a dataset with its values in memory; a RequestError names the variables that cannot be read."""
    with damage_named(dataset):
        return dataset.load()


@contextlib.contextmanager
def damage_named(dataset: "xr.Dataset") -> Iterator[None]:
    """Turn an error in the ``with`` block into a RequestError that names the damaged variables, if any."""
    try:
        yield
    except RequestError:
        raise
    except Exception as problem:
        # another file or a defect of this program may be the cause: blame this file only if it is damaged
        damaged = [str(name) for name, variable in dataset.variables.items() if not _can_be_read(variable)]
        if not damaged:
            raise
        raise RequestError(
            f"The file is damaged: {', '.join(damaged)} cannot be read ({shown(str(problem))}).",
            hint="Recompute it with eulerdisk run, or use an undamaged copy.",
            where=place_of(dataset),
        ) from problem


def _can_be_read(variable: "xr.DataArray | xr.Variable") -> bool:
    try:
        # not `values`, which would stay in memory
        for _, places in chunks(variable.shape):
            np.asarray(variable[places])
    except Exception:
        # every error here comes from the libraries: see `_netcdf_errors`
        return False
    return True


@contextlib.contextmanager
def _netcdf_errors(path: Path) -> Iterator[None]:
    """Turn errors of the libraries into a RequestError, and ignore their warnings, which contain names of the file.

    For a damaged file they raise all kinds of errors: AttributeError, KeyError, IndexError, MemoryError.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except RequestError:
        raise
    except Exception as problem:
        raise RequestError(
            f"This is not a readable netCDF file; an atlas is a complete netCDF-4 file. Got {path.stat().st_size} "
            f"bytes: {shown(str(problem))}.",
            hint="Recompute it with eulerdisk run.",
            where=str(path),
        ) from problem


def _check(file: "xr.Dataset", path: Path, unread: Sequence[str]) -> dict[str, str]:
    """Refuse an open file that is not an atlas; return the variables that no atlas can have, and why."""
    if _MOTION in file.attrs:
        raise MotionGivenError(path)
    known = file.attrs.get("eulerdisk_format")
    try:
        version = int(str(known) if "sweep_spec" in file.attrs else "")
    except (TypeError, ValueError):
        raise RequestError(
            "This is not a stability atlas: an atlas has the attributes sweep_spec and eulerdisk_format, a number. Got "
            f"a netCDF file titled {shown(str(file.attrs.get('title', '(no title)')))!r}.",
            hint="Give a file made by eulerdisk run.",
            where=str(path),
        ) from None
    if version > FORMAT:
        raise RequestError(
            f"The atlas is newer than this program: it has format {version}, and formats up to {FORMAT} can be read.",
            hint="Update eulerdisk.",
            where=str(path),
        )
    spec = spec_named(file)
    if spec.criterion.kind == "function":
        raise no_atlas(path, f"its criterion is the {spec.criterion}, which can only judge atlases in memory")
    names = known_names(spec)
    if mistyped := sorted(names.intersection(unread)):
        raise no_atlas(path, f"{mistyped[0]} has a type that no atlas uses")
    require(file, ("ending", "stability", *spec.model.extremes), str(path))
    left_out = dict.fromkeys(unread, "is neither a number nor text") | strangers(file, spec)
    check_structure(file[[name for name in file.variables if name in names]], spec, str(path))
    return left_out


def _warn_dropped(path: Path, left_out: dict[str, str]) -> None:
    """Warn of variables that were dropped."""
    if left_out:
        name, problem = next(iter(left_out.items()))
        more = f", and {len(left_out) - 1} more" if len(left_out) > 1 else ""
        warnings.warn(
            printable(
                f"{path}: variables that no atlas has are left out: {shown(name)}, which {problem}{more}"
            ),
            LeftOutWarning,
            stacklevel=3,
        )


def no_atlas(path: Path, reason: str) -> RequestError:
    """Return the error for a readable file that is not an atlas."""
    return RequestError(
        f"This file is not a stability atlas, or it is damaged: {reason}.",
        hint="Give a file made by eulerdisk run.",
        where=str(path),
    )


class MotionGivenError(RequestError):
    """A file of a motion was given where an atlas is needed."""

    def __init__(self, path: Path) -> None:
        super().__init__(
            "This file is not a stability atlas: it holds one motion in time, made by eulerdisk simulate.",
            hint="Give a file made by eulerdisk run. The commands info, plot and export also accept motions.",
            where=str(path),
        )
