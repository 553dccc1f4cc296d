"""The settings of a run in the form used by the kernels, and the step length of a cell."""

import math
from typing import NamedTuple

from kernels.disk.arrays import DURATION, FALL_TILT, STEP, TOLERANCE
from kernels.disk.equations import fastest_square
from kernels.jit import kernel, simd

#: Step over the shortest time scale of the start, at a tolerance of 1e-8; see `first_step`.
_RELATIVE_STEP = 0.042

#: Share of this step near a maximum of the potential, and the |V''| (of m g R) above which the shorter step is used.
_MAXIMUM_SHARE = 0.39
_LEAST_CURVATURE = _MAXIMUM_SHARE**2.5


class RunSettings(NamedTuple):
    """Settings of a run (`kernels.disk.arrays.SETTINGS`), cos(fall_tilt), and the relative step of `first_step`."""

    duration: float
    step: float
    fall_tilt: float
    tolerance: float
    cos_fall_tilt: float
    relative_step: float


@kernel
def prepared_settings(settings):
    """Return the `RunSettings` of float64[len(SETTINGS)] settings.

    The step is proportional to the fourth root of the tolerance, because the global error is of fourth order.
    """
    relative_step = _RELATIVE_STEP * math.sqrt(math.sqrt(settings[TOLERANCE] * 1.0e8))
    return RunSettings(
        settings[DURATION], settings[STEP], settings[FALL_TILT], settings[TOLERANCE],
        math.cos(settings[FALL_TILT]), relative_step,
    )  # fmt: skip


@simd
def first_step(state, constants, relative_step):
    """Return the scaled step over cos(tilt), if the request does not set one; see also `share_near_maximum`.

    The rates of the start give the fastest frequency of the linearised motion; the step then shrinks like cos(tilt)
    as the tilt approaches 90 deg.
    """
    return relative_step / math.sqrt(fastest_square(state, constants))


@kernel
def share_near_maximum(curvature):
    """Return the share of `first_step` for a start with the second derivative `curvature` of the potential (of m g R).

    A start near a maximum of the potential leaves it for faster motion. For rolling and spinning starts of several
    alphas, the step that meets the tolerance was 0.43 to 0.46 |V''|^-0.4 of the step of other cells.
    """
    return _MAXIMUM_SHARE * (-curvature) ** -0.4 if curvature < -_LEAST_CURVATURE else 1.0
