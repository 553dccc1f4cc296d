"""Equations of motion of a ball or a spheroid, regular at its poles.

At a pole the tangent of the tilt and the precession rate are infinite, but the motion is regular. The state is S, y,
x, s, n, p, q: the sine of the tilt and its rate y = S' = C w, x = C o, s, n = 1/sqrt(C^2 + square S^2) of the
meridian (`kernels.bodies.ellipse`, with core 0 and edge 1), p = 1/B and q = 1/D; the other letters are the same as in
`kernels.bodies.equations`. Every right-hand side is a polynomial, and the deviations of n, p and q from their
functions of the tilt measure the error. The energy E gives the sum of squares w^2 + o^2, which is 0/0 in the state
variables at a pole:

    B (w^2 + o^2) = 2 (E - h) - (I + a^2 + b^2) s^2 + (b s - n x)^2.

Functions take the state as (S, C, n, y, x, s, p, q), with the tilt first and its rate fourth, as for the disk; y = 0
at a turning point. A motion through a pole turns there: the tilt of the axis does not exceed 90 degrees.
"""

import math
from typing import Any, NamedTuple

from kernels.jit import simd


class Rolling(NamedTuple):
    """The constants of a motion: its `kernels.bodies.shapes.Body`, and its energy over m g R."""

    core: Any
    shift: Any
    edge: Any
    square: Any
    axial: Any
    transverse: Any
    ratio: Any
    energy: Any


@simd
def _shape(S, n, body):
    """Return (rest, b, l/C, r, h) at a tilt, with rest = 1 - square."""
    rest, leaning = 1.0 - body.square, n * S
    return (
        rest, -(body.square * leaning + body.shift), rest * leaning - body.shift, body.square * n * n * n,
        n * (1.0 - rest * S * S) + body.shift * S,
    )  # fmt: skip


@simd
def slopes(S, y, x, s, n, p, q, body):
    """Return the derivatives of (S, y, x, s, n, p, q) in scaled time.

    Notes
    -----
    From `kernels.bodies.equations`, with w^2 + o^2 from the energy.
    """
    rest, b, lever, r, high = _shape(S, n, body)
    A, I = body.transverse, body.axial
    square, nn, bb, yy, ry = 1.0 - S * S, n * n, b * b, y * y, r * y
    across = b * s - n * x
    turning = (2.0 * (body.energy - high) - (I + nn * square + bb) * s * s + across * across) * p
    twist = y * ((n - r) * x - (r * S + body.ratio * b) * s) * q
    pull = lever * (square + r * yy) + x * (s * (I + high * n) + n * b * x)
    return (
        y, (pull - S * (nn * yy + (A + bb) * turning)) * p, -(body.ratio * y * s + I * b * twist), -A * n * twist,
        rest * S * y * nn * n, 2.0 * ry * lever * p * p, 2.0 * ry * (I * b + A * n * S) * q * q,
    )  # fmt: skip


@simd
def _moved(start, slope, h):
    S, y, x, s, n, p, q = start
    dS, dy, dx, ds, dn, dp, dq = slope
    return S + h * dS, y + h * dy, x + h * dx, s + h * ds, n + h * dn, p + h * dp, q + h * dq


@simd
def lane_step(S, y, x, s, n, p, q, body, half):
    """Return the state after one step of the classical Runge-Kutta method, of scaled length 2 `half`."""
    start = S, y, x, s, n, p, q
    slope = slopes(*start, body)
    total = _moved(start, slope, (1.0 / 3.0) * half)
    slope = slopes(*_moved(start, slope, half), body)
    total = _moved(total, slope, (2.0 / 3.0) * half)
    slope = slopes(*_moved(start, slope, half), body)
    total = _moved(total, slope, (2.0 / 3.0) * half)
    slope = slopes(*_moved(start, slope, half + half), body)
    return _moved(total, slope, (1.0 / 3.0) * half)


@simd
def turning_square(S, x, s, n, body):
    """Return w^2 + o^2, from the energy."""
    _, b, _, _, high = _shape(S, n, body)
    aa, bb, across = n * n * (1.0 - S * S), b * b, b * s - n * x
    known = 2.0 * (body.energy - high) - (body.axial + aa + bb) * s * s
    return (known + across * across) / (body.transverse + aa + bb)


@simd
def is_beside_pole(S, turning):
    """Return whether C^2 (w^2 + o^2) = y^2 + x^2 determines the cosine of the tilt better than S does."""
    least = turning if turning < 1.0 else 1.0
    return (1.0 - S) * (1.0 + S) < 0.25 * least


@simd
def cosine(S, y, x, s, n, body):
    """Return the cosine of the tilt."""
    turning = turning_square(S, x, s, n, body)
    beside = is_beside_pole(S, turning)
    square = (x * x + y * y) / turning if beside else (1.0 - S) * (1.0 + S)
    return math.sqrt(square)


@simd
def inlined_step(state, body, h):
    """Return a state after one step."""
    S, _, n, y, x, s, p, q = state
    S, y, x, s, n, p, q = lane_step(S, y, x, s, n, p, q, body, 0.5 * h)
    return S, cosine(S, y, x, s, n, body), n, y, x, s, p, q


@simd
def begun(S, C, w, o, s, body):
    """Return the state of a start, from sine and cosine of the tilt and scaled rates."""
    n = 1.0 / math.sqrt(1.0 - (1.0 - body.square) * S * S)
    _, b, _, _, _ = _shape(S, n, body)
    A, I, aa, bb = body.transverse, body.axial, n * n * C * C, b * b
    return S, C, n, C * w, C * o, s, 1.0 / (A + aa + bb), 1.0 / (I * (A + bb) + A * aa)


@simd
def lost_energy(state, body):
    """Return C^2 times (energy of the motion minus energy of the state), over m g R; regular at a pole."""
    S, _, n, y, x, s, _, _ = state
    _, b, _, _, high = _shape(S, n, body)
    A, bb, square, nn = body.transverse, b * b, 1.0 - S * S, n * n
    known = body.energy - high - 0.5 * (body.axial + nn * square) * s * s - n * b * s * x
    return square * known - 0.5 * (A + nn * square + bb) * y * y - 0.5 * (A + bb) * x * x


@simd
def fastest_square(state, body):
    """Return the square of the fastest rate of a state (S, C, T, w, o, s), including those of its linearised motion.

    The shape changes over angles of the order of the radius of a pole, or of its reciprocal.
    """
    _, _, _, w, o, s = state
    A, pole = body.transverse, math.sqrt(body.square)
    sharp = body.square if pole > 1.0 else 1.0 / pole
    bent, high = abs(pole - 1.0 / pole) + abs(body.shift), pole - abs(body.shift)
    upright = (1.0 + abs(1.0 - body.square) + 2.0 * (body.axial + 1.0) * s * s) / (1.0 + A)
    on_end = (bent + 2.0 * (body.axial + 1.0) * s * s) / (A + high * high)
    return sharp * ((upright if upright > on_end else on_end) + sharp * (o * o + w * w))
