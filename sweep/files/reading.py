"""Atlases read from disk: opened lazily; a file that is not an atlas, or is damaged, is refused with the reason."""

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from sweep.atlas.cf_metadata import FORMAT
from sweep.atlas.dataset import place_of, require, spec_named
from sweep.errors import RequestError
from sweep.files.paths import check_atlas

if TYPE_CHECKING:
    import xarray as xr


def open_atlas(path: str | Path) -> "xr.Dataset":
    """Open an atlas; values are read when they are used. Close it, or use it in a ``with`` statement.

    Raises
    ------
    RequestError
        If the file is missing, is not netCDF, is not an atlas, or has a newer format than this version knows.
    """
    path = Path(path)
    check_atlas(path)
    import xarray as xr

    try:
        dataset = xr.open_dataset(path, engine="netcdf4")
    except (OSError, ValueError, RuntimeError) as problem:
        raise RequestError(
            f"This is not a readable netCDF file, and an atlas is a netCDF-4 file, whole; got {path.stat().st_size} "
            f"bytes: {problem}.",
            hint="Make it again with eulerdisk run.",
            where=str(path),
        ) from problem
    try:
        _check_format(dataset, path)
    except RequestError:
        dataset.close()
        raise
    return dataset


@contextlib.contextmanager
def opened(path: Path) -> Iterator["xr.Dataset"]:
    """Open an atlas as `open_atlas` does; if the ``with`` block fails on a damaged variable, the error names the file.

    Raises
    ------
    RequestError
    """
    with open_atlas(path) as dataset:
        try:
            yield dataset
        except RuntimeError as problem:
            # the block may read several files: the error belongs to this one only if this one is damaged
            if _damaged(dataset):
                raise _damage(dataset, problem) from problem
            raise


def loaded(dataset: "xr.Dataset") -> "xr.Dataset":
    """Return a dataset whose values are in memory.

    Raises
    ------
    RequestError
        If some of them cannot be read, naming the variables.
    """
    try:
        return dataset.load()
    except RuntimeError as problem:
        raise _damage(dataset, problem) from problem


def _damaged(dataset: "xr.Dataset") -> list[str]:
    found = []
    for name, variable in dataset.variables.items():
        try:
            variable.copy(deep=False).load()
        except RuntimeError:
            found.append(str(name))
    return found


def _damage(dataset: "xr.Dataset", problem: Exception) -> RequestError:
    return RequestError(
        f"The file is damaged: {', '.join(_damaged(dataset))} cannot be read ({problem}).",
        hint="Make it again with eulerdisk run, or take a copy that is whole.",
        where=place_of(dataset),
    )


def _check_format(dataset: "xr.Dataset", path: Path) -> None:
    known = dataset.attrs.get("eulerdisk_format")
    try:
        version = int(str(known) if "sweep_spec" in dataset.attrs else "")
    except (TypeError, ValueError):
        raise RequestError(
            "This is not a stability atlas, which has the attributes eulerdisk_format, a number, and sweep_spec; got a "
            f"netCDF file titled {dataset.attrs.get('title', '(no title)')!r}.",
            hint="Give a file made by eulerdisk run.",
            where=str(path),
        ) from None
    if version > FORMAT:
        raise RequestError(
            f"The atlas is newer than this program, which reads formats up to {FORMAT}; got format {version}.",
            hint="Update eulerdisk.",
            where=str(path),
        )
    require(dataset, ("ending", "stability", *spec_named(dataset).model.extremes), str(path))
