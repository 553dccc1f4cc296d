"""Another criterion on a finished atlas, without integrating again: measures are stored, verdicts follow."""

from typing import TYPE_CHECKING

import numpy as np

from sweep import cells
from sweep.atlas import created, edge_variables, spec_of
from sweep.blocks import Span
from sweep.criterion import Criterion

if TYPE_CHECKING:
    import xarray as xr


def reclassify(dataset: "xr.Dataset", criterion: Criterion | str) -> "xr.Dataset":
    """Return an atlas with the verdicts and boundaries that another criterion gives.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas, as `sweep.run` or `sweep.open_atlas` returns it.
    criterion : Criterion or str
        For example ``departure:2deg`` or ``amplification:10``.

    Returns
    -------
    xarray.Dataset
        The same measures; `stability`, the boundaries and the attributes that name the criterion are new.

    Raises
    ------
    RequestError
        If the criterion is none.
    """
    spec = spec_of(dataset).replace(criterion=criterion)
    given = cells.starts(spec, Span(0, spec.size))
    stability = spec.criterion.verdict(
        dataset["ending"].values,
        dataset["tilt_min"].values,
        dataset["tilt_max"].values,
        cells.steady_tilt(spec, given).reshape(spec.shape),
        np.asarray(cells.scale(spec, given)).reshape(spec.shape),
    )
    edges = edge_variables(spec, stability)
    stale = [
        name for name in dataset.data_vars if str(name).startswith(("boundary_", "predicted_", "critical_"))
    ]
    verdicts = dataset["stability"].copy(data=stability)
    changed = dataset.drop_vars(stale).assign({"stability": verdicts} | edges)
    return changed.assign_attrs(
        criterion=str(spec.criterion),
        sweep_spec=spec.canonical(),
        sweep_fingerprint=spec.fingerprint(),
        history=f"{dataset.attrs['history']}\n{created()} reclassified with {spec.criterion}",
    )
