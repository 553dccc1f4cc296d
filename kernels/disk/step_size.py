"""How long the steps of a cell are, and the settings of a run that say so."""

import math

import numpy as np

from kernels.jit import internal, kernel, simd

#: Where the settings of a run stand; see `kernels.lanes.schedule.integrate` and `prepared`.
DURATION, STEP, FALL_TILT, TOLERANCE, COS_FALL, PACE = range(6)

#: Step over the fastest time scale of the start, at a tolerance of 1e-8; see `first_step`.
_PACE = 0.042

#: Share of that step on a hump of the potential, and the |V''| (of m g R) above which it is the smaller one.
_HUMP = 0.39
_SLOW = _HUMP**2.5


@kernel
def prepared(settings):
    """Settings of a run, and what follows from them for all cells: cos(fall_tilt) and the pace of the steps.

    The global error is of fourth order, hence the fourth root of the tolerance.
    """
    pace = _PACE * math.sqrt(math.sqrt(settings[TOLERANCE] * 1.0e8))
    return np.array(
        [
            settings[DURATION], settings[STEP], settings[FALL_TILT], settings[TOLERANCE],
            math.cos(settings[FALL_TILT]), pace,
        ]
    )  # fmt: skip


@simd
def first_step(state, constants, pace):
    """Scaled step of the engine's own choice, per cos(tilt); a start on a hump takes the share `on_hump` of it.

    The rates of the start give the fastest frequency of the linearised motion; the step then shrinks like cos(tilt)
    on the way to flat.
    """
    _, _, _, w, o, s = state
    return pace / math.sqrt(constants[0] * (1.0 + 2.0 * constants[1] * s * s) + o * o + w * w)


@internal
def on_hump(stiffness):
    """Share of the step for a start where the second derivative of the potential (of m g R) is `stiffness`.

    A start on a hump of the potential leaves it for faster motion: over rolling and spinning starts of several alphas
    the step that meets the tolerance was 0.43 to 0.46 |V''|^-0.4 of the other cells' one.
    """
    return _HUMP * (-stiffness) ** -0.4 if stiffness < -_SLOW else 1.0
