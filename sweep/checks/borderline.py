"""Borderline cells: where the last bit of a measure may decide, so that two correct atlases may differ in verdicts."""

import numpy as np
import numpy.typing as npt

from sweep.checks.alignment import Pair
from sweep.engine.compute import reach_and_scale
from sweep.model.description import Starts
from sweep.model.quantity import STABLE, UNSTABLE

Mask = npt.NDArray[np.bool_]


def endings_on_edge(pair: Pair) -> Mask:
    """Return where the endings differ and a neighbour of the cell, in the reference, ended as the new atlas says.

    Returns
    -------
    array of bool, shape of the grid
        An ending changes where time, error or coordinate reaches its limit, and that edge runs between cells.
    """
    new, old = (atlas["ending"].values for atlas in (pair.new, pair.reference))
    on_edge: Mask = (new != old) & _beside(new, old)
    return on_edge


def verdicts_on_edge(pair: Pair, endings: Mask) -> Mask:
    """Return where the verdicts differ and the cell stands on the edge between them.

    Parameters
    ----------
    pair : Pair
    endings : array of bool, shape of the grid
        `endings_on_edge`.

    Returns
    -------
    array of bool, shape of the grid
        With the same ending, a cell may be stable in one and unstable in the other where the limit of the criterion
        lies between the departures of the two, or within the tolerance of the extremes from either. Where the ending
        flips, the verdict that follows from it may flip too.
    """
    new, old = (atlas["stability"].values for atlas in (pair.new, pair.reference))
    decided = np.isin(new, (STABLE, UNSTABLE)) & np.isin(old, (STABLE, UNSTABLE))
    same_ending = pair.new["ending"].values == pair.reference["ending"].values
    on_edge: Mask = (new != old) & (endings | (decided & same_ending & _at_limit(pair)))
    return on_edge


def _beside(new: npt.NDArray[np.integer], old: npt.NDArray[np.integer]) -> Mask:
    """Return where a neighbour along any axis has, in `old`, the code that the cell has in `new`."""
    found = np.zeros(new.shape, bool)
    for axis in range(new.ndim):
        for here, there in ((slice(1, None), slice(None, -1)), (slice(None, -1), slice(1, None))):
            at = (slice(None),) * axis
            found[(*at, here)] |= new[(*at, here)] == old[(*at, there)]
    return found


def _at_limit(pair: Pair) -> Mask:
    model, starts = pair.spec.model, _starts(pair)
    reaches = []
    for atlas in (pair.new, pair.reference):
        reach, scale = reach_and_scale(
            pair.spec, starts, {name: atlas[name].values for name in model.extremes}
        )
        reaches.append(reach)
    limit = np.nan_to_num(pair.spec.criterion.allowed(scale))
    slack = model.variables[model.extremes[1]].tolerance.absolute
    at: Mask = (np.minimum(*reaches) - slack <= limit) & (limit <= np.maximum(*reaches) + slack)
    return at


def _starts(pair: Pair) -> Starts:
    """Return the starts of the cells of a pair, from its coordinates, in the shape of its grid."""
    shape = pair.reference["ending"].shape
    found = {}
    for name in pair.reference.coords:
        values = pair.reference[name]
        along = [shape[i] if axis == name else 1 for i, axis in enumerate(pair.axes)]
        found[str(name)] = np.broadcast_to(values.values.reshape(along if values.dims else ()), shape)
    return found
