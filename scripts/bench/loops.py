"""The engine, and the loops that one would write instead: Numba over cells, NumPy over all cells at once.

The plain loops integrate the textbook equations and find the peak from a parabola through the last step, which is as
accurate as the method at these steps; like the engine, they stop at the turning point.
"""

import math

import numba
import numpy as np

from bench.problem import FALL_TILT, LONGEST, Array, Contender, Solve, peaks, results, timed
from kernels.disk.arrays import (
    ALPHA,
    GRAVITY,
    PRECESSION_RATE,
    RADIUS,
    ROLL_RATE,
    STATE,
    TILT,
    TILT_MAX,
    TILT_MIN,
    TILT_RATE,
)
from sweep.model.disk.model import DISK


@numba.njit(error_model="numpy")
def _rates(tilt, tilt_rate, precession_rate, roll_rate, alpha, radius, gravity):
    sin, cos = math.sin(tilt), math.cos(tilt)
    acceleration = (
        4.0 * gravity * sin
        + (2.0 + alpha) * radius * precession_rate**2 * math.sin(2.0 * tilt)
        + 4.0 * (1.0 + alpha) * radius * roll_rate * precession_rate * cos
    ) / (2.0 * (2.0 + alpha) * radius)
    precession = -2.0 * roll_rate * tilt_rate / cos
    roll = (
        tilt_rate
        * (2.0 * (1.0 + alpha) * roll_rate * sin - (2.0 + alpha) * precession_rate * cos**2)
        / ((1.0 + alpha) * cos)
    )
    return tilt_rate, acceleration, precession, roll


@numba.njit(error_model="numpy")
def _step(a, b, c, d, alpha, radius, gravity, h):
    half = 0.5 * h
    a1, b1, c1, d1 = _rates(a, b, c, d, alpha, radius, gravity)
    a2, b2, c2, d2 = _rates(
        a + half * a1, b + half * b1, c + half * c1, d + half * d1, alpha, radius, gravity
    )
    a3, b3, c3, d3 = _rates(
        a + half * a2, b + half * b2, c + half * c2, d + half * d2, alpha, radius, gravity
    )
    a4, b4, c4, d4 = _rates(a + h * a3, b + h * b3, c + h * c3, d + h * d3, alpha, radius, gravity)
    a += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
    b += h / 6.0 * (b1 + 2.0 * b2 + 2.0 * b3 + b4)
    c += h / 6.0 * (c1 + 2.0 * c2 + 2.0 * c3 + c4)
    d += h / 6.0 * (d1 + 2.0 * d2 + 2.0 * d3 + d4)
    return a, b, c, d


@numba.njit(error_model="numpy", parallel=True)
def equal_steps(starts, steps, h, final):
    """Integrate by RK4, cell by cell in a parallel loop, with the engine's number of steps in each cell."""
    for cell in numba.prange(starts.shape[1]):
        a, b = starts[TILT, cell], starts[TILT_RATE, cell]
        c, d = starts[PRECESSION_RATE, cell], starts[ROLL_RATE, cell]
        alpha, radius, gravity = starts[ALPHA, cell], starts[RADIUS, cell], starts[GRAVITY, cell]
        for _ in range(steps[cell]):
            a, b, c, d = _step(a, b, c, d, alpha, radius, gravity, h)
        final[TILT, cell], final[TILT_RATE, cell] = a, b
        final[PRECESSION_RATE, cell], final[ROLL_RATE, cell] = c, d


@numba.njit(error_model="numpy", parallel=True)
def _to_the_turn(starts, h, most, found):
    for cell in numba.prange(starts.shape[1]):
        a, b = starts[TILT, cell], starts[TILT_RATE, cell]
        c, d = starts[PRECESSION_RATE, cell], starts[ROLL_RATE, cell]
        alpha, radius, gravity = starts[ALPHA, cell], starts[RADIUS, cell], starts[GRAVITY, cell]
        heading = _rates(a, b, c, d, alpha, radius, gravity)[1]
        for _ in range(most):
            a, b, c, d = _step(a, b, c, d, alpha, radius, gravity, h)
            if heading * b < 0.0:
                break
        for _ in range(2):
            back = -b / _rates(a, b, c, d, alpha, radius, gravity)[1]
            a, b, c, d = _step(a, b, c, d, alpha, radius, gravity, back)
        found[cell] = max(abs(a), abs(starts[TILT, cell]))


def _plain(given: Array, step: float) -> Array:
    found = np.empty(given.shape[1])
    _to_the_turn(given, step, int(LONGEST / step), found)
    return found


def _numpy(given: Array, step: float) -> Array:
    """Integrate all cells together, step by step; cells that have turned are finished and dropped."""
    found = np.abs(given[TILT])
    places, count = np.arange(given.shape[1]), len(STATE)
    state, parameters = given[:count].copy(), given[count:]
    heading = np.sign(_array_rates(state, parameters)[TILT_RATE])
    for _ in range(int(LONGEST / step)):
        state = _array_step(state, parameters, step)
        turned = heading * state[TILT_RATE] < 0.0
        if not turned.any():
            continue
        peak, of = state[:, turned], parameters[:, turned]
        for _ in range(2):
            peak = _array_step(peak, of, -peak[TILT_RATE] / _array_rates(peak, of)[TILT_RATE])
        found[places[turned]] = np.maximum(found[places[turned]], np.abs(peak[TILT]))
        on = ~turned
        places, state, parameters, heading = places[on], state[:, on], parameters[:, on], heading[on]
        if places.size == 0:
            break
    return np.asarray(found)


def _array_rates(state: Array, parameters: Array) -> Array:
    return np.stack(_rates_of_arrays(*state, *parameters))


def _rates_of_arrays(a, b, c, d, alpha, radius, gravity):
    sin, cos = np.sin(a), np.cos(a)
    acceleration = (
        2.0 * gravity * sin + (2.0 + alpha) * radius * c * c * sin * cos
        + 2.0 * (1.0 + alpha) * radius * d * c * cos
    ) / ((2.0 + alpha) * radius)  # fmt: skip
    roll = b * (2.0 * (1.0 + alpha) * d * sin - (2.0 + alpha) * c * cos * cos) / ((1.0 + alpha) * cos)
    return b, acceleration, -2.0 * d * b / cos, roll


def _array_step(state: Array, parameters: Array, h: float | Array) -> Array:
    first = _array_rates(state, parameters)
    second = _array_rates(state + 0.5 * h * first, parameters)
    third = _array_rates(state + 0.5 * h * second, parameters)
    fourth = _array_rates(state + h * third, parameters)
    return np.asarray(state + h / 6.0 * (first + 2.0 * (second + third) + fourth))


def _engine(given: Array, tolerance: float) -> Array:
    measures, counts = results(given.shape[1])
    DISK.integrate.load()(given, np.array([300.0, 0.0, FALL_TILT, tolerance]), measures, counts)
    return np.asarray(np.maximum(np.abs(measures[TILT_MIN]), np.abs(measures[TILT_MAX])))


def _exact() -> Solve:
    return timed(lambda given, _: peaks(given))


def contenders(quick: bool) -> list[Contender]:
    """Return this engine (first) and the plain loops."""
    ladder = (0.04, 0.02, 0.01, 0.007, 0.005, 0.0025)
    many = 40_000 if quick else 400_000
    return [
        Contender(
            "eulerdisk rk4", "tolerance", (1e-4, 1e-6, 3e-7, 1e-7, 1e-8, 1e-10), many, lambda: timed(_engine)
        ),
        Contender("eulerdisk exact", "", (0.0,), many, _exact),
        Contender("Numba prange RK4", "step [s]", ladder, 4_000 if quick else 40_000, lambda: timed(_plain)),
        Contender("NumPy RK4", "step [s]", ladder, 2_000 if quick else 20_000, lambda: timed(_numpy)),
    ]
