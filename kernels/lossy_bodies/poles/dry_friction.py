"""What dry friction holds of a ball or a spheroid and what it lets go; see `kernels.lossy_disk.dry_friction`.

Two rates can be held: the horizontal turning rate p as a whole, by rolling and contour friction together, and the
turning rate about the vertical v, by pivoting friction. Of the senses of `kernels.lossy_disk.contact_motion.Senses` the
roll is 1 while p moves, and 0 where friction holds it.
"""

import math

from kernels.jit import kernel
from kernels.lossy_bodies.poles.equations import (
    arm_of,
    bearings,
    contact_rates,
    place_at,
    shape,
    whole_of_vertical,
)
from kernels.lossy_disk.contact_motion import Senses
from kernels.lossy_disk.dry_friction import _HALVINGS, _INSTANT, sign

#: Share of its bounds by which friction may be needed more than that and still hold a body at rest, and hold on: where
#: damping lets a body come nearer and nearer to where it is held, rounding does not decide.
AT_REST, STILL_AT_REST = 1.0 + 1.0e-9, 1.0 + 2.0e-9

#: Horizontal turning rate of which only the direction matters.
_HARDLY = 1.0e-60


@kernel
def _needed(state, pivoted, body):
    """Torque that keeps a body turning about the vertical alone, and the directions across and along the track.

    Returns
    -------
    (along, across, (cosine, sine))
        Components of the torque about the track, which tilts, and about the line across it; the heading.

    Notes
    -----
    The normal force is the weight: the height does not change. `pivoted` is the torque of pivoting friction.
    """
    n1, n2, S, _, _, v = state
    axis = n1, n2, S
    torque = place_at(axis, (0.0, 0.0, v), body).torque
    whole = whole_of_vertical(axis, arm_of(axis, body), body)
    change = (torque[2] + pivoted) / whole[2]
    first, second = change * whole[0] - torque[0], change * whole[1] - torque[1]
    _, cosine, sine = bearings(n1, n2)
    return second * cosine - first * sine, first * cosine + second * sine, (cosine, sine)


@kernel
def _is_within(along, across, semi_axes, arm):
    """Whether a torque is within a distance of an ellipse: what contour friction leaves, rolling friction takes.

    The nearest point has the components a^2 x/(t + a^2), with the t > 0 at which it lies on the ellipse.
    """
    a, b = semi_axes
    x, y = abs(along), abs(across)
    if a <= 0.0 or b <= 0.0:
        return math.sqrt(x * x + y * y) <= arm
    if (x / a) ** 2 + (y / b) ** 2 <= 1.0:
        return True
    least, most = 0.0, math.sqrt((a * x) ** 2 + (b * y) ** 2)
    for _ in range(_HALVINGS):
        t = 0.5 * (least + most)
        if (a * x / (t + a * a)) ** 2 + (b * y / (t + b * b)) ** 2 > 1.0:
            least = t
        else:
            most = t
    return math.sqrt((most * x / (most + a * a)) ** 2 + (most * y / (most + b * b)) ** 2) <= arm


@kernel
def is_held(state, turn, strength, body, losses):
    """Whether friction holds the horizontal turning rate of a body that has none.

    `turn` is the sense of v, and `strength` multiplies the bounds of friction.
    """
    n, _, radius = shape(state[2], body)
    along, across, _ = _needed(state, -losses.pivoting * turn, body)
    contour = strength * losses.contour
    return _is_within(along, across, (contour * radius, contour * n), strength * losses.rolling)


@kernel
def _set_going(state, turn, body, losses):
    """Return state and senses an instant after a body has broken away; and the instant.

    Friction opposes the direction in which the body sets off, and its inertia is not the same in all directions: the
    direction is that of the acceleration which it allows, between tilting alone and rolling alone; found by halving.
    """
    n1, n2, S, _, _, v = state
    along, across, (cosine, sine) = _needed(state, -losses.pivoting * turn, body)
    tilting, rolling, senses = -sign(along), -sign(across), Senses(1.0, turn, 0.0)
    least, most, rate = 0.0, 0.5 * math.pi, (0.0, 0.0, 0.0)
    for _ in range(_HALVINGS):
        angle = 0.5 * (least + most) if rolling != 0.0 else 0.0
        about, beside = tilting * math.cos(angle), rolling * math.sin(angle)
        p1, p2 = beside * cosine - about * sine, beside * sine + about * cosine
        setting_off = n1, n2, S, _HARDLY * p1, _HARDLY * p2, v
        (_, _, _, dp1, dp2, dv), _, _ = contact_rates(setting_off, senses, body, losses)
        rate = dp1, dp2, dv
        tilted, rolled = tilting * (dp2 * cosine - dp1 * sine), rolling * (dp1 * cosine + dp2 * sine)
        if math.sin(angle) * tilted - math.cos(angle) * rolled < 0.0:
            least = angle
        else:
            most = angle
    h = _INSTANT / (1.0 + abs(v))
    dp1, dp2, dv = rate
    return (n1 - h * v * n2, n2 + h * v * n1, S, h * dp1, h * dp2, v + h * dv), senses, h


@kernel
def _turn_held_or_let_go(state, strength, body, losses):
    """Return state and senses of a body whose turning rate has just vanished while it rolls."""
    n1, n2, S, p1, p2, _ = state
    still, held = (n1, n2, S, p1, p2, 0.0), Senses(1.0, 0.0, 0.0)
    _, _, forces = contact_rates(still, held, body, losses)
    if abs(forces.turn) <= strength * losses.pivoting * forces.normal:
        return still, held
    return still, Senses(1.0, -sign(forces.turn), 0.0)


@kernel
def decided(state, senses, vanished, strength, body, losses):
    """See `kernels.lossy_disk.dry_friction.decided`; that the roll rate vanishes means here that all of p does."""
    no_rolling, no_turn, _ = vanished
    n1, n2, S, p1, p2, v = state
    turn = 0.0 if no_turn and losses.pivoting > 0.0 else senses.turn
    if no_rolling:
        still = n1, n2, S, 0.0, 0.0, 0.0 if no_turn else v
        if is_held(still, turn, AT_REST, body, losses):
            return still, Senses(0.0, turn, 0.0), 0.0
        return _set_going(still, turn, body, losses)
    if no_turn and losses.pivoting > 0.0:
        state, senses = _turn_held_or_let_go(state, strength, body, losses)
    return state, senses, 0.0
