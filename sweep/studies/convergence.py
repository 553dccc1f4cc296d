"""The critical rate from integrations alone: boundaries of stricter and stricter criteria, extrapolated.

No analytic value is used. The boundary for a kick e is a power series in e^2, and for vanishing kicks one in the square
of the criterion's angle, or in one over the square of its amplification.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sweep.model.quantity import Array
from sweep.request.spec import SweepSpec
from sweep.runs.in_memory import run

#: Ends and number of the rates where the boundary is sought, in units of sqrt(g/R).
_SEARCHED = (0.3, 1.5, 13)

#: Kicks [1] over sqrt(g/R), and over the cube of the angle or of one over the amplification: small beside the limit.
_KICKS = (0.04, 0.08, 0.16)

_RADIUS, _GRAVITY = 0.5, 9.81

#: Width to which the rate is bisected [rad/s], and tolerance of the extreme tilts [rad].
_WIDTH, _TOLERANCE = 1e-12, 1e-12


@dataclass(frozen=True)
class Convergence:
    """Squared critical rates in units of g/R.

    `small`, shape (limits,): angle^2 [rad^2] or 1/amplification^2. `measured`, shape (kicks, alphas, limits);
    `kickless`, shape (alphas, limits): extrapolated to no kick; `value` and `slope`, shape (alphas,): extrapolated to
    the limit of the criterion, and d(value)/d(small) there.
    """

    small: Array
    measured: Array
    kickless: Array
    value: Array
    slope: Array


def convergence(axis: str, kind: str, limits: Sequence[float], alphas: Sequence[float]) -> Convergence:
    """Measure and extrapolate the critical rate of an upright disk.

    Parameters
    ----------
    axis : {"roll_rate", "precession_rate"}
        Rolling or spinning.
    kind : {"departure", "amplification"}
    limits : sequence of float
        Limits of the criterion: angles [rad] or amplifications.
    alphas : sequence of float
        Mass distributions, increasing.

    Returns
    -------
    Convergence
    """
    strict = 1.0 / np.array(limits) if kind == "amplification" else np.array(limits)
    unit_squared = _RADIUS / _GRAVITY
    low, high, count = _SEARCHED
    rows = []
    for limit, angle in zip(limits, strict, strict=True):
        kicks = [kick * angle**3 / unit_squared**0.5 for kick in _KICKS]
        atlas = run(
            SweepSpec(
                **{axis: f"{low / unit_squared**0.5}:{high / unit_squared**0.5}:{count}"},
                tilt_rate=kicks,
                alpha=list(alphas),
                radius=_RADIUS,
                gravity=_GRAVITY,
                criterion=f"{kind}:{limit!r}",
                tolerance=_TOLERANCE,
                boundary=f"refined:{_WIDTH!r}",
                axes=(axis, "tilt_rate", "alpha"),
            )
        )
        rows.append(atlas[f"boundary_{axis}"].values ** 2 * unit_squared)
    measured = np.stack(rows, axis=-1)
    squares = np.square(_KICKS)
    kickless = extrapolated(squares, measured)[0]
    value, slope = extrapolated(strict**2, np.moveaxis(kickless, -1, 0))
    return Convergence(strict**2, measured, kickless, value, slope)


def extrapolated(x: Array, values: Array) -> tuple[Array, Array]:
    """Return the value and the slope at x = 0 of the polynomial through points (Richardson, Neville).

    Parameters
    ----------
    x : array, shape (n,)
    values : array, shape (n, ...)

    Returns
    -------
    (value, slope) : arrays, shape (...)
    """
    weights = np.zeros((2, len(x)))
    for i, each in enumerate(x):
        others = np.delete(x, i)
        # Lagrange's polynomial at 0, and the logarithmic derivative of it
        weights[0, i] = np.prod(others / (others - each))
        weights[1, i] = -weights[0, i] * np.sum(1.0 / others)
    found = np.tensordot(weights, values, axes=(1, 0))
    return found[0], found[1]
