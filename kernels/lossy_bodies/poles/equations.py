"""Equations of motion of a ball or a spheroid on which losses act, in components along three directions of space.

The axis n and the angular velocity are followed in space, the third direction up. No chart is needed: nothing is
singular where the axis is vertical, and where friction is about to hold the body, its rates have all their digits. The
state is (n_1, n_2, S, p_1, p_2, v): the axis, whose third component is the sine of the tilt; the horizontal turning
rate p, whose components across and along the track are -C f and w; the turning rate about the vertical v.

With e the height of the centre of the surface over that of mass (the shift of `kernels.bodies.shapes.Body`), Q the
square, n = 1/sqrt(1 - (1 - Q) S^2) and l = (1 - Q) n S - e the contact point is at r = l (axis) - n (up) from the
centre of mass, whose height is h = 1/n + e S; the weight acts at the lever l C. About the contact point

    K w' = r x (up - w x r') - (I - A) s (axis)' + torques,   K = A + r^2 + (I - A) (axis)(axis) - r r,

with w here the angular velocity and s its component along the axis. The contact moves over the body, and over the
plane, as fast as |D p|, where D multiplies by n across the track and by the radius of curvature r_m = Q n^3 along it.
At a pole both are the same, and no direction is marked: there is no circle along which the contact runs. So contour
friction takes its arm times the normal force of the whole way, and damping of its square:

    M = -N [c_r p/|p| + c_c D^2 p/|D p|] - k D^2 p,    D^2 p = n^2 p + (Q - 1) n^3 (r_m + n) y (n_2, -n_1),

where y = p_1 n_2 - p_2 n_1 is the rate of S; all of it horizontal. Pivoting friction is -N c_p sign(v) about the
vertical. Of a ball, where D is 1, contour friction is rolling friction.
"""

import math
from typing import NamedTuple

from kernels.bodies.poles.equations import fastest_square
from kernels.jit import kernel, simd
from kernels.lossy_disk.contact import all_held
from kernels.lossy_disk.contact_motion import Forces

#: Added to the square of a rate that divides.
_LEAST_SQUARE = 1.0e-200


class Place(NamedTuple):
    """Where the contact is, and what moves a body on which no friction acts.

    Attributes
    ----------
    axis, arm : tuple of 3 floats
        The axis; the contact point from the centre of mass.
    normal, radius : float
        n and the radius of curvature of the meridian.
    torque : tuple of 3 floats
        Right-hand side without friction.
    level : float
        Normal force without an angular acceleration.
    """

    axis: tuple
    arm: tuple
    normal: float
    radius: float
    torque: tuple
    level: float


@simd
def cross(a, b):
    """Vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@simd
def dot(a, b):
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@simd
def plus(a, h, b):
    """A + h b, of three numbers each."""
    return a[0] + h * b[0], a[1] + h * b[1], a[2] + h * b[2]


@simd
def shape(S, body):
    """(n, l, r_m) of the docstring of the module."""
    rest = 1.0 - body.square
    n = 1.0 / math.sqrt(1.0 - rest * S * S)
    return n, rest * n * S - body.shift, body.square * n * n * n


@simd
def arm_of(axis, body):
    """Contact point from the centre of mass."""
    n, lever, _ = shape(axis[2], body)
    return lever * axis[0], lever * axis[1], lever * axis[2] - n


@simd
def place_at(axis, turning, body):
    """Return the `Place` of a body with an axis and an angular velocity."""
    n, lever, radius = shape(axis[2], body)
    arm, rate = arm_of(axis, body), cross(turning, axis)
    growth = (1.0 - body.square) * n * n * n * rate[2]
    arm_rate = growth * axis[0] + lever * rate[0], growth * axis[1] + lever * rate[1], lever * rate[2]
    push = cross(arm_rate, turning)
    push = push[0], push[1], push[2] + 1.0
    gyroscopic = (body.axial - body.transverse) * dot(turning, axis)
    return Place(axis, arm, n, radius, plus(cross(arm, push), -gyroscopic, rate), push[2])


@simd
def solved(torque, axis, arm, body):
    """Angular acceleration by a torque about the contact point: K is a multiple of 1 but for axis and arm."""
    A, more, square, b = body.transverse, body.axial - body.transverse, dot(arm, arm), dot(arm, axis)
    along, across = dot(axis, torque), dot(arm, torque)
    inverse = 1.0 / (A * (square + body.axial) + more * b * b)
    of_axis = (A * along + b * across) * inverse
    of_arm = ((square + body.axial) * across - more * b * along) * inverse
    found = plus(plus(torque, -more * of_axis, axis), of_arm, arm)
    per = 1.0 / (A + square)
    return per * found[0], per * found[1], per * found[2]


@simd
def whole_of_vertical(axis, arm, body):
    """K (up): angular momentum about the contact point per turning rate about the vertical."""
    more, square = body.axial - body.transverse, dot(arm, arm)
    along = more * axis[2]
    return (
        along * axis[0] - arm[2] * arm[0], along * axis[1] - arm[2] * arm[1],
        body.transverse + square + along * axis[2] - arm[2] * arm[2],
    )  # fmt: skip


@simd
def way_of(horizontal, axis, normal, radius, body):
    """D^2 p and |D p|."""
    p1, p2 = horizontal
    y = p1 * axis[1] - p2 * axis[0]
    bent = (body.square - 1.0) * normal * normal * normal * (radius + normal) * y
    d1, d2 = normal * normal * p1 + bent * axis[1], normal * normal * p2 - bent * axis[0]
    return d1, d2, math.sqrt(p1 * d1 + p2 * d2 + _LEAST_SQUARE)


@simd
def turning_of(state):
    """Turning rate about the vertical."""
    return state[5]


@simd
def tilting_of(state):
    """Rate of the sine of the tilt, y."""
    n1, n2, _, p1, p2, _ = state
    return p1 * n2 - p2 * n1


@simd
def is_above(state):
    """Whether a state is one that a step may lead to."""
    return True


@kernel
def tilt_of(state):
    """Tilt [rad]."""
    n1, n2, S, _, _, _ = state
    return math.atan2(S, math.sqrt(n1 * n1 + n2 * n2))


@kernel
def contact_rates(state, senses, body, losses):
    """See `kernels.lossy_disk.contact_motion.contact_rates`; in the ledger is the heading of a body that stands.

    `senses.turn` is 0 where pivoting friction holds v. The normal force depends on the acceleration, which depends on
    it: both dependences are linear.
    """
    n1, n2, S, p1, p2, v = state
    axis, turning = (n1, n2, S), (p1, p2, v)
    here = place_at(axis, turning, body)
    d1, d2, way = way_of((p1, p2), axis, here.normal, here.radius, body)
    size = math.sqrt(p1 * p1 + p2 * p2 + _LEAST_SQUARE)
    rolling, contour, damping = losses.rolling / size, losses.contour / way, losses.damping
    smooth = here.torque[0] - damping * d1, here.torque[1] - damping * d2, here.torque[2]
    dry = -rolling * p1 - contour * d1, -rolling * p2 - contour * d2, -losses.pivoting * senses.turn
    lifted = here.arm[1], -here.arm[0], 0.0
    free, slowed = solved(smooth, axis, here.arm, body), solved(dry, axis, here.arm, body)
    level, heavy = here.level - dot(free, lifted), 1.0 + dot(slowed, lifted)
    if senses.turn == 0.0:
        held = solved((0.0, 0.0, 1.0), axis, here.arm, body)
        light = dot(held, lifted)
        inverse = 1.0 / (heavy * held[2] - light * slowed[2])
        normal = (level * held[2] + light * free[2]) * inverse
        turn = -(heavy * free[2] + slowed[2] * level) * inverse
        rate = plus(plus(free, normal, slowed), turn, held)
        rate = rate[0], rate[1], 0.0
    else:
        normal = level / heavy
        turn = -losses.pivoting * senses.turn * normal
        rate = plus(free, normal, slowed)
    moving = cross(turning, axis)
    ledger = (
        v, way, losses.rolling * normal * size, losses.pivoting * normal * (senses.turn * v),
        losses.contour * normal * way, damping * (way * way), 0.0,
    )  # fmt: skip
    return (*moving, *rate), ledger, Forces(normal, 0.0, turn)


@kernel
def acceleration(state, senses, body, losses):
    """Angular acceleration, and `Forces`; where friction holds all but the turning about the vertical, that of it."""
    n1, n2, S, _, _, _ = state
    if all_held(senses):
        axis = n1, n2, S
        pivoted = -losses.pivoting * senses.turn
        inertia = whole_of_vertical(axis, arm_of(axis, body), body)[2]
        return (0.0, 0.0, pivoted / inertia), Forces(1.0, 0.0, pivoted)
    (_, _, _, dp1, dp2, dv), _, forces = contact_rates(state, senses, body, losses)
    return (dp1, dp2, dv), forces


@kernel
def contact_forces(state, senses, body, losses):
    """Horizontal force of the plane over m g, two components in space, and `Forces`."""
    n1, n2, S, p1, p2, v = state
    axis, turning = (n1, n2, S), (p1, p2, v)
    rate, forces = acceleration(state, senses, body, losses)
    n, lever, _ = shape(S, body)
    moving = cross(turning, axis)
    growth = (1.0 - body.square) * n * n * n * moving[2]
    arm_rate = (
        growth * n1 + lever * moving[0], growth * n2 + lever * moving[1], lever * moving[2],
    )  # fmt: skip
    first, second = cross(arm_of(axis, body), rate), cross(arm_rate, turning)
    return first[0] + second[0], first[1] + second[1], forces


@kernel
def bearings(n1, n2):
    """Cosine of the tilt, cosine and sine of the heading, which is 0 at a pole."""
    C = math.sqrt(n1 * n1 + n2 * n2)
    return (C, -n1 / C, -n2 / C) if C > 0.0 else (0.0, 1.0, 0.0)


@kernel
def moved(state, h, change):
    """`state` + h * `change`, of six numbers each."""
    a0, a1, a2, a3, a4, a5 = state
    b0, b1, b2, b3, b4, b5 = change
    return a0 + h * b0, a1 + h * b1, a2 + h * b2, a3 + h * b3, a4 + h * b4, a5 + h * b5


@kernel
def horizontal_rate(state, senses, body, losses):
    """See `kernels.lossy_disk.contact_motion.horizontal_rate`."""
    _, _, _, p1, p2, _ = state
    (_, _, _, dp1, dp2, _), _, _ = contact_rates(state, senses, body, losses)
    size = math.sqrt(p1 * p1 + p2 * p2)
    falling = (p1 * dp1 + p2 * dp2) / size if size > 0.0 else 0.0
    return size, falling, math.sqrt(dp1 * dp1 + dp2 * dp2)


@kernel
def energy_of(state, body):
    """Energy over m g R."""
    n1, n2, S, p1, p2, v = state
    axis, turning = (n1, n2, S), (p1, p2, v)
    arm, s = arm_of(axis, body), dot(turning, axis)
    velocity = cross(turning, arm)
    twice = body.transverse * dot(turning, turning) + (body.axial - body.transverse) * s * s
    return 0.5 * (twice + dot(velocity, velocity)) - arm[2]


@kernel
def time_scale(state, body):
    """Scaled time over the fastest rate of the motion without friction."""
    n1, n2, S, p1, p2, v = state
    turning = p1, p2, v
    s = dot(turning, (n1, n2, S))
    across = math.sqrt(max(dot(turning, turning) - s * s, 0.0))
    return 1.0 / math.sqrt(fastest_square((S, 0.0, 0.0, across, 0.0, s), body))


@kernel
def yielding(S, body):
    """Largest acceleration of the horizontal turning rate per torque, at a sine of the tilt."""
    C = math.sqrt(max((1.0 - S) * (1.0 + S), 0.0))
    axis = -C, 0.0, S
    arm = arm_of(axis, body)
    across = solved((1.0, 0.0, 0.0), axis, arm, body)
    return max(across[0], 1.0 / (body.transverse + dot(arm, arm)))
