"""The curve of folds: where a start passes from a potential of two wells to one of one well, from theory alone.

A motion's potential is a function of the tilt with two constants, the rates that the motion has at upright. Where a
saddle of the potential and a minimum merge, the steady motion that sits there has stability coefficient k = 0, and so
the curve of folds in the plane of the two constants is the curve k = 0 of steady circling, carried to upright.
"""

from functools import lru_cache

import numpy as np

from kernels.disk.steady import marginal_precession_rates, steady_roll_rate
from sweep.model.disk.theory import carried_rates
from sweep.model.quantity import Array

#: Nodes on the curve; between them it is interpolated, to 4e-8 of the rate.
_NODES = 4000

#: The curve's ends: where the disk only rolls (0) and where it only spins (1), k = 0 upright.
_UPRIGHT = 1e-7

#: No steady motion with k = 0 is steeper, whatever its alpha.
_STEEPEST = np.radians(20.0)


def saddle_node_rates(tilt: Array, axis: str, alpha: float) -> Array:
    """Return the rate at which the potential of a disk that only rolls, or only spins, changes from two wells to one.

    Parameters
    ----------
    tilt : array, shape (n,)
        Tilt of the start [rad], inside +-90 deg.
    axis : {"roll_rate", "precession_rate"}
        The rate that the start has; the other one is zero.
    alpha : float
        Mass distribution [1].

    Returns
    -------
    array, shape (n,)
        Rate over sqrt(gravity/radius): below it there are two wells, above it one.

    Notes
    -----
    The rate of the tilt does not matter: it is no constant of the potential.
    """
    zero, one = np.zeros_like(tilt), np.ones_like(tilt)
    s0, o0 = (one, zero) if axis == "roll_rate" else (np.sin(tilt), np.cos(tilt))
    s, o = carried_rates(tilt, zero, s0, o0, alpha * one)
    direction, size = _curve(alpha)
    found: Array = np.interp(np.arctan2(np.abs(o), np.abs(s)), direction, size) / np.hypot(s, o)
    return found


@lru_cache(maxsize=8)
def _curve(alpha: float) -> tuple[Array, Array]:
    """The curve of folds in polar coordinates of (s, o) at upright: angle, increasing from 0 to pi/2, and radius."""
    steepest = _steepest(alpha)
    # the two branches meet at the steepest tilt like the sides of a parabola
    tilt = steepest * (1.0 - np.linspace(0.0, np.sqrt(1.0 - _UPRIGHT), _NODES) ** 2)
    one = np.ones_like(tilt)
    branches = []
    for precession in marginal_precession_rates(tilt, 0.0, alpha, one, one):
        roll = steady_roll_rate(tilt, precession, alpha, one, one)
        rates = roll + precession * np.sin(tilt), precession * np.cos(tilt)
        branches.append(carried_rates(tilt, 0.0 * tilt, *rates, alpha * one))
    (slow_s, slow_o), (fast_s, fast_o) = branches
    s, o = np.concatenate((slow_s[::-1], fast_s)), np.concatenate((slow_o[::-1], fast_o))
    known = np.isfinite(s) & np.isfinite(o)
    return np.arctan2(np.abs(o[known]), np.abs(s[known])), np.hypot(s[known], o[known])


def _steepest(alpha: float) -> float:
    """The steepest tilt [rad] of a steady motion with k = 0, by bisection; at 1e-12 rad below it there is one."""
    low, high = _UPRIGHT, float(_STEEPEST)
    while high - low > 1e-12:
        middle = 0.5 * (low + high)
        exists = np.isfinite(marginal_precession_rates(np.array([middle]), 0.0, alpha, 1.0, 1.0)[1][0])
        low, high = (middle, high) if exists else (low, middle)
    return low
