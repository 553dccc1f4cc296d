"""Cells on an edge: where the last bit decides an ending or a verdict, both of two atlases may be right."""

import numpy as np
import numpy.typing as npt

from sweep.checks.alignment import Pair
from sweep.checks.allowed import allowed_of_cells, starts_of_cells, stated
from sweep.engine.compute import reach_and_scale
from sweep.model.quantity import STABLE, UNSTABLE, Truths


def endings_on_edge(pair: Pair) -> Truths:
    """Return where the endings differ and a neighbour of the cell, in the reference, ended as the new atlas says.

    An ending changes where time, error or coordinate reaches its limit, and that edge runs between cells.
    """
    new, old = (atlas["ending"].values for atlas in (pair.new, pair.reference))
    on_edge: Truths = (new != old) & _beside(new, old)
    return on_edge


def verdicts_on_edge(pair: Pair, endings: Truths) -> Truths:
    """Return where the verdicts differ and the cell stands on the edge between them.

    With the same ending, a cell may be stable in one and unstable in the other where the limit of the criterion lies
    between the departures of the two, or within the tolerance of the extremes from either. Where the ending flips
    (`endings`), the verdict that follows from it may flip too.
    """
    new, old = (atlas["stability"].values for atlas in (pair.new, pair.reference))
    decided = np.isin(new, (STABLE, UNSTABLE)) & np.isin(old, (STABLE, UNSTABLE))
    same_ending = pair.new["ending"].values == pair.reference["ending"].values
    on_edge: Truths = (new != old) & (endings | (decided & same_ending & _at_limit(pair)))
    return on_edge


def _beside(new: npt.NDArray[np.integer], old: npt.NDArray[np.integer]) -> Truths:
    """Return where a neighbour along any axis has, in `old`, the code that the cell has in `new`."""
    found = np.zeros(new.shape, bool)
    for axis in range(new.ndim):
        for here, there in ((slice(1, None), slice(None, -1)), (slice(None, -1), slice(1, None))):
            at = (slice(None),) * axis
            found[(*at, here)] |= new[(*at, here)] == old[(*at, there)]
    return found


def _at_limit(pair: Pair) -> Truths:
    model, starts, both = pair.spec.model, starts_of_cells(pair), stated(pair)
    reaches = []
    for atlas in both:
        reach, scale = reach_and_scale(pair.spec, starts, atlas.columns)
        reaches.append(reach)
    limit = np.nan_to_num(pair.spec.criterion.allowed(scale))
    slack = allowed_of_cells(model.variables[model.extremes[1]], *both, starts)
    at: Truths = (np.minimum(*reaches) - slack <= limit) & (limit <= np.maximum(*reaches) + slack)
    return at
