"""Motions near a separatrix, described from their saddle instead of from their start.

Seen from the start, the excess at the saddle is a difference that keeps few digits; it decides the period. Seen from
the saddle it is height + distance^2 Q, with all digits if the height is known (`kernels.disk.exact.saddle_height`).
A motion is rewritten as one that starts on its saddle, without a force and with the kinetic energy -height, which is
negative where it turns before the saddle: the quadrature of `kernels.disk.exact.period` is the same.
"""

import math

from kernels.disk.exact import motion as of
from kernels.disk.exact.legendre import DP1, DP2, DS1, DS2, NODES, REACH
from kernels.disk.exact.saddle_height import height_at
from kernels.disk.exact.wide_panels import CENTRES, SIDE, SPACING, STRIDE, W_ONE, W_PP, W_SP, W_SS
from kernels.jit import internal

#: Share of the height by which it may be wrong, of what it is the difference of, and the error of V' at the saddle.
_HEIGHT_ERROR, _SUM_ERROR, _SLOPE_ERROR = 1e-10, 1e-29, 1e-15
#: Coefficients of Q that are enough up to 0.3 in y from a wide panel's centre, and how far from it one is used.
_TERMS, _REACH = 30, 0.36
#: Newton steps towards the turning point next to the saddle.
_STEPS = 8


@internal
def _expand(motion, tables, top, number, q):
    """Write the coefficients of Q on a wide panel into `q`; returns the place of the saddle there."""
    table = int(motion[of.TABLE])
    panel, node = table * CENTRES + SIDE + number, table * NODES + 2 * (REACH + STRIDE * number)
    c1, c2, nodes, wide = motion[of.C_1], motion[of.C_2], tables.nodes, tables.wide
    s = c1 + (nodes[node, DS1] * c1 + nodes[node, DS2] * c2)
    p = c2 + (nodes[node, DP1] * c1 + nodes[node, DP2] * c2)
    place = math.tanh(0.5 * (top - number * SPACING))
    once = twice = 0.0
    for n in range(_TERMS + 1, 1, -1):
        term = s * (s * wide[panel, W_SS, n] + p * wide[panel, W_SP, n])
        term += p * p * wide[panel, W_PP, n] + wide[panel, W_ONE, n]
        once = term + place * once
        twice = once + place * twice
        q[n - 2] = twice
    return place


@internal
def _polish(motion, tables, height, guess, turn, q):
    """Write the turning point near `guess`, in y from the saddle, and the slope of V there if it is on a wide panel."""
    top, number = motion[of.Y_0], int(round(motion[of.Y_0] / SPACING))
    motion[of.DISTANCE + turn] = guess
    if not abs(top + guess - number * SPACING) < _REACH:
        return
    place = _expand(motion, tables, top, number, q)
    rest, tangent = 1.0 - place * place, math.tanh(0.5 * guess)
    distance, slope = rest * tangent / (1.0 + place * tangent), math.nan
    for _ in range(_STEPS):
        w, value, derivative = place + distance, 0.0, 0.0
        for n in range(_TERMS - 1, -1, -1):
            derivative = derivative * w + value
            value = value * w + q[n]
        slope = distance * (2.0 * value + distance * derivative)
        distance -= (height + distance * distance * value) / slope
    w = place + distance
    motion[of.DISTANCE + turn] = 2.0 * math.atanh(distance / (rest - place * distance))
    motion[of.SLOPE + turn] = 0.5 * (1.0 - w * w) * slope


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
    top, level, bend = motion[of.TOP], motion[of.LEVEL], motion[of.BEND]
    height, slope = height_at(math.tanh(top), tables.alphas[int(motion[of.TABLE])], starts, cell)
    # `top` is a Newton step away from the saddle
    shift = -slope / bend
    top, height = top + shift, height + 0.5 * slope * shift
    doubt = (_SUM_ERROR + _SLOPE_ERROR * abs(shift)) * level
    if not (doubt <= _HEIGHT_ERROR * abs(height) and height * motion[of.HEIGHT] > 0.0):
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
    _polish(motion, tables, height, ahead, 0, q)
    _polish(motion, tables, height, behind, of.BEHIND, q)
    return abs(motion[of.DISTANCE] - motion[of.DISTANCE + of.BEHIND]) > 0.0
