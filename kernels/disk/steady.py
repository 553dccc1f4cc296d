"""Steady motions of the rolling disk, and their stability (all in physical units).

Tilt, precession rate and roll rate of a circling disk are constant; small oscillations about it obey d'' + k d = 0.
The functions are plain arithmetic on scalars and also accept NumPy arrays.
"""

import numpy as np


def steady_roll_rate(tilt, precession_rate, alpha, radius, gravity):
    """Return the roll rate [rad/s] that keeps the tilt constant at a given precession rate.

    Parameters
    ----------
    tilt : float or array
        Constant tilt [rad].
    precession_rate : float or array
        Precession rate [rad/s]. If it is zero, no roll rate supports a tilt, and the result is not finite.
    alpha, radius, gravity : float or array
        Mass distribution [1], radius [m], gravity [m/s^2].

    Returns
    -------
    float or array

    Notes
    -----
    The tilt equation with zero acceleration: with p = precession rate,
    -(4 g sin(tilt) + (2+alpha) R p^2 sin(2 tilt)) / (4 (1+alpha) R p cos(tilt)).
    """
    push = 4.0 * gravity * np.sin(tilt) + (2.0 + alpha) * radius * precession_rate**2 * np.sin(2.0 * tilt)
    return -push / (4.0 * (1.0 + alpha) * radius * precession_rate * np.cos(tilt))


def steady_precession_rates(tilt, roll_rate, alpha, radius, gravity):
    """Return the precession rates [rad/s] that keep the tilt constant at a given roll rate.

    Parameters
    ----------
    tilt, roll_rate, alpha, radius, gravity : float or array

    Returns
    -------
    (slow, fast) : floats or arrays
        The smaller and the larger one in magnitude; NaN if no precession supports the tilt. Both have the sign of
        -roll_rate * tilt, and their product is 2g / ((2+alpha) R cos(tilt)). As the tilt goes to zero, the slow one
        goes to zero (rolling along a line) and the fast one to infinity, so it is not finite at zero tilt.

    Notes
    -----
    `steady_roll_rate` solved for the precession rate p:
    (2+alpha) sin(tilt) p^2 + 2 (1+alpha) f p + 2 (g/R) tan(tilt) = 0 with the roll rate f.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        return both_precession_rates(tilt, roll_rate, alpha, radius, gravity)


def both_precession_rates(tilt, roll_rate, alpha, radius, gravity):
    """Return `steady_precession_rates`, for kernels, which cannot suppress warnings."""
    S, C = np.sin(tilt), np.cos(tilt)
    half, product = (1.0 + alpha) * roll_rate, 2.0 * gravity * S / (radius * C)
    root = np.sqrt(half * half - (2.0 + alpha) * S * product)
    # the root without cancellation; the other one follows from the product
    large = -(half + np.copysign(root, half))
    return product / large, large / ((2.0 + alpha) * S)


def wobble_precession_rate(tilt, alpha, radius, gravity):
    """Return the precession rate [rad/s] of the wobble: circling at a constant tilt with the centre at rest; positive.

    Parameters
    ----------
    tilt, alpha, radius, gravity : float or array

    Notes
    -----
    The tilt equation with zero acceleration and s = 0: p^2 = 2g / (alpha R cos(tilt)).
    """
    return np.sqrt(2.0 * gravity / (alpha * radius * np.cos(tilt)))


def centred_roll_rate(tilt, precession_rate):
    """Return the roll rate [rad/s] at which the centre of a disk with constant tilt is at rest: s = 0.

    Parameters
    ----------
    tilt, precession_rate : float or array
    """
    return -precession_rate * np.sin(tilt)


def stability_coefficient(tilt, precession_rate, roll_rate, alpha, radius, gravity):
    """Return the coefficient k [rad^2/s^2] of small oscillations about a steady motion, which is stable if k > 0.

    sqrt(k) is the nutation frequency of the disturbed motion, sqrt(-k) its growth rate. Parameters as in
    `steady_roll_rate`. Source: tilt equation linearised along Chaplygin's integrals,
    (2+alpha) k = -2 (g/R) cos(tilt) + (2+alpha) p^2 + (6+2 alpha) p f sin(tilt) + 4 (1+alpha) f^2.
    """
    p, f = precession_rate, roll_rate
    pull = -2.0 * gravity / radius * np.cos(tilt)
    mixed = (6.0 + 2.0 * alpha) * p * f * np.sin(tilt)
    return (pull + (2.0 + alpha) * p**2 + mixed + 4.0 * (1.0 + alpha) * f**2) / (2.0 + alpha)


def fall_rate_squared(alpha, radius, gravity):
    """Return the square [rad^2/s^2] of the rate at which an upright disk without spin falls: 2g/[(2+alpha)R]."""
    return 2.0 * gravity / ((2.0 + alpha) * radius)


def critical_roll_rate_squared(alpha, radius, gravity):
    """Return the square [rad^2/s^2] of the roll rate above which upright rolling is stable: g/[2(1+alpha)R]."""
    return gravity / (2.0 * (1.0 + alpha) * radius)


def critical_precession_rate_squared(alpha, radius, gravity):
    """Return the square [rad^2/s^2] of the precession rate above which upright spinning is stable: 2g/[(2+alpha)R]."""
    return fall_rate_squared(alpha, radius, gravity)


def marginal_precession_rates(tilt, coefficient, alpha, radius, gravity):
    """Return the precession rates [rad/s] of the steady motions at one tilt that have a given stability coefficient.

    Parameters
    ----------
    tilt : array
        Constant tilt [rad], not 0.
    coefficient : float or array
        The wanted k [rad^2/s^2]; 0 gives the boundary of stability.
    alpha, radius, gravity : float or array

    Returns
    -------
    (slow, fast) : arrays
        The smaller and the larger positive precession rate; NaN if no steady motion has that coefficient. As the tilt
        goes to zero, the slow branch joins rolling and the fast branch joins spinning.

    Notes
    -----
    With P = p^2, `steady_roll_rate` gives p f = -(a + b P). Inserted into `stability_coefficient` and multiplied by
    P, the condition is a quadratic in P.
    """
    C, S = np.cos(tilt), np.sin(tilt)
    a = gravity * S / ((1.0 + alpha) * radius * C)
    b = (2.0 + alpha) * S / (2.0 * (1.0 + alpha))
    mixed, rolling = (6.0 + 2.0 * alpha) * S, 4.0 * (1.0 + alpha)
    A = (2.0 + alpha) - mixed * b + rolling * b * b
    B = -2.0 * gravity / radius * C - (2.0 + alpha) * coefficient - mixed * a + 2.0 * rolling * a * b
    D = rolling * a * a
    with np.errstate(invalid="ignore", divide="ignore"):
        root = np.sqrt(B * B - 4.0 * A * D)
        large = (-B + root) / (2.0 * A)
        # the product of the roots is D/A: no cancellation in the small one
        return np.sqrt(D / (A * large)), np.sqrt(large)
