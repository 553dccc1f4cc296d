"""Atlases that are in memory, written to netCDF files."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from sweep.atlas.selection import BETWEEN, as_atlas, attributes_of, require_atlas
from sweep.errors import RequestError, as_path, shown
from sweep.files.one_thread import netcdf_to_itself
from sweep.files.paths import check_target
from sweep.files.publish import FILE_SHARE, check_room, published
from sweep.request.criterion import Criterion

if TYPE_CHECKING:
    import xarray as xr

#: Bytes of a file without its data, at most: attributes, and 4 kB for each of 50 variables.
_HEADER_BYTES = 3e5


def save(dataset: "xr.Dataset", path: str | Path, *, overwrite: bool = False) -> None:
    """Write an atlas that is in memory, or a selection from one; the file appears only when it is complete.

    The spec, the boundary and the attributes in the file are those of the selection (`sweep.Eulerdisk.atlas`).

    Raises
    ------
    RequestError
        If the file exists, its folder does not or cannot be written, the disk has not enough room, the dataset holds
        what netCDF does not, a function has judged its cells, or it came from an atlas and no command would read it;
        nothing has been touched then.
    StorageError
        If the file system refuses.
    """
    _check_kind(dataset)
    path, dataset = as_path(path), _rechunked(as_atlas(dataset))
    _check_criterion(dataset, path)
    check_target(path, overwrite)
    needed = dataset.nbytes * FILE_SHARE
    check_room(path, needed)
    # xarray gives every float variable a fill value, also coordinates that were read from a file without one
    unfilled = {name: {"_FillValue": None} for name in dataset.coords}
    # room is reserved, because HDF5 may end the process if a file may not become as large as it wants
    with published(path, needed + _HEADER_BYTES) as unfinished:
        try:
            with netcdf_to_itself(by_xarray=True):
                dataset.to_netcdf(unfinished, format="NETCDF4_CLASSIC", engine="netcdf4", encoding=unfilled)
        except (OSError, TypeError, ValueError) as problem:
            # an attribute of another program, or the caller's own; the errors of the system have a number
            if getattr(problem, "errno", None) is not None:
                raise
            raise RequestError(
                f"The dataset holds what no file of the netCDF classic model can: {shown(str(problem))}.",
                hint="Take away the attribute or variable that is named.",
                where=str(path),
            ) from problem


def _check_kind(dataset: Any) -> None:
    """Refuse what came from an atlas and is none: its file would be opened by no command."""
    attributes = attributes_of(dataset)
    between = str(attributes.get("title", "")).startswith(BETWEEN)
    # an audit states the spec of its atlas too
    stated = "sweep_spec" in attributes and "audit" not in dataset
    if between or stated or isinstance(dataset, type) or not hasattr(dataset, "data_vars"):
        require_atlas(dataset)


def _check_criterion(dataset: "xr.Dataset", path: Path) -> None:
    """Refuse an atlas whose verdicts only a function in memory can give."""
    criterion = str(dataset.attrs.get("criterion", ""))
    if Criterion.named_function(criterion):
        raise RequestError(
            f"The {criterion} has judged these cells, and no file can state it: its verdicts could not be found again.",
            hint='Save the atlas as it was, or reclassify with an expression, as in "peak_tilt > 10deg".',
            where=str(path),
        )


def _rechunked(dataset: "xr.Dataset") -> "xr.Dataset":
    """Return a dataset without the chunks of variables that have become smaller than one since they were read."""
    found = dataset.copy()
    for variable in found.variables.values():
        chunks = variable.encoding.get("chunksizes") or ()
        if len(chunks) != variable.ndim or any(
            chunk > size for chunk, size in zip(chunks, variable.shape, strict=True)
        ):
            variable.encoding.pop("chunksizes", None)
    return found
