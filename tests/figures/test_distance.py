"""Distances to the outside of a region, compared with SciPy."""

import numpy as np
from scipy.ndimage import distance_transform_edt

from sweep.figures.room import distance_to_outside


def test_distances_are_those_of_scipy():
    """Distances agree for regions with many, few and no holes and different spacing of rows and columns."""
    for spacing in ((1.0, 1.0), (0.5, 0.25), (1.0, 1.0 / 6.5)):
        for share in (0.0, 0.3, 0.9, 0.997, 1.0):
            region = np.pad(np.random.default_rng(5).random((40, 57)) < share, 1)
            expected = distance_transform_edt(region, sampling=spacing)
            np.testing.assert_allclose(distance_to_outside(region, spacing), expected, rtol=4e-16, atol=0.0)
