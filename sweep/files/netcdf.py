"""Atlases in netCDF files: written chunk by chunk or from memory, opened lazily, refused with the reason."""

import contextlib
import errno
import math
import warnings
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, NoReturn, Self

import numpy as np
import numpy.typing as npt

from sweep.atlas.cf_metadata import COMPRESSION, FORMAT, Declaration, cell_declarations, coordinates
from sweep.atlas.dataset import place_of, require, spec_named
from sweep.atlas.structure import check_structure, known_names, strangers
from sweep.engine.compute import Block
from sweep.engine.estimate import FILE_SHARE, check_room
from sweep.engine.grid import Span, chunk_shape, chunks
from sweep.errors import LeftOutWarning, RequestError, printable, shown
from sweep.files.paths import check_atlas, check_target
from sweep.files.publish import published
from sweep.files.trial import check_opens
from sweep.model.description import Columns
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr

#: Bytes of netCDF's chunk cache for one variable. Chunks are written and read whole, one after the other: netCDF's
#: default, 16 MB for every variable, would hold chunks that are never used again.
_CACHE_BYTES = 2**20

#: Values over file, in bytes, at most: deflate packs no more than 1032 bytes into one.
_MOST_PACKED = 1032

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
