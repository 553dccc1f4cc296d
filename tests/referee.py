"""Independent motions of the disk, which the tests trust instead of the code under test.

There are three referees. `extremes` does not follow time: along a motion the rates obey Chaplygin's linear system in
the tilt, so the kinetic energy of the tilt is a function of the tilt, and the disk turns where it vanishes. `motion`
integrates the equations of motion with their sines and cosines, by SciPy. `contact` does so too, and takes the forces
at the contact point from Lagrange's form (`lagrange`). Starts are arrays with the rows of `kernels.disk.arrays`, in SI.
"""

import math
from dataclasses import dataclass

import lagrange
import numpy as np
from numpy.polynomial.chebyshev import Chebyshev, chebfit
from scipy.integrate import DOP853, solve_ivp
from scipy.optimize import brentq

from kernels.disk.arrays import ALPHA, GRAVITY, PARAMETERS, RADIUS, STATE, TILT, TILT_RATE

FALL_TILT = math.radians(85.0)

_DEFAULTS = {
    "tilt": 0.0,
    "tilt_rate": 0.0,
    "precession_rate": 0.0,
    "roll_rate": 0.0,
    "alpha": 0.5,
    "radius": 0.5,
    "gravity": 9.81,
}


def starts(**parameters):
    """Return starts, float64[len(PARAMETERS), n]; by default of the report's uniform disk (R = 0.5 m)."""
    given = _DEFAULTS | parameters
    rows = np.broadcast_arrays(*(given[name] for name in PARAMETERS))
    return np.ascontiguousarray(np.stack([np.atleast_1d(row).ravel() for row in rows]), dtype=np.float64)


# --- the turning points ---------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Extremes:
    """Extreme tilts for infinite time [rad], each of shape (n,); `fell` if fall_tilt is reached on the way."""

    least: np.ndarray
    greatest: np.ndarray
    fell: np.ndarray

    @property
    def peak(self):
        """Return the largest magnitude of the tilt [rad]."""
        return np.maximum(np.abs(self.least), np.abs(self.greatest))


#: The scan starts this far [rad] from the initial tilt and grows by a few percent per step.
_NEAREST = 1e-9
_SCAN = 500


def extremes(given, fall_tilt=FALL_TILT):
    """Return the `Extremes` of starts inside +-fall_tilt."""
    tilt, rate = given[TILT], given[TILT_RATE] * np.sqrt(given[RADIUS] / given[GRAVITY])
    force = _carried(given, np.zeros((3, tilt.size)), tilt)[2]
    heading = np.where(rate == 0.0, np.sign(force), np.sign(rate))
    ahead = _turn(given, heading, fall_tilt)
    # Released at rest, the disk is already at a turning point.
    behind, moving = tilt.copy(), rate != 0.0
    if moving.any():
        behind[moving] = _turn(given[:, moving], -heading[moving], fall_tilt)
    fell_ahead, fell_behind = np.isnan(ahead), np.isnan(behind)
    ahead = np.where(fell_ahead, heading * fall_tilt, ahead)
    behind = np.where(fell_behind, -heading * fall_tilt, behind)
    behind = np.where(fell_ahead, tilt, behind)
    return Extremes(np.minimum(ahead, behind), np.maximum(ahead, behind), fell_ahead | fell_behind)


def _carried(given, y, tilt):
    """Return slopes in the tilt of (s - s0, o - o0, kinetic energy of the tilt), scaled with sqrt(R/g).

    Differences from the start make a start of 1e-5 rad as exact as one of 1 rad.
    """
    tilt0, _, precession, roll, alpha, radius, gravity = given
    unit = np.sqrt(radius / gravity)
    s = unit * (roll + precession * np.sin(tilt0)) + y[0]
    o = unit * precession * np.cos(tilt0) + y[1]
    tan = np.tan(tilt)
    force = np.sin(tilt) + o * ((1.0 + alpha) * s - 0.5 * alpha * o * tan)
    return np.stack([-o / (1.0 + alpha), -2.0 * s + o * tan, force])


def _turn(given, side, fall_tilt):
    """Return the first turning point [rad] on one side of the start, NaN if fall_tilt comes first."""
    n, tilt0 = given.shape[1], given[TILT]
    room = fall_tilt - side * tilt0
    growth = np.log1p(room / _NEAREST)

    def tilt_at(u):
        return tilt0 + side * _NEAREST * np.expm1(growth * u)

    def slope(u, y):
        along = side * _NEAREST * growth * np.exp(growth * u)
        return (_carried(given, y.reshape(3, n), tilt_at(u)) * along).ravel()

    kinetic = 0.5 * (1.0 + 0.5 * given[ALPHA]) * given[TILT_RATE] ** 2 * given[RADIUS] / given[GRAVITY]
    y0 = np.concatenate([np.zeros(2 * n), kinetic])
    solver = DOP853(slope, 0.0, y0, 1.0, max_step=1.0 / _SCAN, first_step=1.0 / _SCAN, rtol=1e-13, atol=1e-40)
    found = np.full(n, np.nan)
    force = slope(0.0, y0).reshape(3, n)[2]
    while np.isnan(found).any() and solver.status == "running":
        solver.step()
        if solver.status == "failed":
            raise ArithmeticError("the referee's integration failed")
        new, new_force = solver.y.reshape(3, n)[2], slope(solver.t, solver.y).reshape(3, n)[2]
        suspects = np.flatnonzero(np.isnan(found) & ((new <= 0.0) | ((force < 0.0) & (new_force > 0.0))))
        if suspects.size:
            # The dense output is a polynomial of degree 7 in u, so eight samples determine it.
            middle, half = 0.5 * (solver.t + solver.t_old), 0.5 * (solver.t - solver.t_old)
            samples = solver.dense_output()(middle + half * _NODES).reshape(3, n, 8)[2]
            for cell in suspects:
                found[cell] = tilt_at(middle + half * _root(Chebyshev(chebfit(_NODES, samples[cell], 7))))[
                    cell
                ]
        force = new_force
    return found


#: Chebyshev points of the second kind, including the ends.
_NODES = np.cos(np.pi * np.arange(7, -1, -1) / 7)


def _root(kinetic):
    """Return where in [-1, 1] a kinetic energy, positive at first, vanishes; NaN if it does not."""
    high = 1.0
    if kinetic(high) > 0.0:
        # It has a minimum in between, which may be negative.
        slope = kinetic.deriv()
        if not slope(-1.0) < 0.0 < slope(1.0):
            return np.nan
        high = brentq(slope, -1.0, 1.0, xtol=1e-15)
        if kinetic(high) > 0.0:
            return np.nan
    return brentq(kinetic, -1.0, high, xtol=1e-15) if kinetic(-1.0) > 0.0 else -1.0


# --- the motion in time ---------------------------------------------------------------------------------------------


def accelerations(state, alpha, radius, gravity):
    """Return second derivatives (tilt, heading, roll) [rad/s^2] of (tilt, tilt rate, precession rate, roll rate)."""
    tilt, rate, precession, roll = state
    sin, cos = math.sin(tilt), math.cos(tilt)
    push = 4.0 * gravity * sin + (2.0 + alpha) * radius * precession**2 * math.sin(2.0 * tilt)
    push += 4.0 * (1.0 + alpha) * radius * roll * precession * cos
    turn = rate * (2.0 * (1.0 + alpha) * roll * sin - (2.0 + alpha) * precession * cos**2)
    return push / (2.0 * (2.0 + alpha) * radius), -2.0 * roll * rate / cos, turn / ((1.0 + alpha) * cos)


def energy(state, alpha, radius, gravity):
    """Return the energy per mass [m^2/s^2] of (tilt, tilt rate, precession rate, roll rate).

    It is the translation of the center of mass plus the rotation about it, from velocities, unlike the code's sum of
    squares.
    """
    tilt, rate, precession, roll = state
    sin, cos = math.sin(tilt), math.cos(tilt)
    along = radius * (roll + precession * sin)
    velocity = along**2 + (radius * rate) ** 2
    axial = roll + precession * sin
    rotation = 0.5 * alpha * radius**2 * (rate**2 + (precession * cos) ** 2) + alpha * radius**2 * axial**2
    return 0.5 * (velocity + rotation) + gravity * radius * cos


@dataclass(frozen=True)
class Motion:
    """A motion in time: times and tilts of zero tilt rate, time of fall_tilt (or None), and the states."""

    turn_times: np.ndarray
    turn_tilts: np.ndarray
    fall_time: float | None
    states: np.ndarray


def _equations(start, fall_tilt):
    """Return the slope of the state in time, and SciPy's events: a turning point, and fall_tilt."""
    alpha, radius, gravity = start[ALPHA], start[RADIUS], start[GRAVITY]

    def slope(_, y):
        tilting, turning, rolling = accelerations(y, alpha, radius, gravity)
        return y[1], tilting, turning, rolling

    def turn(_, y):
        return y[1]

    def fall(_, y):
        return abs(y[0]) - fall_tilt

    return slope, turn, fall


def motion(start, duration, fall_tilt=FALL_TILT):
    """Integrate one start (7 numbers) with DOP853 until `duration` or a fall; a turn at time zero is skipped."""
    slope, turn, fall = _equations(start, fall_tilt)
    fall.terminal = True
    run = solve_ivp(
        slope,
        (0.0, duration),
        start[: len(STATE)],
        method="DOP853",
        rtol=1e-12,
        atol=1e-14,
        events=(turn, fall),
    )
    moving = run.t_events[0] > 1e-9 * duration
    times, states = run.t_events[0][moving], run.y_events[0][moving] if moving.any() else np.empty((0, 4))
    falls = run.t_events[1]
    return Motion(times, states[:, 0], float(falls[0]) if falls.size else None, run.y)


# --- the forces at the contact point ---------------------------------------------------------------------------------

#: Samples of a motion, then samples around each extreme, and how often these are refined.
_SPARSE, _NARROW, _CLOSER = 1000, 40, 4


def contact(start, duration, fall_tilt=FALL_TILT):
    """Return least normal force over the weight and largest friction coefficient of one start (7 numbers).

    The motion is followed forward until it turns, falls or reaches `duration`, and backward from the start if it
    turned. The coefficient is infinite where the normal force is not positive.
    """
    first, turned, elapsed = _leg_of_contact(np.asarray(start, float), duration, fall_tilt)
    if turned and start[TILT_RATE] != 0.0 and duration > 2.0 * elapsed:
        back = np.array(start, float)
        back[1:4] *= -1.0
        second, _, _ = _leg_of_contact(back, duration - 2.0 * elapsed, fall_tilt)
        return min(first[0], second[0]), max(first[1], second[1])
    return first


def _leg_of_contact(start, duration, fall_tilt):
    alpha, radius, gravity = start[ALPHA], start[RADIUS], start[GRAVITY]
    slope, turn, fall = _equations(start, fall_tilt)
    first = start[: len(STATE)]
    heading = math.copysign(1.0, first[1] if first[1] != 0.0 else slope(0.0, first)[1])
    turn.terminal = fall.terminal = True
    turn.direction = -heading
    scale = np.array([1e-3, *[math.sqrt(gravity / radius)] * 3])
    run = solve_ivp(
        slope, (0.0, duration), first, "DOP853", events=(turn, fall), dense_output=True,
        rtol=1e-13, atol=1e-15 * scale,
    )  # fmt: skip
    times = np.unique(np.concatenate([np.linspace(0.0, run.t[-1], _SPARSE), run.t]))
    normal, needed = _contact_forces(run.sol(times), alpha, radius, gravity)
    found = [normal.min(), needed.max()]
    for place in {int(normal.argmin()), int(needed.argmax())}:
        low, high = times[max(0, place - 1)], times[min(times.size - 1, place + 1)]
        for _ in range(_CLOSER):
            near = np.linspace(low, high, _NARROW)
            normal, needed = _contact_forces(run.sol(near), alpha, radius, gravity)
            found = [min(found[0], normal.min()), max(found[1], needed.max())]
            # The coefficient has narrow peaks next to the least normal force.
            place = int(needed.argmax()) if np.isfinite(needed).all() else int(normal.argmin())
            low, high = near[max(0, place - 1)], near[min(_NARROW - 1, place + 1)]
    return tuple(map(float, found)), run.t_events[0].size > 0, float(run.t[-1])


def _contact_forces(states, alpha, radius, gravity):
    """Return normal force over the weight and friction coefficient for states of shape (4, n)."""
    tilt, rate, precession, roll = states
    zero = np.zeros_like(tilt)
    q = np.stack([zero, zero, zero, tilt, zero], axis=-1)
    v = np.stack([zero, radius * roll, precession, rate, roll], axis=-1)
    up, friction = lagrange.accelerations(q, v, alpha, 1.0, radius, gravity)
    normal = gravity - radius * (up[..., 3] * np.sin(tilt) + rate**2 * np.cos(tilt))
    with np.errstate(divide="ignore"):
        needed = np.where(normal > 0.0, np.hypot(*friction.T) / normal, np.inf)
    return normal / gravity, needed
