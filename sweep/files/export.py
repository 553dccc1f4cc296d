"""Atlases and motions in other formats: tables of cells or samples (csv, parquet), and zarr.

Each format is an entry in `FORMATS`; no other code depends on the list of formats.
"""

import contextlib
import math
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from sweep.atlas.boundary_rows import as_csv, boundary_rows, curve_rows
from sweep.atlas.completion import without_boundary
from sweep.atlas.curves import without_curves
from sweep.atlas.selection import is_atlas
from sweep.errors import RequestError, shown
from sweep.files.paths import check_target
from sweep.files.publish import published, published_folder
from sweep.files.reading import damage_named, loaded

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

#: Number of rows of a table in memory at a time.
_ROWS = 250_000


class Format(NamedTuple):
    """An export format."""

    #: Writes an atlas; the file appears only when it is complete.
    write: Callable[["xr.Dataset", Path], None]
    #: The distribution that the format needs in addition to those always installed.
    distribution: str | None = None
    #: Refuses a target that cannot be written, or that exists if the second argument (overwrite) is false.
    check: Callable[[Path, bool], None] = check_target
    #: Returns the path of a second file, which some atlases need.
    beside: Callable[[Path], Path] | None = None


def export(dataset: "xr.Dataset", path: str | Path, kind: str, *, overwrite: bool = False) -> list[Path]:
    """Write an atlas or a motion in another format; the file or folder appears only when it is complete.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas, or a motion, whose table has one row for each sample.
    path : str or Path
        The file, or the folder for zarr.
    kind : str
        A key of `FORMATS`. A table (csv, parquet) has one row for each cell: parameters, measures in SI, and flags as
        words. Parquet also has the boundaries of the cell's row, but no curves; its metadata has the units and
        attributes. For csv, the boundary goes to a second file ``NAME.boundary.csv`` if the atlas has one; see
        `sweep.atlas.boundary_rows`.
    overwrite : bool
        Replace an existing file or folder.

    Returns
    -------
    list of Path
        The paths written: `path`, and the file with the boundary if there is one.

    Raises
    ------
    RequestError
        If the format is unknown, its library is missing, or the target cannot be written.
    StorageError
        If the file system fails.
    """
    path = Path(path)
    if kind not in FORMATS:
        raise RequestError(
            f"Unknown format {shown(kind)}; the formats are {', '.join(FORMATS)}.",
            hint="Choose one of these formats.",
            where="--to",
        )
    chosen = FORMATS[kind]
    if chosen.distribution is not None and find_spec(chosen.distribution) is None:
        ready = [name for name, each in FORMATS.items() if each.distribution is None]
        raise RequestError(
            f"The format {kind} needs the package {chosen.distribution}, which is not installed; {', '.join(ready)} "
            "needs no other package.",
            hint=f"Run `pip install {chosen.distribution}`, or choose another format.",
            where="--to",
        )
    chosen.check(path, overwrite)
    chosen.write(dataset, path)
    beside = [] if chosen.beside is None else [chosen.beside(path)]
    return [path, *(each for each in beside if each.exists())]


def _write_csv(dataset: "xr.Dataset", path: Path) -> None:
    of_cells = is_atlas(dataset)
    rows = (boundary_rows(dataset) or curve_rows(dataset)) if of_cells else []
    with published(path) as unfinished:
        for i, table in enumerate(_tables(without_boundary(dataset) if of_cells else dataset)):
            # pandas writes every digit, so that reading gives the same numbers
            table.to_csv(unfinished, mode="a" if i else "w", header=not i, index=False)
    # an existing boundary file belongs to the replaced table, so it is overwritten even without rows
    if rows or boundary_file(path).exists():
        with published(boundary_file(path)) as unfinished:
            unfinished.write_text(as_csv(rows), encoding="ascii")


def _check_csv(path: Path, overwrite: bool) -> None:
    check_target(path, overwrite)
    check_target(boundary_file(path), overwrite)


def boundary_file(path: Path) -> Path:
    """Return the path of the boundary file next to a table of cells: ``atlas.boundary.csv``."""
    return path.parent / f"{path.stem}.boundary{path.suffix}"


def _write_parquet(dataset: "xr.Dataset", path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    with published(path) as unfinished, contextlib.ExitStack() as stack:
        writer: Any = None
        for table in _tables(dataset):
            columns = pa.Table.from_pandas(table, preserve_index=False)
            if writer is None:
                schema = columns.schema.with_metadata(_as_text(dataset.attrs))
                for i, each in enumerate(schema):
                    schema = schema.set(i, each.with_metadata(_as_text(dataset[each.name].attrs)))
                writer = stack.enter_context(pq.ParquetWriter(unfinished, schema))
            writer.write_table(columns.cast(schema))


def _as_text(attributes: dict[Any, Any]) -> dict[str, str]:
    return {str(key): str(value) for key, value in attributes.items()}


def _check_zarr(path: Path, overwrite: bool) -> None:
    if not path.is_dir():
        check_target(path, False)
    elif not overwrite:
        raise RequestError(
            "Nothing was written, because the folder exists; existing data is not replaced by accident.",
            hint="To replace it, add --overwrite (in Python overwrite=True).",
            where=str(path),
        )
    elif any(path.iterdir()) and not any((path / name).exists() for name in (".zgroup", "zarr.json")):
        raise RequestError(
            "This folder is not a zarr store, and --overwrite replaces only zarr stores.",
            hint="Give another name.",
            where=str(path),
        )


def _write_zarr(dataset: "xr.Dataset", path: Path) -> None:
    # values are read lazily while they are written, so damage shows here
    with published_folder(path) as unfinished, damage_named(dataset):
        # format 2: every zarr reader supports it, and consolidated metadata are part of the format
        dataset.drop_encoding().to_zarr(unfinished, mode="w", zarr_format=2, consolidated=True)


#: Formats by name.
FORMATS = {
    "csv": Format(_write_csv, check=_check_csv, beside=boundary_file),
    "parquet": Format(_write_parquet, "pyarrow"),
    "zarr": Format(_write_zarr, "zarr", _check_zarr),
}


def _tables(dataset: "xr.Dataset") -> Iterator["pd.DataFrame"]:
    """Yield the cells in C order, or the samples of a motion, as tables of some rows; flags are words."""
    import numpy as np

    dataset = without_curves(dataset)
    # the ending of a motion is a scalar
    axes = [str(name) for name in dataset["ending"].dims or dataset.dims]
    meanings = {
        str(name): dict(
            zip(
                np.atleast_1d(variable.attrs["flag_values"]).tolist(),
                variable.attrs["flag_meanings"].split(),
                strict=True,
            )
        )
        for name, variable in dataset.data_vars.items()
        if "flag_meanings" in variable.attrs
    }
    order = list(dict.fromkeys([*axes, *map(str, dataset.coords), *map(str, dataset.data_vars)]))
    if not axes:
        # pandas needs at least one dimension for a table
        axes, dataset = ["cell"], dataset.expand_dims("cell")
    rows = dataset.sizes[axes[0]]
    step = max(1, _ROWS * rows // max(1, math.prod(dataset.sizes[name] for name in axes)))
    for start in range(0, rows, step):
        part = loaded(dataset.isel({axes[0]: slice(start, start + step)}))
        table = part.to_dataframe(dim_order=axes).reset_index()
        for name, words in meanings.items():
            table[name] = table[name].map(words).astype(str)
        yield table[order]
