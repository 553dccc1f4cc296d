"""Atlases in other formats: tables of cells (csv, parquet), and zarr."""

import contextlib
import os
import shutil
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sweep.atlas.curves import without_curves
from sweep.errors import RequestError
from sweep.files.reading import loaded
from sweep.files.store import check_target, published

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

#: Format -> the distribution that it needs beside those that are always there.
FORMATS = {"csv": None, "parquet": "pyarrow", "zarr": "zarr"}

#: Rows of a table that are in memory at a time.
_ROWS = 250_000


def export(dataset: "xr.Dataset", path: str | Path, kind: str, *, overwrite: bool = False) -> None:
    """Write an atlas in another format; what is at `path` appears only when it is complete.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas.
    path : str or Path
        The file, or for zarr the folder.
    kind : {"csv", "parquet", "zarr"}
        A table has one row for each cell: the parameters, the measures in SI, flags as words, and the boundaries of the
        cell's row, but not the curves of a refined boundary. Parquet keeps units and attributes in its metadata; csv
        has none.
    overwrite : bool
        Replace what is there.

    Raises
    ------
    RequestError
        If the format is unknown or its library missing, or the target cannot be written.
    """
    path = Path(path)
    _check_kind(kind)
    if kind == "zarr":
        _check_folder(path, overwrite)
        _to_zarr(dataset, path)
        return
    check_target(path, overwrite)
    with published(path) as unfinished:
        (_to_csv if kind == "csv" else _to_parquet)(dataset, unfinished)


def _check_kind(kind: str) -> None:
    if kind not in FORMATS:
        raise RequestError(
            "unknown format", f"the formats are {', '.join(FORMATS)}", kind, "choose one of them", "--to"
        )
    needed = FORMATS[kind]
    if needed is not None and find_spec(needed) is None:
        raise RequestError(
            f"{kind} needs {needed}, which is not installed",
            "csv needs nothing more; parquet needs pyarrow, zarr needs zarr",
            f"--to {kind}",
            "pip install 'eulerdisk[formats]'",
        )


def _check_folder(path: Path, overwrite: bool) -> None:
    if path.is_dir() and overwrite and not _is_zarr(path):
        raise RequestError(
            "not a zarr store",
            "only a zarr store is replaced by one",
            str(path),
            "give another name",
            str(path),
        )
    if not path.is_dir():
        check_target(path, False)
    elif not overwrite:
        raise RequestError(
            "the folder exists",
            "what exists is not replaced by accident",
            str(path),
            "add --overwrite",
            str(path),
        )


def _is_zarr(path: Path) -> bool:
    return any((path / name).exists() for name in (".zgroup", "zarr.json")) or not any(path.iterdir())


def _to_zarr(dataset: "xr.Dataset", path: Path) -> None:
    unfinished = path.with_name(f".{path.name}.unfinished-{os.getpid()}")
    # format 2: every reader of zarr knows it, and its consolidated metadata are part of it
    packed = dataset.drop_encoding()
    try:
        packed.to_zarr(unfinished, mode="w", zarr_format=2, consolidated=True)
        if path.is_dir():
            shutil.rmtree(path)
        os.replace(unfinished, path)
    except OSError as problem:
        raise RequestError(
            "the folder could not be written",
            "there is room for it to the end",
            str(problem),
            "free some space, or give another name",
            str(path),
        ) from problem
    finally:
        if unfinished.exists():
            shutil.rmtree(unfinished)


def _to_csv(dataset: "xr.Dataset", path: Path) -> None:
    for i, table in enumerate(_tables(dataset)):
        # every digit, so that the number read is the number written
        table.to_csv(path, mode="a" if i else "w", header=not i, index=False)


def _to_parquet(dataset: "xr.Dataset", path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    with contextlib.ExitStack() as stack:
        writer: Any = None
        for table in _tables(dataset):
            columns = pa.Table.from_pandas(table, preserve_index=False)
            if writer is None:
                schema = _described(columns.schema, dataset)
                writer = stack.enter_context(pq.ParquetWriter(path, schema))
            writer.write_table(columns.cast(schema))


def _described(schema: Any, dataset: "xr.Dataset") -> Any:
    """Return a pyarrow schema with the attributes of the atlas and of each variable, as text."""
    for i, each in enumerate(schema):
        attributes = {str(key): str(value) for key, value in dataset[each.name].attrs.items()}
        schema = schema.set(i, each.with_metadata(attributes))
    return schema.with_metadata({str(key): str(value) for key, value in dataset.attrs.items()})


def _tables(dataset: "xr.Dataset") -> Iterator["pd.DataFrame"]:
    """Yield the cells in C order, some rows at a time; flags are words."""
    import numpy as np
    import pandas as pd

    dataset = without_curves(dataset)
    axes = [str(name) for name in dataset["ending"].dims]
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
    for part in _parts(dataset, axes):
        if axes:
            table = part.to_dataframe(dim_order=axes).reset_index()
        else:
            table = pd.DataFrame(
                {str(name): [variable.values[()]] for name, variable in part.variables.items()}
            )
        for name, words in meanings.items():
            table[name] = table[name].map(words).astype(str)
        yield table[order]


def _parts(dataset: "xr.Dataset", axes: list[str]) -> Iterator["xr.Dataset"]:
    if not axes:
        yield loaded(dataset)
        return
    step = max(1, _ROWS * dataset.sizes[axes[0]] // max(1, dataset["ending"].size))
    for start in range(0, dataset.sizes[axes[0]], step):
        yield loaded(dataset.isel({axes[0]: slice(start, start + step)}))
