"""Turning points of one motion on the wide panel about its start, where no potentials at upright are subtracted.

Beyond the panel of its start a turning point is sought by the height of V over upright. Of a fast disk that is nearly
flat this is a small difference of large numbers, and the turning point of a narrow swing keeps few digits of its
distance. On a wide panel (`kernels.disk.exact.wide_panels`) the excess is -kinetic + distance (A_1 + distance Q).
"""

import math

from kernels.disk.exact import motion as of
from kernels.disk.exact.legendre import DP1, DP2, DS1, DS2, NODES, REACH
from kernels.disk.exact.near_turning_points import TERM_ERROR
from kernels.disk.exact.wide_panels import CENTRES, SIDE, SPACING, STRIDE, W_ONE, W_PP, W_SP, W_SS
from kernels.jit import internal

#: Coefficients of Q that are enough up to 0.3 in y from a wide panel's centre, and how far from it one is used.
_TERMS, _REACH = 30, 0.36
#: Newton steps towards a turning point.
_STEPS = 8
#: Share of a swing by which a turning point may be wrong, and the largest by which it is moved.
_SHARE, _MOST = 1e-10, 1e-6


@internal
def _expand(motion, tables, number, q):
    """Write the coefficients of Q on a wide panel into `q`; returns the place of the start there."""
    table = int(motion[of.TABLE])
    panel, node = table * CENTRES + SIDE + number, table * NODES + 2 * (REACH + STRIDE * number)
    c1, c2, nodes, wide = motion[of.C_1], motion[of.C_2], tables.nodes, tables.wide
    s = c1 + (nodes[node, DS1] * c1 + nodes[node, DS2] * c2)
    p = c2 + (nodes[node, DP1] * c1 + nodes[node, DP2] * c2)
    place = math.tanh(0.5 * (motion[of.Y_0] - number * SPACING))
    once = twice = 0.0
    for n in range(_TERMS + 1, 1, -1):
        term = s * (s * wide[panel, W_SS, n] + p * wide[panel, W_SP, n])
        term += p * p * wide[panel, W_PP, n] + wide[panel, W_ONE, n]
        once = term + place * once
        twice = once + place * twice
        q[n - 2] = twice
    return place


@internal
def polished(motion, tables, guess, q):
    """Turning point near `guess`, in y from the start, and the slope of V there; `guess` and NaN if it is too far.

    Parameters
    ----------
    motion : float64[COLUMNS]
    tables : Tables
    guess : float64
    q : float64[at least 30]
        Memory.
    """
    number = int(round(motion[of.Y_0] / SPACING))
    if not (abs(motion[of.Y_0] + guess - number * SPACING) < _REACH and abs(number) <= SIDE):
        return guess, math.nan
    place = _expand(motion, tables, number, q)
    rest, tangent = 1.0 - place * place, math.tanh(0.5 * guess)
    pull = -2.0 * motion[of.FORCE] / rest
    distance, slope = rest * tangent / (1.0 + place * tangent), math.nan
    for _ in range(_STEPS):
        w, value, derivative = place + distance, 0.0, 0.0
        for n in range(_TERMS - 1, -1, -1):
            derivative = derivative * w + value
            value = value * w + q[n]
        slope = pull + distance * (2.0 * value + distance * derivative)
        distance -= (distance * (pull + distance * value) - motion[of.KINETIC]) / slope
    w = place + distance
    return 2.0 * math.atanh(distance / (rest - place * distance)), 0.5 * (1.0 - w * w) * slope


@internal
def settle_turns(motion, tables, q):
    """Move turning points that are wrong by more than a period allows; the others keep their bits.

    Arguments as in `polished`; `motion` is bounded, and its DISTANCE and SLOPE are written.
    """
    kicked = motion[of.W] != 0.0
    swing = abs(motion[of.DISTANCE] - (motion[of.DISTANCE + of.BEHIND] if kicked else 0.0))
    for turn in range(0, (of.BEHIND if kicked else 0) + 1, of.BEHIND):
        if TERM_ERROR * motion[of.LEVEL] > 0.1 * _SHARE * swing * abs(motion[of.SLOPE + turn]):
            distance, slope = polished(motion, tables, motion[of.DISTANCE + turn], q)
            if _SHARE * swing < abs(distance - motion[of.DISTANCE + turn]) < _MOST * swing:
                motion[of.DISTANCE + turn], motion[of.SLOPE + turn] = distance, slope
