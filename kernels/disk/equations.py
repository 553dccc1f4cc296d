"""Equations of motion of the rolling disk in the scaled, trigonometry-free form.

Time is counted in units of sqrt(R/g), so radius and gravity drop out. The state consists of six numbers:
S = sin(tilt), C = cos(tilt), T = tan(tilt), w = tilt rate, o = precession rate times cos(tilt), and
s = roll rate + precession rate times sin(tilt), all rates scaled. Every right-hand side is a polynomial: the inner
loop has neither trigonometry nor division, and the deviations from S*S + C*C = 1 and T = S/C measure the error.
"""

import math

from kernels.jit import kernel, simd


@simd
def inertia(alpha):
    """Return the constants of the equations for one mass distribution.

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


@simd
def slopes(state, i_spin, drag):
    """Return the derivatives of a motion with respect to its tilt, and the torque that accelerates the tilt.

    Parameters
    ----------
    state : tuple of 5 floats
        S, C, T, o (see the module docstring) and p = (1+alpha) s.
    i_spin, drag : float
        alpha/2 and 2/(1+alpha).

    Returns
    -------
    (dS, -dC, dT, do, -dp), acceleration
        Derivatives with respect to the tilt; times w they are derivatives in scaled time. The derivatives of C and p
        are -S and -o; they are returned without the sign, which would cost instructions. The tilt acceleration in
        scaled time, times 1 + alpha/2.

    Notes
    -----
    Newton's equations about the contact point with the rolling constraints eliminated; do and dp are Chaplygin's
    linear system ds/dtheta = -o/(1+alpha), do/dtheta = -2s + o tan(theta) (1897).
    """
    S, C, T, o, p = state
    oT = o * T
    return (C, S, 1.0 + T * T, oT - drag * p, o), S + o * (p - i_spin * oT)


@simd
def scaled(S, C, tilt_rate, precession_rate, roll_rate, unit):
    """Return the state (S, C, T, w, o, s) from sine, cosine and rates [rad/s] of a start; `unit` is sqrt(R/g) in s."""
    return (
        S,
        C,
        S / C,
        unit * tilt_rate,
        unit * precession_rate * C,
        unit * (roll_rate + precession_rate * S),
    )


@kernel
def scaled_state(tilt, tilt_rate, precession_rate, roll_rate, unit):
    """Return the state as from `scaled`, of a start given by its tilt [rad]."""
    return scaled(math.sin(tilt), math.cos(tilt), tilt_rate, precession_rate, roll_rate, unit)


@simd
def energy(S, C, w, o, s, alpha):
    """Return the energy over m g R (scaled state), which is conserved along every motion without slip."""
    return 0.5 * (1.0 + 0.5 * alpha) * w * w + 0.5 * (1.0 + alpha) * s * s + 0.25 * alpha * o * o + C


@simd
def energy_change(S, C, w, o, s, S0, C0, w0, o0, s0, alpha):
    """Return the energy minus the energy of the start, over m g R, computed from differences.

    Near upright all changes of the energy are of the order of tilt**2; in the difference of two energies, the
    rounding of cos(tilt) = 1 - tilt**2/2 would hide them.
    """
    return (
        0.5 * (1.0 + 0.5 * alpha) * (w - w0) * (w + w0)
        + 0.5 * (1.0 + alpha) * (s - s0) * (s + s0)
        + 0.25 * alpha * (o - o0) * (o + o0)
        - (S - S0) * (S + S0) / (C + C0)
    )


# The following functions are all that the stages of a cell need from the equations. Other bodies replace them by
# functions of the same names (`kernels.bodies.integrate`), whose `constants` are different.


@simd
def height(S, C, constants):
    """Return the height of the centre of mass, over R."""
    return C


@simd
def potential(S, C, o, s, constants):
    """Return the energy over m g R of a state without its tilt rate."""
    return 0.5 * constants[1] * s * s + 0.5 * constants[2] * o * o + C


@simd
def whole_energy(state, constants, alpha):
    """Return the energy over m g R."""
    S, C, _, w, o, s = state
    return energy(S, C, w, o, s, alpha)


@simd
def energy_gained(state, start, constants, alpha):
    """Return the energy minus the energy of the start (S, C, w, o, s), over m g R: `energy_change`."""
    S, C, _, w, o, s = state
    return energy_change(S, C, w, o, s, *start, alpha)


@simd
def per_inertia(S, C, constants):
    """Return the reciprocal moment of inertia of tilting, in units of 1/(m R^2)."""
    return constants[0]


@simd
def fastest_square(state, constants):
    """Return the square of the fastest rate of a state, including the rates of its linearised motion."""
    _, _, _, w, o, s = state
    return constants[0] * (1.0 + 2.0 * constants[1] * s * s) + o * o + w * w


@simd
def slopes_along(S, C, s, o, constants):
    """Return the derivatives d/dy of (S, C, s, o), where dtilt = C dy: Chaplygin's system without divisions."""
    return C * C, -S * C, -constants[3] * o * C, o * S - 2.0 * s * C


@simd
def fall_along(S, C, s, o, constants):
    """Return the slope of the potential with respect to y, over m g R."""
    return -(S * C + o * (constants[1] * s * C - constants[2] * o * S))


@simd
def pull_and_terms(state, constants):
    """Return the magnitude of the slope of the potential, and the sum of the magnitudes of its terms."""
    S, _, T, _, o, s = state
    p, oT = constants[1] * s, constants[2] * (o * T)
    return abs(S + o * (p - oT)), abs(S) + abs(o) * (abs(p) + abs(oT))


@simd
def force(state, constants):
    """Return the magnitude of the slope of the potential, over m g R, and its second derivative in the tilt.

    V' = -(S + o q) with q = (1+alpha) s - (alpha/2) o T, differentiated along s' = -o/(1+alpha), o' = oT - 2s.
    """
    S, C, T, _, o, s = state
    q = constants[1] * s - constants[2] * (o * T)
    o_slope = o * T - 2.0 * s
    q_slope = -o - constants[2] * (o_slope * T + o * (1.0 + T * T))
    return abs(S + o * q), -(C + o_slope * q + o * q_slope)
