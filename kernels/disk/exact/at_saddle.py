"""Motions near a separatrix, described from their saddle instead of from their start.

Seen from the start, the excess at the saddle is a difference that keeps few digits; it decides the period. Seen from
the saddle it is height + distance^2 Q, with all digits if the height is known (`kernels.disk.exact.saddle_height`).
A motion is rewritten as one that starts on its saddle, without a force and with the kinetic energy -height, which is
negative where it turns before the saddle: the quadrature of `kernels.disk.exact.period` is the same.
"""

import math

from kernels.disk.arrays import PRECESSION_RATE, ROLL_RATE
from kernels.disk.exact import motion as of
from kernels.disk.exact.near_turning_points import ROUNDING
from kernels.disk.exact.polish import polished
from kernels.disk.exact.saddle_height import height_at
from kernels.jit import internal

#: Share of the height by which it may be wrong, of what it is the difference of, and the error of V' at the saddle.
_HEIGHT_ERROR, _SUM_ERROR, _SLOPE_ERROR = 1e-10, 1e-29, 1e-15
#: Newton steps towards the saddle at most, and the distance in y of the last one.
_MOST_SHIFTS, _SMALL_SHIFT = 8, 1e-10
#: Roundings of the terms of the excess that the first pass expects, and the share of the height that others may take.
_EXPECTED, _BLUR = 1.0, 2e-9


@internal
def is_blurred(motion, starts, cell):
    """Whether rounding of the rate s = roll + precession sin(tilt) at the start hides the height of the saddle.

    Of a fast disk that is nearly flat the two parts of s may all but cancel: V - h is then wrong by s ds, of which the
    sizes of the terms of the excess tell nothing.
    """
    parts = abs(starts[ROLL_RATE, cell]) + abs(starts[PRECESSION_RATE, cell] * motion[of.SIN])
    size = 2.0 * abs(motion[of.S_0]) * motion[of.UNIT] * parts
    return size > _EXPECTED * motion[of.LEVEL] and ROUNDING * size > _BLUR * abs(motion[of.HEIGHT])


@internal
def _polish(motion, tables, guess, turn, q):
    """Write the turning point near `guess`, in y from the saddle, and the slope of V there if it is on a wide panel."""
    motion[of.DISTANCE + turn], slope = polished(motion, tables, guess, q)
    if not math.isnan(slope):
        motion[of.SLOPE + turn] = slope


@internal
def move_to_saddle(motion, tables, starts, cell, q):
    """Describe the motion of a cell from its saddle; whether that is possible.

    Parameters
    ----------
    motion : float64[COLUMNS], written
        A bounded motion with a saddle.
    tables : Tables
    starts : float64[len(PARAMETERS), n]
    cell : int
    q : float64[at least 30]
        Memory.
    """
    top, height, shift = motion[of.TOP], math.nan, math.inf
    # next to a fold V'' is small, and a step from half of the digits does not end at the top
    for _ in range(_MOST_SHIFTS):
        height, slope = height_at(math.tanh(top), tables.alphas[int(motion[of.TABLE])], starts, cell)
        shift = -slope / motion[of.BEND]
        top, height = top + shift, height + 0.5 * slope * shift
        if not abs(shift) > _SMALL_SHIFT:
            break
    bend, doubt = motion[of.BEND], (_SUM_ERROR + _SLOPE_ERROR * abs(shift)) * motion[of.LEVEL]
    if not (
        abs(shift) <= _SMALL_SHIFT
        and doubt <= _HEIGHT_ERROR * abs(height)
        and height * motion[of.HEIGHT] > 0.0
    ):
        return False
    # released at rest, the disk starts at its other turning point
    if motion[of.W] == 0.0:
        motion[of.DISTANCE + of.BEHIND], motion[of.SLOPE + of.BEHIND] = 0.0, motion[of.FORCE]
    away = motion[of.Y_0] - top
    motion[of.W], motion[of.Y_0], motion[of.TOP], motion[of.HEIGHT] = 1.0, top, top, height
    motion[of.KINETIC], motion[of.FORCE], motion[of.PULL] = -height, 0.0, 0.0
    ahead, behind = motion[of.DISTANCE] + away, motion[of.DISTANCE + of.BEHIND] + away
    if height > 0.0:
        # what is known from the start of the turning point before the saddle may be wrong altogether
        near = math.copysign(math.sqrt(2.0 * height / abs(bend)), away)
        ahead, behind = (near, behind) if abs(ahead) < abs(behind) else (ahead, near)
    _polish(motion, tables, ahead, 0, q)
    _polish(motion, tables, behind, of.BEHIND, q)
    return abs(motion[of.DISTANCE] - motion[of.DISTANCE + of.BEHIND]) > 0.0
