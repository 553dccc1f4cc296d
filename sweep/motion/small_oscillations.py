"""Linear theory of one motion: the tilt oscillates, or grows, about its start; and the path that follows from it."""

import math
from dataclasses import dataclass

import numpy as np

from kernels.disk import arrays
from kernels.disk.steady import stability_coefficient
from sweep.model.quantity import Array


@dataclass(frozen=True)
class LinearMotion:
    """A motion by linear theory, at given times.

    `coefficient` is k [rad2/s2] of d'' + k d = 0: sqrt(k) is the frequency of the nutation, sqrt(-k) the rate of its
    growth. `tilt` [rad] and the contact point `x`, `y` [m] have the shape of the times.
    """

    coefficient: float
    tilt: Array
    x: Array
    y: Array


def linear_motion(start: Array, times: Array) -> LinearMotion:
    """Return the motion of a start by linear theory.

    Parameters
    ----------
    start : float64 array, shape (len(PARAMETERS),)
        Rows as in `kernels.disk.arrays.PARAMETERS`.
    times : float64 array, shape (n,)
        Increasing, from 0 [s]; dense enough to draw the path through.

    Returns
    -------
    LinearMotion

    Notes
    -----
    Along a motion the rates are functions of the tilt (Chaplygin 1897), with d(precession)/d(tilt) = -2 roll/cos(tilt)
    and d(roll)/d(tilt) = [2(1+alpha) roll sin - (2+alpha) precession cos^2]/[(1+alpha) cos]. To first order in the
    distance d from the start tilt the tilt equation then reads d'' = a - k d, with a the acceleration at the start and
    k the stability coefficient there. The path is that of the rates of first order.
    """
    tilt, rate, turning, rolling = (float(each) for each in start[: len(arrays.STATE)])
    alpha, radius, gravity = (float(start[row]) for row in (arrays.ALPHA, arrays.RADIUS, arrays.GRAVITY))
    sin, cos = math.sin(tilt), math.cos(tilt)
    k = float(stability_coefficient(tilt, turning, rolling, alpha, radius, gravity))
    push = 2.0 * gravity / radius * sin + (2.0 + alpha) * turning**2 * sin * cos
    acceleration = (push + 2.0 * (1.0 + alpha) * rolling * turning * cos) / (2.0 + alpha)
    away = _driven(k, acceleration, rate, times)
    turn = turning - 2.0 * rolling / cos * away
    spin_up = (2.0 * (1.0 + alpha) * rolling * sin - (2.0 + alpha) * turning * cos**2) / ((1.0 + alpha) * cos)
    roll = rolling + spin_up * away
    heading = _integral(turn, times)
    x = _integral(-radius * roll * np.sin(heading), times)
    y = _integral(radius * roll * np.cos(heading), times)
    return LinearMotion(k, tilt + away, x, y)


def _driven(k: float, acceleration: float, rate: float, times: Array) -> Array:
    """Solution of d'' = acceleration - k d with d(0) = 0 and d'(0) = rate."""
    if k == 0.0:
        return rate * times + 0.5 * acceleration * times**2
    root = math.sqrt(abs(k))
    with np.errstate(over="ignore"):
        # linear theory fails long before a growing tilt overflows
        swing = np.sin(root * times) if k > 0.0 else np.sinh(root * times)
        turn = 1.0 - np.cos(root * times) if k > 0.0 else 1.0 - np.cosh(root * times)
        return acceleration / k * turn + rate / root * swing


def _integral(values: Array, times: Array) -> Array:
    steps = 0.5 * (values[1:] + values[:-1]) * np.diff(times)
    return np.concatenate([[0.0], np.cumsum(steps)])
