"""Atlases and motions in other formats: tables of cells or samples (csv, parquet), and zarr.

A format is an entry in `FORMATS`; no other code depends on which formats there are.
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

#: Rows of a table that are in memory at a time.
_ROWS = 250_000


class Format(NamedTuple):
    """A format that atlases are exported to."""

    #: Writes an atlas; what is at the path appears only when it is complete.
    write: Callable[["xr.Dataset", Path], None]
    #: The distribution that the format needs beside those that are always installed.
    distribution: str | None = None
    #: Refuses a target that cannot be written, or that must not be replaced unless the second argument says so.
    check: Callable[[Path, bool], None] = check_target
    #: Returns the name of a second file, which some atlases have.
    beside: Callable[[Path], Path] | None = None


def export(dataset: "xr.Dataset", path: str | Path, kind: str, *, overwrite: bool = False) -> list[Path]:
    """Write an atlas or a motion in another format; what is at `path` appears only when it is complete.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas, or a motion: its table has one row for each sample.
    path : str or Path
        The file, or for zarr the folder.
    kind : str
        A key of `FORMATS`. A table (csv, parquet) has one row for each cell: the parameters, the measures in SI, flags
        as words. Parquet has the boundaries of the cell's row too, but no curves, and keeps units and attributes in its
        metadata. Beside a csv is another one, ``NAME.boundary.csv``, if the atlas has a boundary: see
        `sweep.atlas.boundary_rows`.
    overwrite : bool
        Replace what is there.

    Returns
    -------
    list of Path
        What was written: `path`, and the file with the boundary if there is one.

    Raises
    ------
    RequestError
        If the format is unknown or its library missing, or the target cannot be written.
    StorageError
        If the file system refuses.
    """
    path = Path(path)
    if kind not in FORMATS:
        raise RequestError(
            f"There is no format {shown(kind)}; the formats are {', '.join(FORMATS)}.",
            hint="Choose one of them.",
            where="--to",
        )
    chosen = FORMATS[kind]
    if chosen.distribution is not None and find_spec(chosen.distribution) is None:
        ready = [name for name, each in FORMATS.items() if each.distribution is None]
        raise RequestError(
            f"The format {kind} needs the package {chosen.distribution}, which is not installed; {', '.join(ready)} "
            "needs nothing more.",
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
            # every digit, so that the number read is the number written
            table.to_csv(unfinished, mode="a" if i else "w", header=not i, index=False)
    # one that is there belongs to what has been replaced
    if rows or boundary_file(path).exists():
        with published(boundary_file(path)) as unfinished:
            unfinished.write_text(as_csv(rows), encoding="ascii")


def _check_csv(path: Path, overwrite: bool) -> None:
    check_target(path, overwrite)
    check_target(boundary_file(path), overwrite)


def boundary_file(path: Path) -> Path:
    """Return the file beside a table of cells that has the boundary: ``atlas.boundary.csv``."""
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
            "Nothing is written, because the folder exists; what exists is not replaced by accident.",
            hint="To replace it, add --overwrite (in Python overwrite=True).",
            where=str(path),
        )
    elif any(path.iterdir()) and not any((path / name).exists() for name in (".zgroup", "zarr.json")):
        raise RequestError(
            "This folder is not a zarr store, and only a zarr store is replaced by one.",
            hint="Give another name.",
            where=str(path),
        )


def _write_zarr(dataset: "xr.Dataset", path: Path) -> None:
    # values are read as they are written
    with published_folder(path) as unfinished, damage_named(dataset):
        # format 2: every reader of zarr knows it, and its consolidated metadata are part of it
        dataset.drop_encoding().to_zarr(unfinished, mode="w", zarr_format=2, consolidated=True)


#: Name of the format -> the format.
FORMATS = {
    "csv": Format(_write_csv, check=_check_csv, beside=boundary_file),
    "parquet": Format(_write_parquet, "pyarrow"),
    "zarr": Format(_write_zarr, "zarr", _check_zarr),
}


def _tables(dataset: "xr.Dataset") -> Iterator["pd.DataFrame"]:
    """Yield the cells in C order, or the samples of a motion, some rows at a time; flags are words."""
    import numpy as np

    dataset = without_curves(dataset)
    # a motion has one ending
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
        # pandas makes a table only of what has a dimension
        axes, dataset = ["cell"], dataset.expand_dims("cell")
    rows = dataset.sizes[axes[0]]
    step = max(1, _ROWS * rows // max(1, math.prod(dataset.sizes[name] for name in axes)))
    for start in range(0, rows, step):
        part = loaded(dataset.isel({axes[0]: slice(start, start + step)}))
        table = part.to_dataframe(dim_order=axes).reset_index()
        for name, words in meanings.items():
            table[name] = table[name].map(words).astype(str)
        yield table[order]
