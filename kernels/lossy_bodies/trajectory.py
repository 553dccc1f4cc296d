"""One motion of a body with losses sampled in time; names as in `kernels.lossy_disk.trajectory`."""

import math

from kernels.bodies import arrays as body_row
from kernels.bodies.equations import curvature_radius, height, levers
from kernels.bodies.starts import body_of, side_of
from kernels.disk.equations import scaled_state
from kernels.jit import kernel
from kernels.lanes.binding import variant
from kernels.lossy_bodies import arrays as row
from kernels.lossy_bodies.equations import Rolling
from kernels.lossy_bodies.integrate import MECHANICS
from kernels.lossy_disk import trajectory as disk
from kernels.lossy_disk.loss_coefficients import scaled_losses


@kernel
def beginning(start, settings):
    """See `kernels.lossy_disk.trajectory.beginning`."""
    kind, tilt = settings[row.TRAJECTORY_BODY], start[body_row.TILT, 0]
    body = body_of(start, 0, kind)
    rolling = Rolling(
        body.core, body.shift, body.edge, body.square, body.axial, body.transverse, body.ratio,
        1.0 / body.transverse, side_of(kind, tilt), 1.0, 1.0, 1.0,
    )  # fmt: skip
    radius = start[body_row.RADIUS, 0]
    unit = math.sqrt(radius / start[body_row.GRAVITY, 0])
    rates = start[body_row.TILT_RATE, 0], start[body_row.PRECESSION_RATE, 0], start[body_row.ROLL_RATE, 0]
    S, C, _, w, o, s = scaled_state(tilt, rates[0], rates[1], rates[2], unit)
    losses = scaled_losses(0, start, settings[row.TRAJECTORY_AIR_LAW], body.core)
    return disk.Beginning((S, C, 1.0 / C, w, o, s), rolling, losses, start[row.FRICTION, 0], radius, unit)


@kernel
def contact_speed(state, body):
    """See `kernels.lossy_disk.trajectory.contact_speed`."""
    S, C, w, f, _ = state
    a, _, _ = levers(S, C, body)
    return a * f, curvature_radius(S, C, body) * w


_MOTION = {"beginning": beginning, "contact_speed": contact_speed, "height": height}

#: For bodies that lie flat if the axis is vertical.
trajectory = variant(disk.trajectory, "lossy_bodies", MECHANICS | _MOTION)
