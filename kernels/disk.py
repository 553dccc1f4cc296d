"""Equations of motion of the rolling disk in the scaled, trigonometry-free form.

Time is counted in units of sqrt(R/g), so radius and gravity drop out. The state is carried as six numbers:
S = sin(tilt), C = cos(tilt), T = tan(tilt), w = tilt rate, o = precession rate times cos(tilt), and
s = roll rate + precession rate times sin(tilt), all rates scaled. Every right-hand side is a polynomial: neither
trigonometry nor division stands in the inner loop, and S*S + C*C = 1 and T = S/C come as free gauges of the error.
"""

import math

from numba import njit

#: fastmath may only contract a*b + c into one instruction: any further licence would let a NaN pass unnoticed.
CONTRACT = {"contract"}


@njit(error_model="numpy", fastmath=CONTRACT)
def inertia(alpha):
    """Constants of the equations for one mass distribution.

    Parameters
    ----------
    alpha : float
        Axial moment of inertia over m R^2 (1/2 uniform disk, 1 hoop).

    Returns
    -------
    tuple of 4 floats
        1/(1 + alpha/2), 1 + alpha, alpha/2, 1/(1 + alpha).
    """
    return 1.0 / (1.0 + 0.5 * alpha), 1.0 + alpha, 0.5 * alpha, 1.0 / (1.0 + alpha)


@njit(error_model="numpy", fastmath=CONTRACT, inline="always")
def derivatives(S, C, T, w, o, s, i_tilt, i_roll, i_spin, i_inverse):
    """Time derivatives of (S, C, T, w, o, s) in scaled time.

    Parameters
    ----------
    S, C, T, w, o, s : float
        The state (see the module docstring).
    i_tilt, i_roll, i_spin, i_inverse : float
        The constants of `inertia`.

    Returns
    -------
    tuple of 6 floats

    Notes
    -----
    Newton's equations about the contact point with the rolling constraints eliminated; the last two lines are
    Chaplygin's linear system ds/dtheta = -o/(1+alpha), do/dtheta = -2s + o tan(theta) (1897), times w.
    """
    oT = o * T
    return (
        C * w,
        -S * w,
        w + T * T * w,
        i_tilt * (S + o * (i_roll * s - i_spin * oT)),
        w * (oT - 2.0 * s),
        -i_inverse * (w * o),
    )


@njit(error_model="numpy", fastmath=CONTRACT)
def scaled_state(tilt, tilt_rate, precession_rate, roll_rate, unit):
    """State (S, C, T, w, o, s) of a start given in tilt [rad] and rates [rad/s]; `unit` is sqrt(R/g) in s."""
    S = math.sin(tilt)
    C = math.cos(tilt)
    return (
        S,
        C,
        S / C,
        unit * tilt_rate,
        unit * precession_rate * C,
        unit * (roll_rate + precession_rate * S),
    )


@njit(error_model="numpy", fastmath=CONTRACT)
def energy(S, C, w, o, s, alpha):
    """Energy over m g R (scaled state): conserved along every motion (physics of a disk without slip)."""
    return 0.5 * (1.0 + 0.5 * alpha) * w * w + 0.5 * (1.0 + alpha) * s * s + 0.25 * alpha * o * o + C


@njit(error_model="numpy", fastmath=CONTRACT)
def energy_change(S, C, w, o, s, S0, C0, w0, o0, s0, alpha):
    """Energy minus the start's energy, over m g R, formed from differences.

    Subtracting two energies would drown a nearly upright motion, whose whole budget is tilt**2, in the rounding of
    cos(tilt) = 1 - tilt**2/2.
    """
    return (
        0.5 * (1.0 + 0.5 * alpha) * (w - w0) * (w + w0)
        + 0.5 * (1.0 + alpha) * (s - s0) * (s + s0)
        + 0.25 * alpha * (o - o0) * (o + o0)
        - (S - S0) * (S + S0) / (C + C0)
    )
