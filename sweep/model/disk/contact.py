"""Contact forces: their extremes along the motions of cells, and the cells that slip or lift off."""

from typing import TYPE_CHECKING

import numpy as np

from kernels.bodies import arrays, shapes
from sweep.errors import RequestError, plain_text, shown
from sweep.model.description import Columns, Starts
from sweep.model.disk.path import call_by_body, rows_of_disk
from sweep.model.kernel import Kernel
from sweep.model.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

CONTACT = Kernel("kernels.reduction.contact_extremes", "contact", seconds=14.0)


def contact_columns(rows: Array, number: int, fall_tilt: float, kernel: Kernel = CONTACT) -> Columns:
    """Return the extremes of the contact forces along the motions of cells, for all time.

    Parameters
    ----------
    rows : array, shape (len(kernels.bodies.arrays.PARAMETERS), n)
    number : int
        Of the kind of body (`kernels.bodies.shapes`).
    fall_tilt : float
        Tilt [rad] at which motions end.
    kernel : Kernel
        That of a meridian which is an arc of a circle, or another one.

    Returns
    -------
    mapping of str to array, shape (n,)
        The variables of `tables.CONTACT_VARIABLES`; NaN where a cell has no motion or they are not known.
    """
    extremes = np.empty((len(arrays.CONTACT), rows.shape[1]))
    states = np.empty(rows.shape[1], np.int64)
    call_by_body(kernel, rows, (float(number), fall_tilt), (extremes, states))
    return {**dict(zip(arrays.CONTACT, extremes, strict=True)), "contact_state": states}


def contact_of_disk(starts: Starts, fall_tilt: float) -> Columns:
    """Return the extremes of the contact forces of thin disks, as by `contact_columns`."""
    return contact_columns(rows_of_disk(starts), shapes.TORUS, fall_tilt)


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
    names = (*arrays.CONTACT, "contact_state")
    if missing := [name for name in names if name not in dataset]:
        raise RequestError(
            f"This atlas lacks the contact forces that friction={friction:g} needs: {', '.join(missing)}.",
            hint="Compute it again with eulerdisk run SPEC contact=yes.",
            where=shown(plain_text(dataset.attrs.get("title", ""))) or None,
        )
    least_force, needed, state = (dataset[name] for name in names)
    slips: xr.DataArray = (least_force <= 0.0) | (needed > friction) | (state == arrays.UNRESOLVED_FORCES)
    return slips.rename(f"slips or lifts off at friction {friction:g}")
