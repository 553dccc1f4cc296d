"""Equations of motion of a body of revolution, in the variables of the thin disk.

State and scaling are the same as in `kernels.disk.equations`. The contact point is at -a d + b n from the centre of
mass, with n the axis of the body and d its diameter through that point; the weight acts at the lever arm
l = a S + b C. Here the meridian is an arc of a circle: a = core + edge C and b = -shift - edge S. For an arc of an
ellipse, functions of `kernels.bodies.ellipse` replace those of the same names. With A and I the transverse and the
axial moment of inertia,

    B = A + a^2 + b^2         inertia of tilting about the contact point,
    D = I A + I b^2 + A a^2   determinant of the inertia of the other two rotations,
    v = a s + b o             speed of the centre of mass along the track,

the potential over m g R is A o^2/2 + I s^2/2 + v^2/2 + h, where h is the height of the centre of mass. Along any
motion s and o are functions of the tilt, which obey a linear system. The thin disk is the arc (1, 0, 0) with
A = alpha/2, I = alpha.
"""

from kernels.disk.rk4 import _along, _summed
from kernels.jit import simd


@simd
def levers(S, C, body):
    """Return (a, b, l) of the module docstring."""
    return body.core + body.edge * C, -(body.shift + body.edge * S), body.core * S - body.shift * C


@simd
def curvature_radius(S, C, body):
    """Return the radius of curvature r of the meridian."""
    return body.edge


@simd
def evolute(S, C, body):
    """Return the distance a - r C of the centre of curvature from the axis."""
    return body.core


@simd
def excess(S, C, body):
    """Return the height of the centre of mass above the centre of curvature, h - r."""
    return body.core * C + body.shift * S


@simd
def _inertia(a, b, body):
    """Return (B, D) of the module docstring."""
    A, aa, bb = body.transverse, a * a, b * b
    return A + aa + bb, body.axial * (A + bb) + A * aa


@simd
def slopes(state, w, body):
    """Return the derivatives d/dtilt of a motion, and its tilt acceleration; see `kernels.disk.equations.slopes`.

    Parameters
    ----------
    state : tuple of 5 floats
        S, C, T, o, s.
    w : float
    body : Body

    Returns
    -------
    (dS, -dC, dT, do, -ds), acceleration
        The tilt acceleration is in scaled time.

    Notes
    -----
    Newton's and Euler's equations about the contact point, with the rolling constraints eliminated.
    """
    S, C, T, o, s = state
    a, b, lever = levers(S, C, body)
    A, I = body.transverse, body.axial
    B, D = _inertia(a, b, body)
    # one division costs as much as integrating 1/B and 1/D, and saves two states; two divisions cost twice that
    inverse = 1.0 / (B * D)
    oT = o * T
    r, inner = curvature_radius(S, C, body), evolute(S, C, body)
    twist = (inner * o - (r * S + body.ratio * b) * s) * (B * inverse)
    torque = I * s - A * oT + (a - b * T) * (a * s + b * o)
    acceleration = (lever * (1.0 + r * w * w) + o * torque) * (D * inverse)
    return (C, S, 1.0 + T * T, oT - body.ratio * s - I * b * twist, A * a * twist), acceleration


@simd
def lane_step(S, C, T, w, o, s, body, half):
    """Return the state after one RK4 step of scaled length 2 `half`; see `kernels.disk.rk4.lane_step`."""
    start = S, C, T, o, s
    slope, first = slopes(start, w, body)
    angle = half * w
    total = angle * slope[0], angle * slope[1], angle * slope[2], angle * slope[3], angle * slope[4]
    rate = w + half * first
    slope, second = slopes(_along(start, slope, angle), rate, body)
    total = _summed(total, slope, (half + half) * rate)
    angle, rate = half * rate, w + half * second
    slope, third = slopes(_along(start, slope, angle), rate, body)
    angle = (half + half) * rate
    total = _summed(total, slope, angle)
    rate = w + (half + half) * third
    slope, fourth = slopes(_along(start, slope, angle), rate, body)
    dS, lC, dT, do, ls = _summed(total, slope, half * rate)
    second += third
    part = 1.0 / 3.0  # a division would cost a tenth of the step
    return (
        S + part * dS,
        C - part * lC,
        T + part * dT,
        w + part * half * ((first + fourth) + (second + second)),
        o + part * do,
        s - part * ls,
    )


@simd
def inlined_step(state, body, h):
    """Return a state (6 floats) after one RK4 step."""
    S, C, T, w, o, s = state
    return lane_step(S, C, T, w, o, s, body, 0.5 * h)


@simd
def tilt_acceleration(state, body):
    """Return the scaled second derivative of the tilt in `state`."""
    S, C, T, w, o, s = state
    _, acceleration = slopes((S, C, T, o, s), w, body)
    return acceleration


@simd
def carried(state, body, angle):
    """Return the state at rest at a slightly different tilt, to first order; the second order is below rounding."""
    S, C, T, w, o, s = state
    (dS, lC, dT, do, ls), _ = slopes((S, C, T, o, s), w, body)
    return S + angle * dS, C - angle * lC, T + angle * dT, 0.0, o + angle * do, s - angle * ls


@simd
def height(S, C, body):
    """Return the height of the centre of mass, over R."""
    return body.core * C + body.shift * S + body.edge


@simd
def potential(S, C, o, s, body):
    """Return the energy over m g R of a state without its tilt rate."""
    a, b, _ = levers(S, C, body)
    v = a * s + b * o
    return 0.5 * (body.transverse * o * o + body.axial * s * s + v * v) + height(S, C, body)


@simd
def whole_energy(state, body, axial):
    """Return the energy over m g R."""
    S, C, _, w, o, s = state
    return 0.5 * w * w / per_inertia(S, C, body) + potential(S, C, o, s, body)


@simd
def energy_gained(state, start, body, axial):
    """Return the energy minus the energy of the start (S, C, w, o, s), over m g R, computed from differences."""
    S, C, _, w, o, s = state
    S0, C0, w0, o0, s0 = start
    a, b, _ = levers(S, C, body)
    a0, b0, _ = levers(S0, C0, body)
    rise, fall = S - S0, -(S - S0) * (S + S0) / (C + C0)
    longer, wider = body.edge * fall, -body.edge * rise
    B, _ = _inertia(a, b, body)
    v, v0 = a * s + b * o, a0 * s0 + b0 * o0
    # v - v0
    faster = a * (s - s0) + s0 * longer + b * (o - o0) + o0 * wider
    return (
        0.5 * B * (w - w0) * (w + w0)
        + 0.5 * (longer * (a + a0) + wider * (b + b0)) * w0 * w0
        + 0.5 * body.transverse * (o - o0) * (o + o0)
        + 0.5 * body.axial * (s - s0) * (s + s0)
        + 0.5 * faster * (v + v0)
        + body.core * fall
        + body.shift * rise
    )


@simd
def per_inertia(S, C, body):
    """Return the reciprocal moment of inertia of tilting, in units of 1/(m R^2)."""
    a, b, _ = levers(S, C, body)
    return 1.0 / (body.transverse + a * a + b * b)


@simd
def fastest_square(state, body):
    """Return the square of the fastest rate of a state, including the rates of its linearised motion."""
    S, C, _, w, o, s = state
    a, b, _ = levers(S, C, body)
    per = 1.0 / (body.transverse + a * a + b * b)
    return per * (1.0 + 2.0 * (body.axial + a * a) * s * s) + o * o + w * w


@simd
def slopes_along(S, C, s, o, body):
    """Return the derivatives of (S, C, s, o) with respect to y, where dtilt = C dy."""
    a, b, _ = levers(S, C, body)
    _, D = _inertia(a, b, body)
    r, inner = curvature_radius(S, C, body), evolute(S, C, body)
    twist = C * (inner * o - (r * S + body.ratio * b) * s) / D
    spin = -body.transverse * a * twist
    return C * C, -S * C, spin, o * S - body.ratio * s * C - body.axial * b * twist


@simd
def fall_along(S, C, s, o, body):
    """Return the slope of the potential with respect to y, over m g R."""
    a, b, lever = levers(S, C, body)
    return -(
        C * lever + o * (C * body.axial * s - body.transverse * o * S + (a * C - b * S) * (a * s + b * o))
    )


@simd
def pull_and_terms(state, body):
    """Return the magnitude of the slope of the potential, and the sum of the magnitudes of its terms."""
    S, C, T, _, o, s = state
    a, b, lever = levers(S, C, body)
    A, I = body.transverse, body.axial
    oT, arm = o * T, a - b * T
    pull = abs(lever + o * (I * s - A * oT + arm * (a * s + b * o)))
    heavy = body.core * abs(S) + abs(body.shift) * C
    return pull, heavy + abs(o) * (I * abs(s) + A * abs(oT) + abs(arm) * (abs(a * s) + abs(b * o)))


@simd
def is_steady(state, body):
    """Return whether a state is a steady motion, to within rounding."""
    pull, terms = pull_and_terms(state, body)
    return (state[3] == 0.0) & (pull <= 8.0 * 2.0**-52 * terms)


@simd
def force(state, body):
    """Return the magnitude of the slope of the potential, over m g R, and its second derivative in the tilt.

    V' = -(l + o M) with M = I s - A o T + (a - b T) v, differentiated along the linear system; (a - b T)' = -b/C^2.
    """
    S, C, T, _, o, s = state
    a, b, lever = levers(S, C, body)
    (_, _, _, o_slope, less), _ = slopes((S, C, T, o, s), 0.0, body)
    A, I, s_slope = body.transverse, body.axial, -less
    arm, v, square = a - b * T, a * s + b * o, 1.0 + T * T
    v_slope = a * s_slope + b * o_slope - curvature_radius(S, C, body) * (S * s + C * o)
    torque = I * s - A * o * T + arm * v
    torque_slope = I * s_slope - A * (o_slope * T + o * square) - b * square * v + arm * v_slope
    bend = excess(S, C, body)
    return abs(lever + o * torque), -(bend + o_slope * torque + o * torque_slope)
