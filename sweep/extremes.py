"""The exact extreme tilts of one start: its turning points, found without following time.

Along a motion the two rates are functions of the tilt (`theory.carried_rates`), and so is what energy is left for the
tilt to move: where that is nothing, the disk turns (Chaplygin 1897).
"""

import math
from collections.abc import Callable, Mapping

import numpy as np

from sweep import theory
from sweep.schema import Array

#: The scan for a turning point begins this far from the start [rad], and takes so many steps, each a few per cent.
_NEAREST, _STEPS = 1e-9, 800


def exact_extremes(start: Mapping[str, float], fall_tilt: float) -> tuple[float, float]:
    """Return the turning points below and above a start.

    Parameters
    ----------
    start : mapping of str to float
        Every parameter of `schema.PARAMETERS`, in SI.
    fall_tilt : float
        Where the search ends [rad].

    Returns
    -------
    (least, greatest) : floats
        Extreme tilts [rad] for all time; NaN where the disk passes fall_tilt on that side.

    Notes
    -----
    In units of sqrt(radius/gravity), (1 + alpha/2)/2 w^2 + V(tilt) is constant, with
    V = (1+alpha)/2 s^2 + alpha/4 o^2 + cos(tilt); differences of V are formed without cancellation.
    """
    energy = _energy_left(start)
    tilt, rate = start["tilt"], start["tilt_rate"]
    push = float(energy(np.array([tilt + _NEAREST]))[0] - energy(np.array([tilt - _NEAREST]))[0])
    ends = []
    for side in (-1.0, 1.0):
        if rate == 0.0 and side * push <= 0.0:
            # released at rest: the start itself is the turning point on the side from which it is pushed away
            ends.append(tilt)
        else:
            ends.append(_turning_point(energy, tilt, side, fall_tilt))
    return ends[0], ends[1]


def _turning_point(energy: Callable[[Array], Array], tilt: float, side: float, fall_tilt: float) -> float:
    from scipy.optimize import brentq

    offsets = np.geomspace(_NEAREST, fall_tilt - side * tilt, _STEPS)
    left = energy(tilt + side * offsets)
    moving = np.flatnonzero(left > 0.0)
    if not moving.size:
        return tilt
    stopped = np.flatnonzero(left[moving[0] :] <= 0.0)
    if not stopped.size:
        return math.nan
    last = moving[0] + stopped[0]
    root = brentq(
        lambda offset: float(energy(np.array([tilt + side * offset]))[0]),
        float(offsets[last - 1]),
        float(offsets[last]),
        xtol=1e-15,
        rtol=1e-15,
    )
    return tilt + side * float(root)


def _energy_left(start: Mapping[str, float]) -> Callable[[Array], Array]:
    """Return the function tilt -> kinetic energy of the tilt, in units of mass * gravity * radius."""
    unit = math.sqrt(start["radius"] / start["gravity"])
    tilt, alpha, rate = start["tilt"], start["alpha"], start["tilt_rate"] * unit
    s0 = (start["roll_rate"] + start["precession_rate"] * math.sin(tilt)) * unit
    o0 = start["precession_rate"] * math.cos(tilt) * unit

    def energy(at: Array) -> Array:
        like = np.ones_like(at)
        s, o = theory.carried_rates(tilt * like, at, s0 * like, o0 * like, alpha * like)
        turn = 0.5 * (1.0 + alpha) * (s - s0) * (s + s0) + 0.25 * alpha * (o - o0) * (o + o0)
        height = 2.0 * np.sin(0.5 * (at + tilt)) * np.sin(0.5 * (at - tilt))
        return np.asarray(0.5 * (1.0 + 0.5 * alpha) * rate**2 - turn + height)

    return energy
