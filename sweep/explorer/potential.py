"""The potential of one motion, as a curve to draw: how far it lies over the energy, its wells and its barriers.

A motion swings where its potential is below its energy. Everything is over m g R.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from sweep.model.quantity import Array

#: Steps of the integration from the start to a tilt: the curve is then right to 1e-7 of its height up to 89 deg.
_STEPS = 96

#: Places where extremes of the potential are sought, points of the curve, and how often the distance of the places
#: about an extreme is divided by sixteen: beyond that rounding decides where it is.
_PLACES, _POINTS, _CLOSER = 513, 241, 3

#: What is drawn beside the swing: this share of the height that is seen, above the energy and above the barrier.
_MARGIN = 0.45

#: A barrier that is more often as high over the energy as the well is deep below it is left out of the picture.
_FAR = 12.0

#: The tilt that stretches without end at 90 deg is drawn up to here, about 89.9 deg.
_STEEPEST = 7.0


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
    excess = _excess_of(start)
    far = min(float(np.arctanh(np.sin(fall_tilt))), _STEEPEST)
    places = np.linspace(-far, far, _PLACES)
    # a swing may be far narrower than the distance of two places
    here = float(np.arctanh(np.sin(np.clip(start["tilt"], -fall_tilt, fall_tilt))))
    values = excess(places)
    wells = [_extreme(excess, places, values, i, -1.0) for i in _turning(values, -1.0)]
    barriers = [_extreme(excess, places, values, i, 1.0) for i in _turning(values, 1.0)]
    low, high = _in_view(excess, here, far, wells, barriers)
    within = np.linspace(np.arcsin(np.tanh(low)), np.arcsin(np.tanh(high)), _POINTS)
    seen = [
        tuple((float(np.arcsin(np.tanh(y))), value) for y, value in found if low <= y <= high)
        for found in (wells, barriers)
    ]
    return Potential(within, excess(np.arctanh(np.sin(within))), seen[0], seen[1])


def _excess_of(start: Mapping[str, float]) -> Callable[[Array], Array]:
    """Return the function from stretched tilts y = atanh(sin(tilt)) to the potential there less the energy.

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

    def excess(places: Array) -> Array:
        h = (places - y0) / _STEPS
        s, p = np.zeros_like(h), np.zeros_like(h)
        for i in range(_STEPS):
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
        return np.asarray(rise - kinetic)

    return excess


def _turning(values: Array, sense: float) -> list[int]:
    """Return the places of the maxima (sense 1) or minima (sense -1) within an array."""
    up = sense * np.diff(values)
    return [int(i) + 1 for i in np.flatnonzero((up[:-1] > 0.0) & (up[1:] <= 0.0))]


def _extreme(
    excess: Callable[[Array], Array], places: Array, values: Array, at: int, sense: float
) -> tuple[float, float]:
    """Return an extreme next to a place, as stretched tilt and excess."""
    middle, half, value = float(places[at]), float(places[1] - places[0]), float(values[at])
    for _ in range(_CLOSER):
        near = np.linspace(middle - half, middle + half, 33)
        found = excess(near)
        best = int((sense * found).argmax())
        middle, half, value = float(near[best]), half / 16.0, float(found[best])
    return middle, value


def _in_view(
    excess: Callable[[Array], Array],
    here: float,
    far: float,
    wells: list[tuple[float, float]],
    barriers: list[tuple[float, float]],
) -> tuple[float, float]:
    """Return the stretched tilts between which the potential is drawn: as far as it stays below a height."""
    depth = max(-min([value for _, value in wells] + [float(excess(np.array([here]))[0])]), 0.0)
    # a disk at rest at the bottom of its well has no depth: what is near is drawn
    depth = depth or 1e-3
    near = [value for _, value in barriers if 0.0 <= value <= _FAR * depth]
    height = max(near, default=0.0)
    limit = height + _MARGIN * (height + depth)
    return _crossing(excess, here, -far, limit), _crossing(excess, here, far, limit)


def _crossing(excess: Callable[[Array], Array], here: float, end: float, limit: float) -> float:
    """Return the first stretched tilt from `here` on to `end` at which the excess is over a limit; `end` if none is."""
    # distances from the start over twelve decades: a swing may be as narrow
    shares = np.concatenate([np.geomspace(1e-12, 1e-2, 80), np.linspace(1e-2, 1.0, 240)[1:]])
    places = here + shares * (end - here)
    over = excess(places) > limit
    if not over.any():
        return end
    first = int(over.argmax())
    low, high = (float(places[first - 1]) if first else here), float(places[first])
    near = np.linspace(low, high, 33)
    beyond = excess(near) > limit
    return float(near[int(beyond.argmax())])
