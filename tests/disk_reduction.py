"""Calls of the reduction for thin disks: starts in, measures and counts out."""

import numpy as np

from kernels.bodies.arrays import REDUCED, REDUCED_SEPARATRIX
from kernels.bodies.shapes import TORUS
from kernels.disk.arrays import ALPHA, GRAVITY, PARAMETERS, RADIUS, TILT_RATE
from sweep.model.disk.exact import count_wells, reduce_bodies
from sweep.model.disk.path import rows_of_disk

#: Rows of the counts.
ENDING, COUNT = range(2)


def extremes(given, fall_tilt, timed=False):
    """Return the reduction's measures of disks (rows of `REDUCED`), and two counts: endings and wells."""
    rows = rows_of_disk(dict(zip(PARAMETERS, given, strict=True)))
    found = reduce_bodies(rows, TORUS, fall_tilt, timed)
    return np.stack([found[name] for name in REDUCED]), np.stack([found["ending"], count_wells(rows, TORUS)])


def rates_to_maxima(given, fall_tilt=1.5):
    """Return the tilt rates [rad/s] that reach the potential maxima next to starts at rest.

    The height of a maximum comes from a parabola, which is better the closer the motion gets to it: the search is
    repeated with the rate found, until rounding decides.
    """
    pushed, inertia = given.copy(), 1.0 + 0.5 * given[ALPHA]
    for _ in range(12):
        height = extremes(pushed, fall_tilt)[0][REDUCED_SEPARATRIX]
        gain = 2.0 * np.nan_to_num(height) / inertia * given[GRAVITY] / given[RADIUS]
        pushed[TILT_RATE] = -np.sqrt(np.maximum(pushed[TILT_RATE] ** 2 + gain, 0.0))
    return np.abs(pushed[TILT_RATE])
