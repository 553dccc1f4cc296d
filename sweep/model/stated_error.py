"""How far each variable of a cell may be off, from what the cell states of its extremes."""

import numpy as np
import numpy.typing as npt

from sweep.model.description import Columns, Request, Starts
from sweep.model.quantity import AMPLIFIED, EXTREME, PROMISED, Array, Quantity

#: Share of a time that the errors of a small swing may come to: more would say nothing of it.
_MOST_OF_A_TIME = 0.5


def stated_error(
    quantity: Quantity, spec: Request, starts: Starts, columns: Columns, error: Array | float
) -> Array:
    """Return how far the values of a variable may be off, in its units.

    Parameters
    ----------
    quantity : Quantity
        Its rule (`sweep.model.quantity.Tolerance`) says how that follows from the extremes.
    spec : Request
    starts : mapping of str to array, shape (...)
    columns : mapping of str to array, shape (...)
        `quantity` and the extremes of the cells.
    error : array of float or float
        How far the extremes may be off, in the unit of the coordinate.

    Returns
    -------
    array of float, shape (...)
        What the rule allows for a value that is missing or infinite is that for 0.
    """
    rule, model = quantity.tolerance, spec.model
    size = magnitude(columns[quantity.name])
    allowed = rule.absolute + rule.relative * size
    if not rule.stated:
        return np.asarray(allowed)
    if rule.stated in columns:
        # the cells state it themselves
        return np.asarray(allowed + PROMISED * magnitude(columns[rule.stated]))
    if rule.stated == EXTREME:
        return np.asarray(allowed + error)
    scale = model.perturbation(spec, starts)
    with np.errstate(divide="ignore", invalid="ignore"):
        if rule.stated == AMPLIFIED:
            return np.asarray(allowed + np.where(scale > 0.0, error / scale, 0.0))
        low, high = (columns[name] for name in model.extremes)
        swing = np.minimum(1.0, np.minimum(scale, high - low))
        share = np.minimum(_MOST_OF_A_TIME, np.where(swing > 0.0, error / swing, 0.0))
        return np.asarray(allowed + size * share)


def magnitude(values: npt.NDArray[np.generic]) -> Array:
    """Return magnitudes; 0 of what is missing or infinite, which allows no difference."""
    numbers = np.abs(values.astype(np.float64))
    return np.where(np.isfinite(numbers), numbers, 0.0)
