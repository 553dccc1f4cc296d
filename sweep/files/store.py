"""Atlases on disk: a file at its final name is complete, whatever happens while it is written."""

import contextlib
import errno
import os
import shlex
import zlib
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sweep.atlas import declarations
from sweep.atlas.dataset import boundaries
from sweep.atlas.declarations import Declaration
from sweep.engine.blocks import Span, chunk_shape, chunks
from sweep.engine.estimate import FILE_SHARE, check_room
from sweep.engine.runner import Block, Columns
from sweep.errors import RequestError
from sweep.files.publish import publish, refusals
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr


#: Bytes that netCDF holds of a variable: a chunk.
_CACHE_BYTES = 2**20


def save(dataset: "xr.Dataset", path: str | Path, *, overwrite: bool = False) -> None:
    """Write an atlas that is in memory; the file appears only when it is complete.

    Raises
    ------
    RequestError
        If the file exists, its folder does not or cannot be written, or the disk has not enough room; nothing has been
        touched then.
    """
    path = Path(path)
    check_target(path, overwrite)
    check_room(path, dataset.nbytes * FILE_SHARE)
    # xarray gives every float a fill value, and forgets on reading that coordinates had none
    unfilled = {name: {"_FillValue": None} for name in dataset.coords}
    with published(path) as unfinished:
        dataset.to_netcdf(unfinished, format="NETCDF4_CLASSIC", engine="netcdf4", encoding=unfilled)


def check_target(path: Path, overwrite: bool) -> None:
    """Refuse a file that could not be written in the end.

    Parameters
    ----------
    path : Path
    overwrite : bool
        Whether the file may exist already.

    Raises
    ------
    RequestError
    """
    where, folder = str(path), path.parent
    # os.path, because a pathlib.Path raises where it may not look, or where the name is too long
    if not os.path.isdir(folder):
        raise RequestError(
            "no such folder",
            "the output's folder exists",
            str(folder),
            f"`mkdir -p {shlex.quote(str(folder))}`",
            where,
        )
    exists = os.path.exists(path)
    if exists and not os.path.isfile(path):
        raise RequestError("not a file", "the output is a file", where, "give a file name", where)
    if exists and not overwrite:
        raise RequestError(
            "the file exists", "a finished file is not replaced by accident", where, "add --overwrite", where
        )
    if not os.access(folder, os.W_OK | os.X_OK):
        raise RequestError(
            "the folder cannot be written",
            "the output's folder is writable",
            str(folder),
            "choose another",
            where,
        )


def check_apart(target: Path, *sources: Path) -> None:
    """Refuse to write over what is being read: an atlas is not to be lost to something that was made of it.

    Raises
    ------
    RequestError
    """
    for source in sources:
        if os.path.exists(target) and os.path.samefile(target, source):
            raise RequestError(
                "this would replace the atlas that is read",
                "what is made of an atlas is another file",
                str(target),
                "give another name",
                str(target),
            )


@contextlib.contextmanager
def published(path: Path) -> Iterator[Path]:
    """Give a temporary name beside `path`; what was written there gets the final name when the block ends well.

    Raises StorageError where the file system refuses.
    """
    unfinished = path.with_name(f".{path.name}.unfinished-{os.getpid()}")
    try:
        with refusals(path):
            yield unfinished
            publish(unfinished, path)
    finally:
        if os.path.exists(unfinished):
            unfinished.unlink()


def write(spec: SweepSpec, path: Path, blocks: Iterable[Block], attributes: Mapping[str, Any]) -> None:
    """Write an atlas from its blocks, a chunk at a time, and check it by reading it again.

    Parameters
    ----------
    spec : SweepSpec
    path : Path
        Not the final name: until this returns, the file is not whole.
    blocks : iterable of Block
        All cells in C order.
    attributes : mapping
        The global attributes.

    Raises
    ------
    OSError, RuntimeError
        If the file system or netCDF refuses, or the file does not hold what was written.
    """
    import netCDF4

    declared = declarations.cell_declarations(spec)
    stability = np.zeros(spec.shape, np.int8)
    sums = dict.fromkeys((each.name for each in declared), 0)
    places = list(chunks(spec.shape))
    with netCDF4.Dataset(path, "w", format="NETCDF4_CLASSIC") as file:
        file.setncatts(dict(attributes))
        for name, count in zip(spec.axes, spec.shape, strict=True):
            file.createDimension(name, count)
        for coordinate, values in declarations.coordinates(spec):
            _declare(file, coordinate, None)[...] = values
        variables = {each.name: _declare(file, each, chunk_shape(spec.shape)) for each in declared}
        for (_, slices), columns in zip(places, gather(blocks, [span for span, _ in places]), strict=True):
            shape = tuple(part.stop - part.start for part in slices)
            stability[slices] = columns["stability"].reshape(shape)
            for each in declared:
                filled = _filled(each, columns[each.name]).reshape(shape)
                variables[each.name][slices] = filled
                sums[each.name] = zlib.crc32(filled.data, sums[each.name])
        for each, values in boundaries(spec, stability):
            for name, count in zip(each.dims, values.shape, strict=True):
                if name not in file.dimensions:
                    file.createDimension(name, count)
            _declare(file, each, None)[...] = _filled(each, values)
    _check_sums(path, [slices for _, slices in places], sums)


def _check_sums(path: Path, places: Iterable[tuple[slice, ...]], sums: Mapping[str, int]) -> None:
    import netCDF4

    found = dict.fromkeys(sums, 0)
    with netCDF4.Dataset(path) as file:
        file.set_auto_maskandscale(False)
        for name in found:
            if file[name].ndim:
                file[name].set_var_chunk_cache(size=_CACHE_BYTES)
        for slices in places:
            for name in found:
                found[name] = zlib.crc32(np.ascontiguousarray(file[name][slices]).data, found[name])
    wrong = [name for name in sums if found[name] != sums[name]]
    if wrong:
        raise OSError(errno.EIO, f"the file does not hold what was written: {', '.join(wrong)}")


def gather(blocks: Iterable[Block], spans: Iterable[Span]) -> Iterator[Columns]:
    """Regroup the columns of consecutive blocks by other consecutive spans of the same cells."""
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


def _declare(file: Any, declared: Declaration, chunk: tuple[int, ...] | None) -> Any:
    packed: dict[str, Any] = {}
    if chunk:
        packed = {"zlib": True, "complevel": declarations.COMPRESSION, "shuffle": True, "chunksizes": chunk}
    variable = file.createVariable(
        declared.name, declared.dtype, declared.dims, fill_value=declared.fill, **packed
    )
    variable.set_auto_maskandscale(False)
    if chunk:
        # chunks are written whole, one after the other: netCDF's 16 MB for every variable would hold nothing of use
        variable.set_var_chunk_cache(size=_CACHE_BYTES)
    variable.setncatts(declared.attributes)
    return variable


def _filled(declared: Declaration, values: Any) -> Any:
    return values if declared.fill is None else np.where(np.isnan(values), declared.fill, values)
