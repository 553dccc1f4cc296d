"""Atlases read from netCDF files: opened lazily, refused with the reason."""

import contextlib
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sweep.atlas.cf_metadata import FORMAT
from sweep.atlas.contents import Atlas, Variable
from sweep.atlas.dataset import place_of, require, spec_named
from sweep.atlas.selection import is_whole, settled
from sweep.atlas.slices import slices_of
from sweep.atlas.structure import check_structure, known_names, strangers
from sweep.errors import LeftOutWarning, RequestError, printable, shown
from sweep.files.atlas_file import AtlasFile, MotionGivenError, no_atlas
from sweep.files.paths import check_atlas
from sweep.files.trial import check_opens
from sweep.request.criterion import Function

if TYPE_CHECKING:
    import xarray as xr


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
    path = Path(path)
    file, left_out = _checked(path)
    file.close()
    import xarray as xr

    with _netcdf_errors(path):
        dataset = xr.open_dataset(
            path.absolute(),
            engine="netcdf4",
            decode_times=False,
            drop_variables=[*left_out],
            create_default_indexes=indexed,
        )
    # the attribute `coordinates` of any variable may have made another one of them a coordinate
    wrong = [name for name in dataset.coords if name not in spec_named(dataset).quantities]
    if stray := sorted({*map(str, wrong)} & {*map(str, dataset.dims)}):
        dataset.close()
        raise no_atlas(path, f"{shown(stray[0])} is a coordinate that no atlas has")
    _tell(path, left_out)
    if not wrong:
        return dataset
    found = dataset.reset_coords(wrong)
    found.set_close(dataset.close)
    return found


@contextlib.contextmanager
def opened(path: Path, *, indexed: bool = True) -> Iterator["xr.Dataset"]:
    """Open an atlas as `open_atlas` does; if the ``with`` block fails on a damaged variable, the error names it.

    A file that holds a selection from an atlas is an atlas of its own (`sweep.atlas.selection.settled`).
    """
    with open_atlas(path, indexed=indexed) as dataset, damage_named(dataset):
        yield settled(dataset, trusting=True)


@contextlib.contextmanager
def opened_file(path: Path) -> Iterator[Atlas]:
    """Open an atlas as `opened` does, with the variables alone that every atlas may have.

    Without xarray, unless the file holds a selection or lacks a part, so that spec, boundary or parameters have to be
    made.
    """
    file, left_out = _checked(path)
    with file, damage_named(file):
        if is_whole(file):
            _tell(path, left_out)
            yield file
            return
    with opened(path) as dataset:
        yield dataset


def loaded(dataset: "xr.Dataset") -> "xr.Dataset":
    """Return a dataset whose values are in memory; a RequestError names the variables that cannot be read."""
    with damage_named(dataset):
        return dataset.load()


@contextlib.contextmanager
def damage_named(dataset: Atlas) -> Iterator[None]:
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


def _can_be_read(variable: Variable) -> bool:
    try:
        # not `values`, which would be kept in memory
        for _, places in slices_of(variable.shape):
            np.asarray(variable[places])
    except Exception:
        # only the libraries work here: see `_netcdf_errors`
        return False
    return True


def _checked(path: Path) -> tuple[AtlasFile, dict[str, str]]:
    """Open a file and check that it is an atlas: its known variables, and why others are left out, by their names."""
    check_atlas(path)
    # before the trial, which may fork this process: then the other one need not load it too
    import netCDF4  # noqa: F401

    with _netcdf_errors(path):
        check_opens(path.absolute())
        file = AtlasFile(path)
    try:
        with damage_named(file):
            return file, _check(file, path)
    except BaseException:
        file.close()
        raise


@contextlib.contextmanager
def _netcdf_errors(path: Path) -> Iterator[None]:
    """Turn whatever the libraries raise within into a refusal, and ignore their warnings, which hold names of the file.

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


def _check(file: AtlasFile, path: Path) -> dict[str, str]:
    """Refuse an open file that is no atlas; leave out what no atlas has, and return why some of it must be."""
    if "eulerdisk_trajectory_format" in file.attrs:
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
    if isinstance(spec.criterion, Function):
        raise no_atlas(path, f"it states the {spec.criterion}, which judged an atlas in memory")
    names = known_names(spec)
    if mistyped := sorted(names.intersection(file.unread)):
        raise no_atlas(path, f"{mistyped[0]} is of a type that no atlas has")
    require(file, ("ending", "stability", *spec.model.extremes), str(path))
    left_out = dict.fromkeys(file.unread, "is neither a number nor text") | strangers(file, spec)
    file.keep(names)
    check_structure(file, spec, str(path))
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
