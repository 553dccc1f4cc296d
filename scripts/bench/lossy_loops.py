"""The disk with losses by other means: the loop that one would write in Numba, and heyoka.

Both follow toys with dry contour friction and Bildsten's drag until they are flat, from starts whose roll rate never
changes sign, so that the friction is smooth; only the engine handles friction that holds and lets go. Starts are
float64[len(PARAMETERS), n] (`kernels.lossy_disk.arrays`); the results are the times [s] until flat.
"""

import math
from typing import Any

import numba
import numpy as np

from bench.problem import Array
from kernels.lossy_disk.arrays import (
    AIR_DENSITY,
    AIR_VISCOSITY,
    ALPHA,
    CONTOUR_FRICTION,
    GRAVITY,
    MASS,
    PRECESSION_RATE,
    RADIUS,
    ROLL_RATE,
    TILT,
    TILT_RATE,
)

FLAT_TILT = math.radians(89.9)

#: Longest scaled time for which a motion is followed.
_LONGEST = 1e6


def scale_starts(given: Array) -> tuple[Array, Array, Array]:
    """Return scaled states (tilt and three rates) and constants (alpha, arm, drag) of starts, and the time unit [s]."""
    unit = np.sqrt(given[RADIUS] / given[GRAVITY])
    layer = np.sqrt(given[AIR_VISCOSITY] * given[AIR_DENSITY])
    drag = layer * given[RADIUS] ** 2.25 / (math.sqrt(2.0) * given[MASS] * given[GRAVITY] ** 0.25)
    rates = (unit * given[row] for row in (TILT_RATE, PRECESSION_RATE, ROLL_RATE))
    constants = np.stack([given[ALPHA], given[CONTOUR_FRICTION] / given[RADIUS], drag])
    return np.stack([given[TILT], *rates]), constants, unit


@numba.njit(error_model="numpy")
def _rates(tilt, w, precession, f, alpha, arm, drag):
    sin, cos = math.sin(tilt), math.cos(tilt)
    inertia = 1.0 + 0.5 * alpha
    acceleration = (
        sin + inertia * precession * precession * sin * cos + (1.0 + alpha) * f * precession * cos
    ) / inertia
    normal = 1.0 - acceleration * sin - w * w * cos
    force = -math.copysign(arm * normal, f) - drag * math.sqrt(abs(f)) * f
    tan = sin / cos
    turning = -2.0 * f * w / cos - 2.0 * sin / (alpha * cos * cos) * force
    rolling = w * (2.0 * f * tan - (2.0 + alpha) / (1.0 + alpha) * precession * cos)
    return w, acceleration, turning, rolling + (1.0 / (1.0 + alpha) + 2.0 * tan * tan / alpha) * force


@numba.njit(error_model="numpy")
def _step(a, b, c, d, alpha, arm, drag, h):
    half = 0.5 * h
    a1, b1, c1, d1 = _rates(a, b, c, d, alpha, arm, drag)
    a2, b2, c2, d2 = _rates(a + half * a1, b + half * b1, c + half * c1, d + half * d1, alpha, arm, drag)
    a3, b3, c3, d3 = _rates(a + half * a2, b + half * b2, c + half * c2, d + half * d2, alpha, arm, drag)
    a4, b4, c4, d4 = _rates(a + h * a3, b + h * b3, c + h * c3, d + h * d3, alpha, arm, drag)
    a += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
    b += h / 6.0 * (b1 + 2.0 * b2 + 2.0 * b3 + b4)
    c += h / 6.0 * (c1 + 2.0 * c2 + 2.0 * c3 + c4)
    d += h / 6.0 * (d1 + 2.0 * d2 + 2.0 * d3 + d4)
    return a, b, c, d


@numba.njit(error_model="numpy", parallel=True)
def integrate_until_flat(states, constants, share, times, steps):
    """Integrate by RK4, cell by cell in a parallel loop, with steps of `share` divided by the present fastest rate."""
    for cell in numba.prange(states.shape[1]):
        a, b, c, d = states[0, cell], states[1, cell], states[2, cell], states[3, cell]
        alpha, arm, drag = constants[0, cell], constants[1, cell], constants[2, cell]
        t, done = 0.0, 0
        while abs(a) < FLAT_TILT and t < _LONGEST:
            cos = math.cos(a)
            h = share / math.sqrt(1.0 + c * c + b * b / (cos * cos))
            a, b, c, d = _step(a, b, c, d, alpha, arm, drag, h)
            t += h
            done += 1
        for _ in range(3):
            back = (math.copysign(FLAT_TILT, a) - a) / b
            a, b, c, d = _step(a, b, c, d, alpha, arm, drag, back)
            t += back
        times[cell], steps[cell] = t, done


def plain(given: Array, share: float) -> tuple[Array, float]:
    """Return the times of the plain loop, and its number of steps."""
    states, constants, unit = scale_starts(given)
    times, steps = np.empty(unit.size), np.empty(unit.size, np.int64)
    integrate_until_flat(states, constants, share, times, steps)
    return unit * times, float(steps.sum())


class Heyoka:
    """heyoka's batch mode on the equations without trigonometry, driven explicitly; lanes that are flat rest."""

    def __init__(self) -> None:
        import heyoka

        self._heyoka, self._integrators = heyoka, dict[float, Any]()
        self._width = heyoka.recommended_simd_size()
        self._times = np.zeros(self._width)

    def _system(self) -> tuple[Any, Any]:
        """Return the equations and the event; par[3] is the sign of the roll rate, par[4] is 0 where a lane rests."""
        heyoka = self._heyoka
        sin, cos, w, o, p = heyoka.make_vars("sin", "cos", "w", "o", "p")
        alpha, arm, drag, sign, going = (heyoka.par[i] for i in range(5))
        tan, s = sin / cos, p / (1.0 + alpha)
        f = s - o * tan
        acceleration = (sin + o * (p - 0.5 * alpha * o * tan)) / (1.0 + 0.5 * alpha)
        normal = 1.0 - acceleration * sin - w * w * cos
        force = -sign * arm * normal - drag * heyoka.sqrt(sign * f) * f
        system = [
            (sin, cos * w),
            (cos, -sin * w),
            (w, acceleration),
            (o, w * (o * tan - 2.0 * s) - 2.0 / alpha * tan * force),
            (p, force - w * o),
        ]
        return [(variable, going * rate) for variable, rate in system], cos - math.cos(FLAT_TILT)

    def _integrator(self, tolerance: float) -> Any:
        def at_flat(integrator: Any, _sign: int, lane: int) -> bool:
            self._times[lane] = integrator.time[lane]
            integrator.pars[4, lane] = 0.0
            return bool(integrator.pars[4].any())

        heyoka, (system, flat) = self._heyoka, self._system()
        event = heyoka.t_event_batch(flat, callback=at_flat, direction=heyoka.event_direction.negative)
        size = self._width
        return heyoka.taylor_adaptive_batch(
            system, np.ones((5, size)), pars=np.ones((5, size)), t_events=[event], tol=tolerance
        )

    def __call__(self, given: Array, tolerance: float) -> tuple[Array, float]:
        """Return the times, and 0 for the number of steps, which are not comparable."""
        if tolerance not in self._integrators:
            self._integrators[tolerance] = self._integrator(tolerance)
        integrator = self._integrators[tolerance]
        (tilt, w, turning, f), constants, unit = scale_starts(given)
        sin, cos = np.sin(tilt), np.cos(tilt)
        states = np.stack([sin, cos, w, turning * cos, (1.0 + constants[0]) * (f + turning * sin)])
        found = np.full(unit.size, math.nan)
        for start in range(0, unit.size - self._width + 1, self._width):
            part = slice(start, start + self._width)
            integrator.set_time(0.0)
            integrator.reset_cooldowns()
            integrator.state[:], integrator.pars[:3] = states[:, part], constants[:, part]
            integrator.pars[3], integrator.pars[4] = np.sign(f[part]), 1.0
            self._times[:] = math.nan
            integrator.propagate_until(_LONGEST)
            found[part] = self._times
        return unit * found, 0.0
