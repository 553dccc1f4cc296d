"""Cells of an atlas with contact forces where the disk would slip or lift off, for a friction coefficient."""

from typing import TYPE_CHECKING

from sweep.errors import RequestError
from sweep.model.disk.tables import CONTACT_VARIABLES

if TYPE_CHECKING:
    import xarray as xr


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
            where=str(dataset.attrs["title"]),
        )
    least_force, needed = (dataset[name] for name in CONTACT_VARIABLES)
    found: xr.DataArray = (least_force <= 0.0) | (needed > friction)
    return found.rename(f"slips or lifts off at friction {friction:g}")
