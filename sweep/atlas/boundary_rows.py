"""The boundary of an atlas as a table for programs: one row per row of the grid."""

import csv
import io
from typing import TYPE_CHECKING, Any

import numpy as np

from sweep.atlas.cf_metadata import edge_names
from sweep.atlas.dataset import edge_status, found_edges, spec_of
from sweep.atlas.row_edges import ROW_STATUS

if TYPE_CHECKING:
    import xarray as xr

#: One row of a table: column -> value, None if missing.
Row = dict[str, Any]

#: Columns of an edge in addition to the axes, in the order of `edge_names`.
_VALUES = ("measured", "halfwidth", "predicted", "critical")


def boundary_rows(dataset: "xr.Dataset") -> list[Row]:
    """Return the rows of all edges of an atlas.

    Parameters
    ----------
    dataset : xarray.Dataset
        A whole atlas.

    Returns
    -------
    list of dict
        ``along`` (the parameter), ``edge`` (upper or lower), a value for each axis (None for `along`), ``measured``,
        ``halfwidth``, ``predicted``, ``critical`` [SI], None where they are missing, and ``status``.
    """
    spec, rows = spec_of(dataset), []
    for along, edge in found_edges(dataset, spec):
        names = edge_names(along, edge)
        others = [str(name) for name in dataset[names[0]].dims]
        shape = dataset[names[0]].shape
        values = [dataset[name].values.reshape(-1) for name in names]
        codes = edge_status(dataset, along, edge).reshape(-1).tolist()
        places = np.indices(shape).reshape(len(others), len(codes)).T
        coordinates = {name: dataset[name].values for name in others}
        for place, code, *found in zip(places, codes, *values, strict=True):
            where = {name: float(coordinates[name][i]) for name, i in zip(others, place, strict=True)}
            rows.append(
                {"along": along, "edge": edge}
                | {axis: where.get(axis) for axis in spec.axes}
                | {column: _number(value) for column, value in zip(_VALUES, found, strict=True)}
                | {"status": ROW_STATUS[code]}
            )
    return rows


def curve_rows(dataset: "xr.Dataset") -> list[Row]:
    """Return the points of the curves of a refined boundary; an empty list if there are no curves.

    Returns
    -------
    list of dict
        ``curve`` (from 1), ``closed``, and for each axis the position and its half-width [SI].
    """
    if "curve_point_count" not in dataset:
        return []
    spec = spec_of(dataset)
    numbers = np.repeat(np.arange(dataset["curve_closed"].values.size), dataset["curve_point_count"].values)
    closed = dataset["curve_closed"].values.astype(bool)
    names = [name for axis in spec.axes for name in (axis, f"{axis}_halfwidth")]
    columns = [dataset[f"curve_{name}"].values.tolist() for name in names]
    return [
        {"curve": number + 1, "closed": bool(closed[number])}
        | {name: _number(value) for name, value in zip(names, values, strict=True)}
        for number, *values in zip(numbers.tolist(), *columns, strict=True)
    ]


def as_csv(rows: list[Row]) -> str:
    """Return rows as CSV with a heading, with all digits of every number and empty fields for missing values.

    Without rows, return the heading for an atlas without axes.
    """
    text = io.StringIO()
    columns = list(rows[0]) if rows else ["along", "edge", *_VALUES, "status"]
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
