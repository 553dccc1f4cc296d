"""The distance from every point of a region to its border, on a small raster."""

import numpy as np

from sweep.model.quantity import Array, Truths


def distance_to_outside(region: Truths, spacing: tuple[float, float]) -> Array:
    """Return how far each point of a region is from the nearest point outside it.

    `scipy.ndimage.distance_transform_edt` does the same for a raster of any size, but loading it takes as long as
    drawing a map.

    Parameters
    ----------
    region : array of bool, shape (n, m)
        False along its whole border, so that every row and column leaves the region.
    spacing : (float, float)
        Distance between two rows and between two columns.

    Returns
    -------
    array, shape (n, m)
        Euclidean distances; 0 outside.

    Notes
    -----
    The nearest point outside is sought along each column, then among the columns of each row, all against all: the
    squares of the two distances add up. Memory: 8 n m^2 bytes.
    """
    rows, columns = (np.arange(count, dtype=float) for count in region.shape)
    places = rows[:, np.newaxis]
    above = np.maximum.accumulate(np.where(region, -np.inf, places), axis=0)
    below = np.minimum.accumulate(np.where(region, np.inf, places)[::-1], axis=0)[::-1]
    up = (np.minimum(places - above, below - places) * spacing[0]) ** 2
    across = ((columns[:, np.newaxis] - columns) * spacing[1]) ** 2
    return np.asarray(np.sqrt((up[:, np.newaxis, :] + across).min(axis=-1)))
