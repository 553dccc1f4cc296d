"""Where rolling without slipping is believable: what the motion of each cell asks of the contact."""

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from sweep.engine.compiled import contact_extremes
from sweep.schema import CONTACT_VARIABLES, Array


def columns(
    given: Mapping[str, Array], tilt_min: Array, tilt_max: Array
) -> dict[str, npt.NDArray[np.generic]]:
    """Find the extremes of the contact forces of the cells of a span.

    Parameters
    ----------
    given : mapping of str to float64 array, shape (n,)
        The starts, as `cells.starts` returns them.
    tilt_min, tilt_max : float64 array, shape (n,)
        Extreme tilts of the motions [rad], NaN where there are none.

    Returns
    -------
    dict of str to float64 array, shape (n,)
        The variables of `schema.CONTACT_VARIABLES`; NaN where a cell has no motion to speak of.
    """
    extremes = np.empty((2, tilt_min.size))
    contact_extremes()(np.stack(list(given.values())), np.stack([tilt_min, tilt_max]), extremes)
    return dict(zip(CONTACT_VARIABLES, extremes, strict=True))
