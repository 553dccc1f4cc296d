"""Cells on an edge: where the last bit of a measure may decide, and two sound atlases may differ in their verdicts."""

import numpy as np
import numpy.typing as npt

from sweep.checks.alignment import Pair
from sweep.engine import cells
from sweep.schema import STABLE, UNSTABLE, VARIABLES, Array

Mask = npt.NDArray[np.bool_]


def endings_on_edge(pair: Pair) -> Mask:
    """Return where the endings differ and a neighbour of the cell, in the reference, ended as the new atlas says.

    Returns
    -------
    array of bool, shape of the grid
        An ending changes where a gauge meets its limit (time, tolerance, fall_tilt), and that is between cells.
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
        With the same ending, stable and unstable may change places where the criterion's limit lies between the
        departures of the two atlases, or within the tolerance of the tilts from both. Where the ending flips, so may
        the verdict that follows from it.
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
    limit, steady = _limits(pair)
    reaches = []
    for atlas in (pair.new, pair.reference):
        tilts = (atlas["tilt_min"].values, atlas["tilt_max"].values)
        reaches.append(np.maximum(*(np.abs(tilt - steady) for tilt in tilts)))
    slack = VARIABLES["tilt_max"].tolerance.absolute
    at: Mask = (np.minimum(*reaches) - slack <= limit) & (limit <= np.maximum(*reaches) + slack)
    return at


def _limits(pair: Pair) -> tuple[Array, Array]:
    """Return the criterion's limit and the steady tilt [rad] in every cell of the pair."""
    shape = pair.reference["ending"].shape
    given: dict[str, Array] = {}
    for name in pair.reference.coords:
        values = pair.reference[name]
        along = [shape[i] if axis == name else 1 for i, axis in enumerate(pair.axes)]
        given[str(name)] = np.broadcast_to(values.values.reshape(along if values.dims else ()), shape)
    steady = cells.steady_tilt(pair.spec, given)
    if pair.spec.criterion.kind == "departure":
        return np.full(shape, pair.spec.criterion.limit), steady
    return pair.spec.criterion.limit * cells.scale(pair.spec, given), steady
