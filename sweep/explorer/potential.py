"""The potential of one motion, as a curve to draw: how far it lies over the energy, its wells and its barriers.

A motion swings where its potential is below its energy. Everything is over m g R.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from sweep.model.quantity import Array

#: Longest step of the integration from the start to a stretched tilt, and the fewest steps: the curve is right to 1e-7
#: of its height up to 89 deg.
_STEP, _FEWEST = 0.06, 6

#: Places where extremes of the potential are sought, points of the curve, and steps of the search for an extreme.
_PLACES, _POINTS, _MOST_STEPS = 513, 241, 60

#: What is drawn beside the swing: this share of the height that is seen, above the energy and above the barrier.
_MARGIN = 0.45

#: A barrier that is more often as high over the energy as the well is deep below it is left out of the picture.
_FAR = 12.0

#: The tilt that stretches without end at 90 deg is drawn up to here, about 89.9 deg.
_STEEPEST = 7.0

#: Stretched tilts -> the potential there less the energy, and its slope.
_Curve = Callable[[Array], tuple[Array, Array]]


@dataclass(frozen=True)
class Potential:
    """The potential less the energy, over m g R, of one motion.

    `tilt` [rad] and `excess` [1] are the curve, shape (n,); the disk swings where the excess is negative. `wells` and
    `barriers` are the minima and maxima within the curve, as pairs of tilt and excess.
    """

    tilt: Array
    excess: Array
    wells: tuple[tuple[float, float], ...]
    barriers: tuple[tuple[float, float], ...]


def potential_of(start: Mapping[str, float], fall_tilt: float) -> Potential:
    """Return the potential of the motion that a start begins.

    Parameters
    ----------
    start : mapping of str to float
        Every parameter of the disk [SI].
    fall_tilt : float
        Tilt [rad] beyond which nothing is drawn.

    Notes
    -----
    (1 + alpha/2) w^2/2 + V = E with V = (1+alpha)/2 s^2 + alpha/4 o^2 + cos(tilt), where s and o are functions of the
    tilt alone (docs/theory.md; Borisov, Mamaev and Kilin, Regul. Chaotic Dyn. 8 (2003) 201).
    """
    curve = _curve_of(start)
    far = min(float(np.arctanh(np.sin(fall_tilt))), _STEEPEST)
    here = float(np.arctanh(np.sin(np.clip(start["tilt"], -fall_tilt, fall_tilt))))
    places = np.unique(np.append(np.linspace(-far, far, _PLACES), here))
    wells, barriers = _extremes(curve, places)
    low, high = _in_view(curve, here, far, wells, barriers)
    within = np.linspace(np.arcsin(np.tanh(low)), np.arcsin(np.tanh(high)), _POINTS)
    seen = [
        tuple((float(np.arcsin(np.tanh(y))), value) for y, value in found if low <= y <= high)
        for found in (wells, barriers)
    ]
    return Potential(within, curve(np.arctanh(np.sin(within)))[0], seen[0], seen[1])


def _curve_of(start: Mapping[str, float]) -> _Curve:
    """Return the function from stretched tilts y = atanh(sin(tilt)) to the potential there less the energy, and dV/dy.

    With p = o cos(tilt), ds/dy = -p/(1+alpha) and dp/dy = -2 s cos(tilt)^2. The changes of s and p since the start are
    integrated, so that the excess of a narrow swing is no difference of large numbers.
    """
    alpha, tilt = start["alpha"], start["tilt"]
    unit = float(np.sqrt(start["radius"] / start["gravity"]))
    turning, rolling = unit * start["precession_rate"], unit * start["roll_rate"]
    s0, p0 = rolling + turning * np.sin(tilt), turning * np.cos(tilt) ** 2
    y0 = float(np.arctanh(np.sin(tilt)))
    kinetic = 0.5 * (1.0 + 0.5 * alpha) * (unit * start["tilt_rate"]) ** 2

    def slopes(y: Array, s: Array, p: Array) -> tuple[Array, Array]:
        return -(p0 + p) / (1.0 + alpha), -2.0 * (s0 + s) / np.cosh(y) ** 2

    def curve(places: Array) -> tuple[Array, Array]:
        steps = max(_FEWEST, math.ceil(float(np.abs(places - y0).max()) / _STEP))
        h = (places - y0) / steps
        s, p = np.zeros_like(h), np.zeros_like(h)
        for i in range(steps):
            y = y0 + i * h
            s1, p1 = slopes(y, s, p)
            s2, p2 = slopes(y + 0.5 * h, s + 0.5 * h * s1, p + 0.5 * h * p1)
            s3, p3 = slopes(y + 0.5 * h, s + 0.5 * h * s2, p + 0.5 * h * p2)
            s4, p4 = slopes(y + h, s + h * s3, p + h * p3)
            s, p = (
                s + h / 6.0 * (s1 + 2.0 * s2 + 2.0 * s3 + s4),
                p + h / 6.0 * (p1 + 2.0 * p2 + 2.0 * p3 + p4),
            )
        there = np.arcsin(np.tanh(places))
        cos, cos0 = np.cos(there), np.cos(tilt)
        o, o0 = (p0 + p) / cos, p0 / cos0
        # o - o0, formed without the difference of two like numbers
        narrow = np.sin(0.5 * (there + tilt)) * np.sin(0.5 * (there - tilt))
        change = p / cos + 2.0 * p0 * narrow / (cos * cos0)
        rise = 0.5 * (1.0 + alpha) * s * (2.0 * s0 + s) + 0.25 * alpha * change * (o + o0) - 2.0 * narrow
        pull = np.sin(there) * cos + (1.0 + alpha) * (s0 + s) * (p0 + p) - 0.5 * alpha * o * o * np.sin(there)
        return np.asarray(rise - kinetic), np.asarray(-pull)

    return curve


def _extremes(curve: _Curve, places: Array) -> tuple[list[tuple[float, float]], list[tuple[float, float]]]:
    """Return minima and maxima within increasing places, each as stretched tilt and excess."""
    slope = curve(places)[1]
    wells: list[tuple[float, float]] = []
    barriers: list[tuple[float, float]] = []
    for i in np.flatnonzero((slope[:-1] < 0.0) != (slope[1:] < 0.0)):
        y = _root(
            lambda at: float(curve(np.array([at]))[1][0]),
            places[i : i + 2].tolist(),
            slope[i : i + 2].tolist(),
        )
        found = wells if slope[i] < 0.0 else barriers
        found.append((y, float(curve(np.array([y]))[0][0])))
    return wells, barriers


def _root(function: Callable[[float], float], ends: list[float], values: list[float]) -> float:
    """Return the root in an interval at whose ends a function has values of either sign (regula falsi, Illinois)."""
    (a, b), (fa, fb) = ends, values
    for _ in range(_MOST_STEPS):
        if fb == 0.0 or a == b:
            break
        c = b - fb * (b - a) / (fb - fa)
        if c in (a, b):
            break
        fc = function(c)
        a, fa = (b, fb) if (fc < 0.0) != (fb < 0.0) else (a, 0.5 * fa)
        b, fb = c, fc
    return b


def _in_view(
    curve: _Curve,
    here: float,
    far: float,
    wells: list[tuple[float, float]],
    barriers: list[tuple[float, float]],
) -> tuple[float, float]:
    """Return the stretched tilts between which the potential is drawn: as far as it stays below a height."""
    depth = max(-min([value for _, value in wells] + [float(curve(np.array([here]))[0][0])]), 0.0)
    # a disk at rest at the bottom of its well has no depth: what is near is drawn
    depth = depth or 1e-3
    near = [value for _, value in barriers if 0.0 <= value <= _FAR * depth]
    height = max(near, default=0.0)
    limit = height + _MARGIN * (height + depth)
    return _crossing(curve, here, -far, limit), _crossing(curve, here, far, limit)


def _crossing(curve: _Curve, here: float, end: float, limit: float) -> float:
    """Return the first stretched tilt from `here` on to `end` at which the excess is over a limit; `end` if none is."""
    # distances from the start over twelve decades: a swing may be as narrow
    shares = np.concatenate([np.geomspace(1e-12, 1e-2, 80), np.linspace(1e-2, 1.0, 240)[1:]])
    places = here + shares * (end - here)
    over = curve(places)[0] > limit
    if not over.any():
        return end
    first = int(over.argmax())
    low, high = (float(places[first - 1]) if first else here), float(places[first])
    near = np.linspace(low, high, 33)
    beyond = curve(near)[0] > limit
    return float(near[int(beyond.argmax())])
