"""Atlases in other formats: tables of cells (csv, parquet), and zarr.

A format is a subclass of `Format` and an entry in `FORMATS`; nothing else knows the formats.
"""

import contextlib
import os
import shutil
from abc import ABC, abstractmethod
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sweep.atlas.curves import without_curves
from sweep.errors import RequestError, shown
from sweep.files.netcdf import loaded
from sweep.files.paths import check_target
from sweep.files.publish import published

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

#: Rows of a table that are in memory at a time.
_ROWS = 250_000


class Format(ABC):
    """A format that atlases are exported to."""

    #: The distribution that the format needs beside those that are always installed.
    distribution: str | None = None

    def check(self, path: Path, overwrite: bool) -> None:
        """Refuse a target that cannot be written or must not be replaced, with a RequestError; here: a file."""
        check_target(path, overwrite)

    @abstractmethod
    def write(self, dataset: "xr.Dataset", path: Path) -> None:
        """Write the atlas; what is at `path` appears only when it is complete."""


def export(dataset: "xr.Dataset", path: str | Path, kind: str, *, overwrite: bool = False) -> None:
    """Write an atlas in another format; what is at `path` appears only when it is complete.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas.
    path : str or Path
        The file, or for zarr the folder.
    kind : str
        A key of `FORMATS`. A table (csv, parquet) has one row for each cell: the parameters, the measures in SI, flags
        as words, and the boundaries of the cell's row, but not the curves of a refined boundary. Parquet keeps units
        and attributes in its metadata; csv has none.
    overwrite : bool
        Replace what is there.

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
            hint="Run `pip install 'eulerdisk[formats]'`, or choose another format.",
            where="--to",
        )
    chosen.check(path, overwrite)
    chosen.write(dataset, path)


class _Csv(Format):
    def write(self, dataset: "xr.Dataset", path: Path) -> None:
        with published(path) as unfinished:
            for i, table in enumerate(_tables(dataset)):
                # every digit, so that the number read is the number written
                table.to_csv(unfinished, mode="a" if i else "w", header=not i, index=False)


class _Parquet(Format):
    distribution = "pyarrow"

    def write(self, dataset: "xr.Dataset", path: Path) -> None:
        import pyarrow as pa
        import pyarrow.parquet as pq

        with published(path) as unfinished, contextlib.ExitStack() as stack:
            writer: Any = None
            for table in _tables(dataset):
                columns = pa.Table.from_pandas(table, preserve_index=False)
                if writer is None:
                    schema = self._described(columns.schema, dataset)
                    writer = stack.enter_context(pq.ParquetWriter(unfinished, schema))
                writer.write_table(columns.cast(schema))

    def _described(self, schema: Any, dataset: "xr.Dataset") -> Any:
        """Return a pyarrow schema with the attributes of the atlas and of each variable, as text."""
        for i, each in enumerate(schema):
            attributes = {str(key): str(value) for key, value in dataset[each.name].attrs.items()}
            schema = schema.set(i, each.with_metadata(attributes))
        return schema.with_metadata({str(key): str(value) for key, value in dataset.attrs.items()})


class _Zarr(Format):
    distribution = "zarr"

    def check(self, path: Path, overwrite: bool) -> None:
        if not path.is_dir():
            check_target(path, False)
        elif not overwrite:
            raise RequestError(
                "Nothing is written, because the folder exists; what exists is not replaced by accident.",
                hint="To replace it, add --overwrite.",
                where=str(path),
            )
        elif any(path.iterdir()) and not any((path / name).exists() for name in (".zgroup", "zarr.json")):
            raise RequestError(
                "This folder is not a zarr store, and only a zarr store is replaced by one.",
                hint="Give another name.",
                where=str(path),
            )

    def write(self, dataset: "xr.Dataset", path: Path) -> None:
        unfinished = path.with_name(f".{path.name}.unfinished-{os.getpid()}")
        packed = dataset.drop_encoding()
        try:
            # format 2: every reader of zarr knows it, and its consolidated metadata are part of it
            packed.to_zarr(unfinished, mode="w", zarr_format=2, consolidated=True)
            if path.is_dir():
                shutil.rmtree(path)
            os.replace(unfinished, path)
        except OSError as problem:
            raise RequestError(
                f"The folder could not be written: {problem}.",
                hint="Free some space, or give another name.",
                where=str(path),
            ) from problem
        finally:
            if unfinished.exists():
                shutil.rmtree(unfinished)


#: Name of the format -> the format.
FORMATS: dict[str, Format] = {"csv": _Csv(), "parquet": _Parquet(), "zarr": _Zarr()}


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
    for part in _slices(dataset, axes):
        if axes:
            table = part.to_dataframe(dim_order=axes).reset_index()
        else:
            table = pd.DataFrame(
                {str(name): [variable.values[()]] for name, variable in part.variables.items()}
            )
        for name, words in meanings.items():
            table[name] = table[name].map(words).astype(str)
        yield table[order]


def _slices(dataset: "xr.Dataset", axes: list[str]) -> Iterator["xr.Dataset"]:
    """Yield consecutive slices along the first axis, each of about `_ROWS` cells, in memory."""
    if not axes:
        yield loaded(dataset)
        return
    step = max(1, _ROWS * dataset.sizes[axes[0]] // max(1, dataset["ending"].size))
    for start in range(0, dataset.sizes[axes[0]], step):
        yield loaded(dataset.isel({axes[0]: slice(start, start + step)}))
