"""A disk that rolling friction only just does not hold: it sets off slowly, and friction keeps a balanced direction.

The horizontal turning rate (w, C f) then grows slowly from nothing, while friction, which opposes it, turns its
direction within about its magnitude over the arm. Explicit steps as short as that would be as many as one over the
relative excess over what holds. The direction is therefore taken as the one to which friction turns it: the one in
which the acceleration is, but for the little by which that direction changes itself (a slow manifold to first order).
"""

import math

from kernels.jit import kernel
from kernels.lossy_disk.contact_motion import (
    compliance,
    contact_rates,
    contact_step,
    entered,
    horizontal_rate,
    per_inertia,
    time_scale,
)

#: Share of the time scale of the motion, and of the time in which the rate grows, within which friction has turned it.
_FAST = 1.0e-4

#: Share of that time over which it is found how the direction changes.
_AHEAD = 1.0e-4

#: Least horizontal turning rate of which the direction of friction is taken.
_LEAST = 1.0e-60

#: Iterations for a direction at most, and the change of an angle [rad] over itself that ends them.
_MOST_TRIALS, _SHARP = 20, 1.0e-13


@kernel
def stiffness(S, C, G_ff, losses, inertia):
    """Magnitude of the horizontal turning rate over the time in which rolling friction turns its direction."""
    return losses.rolling * (per_inertia(S, C, inertia) + C * C * G_ff)


@kernel
def creeps(state, senses, inertia, losses):
    """Whether friction turns the horizontal turning rate of a motion much faster than anything else changes it."""
    S, C, w, f, v = state
    if not losses.rolling > 0.0 or senses.roll == 0.0 or (f == 0.0 and v == 0.0):
        # one that falls straight has nothing across
        return False
    G_ff, _, _ = compliance(S, C, inertia)
    fast = _FAST * stiffness(S, C, G_ff, losses, inertia)
    if w * w + C * C * f * f > (fast * time_scale(state, inertia)) ** 2:
        return False
    size, _, change = horizontal_rate(state, senses, inertia, losses)
    # off its direction, or where friction stops it, a motion is not slow
    return 0.0 < size and change < fast


@kernel
def stiffness_at(place, losses, inertia):
    """`stiffness` at a place."""
    S, C, _, _ = place
    G_ff, _, _ = compliance(S, C, inertia)
    return stiffness(S, C, G_ff, losses, inertia)


@kernel
def parted(state):
    """(S, C, size, v) of the horizontal turning rate of a state, and the angle of its direction."""
    S, C, w, f, v = state
    return (S, C, math.sqrt(w * w + C * C * f * f), v), math.atan2(C * f, w)


@kernel
def placed(place, angle):
    """State (S, C, w, f, v) of (S, C, size, v) of the horizontal turning rate, in the direction of an angle."""
    S, C, size, v = place
    return S, C, size * math.cos(angle), size * math.sin(angle) / C, v


@kernel
def accelerations(place, angle, senses, inertia, losses):
    """Acceleration of the horizontal turning rate along its direction and across it; `contact_rates`.

    Within a step at whose end friction has stopped the rate, what is beyond is as if it had not yet.
    """
    S, C, size, v = place
    S, C, w, f, _ = state = placed((S, C, max(size, _LEAST), v), angle)
    changes, ledger, _ = contact_rates(state, senses, inertia, losses)
    _, _, dw, df, _ = changes
    cosine, sine, dx = math.cos(angle), math.sin(angle), C * df - S * w * f
    return cosine * dw + sine * dx, cosine * dx - sine * dw, changes, ledger


@kernel
def _balanced(place, angle, swing, senses, inertia, losses):
    """Angle near another one at which the acceleration turns the rate as fast as `swing`: by the secant method."""
    size = place[2]
    _, turning, _, _ = accelerations(place, angle, senses, inertia, losses)
    across = turning - max(size, _LEAST) * swing
    change = across / stiffness_at(place, losses, inertia)
    for _ in range(_MOST_TRIALS):
        if abs(change) <= _SHARP * abs(angle):
            break
        angle += change
        before = across
        _, turning, _, _ = accelerations(place, angle, senses, inertia, losses)
        across = turning - max(size, _LEAST) * swing
        if across == before:
            break
        change *= across / (before - across)
    return angle


@kernel
def along(place, h, change):
    """`place` + h * `change`, of four numbers each."""
    S, C, size, v = place
    dS, dC, growth, dv = change
    return S + h * dS, C + h * dC, size + h * growth, v + h * dv


@kernel
def growing(place, angle, senses, inertia, losses):
    """Derivatives of (S, C, size, v) and of the ledger."""
    growth, _, changes, ledger = accelerations(place, angle, senses, inertia, losses)
    dS, dC, _, _, dv = changes
    return (dS, dC, growth, dv), ledger


@kernel
def _direction(place, angle, senses, inertia, losses):
    """Angle near another one in which friction keeps the horizontal turning rate."""
    angle = _balanced(place, angle, 0.0, senses, inertia, losses)
    change, _ = growing(place, angle, senses, inertia, losses)
    size, growth = place[2], change[2]
    scale = time_scale(placed(place, angle), inertia)
    h = _AHEAD * (scale if abs(growth) * scale < abs(size) else abs(size / growth))
    if h == 0.0:
        # at rest the angle may change at any rate
        return angle
    later = _balanced(along(place, h, change), angle, 0.0, senses, inertia, losses)
    return _balanced(place, angle, (later - angle) / h, senses, inertia, losses)


@kernel
def _slopes(place, angle, senses, inertia, losses):
    """`growing` in the direction near an angle, and that direction."""
    angle = _direction(place, angle, senses, inertia, losses)
    change, ledger = growing(place, angle, senses, inertia, losses)
    return change, ledger, angle


@kernel
def creeping_step(state, senses, inertia, losses, h):
    """`kernels.lossy_disk.contact_motion.contact_step` of a motion that creeps."""
    place, angle = parted(state)
    total, gained, angle = _slopes(place, angle, senses, inertia, losses)
    change, more, angle = _slopes(along(place, 0.5 * h, total), angle, senses, inertia, losses)
    total, gained = along(total, 2.0, change), entered(gained, 2.0, more)
    change, more, angle = _slopes(along(place, 0.5 * h, change), angle, senses, inertia, losses)
    total, gained = along(total, 2.0, change), entered(gained, 2.0, more)
    change, more, angle = _slopes(along(place, h, change), angle, senses, inertia, losses)
    sixth, nothing = h / 6.0, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    there = along(place, sixth, along(total, 1.0, change))
    angle = _direction(there, angle, senses, inertia, losses)
    return placed(there, angle), entered(nothing, sixth, entered(gained, 1.0, more))


@kernel
def next_state(state, senses, inertia, losses, h):
    """State and gain of the ledger after a step, as of `kernels.lossy_disk.contact_motion.contact_step`."""
    if creeps(state, senses, inertia, losses):
        return creeping_step(state, senses, inertia, losses, h)
    return contact_step(state, senses, inertia, losses, h)
