"""The settings of a run as the kernels use them, and how long the steps of a cell are."""

import math
from typing import NamedTuple

from kernels.disk.arrays import DURATION, FALL_TILT, STEP, TOLERANCE
from kernels.disk.equations import fastest_square
from kernels.jit import kernel, simd

#: Step over the fastest time scale of the start, at a tolerance of 1e-8; see `first_step`.
_RELATIVE_STEP = 0.042

#: Share of that step near a maximum of the potential, and the |V''| (of m g R) above which the shorter step is taken.
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

    The global error is of fourth order, hence the fourth root of the tolerance.
    """
    relative_step = _RELATIVE_STEP * math.sqrt(math.sqrt(settings[TOLERANCE] * 1.0e8))
    return RunSettings(
        settings[DURATION], settings[STEP], settings[FALL_TILT], settings[TOLERANCE],
        math.cos(settings[FALL_TILT]), relative_step,
    )  # fmt: skip


@simd
def first_step(state, constants, relative_step):
    """Scaled step over cos(tilt), where the request leaves it open; see `share_near_maximum` too.

    The rates of the start give the fastest frequency of the linearised motion; the step then shrinks like cos(tilt)
    as the tilt approaches 90 deg.
    """
    return relative_step / math.sqrt(fastest_square(state, constants))


@kernel
def share_near_maximum(curvature):
    """Share of `first_step` for a start where the second derivative V'' of the potential (of m g R) is `curvature`.

    A start near a maximum of the potential leaves it for faster motion: over rolling and spinning starts of several
    alphas the step that meets the tolerance was 0.43 to 0.46 |V''|^-0.4 of that of the other cells.
    """
    return _MAXIMUM_SHARE * (-curvature) ** -0.4 if curvature < -_LEAST_CURVATURE else 1.0
