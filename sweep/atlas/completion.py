"""Restoration, from the spec and the verdicts, of parts of an atlas that other programs drop.

CDO writes no scalar variables, so the fixed parameters are lost; ``ncks -v`` and ``drop_vars`` drop variables on
request.
"""

import itertools
from typing import TYPE_CHECKING

import numpy as np

from sweep.atlas.cf_metadata import (
    CURVES,
    EDGES,
    POINTS,
    cell_declarations,
    created,
    edge_declarations,
    edge_quantities,
)
from sweep.atlas.dataset import as_variable, coordinates, edge_variables
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr

#: Prefixes of the variables that follow from the verdicts.
BOUNDARY = ("boundary_", "predicted_", "critical_", "curve_")


def is_complete(dataset: "xr.Dataset", spec: SweepSpec) -> bool:
    """Return whether an atlas of a spec has its fixed parameters and its boundary."""
    return not _lost_parameters(dataset, spec) and not _has_lost_boundary(dataset, spec)


def completed(dataset: "xr.Dataset", spec: SweepSpec) -> "xr.Dataset":
    """Restore the missing parts of an atlas from its spec and verdicts; return it unchanged if nothing is missing.

    Parameters
    ----------
    dataset : xarray.Dataset
        All cells of the spec, in its order.
    spec : SweepSpec
        The spec that the dataset states.

    Returns
    -------
    xarray.Dataset
        The atlas with the fixed parameters and the boundary. If a part of the boundary is missing, all of it is
        searched again (and bisected again if it was refined). `history` lists what was restored.
    """
    done = []
    if _has_lost_boundary(dataset, spec):
        edges = edge_variables(spec, np.asarray(dataset["stability"].values))
        dataset = without_boundary(dataset).assign(edges)
        done.append("boundary sought again from the verdicts")
    if lost := _lost_parameters(dataset, spec):
        dataset = _with_parameters(dataset, spec)
        done.append(f"{', '.join(lost)} taken from the spec")
    if not done:
        return dataset
    history = f"{dataset.attrs.get('history', '')}\n{created()} {'; '.join(done)}"
    return dataset.assign_attrs(history=history.lstrip("\n"))


def _with_parameters(dataset: "xr.Dataset", spec: SweepSpec) -> "xr.Dataset":
    """Restore the fixed parameters, the `coordinates` attributes that name them, and all attributes of the axes."""
    made = {each.name: as_variable(each, value, spec) for each, value in coordinates(spec)}
    lost = _lost_parameters(dataset, spec)
    found = dataset.assign_coords({name: made[name] for name in lost})
    for name in spec.axes:
        found[name].attrs = {**made[name].attrs, **found[name].attrs}
    edges = [edge_declarations(spec, axis, edge) for axis in spec.model.controls(spec.axes) for edge in EDGES]
    for declared in (*cell_declarations(spec), *itertools.chain.from_iterable(edges)):
        names = declared.attributes.get("coordinates")
        if names is not None and declared.name in found:
            found[declared.name].encoding = found[declared.name].encoding | {"coordinates": names}
    return found


def without_boundary(dataset: "xr.Dataset") -> "xr.Dataset":
    """Return a dataset without the variables that follow from the verdicts."""
    stale = [name for name in dataset.data_vars if str(name).startswith(BOUNDARY)]
    return dataset.drop_vars(stale).drop_dims([CURVES, POINTS], errors="ignore")


def _lost_parameters(dataset: "xr.Dataset", spec: SweepSpec) -> list[str]:
    """Return the fixed parameters that an atlas lacks."""
    return [name for name in spec.fixed if name not in dataset.variables]


def _has_lost_boundary(dataset: "xr.Dataset", spec: SweepSpec) -> bool:
    """Return whether an atlas lacks the upper edge along a control, which every grid has, or its curves."""
    if spec.is_list:
        return False
    lost = any(
        name not in dataset.variables
        for axis in spec.model.controls(spec.axes)
        for name in edge_quantities(spec.model, axis, "upper")
    )
    has_curves = spec.boundary_width is not None and len(spec.axes) > 1
    return lost or (has_curves and "curve_point_count" not in dataset.variables)
