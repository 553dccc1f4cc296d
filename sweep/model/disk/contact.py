"""Where rolling without slipping is believable: what the motion of each cell asks of the contact."""

import numpy as np

from kernels.disk import arrays
from sweep.model.description import Columns, Starts
from sweep.model.kernel import Kernel

CONTACT_EXTREMES = Kernel("kernels.disk.contact", "contact_extremes")


def contact_columns(starts: Starts, measured: Columns) -> Columns:
    """Find the extremes of the contact forces along the motions of cells.

    Parameters
    ----------
    starts : mapping of str to array, shape (n,)
    measured : mapping of str to array, shape (n,)
        With ``tilt_min`` and ``tilt_max`` [rad], NaN where there is no motion.

    Returns
    -------
    mapping of str to float64 array, shape (n,)
        The variables of `tables.CONTACT_VARIABLES`; NaN where a cell has no motion.
    """
    rows = np.stack([starts[name] for name in arrays.PARAMETERS])
    tilts = np.stack([measured["tilt_min"], measured["tilt_max"]])
    extremes = np.empty((len(arrays.CONTACT), rows.shape[1]))
    CONTACT_EXTREMES.load()(rows, tilts, extremes)
    return dict(zip(arrays.CONTACT, extremes, strict=True))
