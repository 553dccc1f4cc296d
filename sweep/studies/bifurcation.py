"""The steady motions that share the two constants of a motion, and the drift of the contact point in one period.

Scaled as in the kernels: time in units of sqrt(R/g), s = roll rate + precession rate * sin(tilt), o = precession rate *
cos(tilt). The constants c1, c2 of a motion are its s and o as it would pass upright (Chaplygin 1897). Diagrams in the
form of Borisov, Mamaev, Kilin, Regul. Chaotic Dyn. 8 (2003) 201.
"""

from dataclasses import dataclass

import numpy as np

from kernels.disk import motion_arrays
from kernels.disk.endings import HORIZON
from sweep.model.disk.theory import carried_rates
from sweep.model.kernel import Kernel
from sweep.model.quantity import Array, Truths
from sweep.studies.steady import marginal_curve

_TRAJECTORY = Kernel("kernels.disk.trajectory", "trajectory", seconds=1.0)

#: Steps of one nutation period, two RK4 steps each.
_STEPS = 2000

#: Largest tilt [rad], to either side, at which steady motions are looked for, and the number of tilts.
_MOST_TILT, _TILTS = 1.2, 4001

#: Tilt [rad] that no motion reaches: none is ended by a fall.
_FLAT = 0.5 * np.pi


@dataclass(frozen=True)
class Branch:
    """Steady motions with one value of c2: tilt [rad], c1, energy over m g R, and whether stable; shape (n,)."""

    tilt: Array
    c1: Array
    energy: Array
    stable: Truths


def fold(alpha: float) -> tuple[Array, Array]:
    """Return c1 and c2 of the steady motions with k = 0 (positive tilt and precession), from rolling to spinning.

    Along this line two of the steady motions that share the constants merge; at its two ends, cusps, all three do.
    """
    curve = marginal_curve(alpha, 1.0, 1.0)
    tilt, p = curve["tilt"], curve["precession_rate"]
    s, o = curve["roll_rate"] + p * np.sin(tilt), p * np.cos(tilt)
    return carried_rates(tilt, np.zeros_like(tilt), s, o, np.full_like(tilt, alpha))


def branches(alpha: float, c2: float) -> list[Branch]:
    """Return the steady motions with a given c2 as curves over their tilt.

    Parameters
    ----------
    alpha : float
    c2 : float
        Not 0: the curves for 0 cross at upright, where every c1 is steady.

    Returns
    -------
    list of Branch
        Of the two values of c1 at each tilt, the smaller and the larger ones.

    Notes
    -----
    s and o are linear in c1 and c2, so that the tilt equation at rest, S + o ((1+alpha) s - (alpha/2) o T) = 0, is a
    quadratic in c1. Stable where V'' > 0.
    """
    tilt = np.linspace(-_MOST_TILT, _MOST_TILT, _TILTS)
    zero, ones, alphas = np.zeros_like(tilt), np.ones_like(tilt), np.full_like(tilt, alpha)
    s1, o1 = carried_rates(zero, tilt, ones, zero, alphas)
    s2, o2 = (c2 * each for each in carried_rates(zero, tilt, zero, ones, alphas))
    tangent = np.tan(tilt)
    q1, q2 = ((1.0 + alpha) * s - 0.5 * alpha * o * tangent for s, o in ((s1, o1), (s2, o2)))
    a, b, c = o1 * q1, o1 * q2 + o2 * q1, np.sin(tilt) + o2 * q2
    found = []
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(b * b - 4.0 * a * c)
        large = -0.5 * (b + np.copysign(root, b))
        for c1 in (c / large, large / a):
            s, o = c1 * s1 + s2, c1 * o1 + o2
            energy = 0.5 * (1.0 + alpha) * s * s + 0.25 * alpha * o * o + np.cos(tilt)
            # V' = -(S + o q), q = (1+alpha) s - (alpha/2) o T, o' = oT - 2s
            o_slope = o * tangent - 2.0 * s
            q = (1.0 + alpha) * s - 0.5 * alpha * o * tangent
            q_slope = -o - 0.5 * alpha * (o_slope * tangent + o * (1.0 + tangent**2))
            stable = -(np.cos(tilt) + o_slope * q + o * q_slope) > 0.0
            there = np.isfinite(c1)
            found.append(Branch(tilt[there], c1[there], energy[there], stable[there]))
    return found


@dataclass(frozen=True)
class Drift:
    """The change of heading and contact point in one nutation period, shape (n,).

    `turn` [rad] is how far the heading has gone, `advance` [R] the distance between the contact points at the two ends.
    Period after period this is a rotation about a fixed centre: the contact point stays in a ring whose middle circle,
    through the ends of the periods, has the radius `radius` [R]; that is infinite, the drift unbounded, only if
    the heading comes back to itself.
    """

    turn: Array
    advance: Array
    radius: Array


def drift(tilt: Array, s: Array, o: Array, alpha: float, period: Array) -> Drift:
    """Integrate motions from a turning point, where the tilt is at rest, through one nutation period.

    Parameters
    ----------
    tilt : array, shape (n,)
        Turning point [rad].
    s, o : array, shape (n,)
        Scaled rates there.
    alpha : float
    period : array, shape (n,)
        Nutation period over sqrt(R/g).

    Returns
    -------
    Drift
        NaN where the period is not finite, or the motion could not be integrated.
    """
    precession_rate = o / np.cos(tilt)
    roll_rate = s - precession_rate * np.sin(tilt)
    ends = np.full((len(motion_arrays.SAMPLES), tilt.size), np.nan)
    for i in np.flatnonzero(np.isfinite(period)):
        start = np.array([tilt[i], 0.0, precession_rate[i], roll_rate[i], alpha, 1.0, 1.0])
        samples = np.empty((len(motion_arrays.SAMPLES), 2))
        settings = np.array([period[i] / _STEPS, 0.0, _FLAT])
        ending, *_ = _TRAJECTORY.load()(start, settings, np.array([0.0, period[i]]), samples)
        if ending == HORIZON:
            ends[:, i] = samples[:, 1]
    turn = ends[motion_arrays.HEADING]
    advance = np.hypot(ends[motion_arrays.CONTACT_X], ends[motion_arrays.CONTACT_Y])
    with np.errstate(divide="ignore"):
        return Drift(turn, advance, advance / (2.0 * np.abs(np.sin(0.5 * turn))))
