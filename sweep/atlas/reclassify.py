"""Another criterion or a finer boundary on a finished atlas: measures are stored, verdicts follow from them."""

from typing import TYPE_CHECKING

import numpy as np

from sweep.atlas.cf_metadata import created, spec_attributes
from sweep.atlas.dataset import edge_variables, require, spec_of
from sweep.atlas.selection import BOUNDARY, settled
from sweep.engine.compute import reach_and_scale
from sweep.engine.grid import blocks, starts_of
from sweep.request.criterion import Criterion
from sweep.request.spec import SweepSpec
from sweep.request.words import REFINED, REFINED_WIDTH

if TYPE_CHECKING:
    import xarray as xr


def reclassify(dataset: "xr.Dataset", criterion: Criterion | str) -> "xr.Dataset":
    """Return an atlas with the verdicts and boundaries that another criterion gives.

    No cell of the grid is integrated again; for a refined boundary the places between cells are.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas, as `sweep.run` or `sweep.open_atlas` returns it, or a selection from one.
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
    atlas = settled(dataset)
    return _judged(atlas, spec_of(atlas).replace(criterion=criterion), f"reclassified with {criterion}")


def refine(dataset: "xr.Dataset", width: float = REFINED_WIDTH) -> "xr.Dataset":
    """Return an atlas whose boundary is bisected, row by row and as curves.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas, as `sweep.run` or `sweep.open_atlas` returns it, or a selection from one.
    width : float
        Width of the brackets in the SI unit of each axis.

    Returns
    -------
    xarray.Dataset
        The same cells; the boundary and the attributes that describe it are new.

    Raises
    ------
    RequestError
        If the width is not above 0.
    """
    atlas = settled(dataset)
    spec = spec_of(atlas).replace(boundary=f"{REFINED}:{width!r}")
    return _judged(atlas, spec, f"boundary refined to {width!r}")


def _judged(dataset: "xr.Dataset", spec: SweepSpec, done: str) -> "xr.Dataset":
    needed = dict.fromkeys((*spec.criterion.needs(spec.model), *spec.model.extremes))
    require(dataset, needed)
    measured = {name: dataset[name].values.reshape(-1) for name in needed}
    found = np.empty(spec.size, np.int8)
    for span in blocks(spec.size):
        part = {name: values[span.start : span.stop] for name, values in measured.items()}
        reach = reach_and_scale(spec, starts_of(spec, span), part)
        found[span.start : span.stop] = spec.criterion.verdict(spec.model.endings, part, *reach)
    stability = found.reshape(spec.shape)
    edges = edge_variables(spec, stability)
    stale = [name for name in dataset.data_vars if str(name).startswith(BOUNDARY)]
    verdicts = dataset["stability"].copy(data=stability)
    changed = dataset.drop_vars(stale).assign({"stability": verdicts} | edges)
    return changed.assign_attrs(
        **spec_attributes(spec),
        history=f"{dataset.attrs.get('history', '')}\n{created()} {done}".lstrip("\n"),
    )
