"""heyoka for the same task: Taylor series of high order, batches driven explicitly, and its ensemble mode.

It gets the polynomial form of the equations, which suits it as well as the engine.
"""

import itertools
import time
from typing import Any

import numpy as np

from bench.problem import Array, Contender, Solve, headings, longest, periods, scaled, timed
from kernels.disk.arrays import GRAVITY, RADIUS, TILT

_TOLERANCES = (1e-5, 1e-6, 1e-7, 1e-9, 1e-12, 1e-15)


def _system(heyoka: Any) -> tuple[Any, Any]:
    """Return the six polynomial equations (`kernels.disk.equations`) and the event function; par[4] is the heading."""
    sin, cos, tan, w, o, s = heyoka.make_vars("sin", "cos", "tan", "w", "o", "s")
    a, b, c, d, heading = heyoka.par[0], heyoka.par[1], heyoka.par[2], heyoka.par[3], heyoka.par[4]
    pull = o * tan
    system = [
        (sin, cos * w),
        (cos, -sin * w),
        (tan, w + tan * tan * w),
        (w, a * (sin + o * (b * s - c * pull))),
        (o, w * (pull - 2.0 * s)),
        (s, -d * w * o),
    ]
    return system, heading * w


def _columns(given: Array) -> tuple[Array, Array]:
    """Return states (6, n) and parameters (5, n)."""
    (tilt, w, o, s), constants = scaled(given)
    state = np.stack([np.sin(tilt), np.cos(tilt), np.tan(tilt), w, o, s])
    return state, np.concatenate([constants, headings(given)[None]])


def _batch() -> Solve:
    import heyoka

    system, turn = _system(heyoka)
    width = heyoka.recommended_simd_size()
    peaks = np.zeros(width)
    turned = np.zeros(width, bool)

    def at_turn(integrator: Any, _sign: int, lane: int) -> bool:
        if not turned[lane]:
            peaks[lane] = abs(np.arctan2(integrator.state[0, lane], integrator.state[1, lane]))
            turned[lane] = True
        return not turned.all()

    integrators: dict[float, Any] = {}

    def solve(given: Array, tolerance: float) -> Array:
        if tolerance not in integrators:
            event = heyoka.t_event_batch(turn, callback=at_turn, direction=heyoka.event_direction.negative)
            integrators[tolerance] = heyoka.taylor_adaptive_batch(
                system, np.zeros((6, width)), pars=np.zeros((5, width)), t_events=[event], tol=tolerance
            )
        integrator, end = integrators[tolerance], longest(given)
        state, parameters = _columns(given)
        found = np.abs(given[TILT])
        for start in range(0, given.shape[1] - width + 1, width):
            part = slice(start, start + width)
            integrator.set_time(0.0)
            integrator.reset_cooldowns()
            integrator.state[:], integrator.pars[:] = state[:, part], parameters[:, part]
            turned[:] = False
            integrator.propagate_until(end)
            found[part] = np.maximum(found[part], peaks)
        return np.asarray(found)

    return timed(solve)


def _ensemble() -> Solve:
    """Return heyoka's ensemble mode, without events.

    Copying an integrator with events costs more than everything else. Time is scaled by half of each cell's nutation
    period, known from the exact reduction, so that the integration ends at the peak.
    """
    import heyoka

    system, _ = _system(heyoka)
    system = [(variable, heyoka.par[5] * rate) for variable, rate in system]
    integrators: dict[float, Any] = {}

    def solve(given: Array, tolerance: float) -> tuple[float, Array]:
        if tolerance not in integrators:
            integrators[tolerance] = heyoka.taylor_adaptive(
                system, np.zeros(6), pars=np.zeros(6), tol=tolerance
            )
        state, parameters = _columns(given)
        unit = np.sqrt(given[RADIUS] / given[GRAVITY])
        parameters = np.concatenate([parameters, (0.5 * periods(given) / unit)[None]])

        def generate(copy: Any, cell: int) -> Any:
            copy.time = 0.0
            copy.state[:], copy.pars[:] = state[:, cell], parameters[:, cell]
            return copy

        began = time.process_time()
        done = heyoka.ensemble_propagate_until(
            integrators[tolerance], 1.0, given.shape[1], generate, max_workers=1
        )
        seconds = time.process_time() - began
        ends = np.array([each[0].state[:2] for each in done])
        return seconds, np.maximum(np.abs(given[TILT]), np.abs(np.arctan2(ends[:, 0], ends[:, 1])))

    return solve


def contenders(quick: bool) -> list[Contender]:
    """Return both of heyoka's modes."""
    counts = itertools.cycle((2048, 128) if quick else (20480, 1024))
    modes = (("heyoka batch", _batch), ("heyoka ensemble", _ensemble))
    return [Contender(name, "tol", _TOLERANCES, next(counts), prepare) for name, prepare in modes]
