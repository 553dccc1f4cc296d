"""Atlases on disk: a file at its final name is complete, whatever happens while it is written."""

import contextlib
import os
import shutil
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sweep import atlas
from sweep.atlas import Declaration
from sweep.blocks import BLOCK_CELLS, Span, chunk_shape, chunks
from sweep.boundary import edges
from sweep.errors import RequestError
from sweep.filenames import check_atlas
from sweep.runner import Block, Columns, run_blocks
from sweep.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr

#: Called with the cells computed so far and the cells in all.
Progress = Callable[[int, int], None]

#: An atlas compresses to about this share (measured on the presets: 0.55 to 0.75).
_SHARE_ON_DISK = 0.8


def run_to_file(
    spec: SweepSpec,
    path: str | Path,
    *,
    overwrite: bool = False,
    threads: int | None = None,
    block_cells: int = BLOCK_CELLS,
    command: str = "sweep.run_to_file",
    progress: Progress | None = None,
) -> None:
    """Compute the atlas of a spec and write it to one netCDF file, a block at a time.

    Parameters
    ----------
    spec : SweepSpec
    path : str or Path
        The file; it appears only when it is complete.
    overwrite : bool
        Replace an existing file, at the very end.
    threads, block_cells
        As in `atlas.run`.
    command : str
        What the user ran, for the history.
    progress : callable, optional
        Called with (cells done, cells in all) after every block.

    Raises
    ------
    RequestError
        If the file exists, its folder does not or cannot be written, or the disk has not enough room; nothing has been
        touched then.
    """
    path = Path(path)
    check_target(path, overwrite, spec.size * _cell_bytes(spec))
    blocks = run_blocks(spec, threads=threads, block_cells=block_cells)
    with published(path) as unfinished:
        _write(spec, unfinished, _reporting(blocks, spec.size, progress), command)


def save(dataset: "xr.Dataset", path: str | Path, *, overwrite: bool = False) -> None:
    """Write an atlas that is in memory; the file appears only when it is complete.

    Raises
    ------
    RequestError
        As in `run_to_file`.
    """
    path = Path(path)
    check_target(path, overwrite, dataset.nbytes)
    # xarray gives every float a fill value, and forgets on reading that coordinates had none
    unfilled = {name: {"_FillValue": None} for name in dataset.coords}
    with published(path) as unfinished:
        dataset.to_netcdf(unfinished, format="NETCDF4_CLASSIC", engine="netcdf4", encoding=unfilled)


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
            "not a readable netCDF file",
            "an atlas is a netCDF-4 file, whole",
            f"{path.stat().st_size} bytes: {problem}",
            "make it again with eulerdisk run",
            str(path),
        ) from problem
    try:
        _check_format(dataset, path)
    except RequestError:
        dataset.close()
        raise
    return dataset


def check_target(path: Path, overwrite: bool, size: float) -> None:
    """Refuse a file that could not be written in the end.

    Parameters
    ----------
    path : Path
    overwrite : bool
        Whether the file may exist already.
    size : float
        Bytes needed.

    Raises
    ------
    RequestError
    """
    where, folder = str(path), path.parent
    # os.path, because a pathlib.Path raises where it may not look, or where the name is too long
    if not os.path.isdir(folder):
        raise RequestError(
            "no such folder", "the output's folder exists", str(folder), f"mkdir -p {folder}", where
        )
    exists = os.path.exists(path)
    if exists and not os.path.isfile(path):
        raise RequestError("not a file", "the output is a file", where, "give a file name", where)
    if exists and not overwrite:
        raise RequestError(
            "the file exists", "a finished atlas is not replaced by accident", where, "add --overwrite", where
        )
    if not os.access(folder, os.W_OK | os.X_OK):
        raise RequestError(
            "the folder cannot be written",
            "the output's folder is writable",
            str(folder),
            "choose another",
            where,
        )
    free = shutil.disk_usage(folder).free
    if size * _SHARE_ON_DISK > free:
        raise RequestError(
            "the atlas does not fit on the disk",
            f"about {size * _SHARE_ON_DISK / 1e6:.0f} MB are free for it",
            f"{free / 1e6:.0f} MB free in {folder.resolve()}",
            "use fewer cells or another disk",
            where,
        )


@contextlib.contextmanager
def published(path: Path) -> Iterator[Path]:
    """Give a temporary name beside `path`; what was written there gets the final name when the block ends well.

    Raises RequestError where the file system refuses; of a full disk netCDF only says "HDF error".
    """
    unfinished = path.with_name(f".{path.name}.unfinished-{os.getpid()}")
    try:
        yield unfinished
        with open(unfinished, "rb+") as file:
            os.fsync(file.fileno())
        os.replace(unfinished, path)
        _sync_folder(path.parent)
    except (OSError, RuntimeError) as problem:
        if isinstance(problem, RuntimeError) and "NetCDF" not in str(problem):
            raise
        raise RequestError(
            "the file could not be written",
            "the folder takes a new file of this name, and the disk has room for it to the end",
            f"{problem}; {shutil.disk_usage(path.parent).free / 1e6:.0f} MB are free",
            "free some space, or give another name or folder",
            str(path),
        ) from problem
    finally:
        if os.path.exists(unfinished):
            unfinished.unlink()


def _sync_folder(folder: Path) -> None:
    # the new name itself must survive a power cut; some file systems cannot open a folder
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _cell_bytes(spec: SweepSpec) -> int:
    return sum(np.dtype(each.dtype).itemsize for each in atlas.cell_declarations(spec))


def _reporting(blocks: Iterable[Block], size: int, progress: Progress | None) -> Iterator[Block]:
    for block in blocks:
        # before the block is handed on: nobody asks for another one after the last
        if progress is not None:
            progress(block.span.stop, size)
        yield block


def _write(spec: SweepSpec, path: Path, blocks: Iterable[Block], command: str) -> None:
    import netCDF4

    declared = atlas.cell_declarations(spec)
    stability = np.zeros(spec.shape, np.int8)
    with netCDF4.Dataset(path, "w", format="NETCDF4_CLASSIC") as file:
        file.setncatts(atlas.global_attributes(spec, command))
        for name, count in zip(spec.axes, spec.shape, strict=True):
            file.createDimension(name, count)
        for coordinate, values in atlas.coordinates(spec):
            _declare(file, coordinate, None)[...] = values
        variables = {each.name: _declare(file, each, chunk_shape(spec.shape)) for each in declared}
        spans = list(chunks(spec.shape))
        for (_, slices), columns in zip(spans, gather(blocks, [span for span, _ in spans]), strict=True):
            shape = tuple(part.stop - part.start for part in slices)
            stability[slices] = columns["stability"].reshape(shape)
            for each in declared:
                variables[each.name][slices] = _filled(each, columns[each.name]).reshape(shape)
        for (axis, edge), line in edges(spec, stability).items():
            for each, values in zip(
                atlas.edge_declarations(spec, axis, edge), atlas.edge_values(line), strict=True
            ):
                _declare(file, each, None)[...] = _filled(each, values)


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
        packed = {"zlib": True, "complevel": atlas.COMPRESSION, "shuffle": True, "chunksizes": chunk}
    variable = file.createVariable(
        declared.name, declared.dtype, declared.dims, fill_value=declared.fill, **packed
    )
    variable.set_auto_maskandscale(False)
    variable.setncatts(declared.attributes)
    return variable


def _filled(declared: Declaration, values: Any) -> Any:
    return values if declared.fill is None else np.where(np.isnan(values), declared.fill, values)


def _check_format(dataset: "xr.Dataset", path: Path) -> None:
    known = dataset.attrs.get("eulerdisk_format")
    if known is None or "sweep_spec" not in dataset.attrs:
        raise RequestError(
            "not a stability atlas",
            "an atlas has the attributes eulerdisk_format and sweep_spec",
            f"a netCDF file titled {dataset.attrs.get('title', '(no title)')!r}",
            "give a file made by eulerdisk run",
            str(path),
        )
    if int(known) > atlas.FORMAT:
        raise RequestError(
            "the atlas is newer than this program",
            f"formats up to {atlas.FORMAT} are known",
            f"format {int(known)}",
            "update eulerdisk",
            str(path),
        )
    missing = [name for name in ("ending", "tilt_min", "tilt_max") if name not in dataset]
    if missing:
        raise RequestError(
            "an atlas without its measures",
            "an atlas has ending, tilt_min and tilt_max",
            f"missing: {', '.join(missing)}",
            "make it again with eulerdisk run",
            str(path),
        )
