"""Saving atlases in memory to netCDF files."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from sweep.atlas.selection import INTERPOLATED, as_atlas, attributes_of, require_atlas
from sweep.errors import RequestError, as_path, shown
from sweep.files.one_thread import netcdf_to_itself
from sweep.files.paths import check_target
from sweep.files.publish import FILE_SHARE, check_room, published
from sweep.request.criterion import Criterion

if TYPE_CHECKING:
    import xarray as xr

#: Upper limit of the bytes of a file without its data: attributes, and 4 kB for each of 50 variables.
_HEADER_BYTES = 3e5


def save(dataset: "xr.Dataset", path: str | Path, *, overwrite: bool = False) -> None:
    """Write an atlas in memory, or a selection from one; the file appears only when it is complete.

    The spec, the boundary and the attributes in the file describe the selection (`sweep.Eulerdisk.atlas`).

    Raises
    ------
    RequestError
        If the file exists, the folder is missing or not writable, the disk has not enough room, netCDF cannot store
        the dataset, a function in memory judged the cells, or the dataset came from an atlas but is no longer one.
        Nothing has been written then.
    StorageError
        If the file system fails.
    """
    _check_kind(dataset)
    path, dataset = as_path(path), _rechunked(as_atlas(dataset))
    _check_criterion(dataset, path)
    check_target(path, overwrite)
    needed = dataset.nbytes * FILE_SHARE
    check_room(path, needed)
    # xarray would add a fill value to every float coordinate, even if it was read from a file without one
    unfilled = {name: {"_FillValue": None} for name in dataset.coords}
    # reserve room first: HDF5 may abort the process if the file cannot grow
    with published(path, needed + _HEADER_BYTES) as unfinished:
        try:
            with netcdf_to_itself(by_xarray=True):
                dataset.to_netcdf(unfinished, format="NETCDF4_CLASSIC", engine="netcdf4", encoding=unfilled)
        except (OSError, TypeError, ValueError) as problem:
            # caused by a foreign attribute or variable; errors of the system have a number
            if getattr(problem, "errno", None) is not None:
                raise
            raise RequestError(
                f"The netCDF classic model cannot store this dataset: {shown(str(problem))}.",
                hint="Remove the named attribute or variable.",
                where=str(path),
            ) from problem


def _check_kind(dataset: Any) -> None:
    """Refuse a dataset that came from an atlas but is no longer one: no command could open its file."""
    attributes = attributes_of(dataset)
    # an audit also has the spec of its atlas
    stated = "sweep_spec" in attributes and "audit" not in dataset
    if INTERPOLATED in attributes or stated or isinstance(dataset, type) or not hasattr(dataset, "data_vars"):
        require_atlas(dataset)


def _check_criterion(dataset: "xr.Dataset", path: Path) -> None:
    """Refuse an atlas whose verdicts come from a function in memory."""
    criterion = str(dataset.attrs.get("criterion", ""))
    if Criterion.named_function(criterion):
        raise RequestError(
            f"The {criterion} has judged these cells, but a file cannot store it: nobody could reproduce the verdicts.",
            hint='Save the original atlas, or reclassify with an expression such as "peak_tilt > 10deg".',
            where=str(path),
        )


def _rechunked(dataset: "xr.Dataset") -> "xr.Dataset":
    """Return a dataset without the chunk sizes of variables that are now smaller than a chunk."""
    found = dataset.copy()
    for variable in found.variables.values():
        chunks = variable.encoding.get("chunksizes") or ()
        if len(chunks) != variable.ndim or any(
            chunk > size for chunk, size in zip(chunks, variable.shape, strict=True)
        ):
            variable.encoding.pop("chunksizes", None)
    return found
