"""Where rolling without slipping is believable: what the motion of each cell asks of the contact."""

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from sweep.compiled import contact_extremes
from sweep.schema import CONTACT_VARIABLES, Array
from sweep.spec import SweepSpec


def columns(
    spec: SweepSpec, given: Mapping[str, Array], endings: npt.NDArray[np.int32]
) -> dict[str, npt.NDArray[np.generic]]:
    """Follow the cells of a span once more, for the extremes of their contact forces.

    Parameters
    ----------
    spec : SweepSpec
    given : mapping of str to float64 array, shape (n,)
        The starts, as `cells.starts` returns them.
    endings : int32 array, shape (n,)
        How each cell ended.

    Returns
    -------
    dict of str to float64 array, shape (n,)
        The variables of `schema.CONTACT_VARIABLES`; NaN where a cell has no motion to speak of.
    """
    extremes = np.empty((2, endings.size))
    settings = np.array([spec.duration, spec.fall_tilt])
    contact_extremes()(np.stack(list(given.values())), settings, np.ascontiguousarray(endings), extremes)
    return dict(zip(CONTACT_VARIABLES, extremes, strict=True))
