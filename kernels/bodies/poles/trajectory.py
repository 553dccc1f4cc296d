"""One motion of a ball or a spheroid sampled in time, through its poles; see `kernels.bodies.trajectory`.

At a pole the heading is undefined, and near one it changes by half a turn almost at once. The horizontal part of the
axis, -C (cos heading, sin heading), passes smoothly through 0 there, and its velocity, S w along the lean and -o
along the track, does not vanish. So the direction of this velocity is integrated, which is the heading minus the
`lean` atan2(x, S y), and the sum of roll angle and heading (at the other pole, their difference). The letters are the
same as in `kernels.bodies.poles.equations`.
"""

import math

from kernels.bodies import arrays as row
from kernels.bodies.poles import equations
from kernels.bodies.poles.equations import (
    Rolling,
    begun,
    fastest_square,
    is_beside_pole,
    lost_energy,
    turning_square,
)
from kernels.bodies.starts import body_of
from kernels.bodies.trajectory import Flow, Forces, _trajectory
from kernels.disk.endings import HORIZON
from kernels.disk.equations import scaled_state
from kernels.jit import kernel, simd
from kernels.lanes.binding import variant

#: Square of the cosine of the tilt below which the change of the energy cannot be distinguished from its rounding.
_LEAST = 0.01


@simd
def set_out(start, kind):
    """See `kernels.bodies.trajectory.set_out`."""
    unit = math.sqrt(start[row.RADIUS, 0] / start[row.GRAVITY, 0])
    rates = start[row.TILT_RATE, 0], start[row.PRECESSION_RATE, 0], start[row.ROLL_RATE, 0]
    S, C, _, w, o, s = scaled_state(start[row.TILT, 0], rates[0], rates[1], rates[2], unit)
    arc = body_of(start, 0, kind)
    n = 1.0 / math.sqrt(1.0 - (1.0 - arc.square) * S * S)
    a, b, high = n * C, -(arc.square * n * S + arc.shift), 1.0 / n + arc.shift * S
    v, A, I = a * s + b * o, arc.transverse, arc.axial
    energy = 0.5 * ((A + a * a + b * b) * w * w + A * o * o + I * s * s + v * v) + high
    body = Rolling(0.0, arc.shift, 1.0, arc.square, I, A, arc.ratio, energy)
    return begun(S, C, w, o, s, body), body


@simd
def rates_of(state):
    """Return (S, C, w, o, s) of a state; w and o are set to 0 exactly at a pole, where they are undefined."""
    S, C, _, y, x, s, _, _ = state
    divisor = C if C > 0.0 else 1.0
    return S, C, y / divisor, x / divisor, s


@simd
def pole_near(state, body):
    """See `kernels.bodies.trajectory.pole_near`."""
    S, _, n, _, x, s, _, _ = state
    return math.copysign(1.0, S) if is_beside_pole(S, turning_square(S, x, s, n, body)) else 0.0


@simd
def lean(state, pole):
    """See `kernels.bodies.trajectory.lean`."""
    S, _, _, y, x, _, _, _ = state
    return math.atan2(x, S * y) if pole != 0.0 else 0.0


@simd
def _shape(S, n, body):
    """Return (b, l/C, r, h, n S) at a tilt."""
    rest, leaning = 1.0 - body.square, n * S
    b, lever = -(body.square * leaning + body.shift), rest * leaning - body.shift
    return b, lever, body.square * n * n * n, n * (1.0 - rest * S * S) + body.shift * S, leaning


@simd
def flow(state, body, pole):
    """See `kernels.bodies.trajectory.flow`.

    Notes
    -----
    With Q = w^2 + o^2 and G of `forces`, the direction of the horizontal velocity of the axis turns with
    [S w^2 (I s/A + I b P/D) + S o G + x Q]/(Q - y^2).
    """
    S, C, n, y, x, s, p, q = state
    b, lever, r, high, leaning = _shape(S, n, body)
    _, _, w, o, _ = rates_of(state)
    I = body.axial
    ahead, aside = n * (C * s - S * o), r * w
    gaining = n * (high - r) * y * s - w * o * (high * leaning + r * b)
    if pole == 0.0:
        turning = o / C
        return Flow(turning, s - turning * S, ahead, aside, gaining)
    square = turning_square(S, x, s, n, body)
    across = o * o
    twist = ((n - r) * x - (r * S + body.ratio * b) * s) * q
    inward = body.ratio * s + I * b * twist
    outward = s * (I + n * n * C * C - b * leaning) + n * x * (b + leaning)
    pull = lever * x * (1.0 + r * (square - across)) + across * outward
    turning = (S * ((square - across) * inward + pull * p) + square * x) / (square - y * y)
    return Flow(turning, s + pole * x / (1.0 + abs(S)), ahead, aside, gaining)


@simd
def forces(state, start, body):
    """See `kernels.bodies.trajectory.forces`.

    Notes
    -----
    G, the tilt acceleration plus o^2 T, is regular: its product with B is
    o s (I + a^2 - n b S) + n o x (b + n S) + l (1 + r w^2). The friction across the track is
    h G - l (w^2 + o^2) - n o s.
    """
    S, C, n, y, x, s, p, q = state
    b, lever, r, high, leaning = _shape(S, n, body)
    _, _, w, o, _ = rates_of(state)
    A, I, rest = body.transverse, body.axial, 1.0 - body.square
    square = turning_square(S, x, s, n, body)
    pull = (
        C * lever * (1.0 + r * w * w) + o * s * (I + n * n * C * C - b * leaning) + n * o * x * (b + leaning)
    )
    inward = pull * p
    rise = C * inward - S * square
    twist = ((n - r) * x - (r * S + body.ratio * b) * s) * q
    across = (1.0 - S) * (1.0 + S)
    change = -lost_energy(state, body) / (across if across > _LEAST else _LEAST)
    momentum = A * x + I * S * s + C * lever * (n * C * s + b * o)
    return Forces(
        high, C * lever, body.energy + change, change, momentum, flow(state, body, 0.0).gaining,
        1.0 - lever * rise - rest * n * n * n * y * y, high * inward - C * lever * square - n * o * s,
        I * A * w * twist,
    )  # fmt: skip


@simd
def suitable_step(state, body, relative_step):
    """Return the scaled step: `relative_step` over the fastest frequency of the linearised motion."""
    S, C, w, o, s = rates_of(state)
    return relative_step / math.sqrt(fastest_square((S, C, 0.0, w, o, s), body))


@kernel
def ended(before, after, body, fall_tilt, side, h):
    """Return HORIZON: no motion through the poles ends."""
    return HORIZON, 0.0


#: For balls and spheroids.
trajectory = variant(
    _trajectory,
    "poles",
    {name: getattr(equations, name) for name in ("inlined_step",)}
    | {
        each.__name__: each
        for each in (set_out, rates_of, pole_near, lean, flow, forces, suitable_step, ended)
    },
)
