"""Contact forces: their extremes along the motions of cells, and the cells that slip or lift off."""

from typing import TYPE_CHECKING

import numpy as np

from kernels.disk import arrays, motion_arrays
from sweep.errors import RequestError, plain_text, shown
from sweep.model.description import Columns, Starts
from sweep.model.kernel import Kernel

if TYPE_CHECKING:
    import xarray as xr

CONTACT_EXTREMES = Kernel("kernels.disk.contact_extremes", "contact_extremes", seconds=3.0)


def contact_columns(starts: Starts, measured: Columns, fall_tilt: float) -> Columns:
    """Return the extremes of the contact forces along the motions of cells.

    Parameters
    ----------
    starts : mapping of str to array, shape (n,)
    measured : mapping of str to array, shape (n,)
        Includes ``ending``, and ``tilt_min``, ``tilt_max``, ``tilt_error`` [rad], NaN where there is no motion.
    fall_tilt : float
        Tilt [rad] at which motions end.

    Returns
    -------
    mapping of str to array, shape (n,)
        The variables of `tables.CONTACT_VARIABLES`; NaN where a cell has no motion or they are not known.
    """
    rows = np.stack([starts[name] for name in arrays.PARAMETERS])
    extents = np.stack([measured[name] for name in motion_arrays.EXTENT])
    extremes = np.empty((len(motion_arrays.CONTACT), rows.shape[1]))
    states = np.empty(rows.shape[1], np.int64)
    endings = measured["ending"].astype(np.int64)
    CONTACT_EXTREMES.load()(rows, extents, endings, fall_tilt, extremes, states)
    return {**dict(zip(motion_arrays.CONTACT, extremes, strict=True)), "contact_state": states}


def slipping(dataset: "xr.Dataset", friction: float) -> "xr.DataArray":
    """Return which cells need more friction than a coefficient, or lift off: array of bool on the grid of the atlas.

    They include the cells whose forces are not known: these nearly lift off, and no coefficient is known to be enough.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas, or a selection from one.
    friction : float
        Friction coefficient of disk and plane.

    Raises
    ------
    RequestError
        If the atlas has no contact forces.
    """
    names = (*motion_arrays.CONTACT, "contact_state")
    if missing := [name for name in names if name not in dataset]:
        raise RequestError(
            f"This atlas lacks the contact forces that friction={friction:g} needs: {', '.join(missing)}.",
            hint="Compute it again with eulerdisk run SPEC contact=yes.",
            where=shown(plain_text(dataset.attrs.get("title", ""))) or None,
        )
    least_force, needed, state = (dataset[name] for name in names)
    slips: xr.DataArray = (
        (least_force <= 0.0) | (needed > friction) | (state == motion_arrays.UNRESOLVED_FORCES)
    )
    return slips.rename(f"slips or lifts off at friction {friction:g}")
