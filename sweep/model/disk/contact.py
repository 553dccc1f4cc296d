"""Contact forces: their extremes along the motions of cells, and where a disk would slip or lift off."""

from typing import TYPE_CHECKING

import numpy as np

from kernels.disk import arrays, motion_arrays
from sweep.errors import RequestError, shown
from sweep.model.description import Columns, Starts
from sweep.model.disk.tables import CONTACT_VARIABLES
from sweep.model.kernel import Kernel

if TYPE_CHECKING:
    import xarray as xr

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
    extremes = np.empty((len(motion_arrays.CONTACT), rows.shape[1]))
    CONTACT_EXTREMES.load()(rows, tilts, extremes)
    return dict(zip(motion_arrays.CONTACT, extremes, strict=True))


def slipping(dataset: "xr.Dataset", friction: float) -> "xr.DataArray":
    """Return which cells need more than a friction coefficient, or lift off: array of bool on the grid of the atlas.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas, or a selection from one.
    friction : float
        Friction coefficient of disk and plane.

    Raises
    ------
    RequestError
        If the atlas holds no contact forces.
    """
    missing = [name for name in CONTACT_VARIABLES if name not in dataset]
    if missing:
        raise RequestError(
            f"This atlas holds no contact forces to compare friction={friction:g} with: {' and '.join(missing)} "
            "are missing.",
            hint="Make it again with eulerdisk run SPEC contact=yes.",
            where=shown(str(dataset.attrs.get("title", ""))) or None,
        )
    least_force, needed = (dataset[name] for name in CONTACT_VARIABLES)
    found: xr.DataArray = (least_force <= 0.0) | (needed > friction)
    return found.rename(f"slips or lifts off at friction {friction:g}")
