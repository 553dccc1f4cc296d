"""Atlases written to netCDF files: chunk by chunk, or from memory."""

import errno
import zlib
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import numpy.typing as npt

from sweep.atlas.cf_metadata import COMPRESSION, Declaration, cell_declarations, coordinates
from sweep.engine.compute import Block
from sweep.engine.estimate import FILE_SHARE, check_room
from sweep.engine.grid import Span, chunk_shape, chunks
from sweep.errors import RequestError, shown
from sweep.files.paths import check_target
from sweep.files.publish import published
from sweep.model.description import Columns
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr

#: Bytes of netCDF's chunk cache for one variable. Chunks are written and read whole, one after the other: netCDF's
#: default, 16 MB for every variable, would hold chunks that are never used again.
_CACHE_BYTES = 2**20

#: Bytes of a file without its data, at most: attributes, and 4 kB for each of 50 variables.
_HEADER_BYTES = 3e5


def save(dataset: "xr.Dataset", path: str | Path, *, overwrite: bool = False) -> None:
    """Write an atlas that is in memory; the file appears only when it is complete.

    Raises
    ------
    RequestError
        If the file exists, its folder does not or cannot be written, the disk has not enough room, or the dataset holds
        what netCDF does not; nothing has been touched then.
    StorageError
        If the file system refuses.
    """
    path, dataset = Path(path), _rechunked(dataset)
    check_target(path, overwrite)
    needed = dataset.nbytes * FILE_SHARE
    check_room(path, needed)
    # xarray gives every float variable a fill value, also coordinates that were read from a file without one
    unfilled = {name: {"_FillValue": None} for name in dataset.coords}
    # room is reserved, because HDF5 may end the process if a file may not become as large as it wants
    with published(path, needed + _HEADER_BYTES) as unfinished:
        try:
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


class AtlasWriter:
    """The netCDF file of an atlas while it is written: cells first, then the boundary; a context manager.

    When the ``with`` block ends without an error, the file is closed, and its cells are read again and compared with
    what was written. All netCDF calls have to be made in one thread.

    Parameters
    ----------
    path : Path
        A temporary name: until the ``with`` block has ended, the file is not complete.
    spec : SweepSpec
    attributes : mapping
        The global attributes.

    Raises
    ------
    OSError, RuntimeError
        From every method: if the file system or netCDF refuses, or the file does not hold what was written.
    """

    def __init__(self, path: Path, spec: SweepSpec, attributes: Mapping[str, Any]) -> None:
        # not at the top: a request that is refused before any file is opened need not wait for this import
        import netCDF4

        # absolute, because netCDF-C leaves out blanks at the begin of a name
        self._path, self._spec, self._attributes = path.absolute(), spec, dict(attributes)
        self._sums: dict[str, int] = {}
        self._file = netCDF4.Dataset(self._path, "w", format="NETCDF4_CLASSIC")

    def write_cells(self, blocks: Iterable[Block]) -> None:
        """Write the global attributes, the coordinates, and the variables with one value per cell, chunk by chunk.

        The order of the chunks depends on the grid alone, and so do the bytes of the file.

        Parameters
        ----------
        blocks : iterable of Block
            All cells in C order.
        """
        self._file.setncatts(self._attributes)
        for name, count in zip(self._spec.axes, self._spec.shape, strict=True):
            self._file.createDimension(name, count)
        for coordinate, values in coordinates(self._spec):
            self._declare(coordinate)[...] = values
        declared = cell_declarations(self._spec)
        self._sums = dict.fromkeys((each.name for each in declared), 0)
        variables = {each.name: self._declare(each, chunk_shape(self._spec.shape)) for each in declared}
        places = list(chunks(self._spec.shape))
        for (_, slices), columns in zip(places, regroup(blocks, [span for span, _ in places]), strict=True):
            shape = tuple(part.stop - part.start for part in slices)
            for each in declared:
                filled = _filled(each, columns[each.name]).reshape(shape)
                variables[each.name][slices] = filled
                self._sums[each.name] = zlib.crc32(filled.data, self._sums[each.name])

    def write_boundary(self, variables: Iterable[tuple[Declaration, npt.NDArray[Any]]]) -> None:
        """Write the variables of the boundary, with the dimensions that only they have."""
        for declared, values in variables:
            for name, count in zip(declared.dims, values.shape, strict=True):
                if name not in self._file.dimensions:
                    self._file.createDimension(name, count)
            self._declare(declared)[...] = _filled(declared, values)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, problem: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._file.close()
        if kind is None:
            self._check_sums()

    def _declare(self, declared: Declaration, chunk: tuple[int, ...] | None = None) -> Any:
        packed: dict[str, Any] = {}
        if chunk:
            packed = {"zlib": True, "complevel": COMPRESSION, "shuffle": True, "chunksizes": chunk}
        variable = self._file.createVariable(
            declared.name, declared.dtype, declared.dims, fill_value=declared.fill, **packed
        )
        variable.set_auto_maskandscale(False)
        if chunk:
            variable.set_var_chunk_cache(size=_CACHE_BYTES)
        variable.setncatts(declared.attributes)
        return variable

    def _check_sums(self) -> None:
        import netCDF4

        found = dict.fromkeys(self._sums, 0)
        with netCDF4.Dataset(self._path) as file:
            file.set_auto_maskandscale(False)
            for name in found:
                if file[name].ndim:
                    file[name].set_var_chunk_cache(size=_CACHE_BYTES)
            for _, slices in chunks(self._spec.shape):
                for name in found:
                    found[name] = zlib.crc32(np.ascontiguousarray(file[name][slices]).data, found[name])
        wrong = [name for name, sum_written in self._sums.items() if found[name] != sum_written]
        if wrong:
            raise OSError(errno.EIO, f"the file does not hold what was written: {', '.join(wrong)}")


def regroup(blocks: Iterable[Block], spans: Iterable[Span]) -> Iterator[Columns]:
    """Yield the columns of consecutive spans of cells, cut from consecutive blocks of the same cells."""
    stream, held = iter(blocks), list[Block]()
    for span in spans:
        while not held or held[-1].span.stop < span.stop:
            held.append(next(stream))
        yield {
            name: np.concatenate(
                [
                    each.columns[name][max(0, span.start - each.span.start) : span.stop - each.span.start]
                    for each in held
                ]
            )
            for name in held[0].columns
        }
        held = [each for each in held if each.span.stop > span.stop]


def _filled(declared: Declaration, values: Any) -> Any:
    return values if declared.fill is None else np.where(np.isnan(values), declared.fill, values)
