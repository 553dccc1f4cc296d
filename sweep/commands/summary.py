"""The output of `info --json` and `boundary --to json`: an atlas as plain values in SI units."""

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from sweep.atlas.boundary_rows import boundary_rows, curve_rows
from sweep.atlas.cf_metadata import edge_names, read_texts
from sweep.atlas.dataset import edge_status, found_edges, require, spec_of
from sweep.atlas.row_edges import ROW_STATUS
from sweep.atlas.share import unstable_share
from sweep.errors import plain_text
from sweep.model.quantity import Quantity
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr


def summary(dataset: "xr.Dataset") -> dict[str, Any]:
    """Describe an atlas: its grid, how it was made, how its cells ended, and where the boundary lies."""
    spec = spec_of(dataset)
    model = spec.model
    require(dataset, (model.peak, model.error_name))
    return {
        "title": plain_text(dataset.attrs.get("title", "")),
        "model": model.name,
        "cells": spec.size,
        "axes": [_axis(spec, name) for name in spec.axes],
        "fixed": {name: _with_units(getattr(spec, name), model.parameters[name]) for name in spec.fixed},
        "listed": {name: str(getattr(spec, name)) for name in spec.listed},
        "unstable_share": _share(dataset) if spec.is_list else None,
        "computed_per_cell": {name: getattr(spec, name) for name in spec.computed},
        "criterion": str(spec.criterion),
        "unstable_if": spec.criterion.unstable_if(model),
        "method": spec.method,
        "settings": {
            name: _with_units(getattr(spec, name), quantity) for name, quantity in model.settings.items()
        },
        "endings": _counts(dataset["ending"], model.variables["ending"]),
        "verdicts": _counts(dataset["stability"], model.variables["stability"]),
        model.peak: _extent(dataset[model.peak]),
        "added": {
            name: _counts(dataset[name], quantity) if quantity.flags else _extent(dataset[name])
            for name, quantity in model.cell_variables(spec).items()
            if name not in model.variables and name in dataset
        },
        "largest_error": {model.error_name: _extent(dataset[model.error_name])["largest"]},
        "boundary": [_edge(dataset, axis, edge) for axis, edge in found_edges(dataset, spec)],
        "curves": int(dataset["curve_closed"].values.size) if "curve_closed" in dataset else 0,
        "history": plain_text(dataset.attrs.get("history", "")).split("\n"),
        "requested_as": dict(spec.requested),
        "source": str(dataset.attrs.get("source", "")),
        "license": str(dataset.attrs.get("license", "")),
        "citation": str(dataset.attrs.get("citation", "")),
        "versions": read_texts(dataset.attrs.get("versions")) or {},
        "kernel_hash": str(dataset.attrs.get("kernel_hash", "")),
        "sweep_fingerprint": str(dataset.attrs.get("sweep_fingerprint", "")),
        "sweep_spec": json.loads(spec.canonical()),
    }


def _share(dataset: "xr.Dataset") -> dict[str, Any]:
    share = unstable_share(dataset)
    value = share.value if share.decided else None
    return {**vars(share), "value": value, "interval": list(share.interval), "confidence": 0.95}


def boundary(dataset: "xr.Dataset") -> dict[str, Any]:
    """Return the rows of the boundary, the points of its curves, and the units of both."""
    spec = spec_of(dataset)
    units = {name: spec.quantities[name].units for name in spec.axes}
    return {
        "criterion": str(spec.criterion),
        "units": units,
        "rows": boundary_rows(dataset),
        "curves": curve_rows(dataset),
    }


def as_json(values: dict[str, Any]) -> str:
    """Return plain values as JSON; a NaN or infinity among them is an error."""
    return json.dumps(values, indent=1, allow_nan=False)


def _axis(spec: SweepSpec, name: str) -> dict[str, Any]:
    axis = getattr(spec, name)
    first, last = axis.ends().tolist()
    spacing = getattr(axis, "spacing", "listed")
    units = spec.quantities[name].units
    return {
        "name": name,
        "units": units,
        "count": len(axis),
        "first": first,
        "last": last,
        "spacing": spacing,
    }


def _with_units(value: float | str, quantity: Quantity) -> dict[str, Any]:
    return {"value": value} if isinstance(value, str) else {"value": value, "units": quantity.units}


def _counts(variable: "xr.DataArray | xr.Variable", quantity: Quantity) -> dict[str, int]:
    codes, counts = np.unique(variable.values, return_counts=True)
    numbers = dict(zip(codes.tolist(), counts.tolist(), strict=True))
    return {word: numbers.get(code, 0) for code, word in (quantity.flags or {}).items()}


def _extent(variable: "xr.DataArray | xr.Variable") -> dict[str, Any]:
    known = variable.values[np.isfinite(variable.values)].astype(np.float64)
    units = str(variable.attrs.get("units", "1"))
    if not known.size:
        return {"smallest": None, "largest": None, "units": units}
    return {"smallest": float(known.min()), "largest": float(known.max()), "units": units}


def _edge(dataset: "xr.Dataset", axis: str, edge: str) -> dict[str, Any]:
    measured, halfwidth, _, _ = edge_names(axis, edge)
    codes, counts = np.unique(edge_status(dataset, axis, edge), return_counts=True)
    return {
        "along": axis,
        "edge": edge,
        **_extent(dataset[measured]),
        "largest_halfwidth": _extent(dataset[halfwidth])["largest"],
        "rows": {
            ROW_STATUS[code]: count for code, count in zip(codes.tolist(), counts.tolist(), strict=True)
        },
    }
