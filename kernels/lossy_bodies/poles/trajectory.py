"""One motion of a ball or a spheroid with losses sampled in time; see `kernels.lossy_disk.trajectory`.

Contact point and orientation are regular through a pole, where heading and roll angle are not: the path is an integral
of the velocity of the contact in space, and of the roll angle the sum with the heading is, beside the lower pole the
difference. What the heading turns by follows from the axis.
"""

import math

from kernels.bodies import arrays as body_row
from kernels.bodies.stages import body_of
from kernels.jit import kernel
from kernels.lanes.binding import variant
from kernels.lossy_bodies import arrays as row
from kernels.lossy_bodies.poles.equations import arm_of, bearings, shape
from kernels.lossy_bodies.poles.follow import begun
from kernels.lossy_bodies.poles.integrate import DIFFERENT
from kernels.lossy_bodies.stages import losses_of
from kernels.lossy_disk import trajectory as disk


@kernel
def beginning(start, settings):
    """See `kernels.lossy_disk.trajectory.beginning`; the state is that of `kernels.lossy_bodies.poles.follow.begun`."""
    tilt, radius = start[body_row.TILT, 0], start[body_row.RADIUS, 0]
    unit = math.sqrt(radius / start[body_row.GRAVITY, 0])
    state = (
        math.sin(tilt), math.cos(tilt), unit * start[body_row.TILT_RATE, 0],
        unit * start[body_row.PRECESSION_RATE, 0], unit * start[body_row.ROLL_RATE, 0],
    )  # fmt: skip
    losses = losses_of(0, start, settings[row.TRAJECTORY_AIR_LAW], 1.0)
    body = body_of(start, 0, settings[row.TRAJECTORY_BODY])
    return disk.Beginning(state, body, losses, start[row.FRICTION, 0], radius, unit)


@kernel
def contact_velocity(state, heading, body):
    """See `kernels.lossy_disk.trajectory.contact_velocity`: D p of `equations`, turned back by a quarter."""
    n1, n2, S, p1, p2, _ = state
    n, _, _ = shape(S, body)
    bent = (body.square - 1.0) * n * n * n * (p1 * n2 - p2 * n1)
    return n * p2 - bent * n1, -(n * p1 + bent * n2)


@kernel
def _turning(state, pole):
    """Rate of the heading plus that of the roll angle, beside the lower pole, -1, minus it; C^2 f = p n."""
    n1, n2, S, p1, p2, v = state
    return v + pole * (p1 * n1 + p2 * n2) / (1.0 + pole * S)


@kernel
def rolled(before, middle, after, h, turned):
    """See `kernels.lossy_disk.trajectory.rolled`."""
    pole = math.copysign(1.0, middle[2])
    whole = _turning(before, pole) + 4.0 * _turning(middle, pole) + _turning(after, pole)
    return pole * (h / 6.0 * whole - turned)


@kernel
def seen(state, tilt):
    """See `kernels.lossy_disk.trajectory.seen`."""
    n1, n2, _, p1, p2, v = state
    S, C, (_, cosine, sine) = math.sin(tilt), math.cos(tilt), bearings(n1, n2)
    w, across = p2 * cosine - p1 * sine, p1 * cosine + p2 * sine
    return (S, C, w, -across / C, v), (-C, 0.0, S, across, w, v)


@kernel
def lever(S, C, body):
    """See `kernels.lossy_disk.contact_motion.lever`."""
    return -arm_of((-C, 0.0, S), body)[0]


@kernel
def height(S, C, body):
    """See `kernels.lossy_disk.trajectory.height`."""
    return -arm_of((-C, 0.0, S), body)[2]


_MOTION = {
    "set_going": begun,
    **{each.__name__: each for each in (beginning, contact_velocity, rolled, seen, lever, height)},
}

_SHARED = {name: value for name, value in DIFFERENT.items() if name != "MOST_STEPS"}

#: Of balls and spheroids.
trajectory = variant(disk.trajectory, "lossy_poles", _SHARED | _MOTION)
