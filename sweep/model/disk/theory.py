"""Theory of the disk without time stepping: edges of stability, folds of the potential, small oscillations.

Along any motion of the disk the two scaled rates s and o are linear combinations of two fixed functions of the tilt
(Chaplygin 1897), so the rate at which a start turns back at a given tilt is a closed expression.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from kernels.disk.steady import (
    critical_precession_rate_squared,
    critical_roll_rate_squared,
    marginal_precession_rates,
    stability_coefficient,
    steady_roll_rate,
)
from sweep.model.description import Request, Starts
from sweep.model.disk.initial_conditions import circling, computed_rates
from sweep.model.disk.tables import PARAMETERS
from sweep.model.quantity import Array

#: The terms decrease like sin(tilt)**n: this many give 1e-15 up to the steepest useful fall_tilt.
_MOST_TERMS = 200_000

#: Number of tilts on the way to the limit at which a barrier is searched, and the most values computed at once.
_ON_THE_WAY, _AT_ONCE = 32, 4096


class Formulas(NamedTuple):
    """The formulas of the disk or another body that theory needs; the first argument is the spec.

    Attributes
    ----------
    critical : callable
        (starts, rate) -> critical rate [rad/s] of the upright body that only rolls, or only spins.
    marginal : callable
        (starts, k) -> slow and fast precession rate [rad/s] of circling with the coefficient k [rad2/s2].
    turning : callable
        (starts, tilt, rate) -> rate [rad/s] at which starts turn back at a tilt; infinite if there is none.
    coefficient : callable
        (start of one cell) -> k [rad2/s2] of its undisturbed motion.
    released : callable
        (start of one cell, rate) -> largest tilt after a release from rest, over the tilt of the start.
    """

    critical: Callable[[Request, Starts, str], Array]
    marginal: Callable[[Request, Starts, Array | float], tuple[Array, Array]]
    turning: Callable[[Request, Starts, Array, str], Array]
    coefficient: Callable[[Request, Mapping[str, float]], float]
    released: Callable[[Request, Mapping[str, float], str], float]


def lines(
    spec: Request, axis: str, starts: Starts, formulas: "Formulas | None" = None
) -> dict[str, tuple[Array, Array]]:
    """Return the edges of the unstable band along a rate axis; see `sweep.model.description.Model.lines`.

    Parameters
    ----------
    spec : Request
    axis : str
        A rate that is an axis of the spec.
    starts : mapping of str to array, shape (n,)
        The starts of the rows along the axis.
    formulas : Formulas, optional
        By default those of the disk.

    Returns
    -------
    dict of str to (critical, predicted)
        For the ``"upper"`` edge (stable above it) and, where theory has one inside the axis, the ``"lower"`` edge:
        two arrays [rad/s], shape (n,).
    """
    of, along = formulas or FORMULAS, getattr(spec, axis).ends()
    if computed_rates(spec) and not circling(spec):
        # a start with its centre at rest rolls and precesses at the same time
        return {}
    if circling(spec):
        slow, fast = _circling_edges(spec, starts, of) if axis == "precession_rate" else (None, None)
    else:
        slow, fast = None, _upright_edges(spec, starts, axis, of)
    if fast is None:
        return {}
    if along[0] < 0.0 < along[1]:
        return {"upper": fast, "lower": _signed(fast, -1.0)}
    # the motion is symmetric under a change of sign of its rates: a negative axis has the mirrored band
    sign, outer, inner = (1.0, "upper", "lower") if along[1] > 0.0 else (-1.0, "lower", "upper")
    edges = {outer: _signed(fast, sign)}
    return edges if slow is None else edges | {inner: _signed(slow, sign)}


def _signed(edges: tuple[Array, Array], sign: float) -> tuple[Array, Array]:
    return sign * edges[0], sign * edges[1]


def critical_square(spec: Request, rate: str) -> str:
    """Return the squared critical rate of the upright disk, in mathtext."""
    rolling = rate == "roll_rate"
    if spec.alpha == 0.5:
        return "g/3R" if rolling else "4g/5R"
    if spec.alpha == 1.0:
        return "g/4R" if rolling else "2g/3R"
    return r"g/[2(1{+}\alpha)R]" if rolling else r"2g/[(2{+}\alpha)R]"


def _limit(spec: Request, starts: Starts) -> Array:
    """Return the departure [rad] from the steady tilt at which the criterion calls each cell unstable."""
    return np.asarray(np.nan_to_num(spec.criterion.allowed(spec.model.perturbation(spec, starts))))


def _circling_edges(
    spec: Request, given: Starts, of: Formulas
) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Return the slow and the fast edge of the band of unstable circling, each (critical, predicted).

    A kick e swings a stable steady motion out by e/sqrt(k), so the limit L of the criterion is met at k = (e/L)^2.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        slow, fast = of.marginal(spec, given, 0.0)
        predicted = of.marginal(spec, given, (given["tilt_rate"] / _limit(spec, given)) ** 2)
    return (slow, predicted[0]), (fast, predicted[1])


def _upright_edges(spec: Request, given: Starts, axis: str, of: Formulas) -> tuple[Array, Array] | None:
    """Return the (critical, predicted) rate of an upright disk that only rolls or only spins; None if all do both."""
    other = {"roll_rate": "precession_rate", "precession_rate": "roll_rate"}.get(axis)
    if other is None or np.all(given[other] != 0.0):
        return None
    reach = np.minimum(_limit(spec, given), spec.fall_tilt)
    outward = np.where(given["tilt"] < 0.0, -1.0, 1.0)
    predicted = _holding_rate(spec, given, outward * reach, axis, of)
    # a kicked disk swings to both sides, a released one only away from its start
    kicked = given["tilt_rate"] != 0.0
    if kicked.any():
        both = np.maximum(predicted, _holding_rate(spec, given, -outward * reach, axis, of))
        predicted = np.where(kicked, both, predicted)
    known = given[other] == 0.0
    return np.where(known, of.critical(spec, given, axis), np.nan), np.where(
        known & np.isfinite(predicted), predicted, np.nan
    )


def _holding_rate(spec: Request, given: Starts, tilt: Array, axis: str, of: Formulas) -> Array:
    """Return the least rate [rad/s] along `axis` at which a start turns back before `tilt` [rad]; infinite if none.

    Usually it is the rate at which the start turns back at `tilt`, but a tilted disk that is pushed towards upright may
    meet a barrier earlier. NaN for a start beyond `tilt`.
    """
    rates = np.full_like(given["tilt"], np.nan)
    # the series of a steep start has many terms: skip it where the result is not used
    inside = np.flatnonzero(np.abs(given["tilt"]) < np.abs(tilt))
    few = {name: values[inside] for name, values in given.items()}
    start, end = few["tilt"], tilt[inside]
    shares = np.arange(1, _ON_THE_WAY + 1) / _ON_THE_WAY
    if inside.size * _ON_THE_WAY <= _AT_ONCE:
        # a sum over a short array takes as long as one over a long array: all tilts at once
        tiled = {name: np.tile(values, _ON_THE_WAY) for name, values in few.items()}
        tilts = (start + shares[:, None] * (end - start)).reshape(-1)
        rates[inside] = of.turning(spec, tiled, tilts, axis).reshape(_ON_THE_WAY, inside.size).min(axis=0)
        return rates
    least = np.full_like(start, np.inf)
    for share in shares:
        least = np.minimum(least, of.turning(spec, few, start + share * (end - start), axis))
    rates[inside] = least
    return rates


def _turning_rate(given: Starts, tilt: Array, axis: str) -> Array:
    """Return the rate [rad/s] along `axis` at which a start turns back exactly at `tilt` [rad]; infinite if none.

    The scaled rates are s = p f, o = p g, with the wanted rate p and fixed functions f, g of the tilt, so energy
    conservation is linear in p^2.
    """
    start, alpha = given["tilt"], given["alpha"]
    unit_squared = given["radius"] / given["gravity"]
    f0 = np.ones_like(start) if axis == "roll_rate" else np.sin(start)
    g0 = np.zeros_like(start) if axis == "roll_rate" else np.cos(start)
    f, g = carried_rates(start, tilt, f0, g0, alpha)
    half = 0.5 * (tilt + start), 0.5 * (tilt - start)
    height = 0.5 * (1.0 + 0.5 * alpha) * given["tilt_rate"] ** 2 * unit_squared
    height = height + 2.0 * np.sin(half[0]) * np.sin(half[1])
    barrier = 0.5 * (1.0 + alpha) * (f - f0) * (f + f0) + 0.25 * alpha * (g - g0) * (g + g0)
    with np.errstate(divide="ignore", invalid="ignore"):
        rate = np.sqrt(np.maximum(height, 0.0) / (barrier * unit_squared))
    return np.where(barrier > 0.0, rate, np.inf)


def carried_rates(start: Array, tilt: Array, s0: Array, o0: Array, alpha: Array) -> tuple[Array, Array]:
    """Return the scaled rates s and o at `tilt` of a motion with s0 and o0 at `start`.

    Parameters
    ----------
    start, tilt : array, shape (n,)
        Tilts [rad], inside +-90 deg.
    s0, o0 : array, shape (n,)
        s = roll rate + precession rate * sin(tilt), o = precession rate * cos(tilt), in the same unit.
    alpha : array, shape (n,)
        Mass distribution [1].

    Returns
    -------
    (s, o) : arrays, shape (n,)

    Notes
    -----
    ds/dtheta = -o/(1+alpha), do/dtheta = -2s + o tan(theta) (Chaplygin 1897). With u = sin(theta), s obeys Legendre's
    equation (1-u^2) s'' - 2u s' - 2s/(1+alpha) = 0; its even and odd power series have positive terms only.
    """
    even, odd, even_slope, odd_slope = _legendre(np.sin(start), alpha)
    cos = np.cos(start)
    slope = -o0 / ((1.0 + alpha) * cos)
    # the Wronskian even * odd_slope - odd * even_slope is 1/cos^2 (Abel)
    a = (s0 * odd_slope - slope * odd) * cos**2
    b = (slope * even - s0 * even_slope) * cos**2
    even, odd, even_slope, odd_slope = _legendre(np.sin(tilt), alpha)
    return a * even + b * odd, -(1.0 + alpha) * np.cos(tilt) * (a * even_slope + b * odd_slope)


def _legendre(u: Array, alpha: Array) -> tuple[Array, Array, Array, Array]:
    """Return the even and the odd solution of Legendre's equation, s(0) = 1 or s'(0) = 1, and their derivatives."""
    constant = 2.0 / (1.0 + alpha)
    solutions = []
    for first in (0, 1):
        term = np.ones_like(u) if first == 0 else u.copy()
        total, slope = term.copy(), np.zeros_like(u) if first == 0 else np.ones_like(u)
        for n in range(first, _MOST_TERMS, 2):
            coefficient = (n * (n + 1) + constant) / ((n + 1) * (n + 2))
            # the derivative of the new term, (n + 2) * its value / u, without the division
            slope_term = coefficient * (n + 2) * term * u
            term = coefficient * term * u * u
            total += term
            slope += slope_term
            if np.all(np.abs(slope_term) <= 1e-17 * np.abs(slope)):
                break
        solutions.append((total, slope))
    (even, even_slope), (odd, odd_slope) = solutions
    return even, odd, even_slope, odd_slope


#: Number of nodes on the curve of folds; the interpolated rate has a relative error of 4e-8.
_NODES = 4000

#: Tilt [rad] of the ends of the curve: upright, where the disk only rolls or only spins.
_UPRIGHT = 1e-7

#: An upper bound of the tilt [rad] of steady motions with k = 0, for any alpha.
_STEEPEST = np.radians(20.0)


def saddle_node_rates(tilt: Array, axis: str, alpha: float) -> Array:
    """Return the rate at which the potential changes from two wells to one, for a disk that only rolls or only spins.

    Parameters
    ----------
    tilt : array, shape (n,)
        Tilt of the start [rad], inside +-90 deg.
    axis : {"roll_rate", "precession_rate"}
        The nonzero rate of the start.
    alpha : float
        Mass distribution [1].

    Returns
    -------
    array, shape (n,)
        Rate over sqrt(gravity/radius): below it the potential has two wells, above it one.

    Notes
    -----
    The tilt rate does not matter: the potential does not depend on it.
    """
    zero, one = np.zeros_like(tilt), np.ones_like(tilt)
    s0, o0 = (one, zero) if axis == "roll_rate" else (np.sin(tilt), np.cos(tilt))
    s, o = carried_rates(tilt, zero, s0, o0, alpha * one)
    direction, size = _curve(alpha)
    rate: Array = np.interp(np.arctan2(np.abs(o), np.abs(s)), direction, size) / np.hypot(s, o)
    return rate


@lru_cache(maxsize=8)
def _curve(alpha: float) -> tuple[Array, Array]:
    """Return the curve of folds in polar coordinates of (s, o) at upright: angle, from 0 to pi/2, and radius."""
    steepest = _steepest(alpha)
    # the two branches meet at the steepest tilt like the two sides of a parabola
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
    """Return the steepest tilt [rad] of a steady motion with k = 0, by bisection to 1e-12 rad from below."""
    low, high = _UPRIGHT, float(_STEEPEST)
    while high - low > 1e-12:
        middle = 0.5 * (low + high)
        exists = np.isfinite(marginal_precession_rates(np.array([middle]), 0.0, alpha, 1.0, 1.0)[1][0])
        low, high = (middle, high) if exists else (low, middle)
    return low


_DISK = ("alpha", "radius", "gravity")


def linear_prediction(
    spec: Request,
    start: Mapping[str, float],
    stored: Mapping[str, float],
    formulas: "Formulas | None" = None,
) -> Iterator[str]:
    """Yield the lines of `explain` with the prediction for a cell, from its start and its stored measures [SI]."""
    if not all(np.isfinite(list(start.values()))):
        return
    if not circling(spec) and start["roll_rate"] and start["precession_rate"]:
        yield "linear      no prediction: a disk that both rolls and precesses has no upright steady motion"
        return
    of = formulas or FORMULAS
    k = of.coefficient(spec, start)
    if not math.isfinite(k):
        yield "linear      no prediction: the squares of these rates overflow"
        return
    if k <= 0.0:
        growth = math.sqrt(-k)
        speed = f"doubles every {math.log(2.0) / growth:.4g} s" if growth else "grows"
        yield f"linear      unstable: k = {k:.6g} rad2 s-2 < 0, a tilt {speed} while it is small"
        return
    period = 2.0 * math.pi / math.sqrt(k)
    measured = stored["nutation_period"]
    in_cell = f" (the cell has {measured:.6g} s)" if np.isfinite(measured) else ""
    yield f"linear      stable: k = {k:.6g} rad2 s-2 > 0, small oscillations with a period of {period:.6g} s{in_cell}"
    reach = small_reach(spec, start, k, of)
    if reach is not None:
        yield f"            with a largest departure of {_angle(reach)} from the steady tilt"


def coefficient(spec: Request, start: Mapping[str, float]) -> float:
    """Return k [rad2 s-2] of the undisturbed motion of a cell: upright, or circling at its own tilt."""
    tilt = start["tilt"] if circling(spec) else 0.0
    rates = np.array([start["precession_rate"], start["roll_rate"]])
    with np.errstate(over="ignore", invalid="ignore"):
        return float(stability_coefficient(tilt, *rates, *(start[name] for name in _DISK)))


def small_reach(
    spec: Request, start: Mapping[str, float], k: float, formulas: "Formulas | None" = None
) -> float | None:
    """Return the largest departure [rad] in linear theory of a stable cell; None for a start with tilt and tilt rate.

    Notes
    -----
    A kick e swings out by e/sqrt(k). A release from the tilt t changes the steady motion, and the disk swings out to
    t (1 + 2/(r-1)) if it rolls and t (3 + 4/(r-1)) if it spins, with r = (rate / critical rate)^2.
    """
    if circling(spec) or start["tilt"] == 0.0:
        return abs(start["tilt_rate"]) / math.sqrt(k)
    if start["tilt_rate"] != 0.0:
        return None
    rate = "roll_rate" if start["roll_rate"] else "precession_rate"
    return abs(start["tilt"]) * (formulas or FORMULAS).released(spec, start, rate)


def _critical_rate(spec: Request, starts: Starts, axis: str) -> Array:
    return np.asarray(np.sqrt(_critical_square(axis, *(starts[name] for name in _DISK))))


def _critical_square(axis: str, *disk: Array | float) -> Any:
    if axis == "roll_rate":
        return critical_roll_rate_squared(*disk)
    return critical_precession_rate_squared(*disk)


def _marginal_rates(spec: Request, starts: Starts, k: Array | float) -> tuple[Array, Array]:
    slow, fast = marginal_precession_rates(starts["tilt"], k, *(starts[name] for name in _DISK))
    return slow, fast


def _released(spec: Request, start: Mapping[str, float], axis: str) -> float:
    r = start[axis] ** 2 / float(_critical_square(axis, *(start[name] for name in _DISK)))
    return 1.0 + 2.0 / (r - 1.0) if axis == "roll_rate" else 3.0 + 4.0 / (r - 1.0)


def _angle(value: float) -> str:
    return PARAMETERS["tilt"].spell(value, 6)


#: The formulas of the disk.
FORMULAS = Formulas(
    _critical_rate,
    _marginal_rates,
    lambda _, given, tilt, axis: _turning_rate(given, tilt, axis),
    coefficient,
    _released,
)
