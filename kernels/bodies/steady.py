"""Steady motions of bodies of revolution, and their stability, in the same form as `kernels.disk.steady`.

Plain arithmetic on scalars and NumPy arrays. All quantities are scaled (`kernels.bodies.equations`); `body` is a
`Body`.
"""

from typing import Any, NamedTuple

import numpy as np


def _levers(S, C, body):
    """Return (a, b, lever) as from `kernels.bodies.equations.levers`, also for an arc of an ellipse."""
    n = 1.0 / np.sqrt(1.0 - (1.0 - body.square) * S * S)
    return (
        body.core + body.edge * (n * C),
        -body.shift - body.edge * (body.square * n) * S,
        body.core * S - body.shift * C + body.edge * n * (1.0 - body.square) * S * C,
    )


def _curvature(S, C, body):
    """Return (r, a - r C, h - r), also for an arc of an ellipse (`kernels.bodies.ellipse`)."""
    root = np.sqrt(1.0 - (1.0 - body.square) * S * S)
    n = 1.0 / root
    curved = body.square * n * n
    return (
        body.edge * (curved * n),
        body.core + body.edge * n * C * (1.0 - curved),
        body.core * C + body.shift * S + body.edge * (root - curved * n),
    )


def steady_spin(tilt, o, body):
    """Return the spin s that keeps the tilt constant at o = precession rate times cos(tilt); not finite if o is 0.

    Notes
    -----
    The tilt equation with zero acceleration: s = -[l + o^2 (h b/C - A T)] / [o (I + a h/C)].
    """
    S, C = np.sin(tilt), np.cos(tilt)
    a, b, lever = _levers(S, C, body)
    tall = (a * C - b * S) / C
    return -(lever + o * o * (tall * b - body.transverse * S / C)) / (o * (body.axial + a * tall))


def wobble_square(tilt, body):
    """Return the square of the precession rate at which the tilt is constant and the centre of mass at rest.

    Notes
    -----
    With a s + b o = 0 the same equation gives o^2 (A T + I b/a) = l: precession rate^2 = l/[C^2 (A T + I b/a)].
    """
    S, C = np.sin(tilt), np.cos(tilt)
    a, b, lever = _levers(S, C, body)
    return lever / (C * C * (body.transverse * S / C + body.axial * b / a))


def centred_spin(tilt, o, body):
    """Return the spin s at which the centre of mass of a body with constant tilt is at rest: -b o/a."""
    a, b, _ = _levers(np.sin(tilt), np.cos(tilt), body)
    return -b * o / a


class Nearby(NamedTuple):
    """A motion to first order in the deviation of its tilt from one state; all scaled, with slopes in the tilt.

    Attributes
    ----------
    coefficient, acceleration : float or array
        k and the acceleration in d'' = acceleration - k d, for a state without tilt rate.
    turning, ahead : (float or array, float or array)
        Rate of the heading, and speed of the contact point along the track, each with its slope.
    curvature : float or array
        Radius of curvature of the meridian; times the tilt rate, the speed of the contact point across the track.
    """

    coefficient: Any
    acceleration: Any
    turning: tuple[Any, Any]
    ahead: tuple[Any, Any]
    curvature: Any


def stability_coefficient(tilt, o, s, body):
    """Return the coefficient k of small oscillations d'' + k d = 0 about a steady motion, which is stable if k > 0."""
    return nearby(tilt, o, s, body).coefficient


def nearby(tilt, o, s, body):
    """Return the motion `Nearby` a state.

    Notes
    -----
    k is the second derivative of the potential, -(l + o M)', along the linear system of o and s, over the inertia B.
    """
    S, C = np.sin(tilt), np.cos(tilt)
    a, b, lever = _levers(S, C, body)
    r, inner, bend = _curvature(S, C, body)
    T, A, I = S / C, body.transverse, body.axial
    B, D = A + a * a + b * b, I * A + I * b * b + A * a * a
    twist = (inner * o - (r * S + body.ratio * b) * s) / D
    o_slope, s_slope = T * o - body.ratio * s - I * b * twist, -A * a * twist
    v, arm = a * s + b * o, a - b * T
    v_slope = a * s_slope + b * o_slope - r * (S * s + C * o)
    torque = I * s - A * T * o + arm * v
    torque_slope = I * s_slope - A * o / (C * C) - A * T * o_slope - b / (C * C) * v + arm * v_slope
    rolling, rolling_slope = s - o * T, s_slope - o_slope * T - o / (C * C)
    return Nearby(
        -(bend + o_slope * torque + o * torque_slope) / B, (lever + o * torque) / B,
        (o / C, (o_slope + o * T) / C), (a * rolling, a * rolling_slope - r * S * rolling), r,
    )  # fmt: skip


def critical_spin_square(body):
    """Return the square of the spin above which upright rolling of a balanced body is stable: A (1-r)/[I (1+I)].

    r is the radius of curvature of the meridian at the contact; if it is 1 or more, the motion is stable at any spin.
    """
    return body.transverse * (1.0 - body.edge * body.square) / (body.axial * (1.0 + body.axial))


def critical_precession_square(body):
    """Return the square of the precession rate above which upright spinning is stable: (1-r)/(1+A)."""
    return (1.0 - body.edge * body.square) / (1.0 + body.transverse)


def critical_pole_spin_square(body, side):
    """Return the square of the spin above which a ball or spheroid stays on its end; 0 or less if it always does.

    Parameters
    ----------
    body : Body
        Its meridian has its centre on the axis.
    side : float or array
        Sign of the tilt; with 1, a positive shift is above the centre.

    Notes
    -----
    The linear motion of a rolling body about the vertical: s^2 = 4 (A + h^2) (h - r)/(I + h r)^2, with h the height
    of the centre of mass and r the radius of curvature there. r = 0 gives the sleeping top.
    """
    q = np.sqrt(body.square)
    high, r = body.edge * q + side * body.shift, body.edge / q
    square = (body.axial + high * r) ** 2
    return 4.0 * (body.transverse + high * high) * (high - r) / square


def marginal_precession_rates(tilt, coefficient, body):
    """Return the precession rates of the steady motions at one tilt that have a given stability coefficient.

    Returns
    -------
    (slow, fast)
        As from `kernels.disk.steady.marginal_precession_rates`; NaN if there is no such motion.

    Notes
    -----
    The coefficient is a quadratic form of o and s. With o s = -(p + q o^2) of a steady motion, the condition times
    o^2 is a quadratic in o^2.
    """
    S, C = np.sin(tilt), np.cos(tilt)
    a, b, lever = _levers(S, C, body)
    tall = (a * C - b * S) / C
    arm = body.axial + a * tall
    p, q = lever / arm, (tall * b - body.transverse * S / C) / arm
    nothing = stability_coefficient(tilt, 0.0 * tilt, 0.0 * tilt, body)
    along = stability_coefficient(tilt, 1.0 + 0.0 * tilt, 0.0 * tilt, body) - nothing
    spin = stability_coefficient(tilt, 0.0 * tilt, 1.0 + 0.0 * tilt, body) - nothing
    mixed = stability_coefficient(tilt, 1.0 + 0.0 * tilt, 1.0 + 0.0 * tilt, body) - nothing - along - spin
    square = along - mixed * q + spin * q * q
    linear = nothing - coefficient - mixed * p + 2.0 * spin * p * q
    constant = spin * p * p
    with np.errstate(invalid="ignore", divide="ignore"):
        root = np.sqrt(linear * linear - 4.0 * square * constant)
        large = (-linear + root) / (2.0 * square)
        # the product of the roots is constant/square: no cancellation in the small one
        return np.sqrt(constant / (square * large)) / C, np.sqrt(large) / C
