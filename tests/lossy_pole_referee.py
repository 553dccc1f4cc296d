"""The motion of a ball or a spheroid with losses by other means: Newton and Euler in space, by SciPy.

State and units are those of `body_referee`, behind them `lossy_body_referee.LEDGER`, with the heading as the angle of
the horizontal part of the axis. Contour friction opposes the whole way of the contact over the body: how that follows
from the angular velocity is asked of the geometry, one direction after the other.
"""

import math
from dataclasses import dataclass

import numpy as np
from body_referee import UP, Body, cross
from body_runner import drawn
from lossy_body_referee import ARMS, LEDGER, Lossy, some
from scipy.integrate import solve_ivp


@dataclass(frozen=True)
class Polar:
    """A ball or a spheroid, its lever arms over R, its scaled damping; `soft` as of `lossy_body_referee`."""

    body: Body
    rolling: float = 0.0
    pivoting: float = 0.0
    contour: float = 0.0
    damping: float = 0.0
    soft: float = 0.0

    def over(self, n):
        """Return the matrix that says how the contact moves over the body with an angular velocity."""
        r, _ = self.body.contact(n, np.zeros(3))
        return np.array([self.body.contact(n, cross(e, n))[1] - cross(e, r) for e in np.eye(3)]).T

    def right_side(self, _, y):
        """Return the derivatives of axis, angular velocity and ledger."""
        n, turning = y[:3], y[3:6]
        n_rate = cross(turning, n)
        r, r_rate = self.body.contact(n, n_rate)
        inertia, over = self.body.inertia(n), self.over(n)
        horizontal, moving = turning - turning[2] * UP, over @ turning
        size, way = (math.hypot(np.linalg.norm(each), self.soft) for each in (horizontal, moving))
        upright = turning[2] / math.hypot(turning[2], self.soft) if turning[2] else 0.0
        laws = (
            -self.rolling * horizontal / size if size else np.zeros(3),
            -self.pivoting * upright * UP,
            -self.contour * over.T @ moving / way if way else np.zeros(3),
        )
        damped = -self.damping * over.T @ moving
        whole = inertia + (r @ r) * np.eye(3) - np.outer(r, r)
        known = -cross(turning, inertia @ turning) + cross(r, UP - cross(turning, r_rate))
        free, slowed = np.linalg.solve(whole, np.stack([known + damped, sum(laws)], axis=1)).T
        lifted = cross(r, UP)
        normal = (1.0 - UP @ cross(turning, r_rate) - free @ lifted) / (1.0 + slowed @ lifted)
        square = n[0] ** 2 + n[1] ** 2
        taken = (
            (n[0] * n_rate[1] - n[1] * n_rate[0]) / square, np.linalg.norm(moving),
            *(-normal * law @ turning for law in laws), -damped @ turning, 0.0,
        )  # fmt: skip
        return np.concatenate([n_rate, free + normal * slowed, taken])

    path, energy = Lossy.path, Lossy.energy

    def follow(self, start, end, method="DOP853", accuracy=1e-11):
        """Return SciPy's solution from (tilt, w, o, s), to a dry rate that vanishes, and its tilts."""

        def turns(_, y):
            return cross(y[3:6], y[:3])[2]

        def stops(_, y):
            return math.hypot(y[3], y[4]) - 1e-9 if (self.rolling or self.contour) and not self.soft else 1.0

        def spins(_, y):
            return y[5] if self.pivoting and not self.soft else 1.0

        stops.terminal = spins.terminal = True
        begun = np.concatenate([self.body.start(*start), np.zeros(len(LEDGER))])
        found = solve_ivp(
            self.right_side, (0.0, end), begun, method=method, rtol=accuracy, atol=1e-2 * accuracy,
            events=[stops, spins, turns],
        )  # fmt: skip
        met = [each for each in found.y_events if len(each)]
        x, y, z = np.concatenate([found.y[:, [0, -1]].T, *met])[:, :3].T
        return found, np.arctan2(z, np.hypot(x, y))


def drawn_polar(name, rng, most=-1.3):
    """Return the parameters of a ball or a spheroid with losses by their words, and the referee's; arms to 10^most."""
    lengths, (axial, transverse), (core, shift, edge, square) = drawn(name, rng)
    calm = 0.1 if rng.random() < 0.3 else 1.0
    tilt, rates = rng.uniform(-1.5, 1.5), calm * rng.normal(size=3) * (0.3, 1.0, 1.0)
    laws = some(rng, (*ARMS, "contour_damping"), most=most)
    words = {**lengths, **laws, "axial_moment": axial, "transverse_moment": transverse, "tilt": tilt}
    words |= dict(zip(("tilt_rate", "precession_rate", "roll_rate"), rates, strict=True))
    body = Body(core, shift, edge, axial, transverse, square)
    return words, Polar(body, *(laws[each] for each in ARMS), laws["contour_damping"])
