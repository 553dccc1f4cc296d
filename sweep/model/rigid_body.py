"""A rigid body of revolution that rolls without slipping: the Newton-Euler equations in space, solved with SciPy.

The state is the axis n and the angular velocity, both in space; tilt and tilt rate do not occur. The body is the set
of points within `edge` of a ring of radius `core`, whose center is at `-shift` along the axis; its lowest point is the
contact. If `square` is not 1, the cross-section of the tube is an ellipse, sqrt(square) times as long along the axis
as across it. Units are m = g = R = 1. It shares no code with the kernels, so it can check their results.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from sweep.model.quantity import Array

UP = np.array([0.0, 0.0, 1.0])

#: Relative tolerance per step of DOP853.
_ACCURACY = 1e-12


def cross(a: Array, b: Array) -> Array:
    """Return the vector product: numpy.cross takes four times as long."""
    (x, y, z), (u, v, w) = a.tolist(), b.tolist()
    return np.array((y * w - z * v, z * u - x * w, x * v - y * u))


@dataclass(frozen=True)
class RigidBody:
    """A rolling body: its meridian, and its moments of inertia about the axis and across it."""

    core: float
    shift: float
    edge: float
    axial: float
    transverse: float
    square: float = 1.0

    def contact(self, n: Array, n_rate: Array) -> tuple[Array, Array]:
        """Return the contact point, from the center of mass, and its rate when the axis moves with `n_rate`.

        The lowest point of an ellipsoid with the matrix M is -M UP/sqrt(UP M UP): M = edge^2 (1 + (square - 1) n n).
        """
        sine, sine_rate, more = n[2], n_rate[2], self.square - 1.0
        size = math.sqrt(1.0 + more * sine * sine)
        size_rate = more * sine * sine_rate / size
        low = UP + more * sine * n
        r = -self.shift * n - self.edge * low / size
        low_rate = more * (sine_rate * n + sine * n_rate)
        r_rate = -self.shift * n_rate - self.edge * (low_rate - low * size_rate / size) / size
        if self.core:
            # NaN past the flat position, which a trial step may reach
            cosine = np.sqrt(1.0 - sine * sine)
            d = (UP - sine * n) / cosine
            d_rate = (-sine_rate * n - sine * n_rate + sine * sine_rate / cosine * d) / cosine
            r, r_rate = r - self.core * d, r_rate - self.core * d_rate
        return r, r_rate

    def inertia(self, n: Array) -> Array:
        """Return the tensor of inertia."""
        return np.asarray(self.transverse * np.eye(3) + (self.axial - self.transverse) * np.outer(n, n))

    def right_side(self, _: float, y: Array) -> Array:
        """Return the derivatives of the axis and the angular velocity."""
        n, turning = y[:3], y[3:]
        n_rate = cross(turning, n)
        r, r_rate = self.contact(n, n_rate)
        inertia = self.inertia(n)
        # the center of mass moves with -turning x r; contact force = its acceleration + weight
        known = -cross(turning, inertia @ turning) + cross(r, UP - cross(turning, r_rate))
        whole = inertia + (r @ r) * np.eye(3) - np.outer(r, r)
        return np.concatenate([n_rate, np.linalg.solve(whole, known)])

    def start(self, tilt: float, w: float, o: float, s: float) -> Array:
        """Return the state for a tilt and scaled rates (`kernels.bodies.equations`)."""
        n = np.array([-math.cos(tilt), 0.0, math.sin(tilt)])
        d = np.array([math.sin(tilt), 0.0, math.cos(tilt)])
        return np.concatenate([n, w * np.array([0.0, 1.0, 0.0]) + o * d + s * n])

    def motion(
        self,
        tilt: float,
        w: float,
        o: float,
        s: float,
        end: float,
        accuracy: float = _ACCURACY,
        most: int = 0,
        **more: Any,
    ) -> Any:
        """Return SciPy's solution until `end`, or until the `most`-th turning point of the tilt; these are events."""
        from scipy.integrate import solve_ivp

        def turns(_: float, y: Array) -> float:
            return float(cross(y[3:], y[:3])[2])

        turns.terminal = most  # type: ignore[attr-defined]  # SciPy reads this attribute
        return solve_ivp(
            self.right_side, (0.0, end), self.start(tilt, w, o, s), method="DOP853", rtol=accuracy,
            atol=1e-2 * accuracy, events=turns, **more,
        )  # fmt: skip

    def extremes(
        self, tilt: float, w: float, o: float, s: float, end: float = 300.0, accuracy: float = _ACCURACY
    ) -> tuple[float, float, float]:
        """Return the extreme tilts and the scaled period of a motion; NaN if `end` comes before a full period."""
        solution = self.motion(tilt, w, o, s, end, accuracy, most=4)
        # a start at rest is a turning point: SciPy may see it as an event or not
        later = solution.t_events[0] > 0.0
        times, states = solution.t_events[0][later], solution.y_events[0][later]
        if w == 0.0:
            times = np.concatenate([[0.0], times])
            states = np.concatenate([[self.start(tilt, w, o, s)], states.reshape(-1, 6)])
        if times.size < 3:
            return math.nan, math.nan, math.nan
        x, y, z = states[:2, :3].T
        tilts = np.arctan2(z, np.hypot(x, y))
        return float(tilts.min()), float(tilts.max()), float(times[2] - times[0])
