"""A ball or a spheroid that friction only just does not hold; see `kernels.lossy_disk.creeping`.

There the horizontal turning rate has components along and across the track; so it has here, while friction turns its
direction. A place is (n_1, n_2, size, S, v), and an angle is that from the track.
"""

import math

from kernels.jit import kernel
from kernels.lossy_bodies.poles.equations import (
    bearings,
    contact_rates,
    horizontal_rate,
    shape,
    time_scale,
    yielding,
)
from kernels.lossy_disk.creeping import _FAST, _LEAST


@kernel
def stiffness(S, body, losses):
    """Magnitude of the horizontal turning rate over the time in which friction turns its direction, at most."""
    n, _, radius = shape(S, body)
    wide = max(n, radius)
    return (losses.rolling + losses.contour * wide * wide / min(n, radius)) * yielding(S, body)


@kernel
def stiffness_at(place, losses, body):
    """`stiffness` at a place."""
    return stiffness(place[3], body, losses)


@kernel
def creeps(state, senses, body, losses):
    """See `kernels.lossy_disk.creeping.creeps`."""
    n1, n2, S, p1, p2, v = state
    if not (losses.rolling > 0.0 or losses.contour > 0.0) or rolls_straight(state):
        return False
    fast = _FAST * stiffness(S, body, losses)
    if p1 * p1 + p2 * p2 > (fast * time_scale(state, body)) ** 2 or n1 * n1 + n2 * n2 == 0.0:
        return False
    size, _, change = horizontal_rate(state, senses, body, losses)
    return 0.0 < size and change < fast


@kernel
def rolls_straight(state):
    """Whether a body has nothing across the direction in which friction acts."""
    n1, n2, _, p1, p2, v = state
    return v == 0.0 and p1 * n1 + p2 * n2 == 0.0


@kernel
def parted(state):
    """Place of a state, and the angle of its horizontal turning rate from the track."""
    n1, n2, S, p1, p2, v = state
    _, cosine, sine = bearings(n1, n2)
    along, across = p2 * cosine - p1 * sine, p1 * cosine + p2 * sine
    return (n1, n2, math.sqrt(p1 * p1 + p2 * p2), S, v), math.atan2(across, along)


@kernel
def placed(place, angle):
    """State of a place and an angle."""
    n1, n2, size, S, v = place
    _, cosine, sine = bearings(n1, n2)
    along, across = size * math.cos(angle), size * math.sin(angle)
    return n1, n2, S, across * cosine - along * sine, across * sine + along * cosine, v


@kernel
def accelerations(place, angle, senses, body, losses):
    """See `kernels.lossy_disk.creeping.accelerations`: the track turns with the heading."""
    n1, n2, size, S, v = place
    n1, n2, S, p1, p2, _ = state = placed((n1, n2, max(size, _LEAST), S, v), angle)
    changes, ledger, _ = contact_rates(state, senses, body, losses)
    _, _, _, dp1, dp2, _ = changes
    C, c, s = bearings(n1, n2)
    along, across = p2 * c - p1 * s, p1 * c + p2 * s
    turning = v + S * across / C
    tilting, rolling = dp2 * c - dp1 * s - across * turning, dp1 * c + dp2 * s + along * turning
    cosine, sine = math.cos(angle), math.sin(angle)
    return cosine * tilting + sine * rolling, cosine * rolling - sine * tilting, changes, ledger


@kernel
def along(place, h, change):
    """`place` + h * `change`, of five numbers each."""
    a0, a1, a2, a3, a4 = place
    b0, b1, b2, b3, b4 = change
    return a0 + h * b0, a1 + h * b1, a2 + h * b2, a3 + h * b3, a4 + h * b4


@kernel
def growing(place, angle, senses, body, losses):
    """Derivatives of a place and of the ledger."""
    growth, _, changes, ledger = accelerations(place, angle, senses, body, losses)
    dn1, dn2, dS, _, _, dv = changes
    return (dn1, dn2, growth, dS, dv), ledger
