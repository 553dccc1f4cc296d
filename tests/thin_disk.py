"""The thin disk: its contact forces by the kernels of a body's motion, and its motion in time by SciPy."""

import math

import lagrange
import numpy as np
import referee
from scipy.integrate import solve_ivp

from kernels.bodies.shapes import thin_disk
from kernels.bodies.trajectory import forces

#: Rows of a motion: the state and the path, in the order in which files have them.
ROWS = (
    "tilt", "tilt_rate", "precession_rate", "roll_rate", "heading", "roll_angle", "contact_x", "contact_y",
)  # fmt: skip


def _forces_of(state, alpha):
    return forces(state, state, thin_disk(alpha))


def contact_forces(state, alpha):
    """Return the force over m g: vertical, across the track, along the track."""
    found = _forces_of(state, alpha)
    return found.normal, found.across, found.along


def friction_needed(state, alpha):
    """Return the horizontal force over the normal force."""
    normal, across, along = contact_forces(state, alpha)
    return math.hypot(across, along) / normal


def vertical_momentum(state, alpha):
    """Return the vertical momentum about the contact point, over m R^2/sqrt(R/g), and its rate of change."""
    found = _forces_of(state, alpha)
    return found.momentum, found.gaining


def path_by_scipy(start, times, alpha=0.5, radius=0.5, gravity=9.81):
    """Integrate state and path by DOP853 at 1e-12 from the referee's equations: shape (len(ROWS), n)."""

    def slope(_, y):
        tilting, turning, rolling = referee.accelerations(y[:4], alpha, radius, gravity)
        ahead = radius * y[3]
        return [y[1], tilting, turning, rolling, y[2], y[3], -ahead * math.sin(y[4]), ahead * math.cos(y[4])]

    first = [*start, 0.0, 0.0, 0.0, 0.0]
    return solve_ivp(slope, (0.0, times[-1]), first, "DOP853", times, rtol=1e-12, atol=1e-15).y


def motion_by_scipy(start, times):
    """Return state, path and contact forces over the weight of a start, a mapping with all parameters."""
    masses = [start[name] for name in ("alpha", "radius", "gravity")]
    rows = path_by_scipy([start[name] for name in ROWS[:4]], times, *masses)
    tilt, rate, precession, roll = rows[:4]
    alpha, radius, gravity = masses
    zero = np.zeros_like(tilt)
    q = np.stack([zero, zero, zero, tilt, zero], axis=-1)
    v = np.stack([zero, radius * roll, precession, rate, roll], axis=-1)
    up, friction = lagrange.accelerations(q, v, alpha, 1.0, radius, gravity)
    normal = 1.0 - radius / gravity * (up[..., 3] * np.sin(tilt) + rate**2 * np.cos(tilt))
    across, along = friction.T / gravity
    force = {"normal_force": normal, "friction_across": across, "friction_along": along}
    return dict(zip(ROWS, rows, strict=True)) | force
