"""General integrators for the same task: SciPy's solve_ivp, Octave's ode45, JAX with diffrax."""

import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

import numpy as np

from bench.problem import LONGEST, Array, Contender, Solve, headings, longest, scaled, timed
from kernels.disk.arrays import TILT

#: Time [s] for which a sweep script integrates that does not detect turning points.
_WHILE = 10.0

_TOLERANCES = (1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-12)


def _scipy(method: str, to_the_turn: bool = True) -> Solve:
    """Return `solve_ivp` to the turning point, or for 10 s past all turning points (whose peaks are equal)."""
    from scipy.integrate import solve_ivp

    def rates(_t: float, y: Array, a: float, b: float, c: float, d: float) -> list[float]:
        tilt, w, o, s = y
        pull = o * np.tan(tilt)
        return [w, a * (np.sin(tilt) + o * (b * s - c * pull)), w * (pull - 2.0 * s), -d * w * o]

    def solve(given: Array, tolerance: float) -> Array:
        state, constants = scaled(given)
        heading, end = headings(given), longest(given, LONGEST if to_the_turn else _WHILE)
        found = np.abs(given[TILT])
        for cell in range(given.shape[1]):
            turn: Any = lambda _t, y, *_: y[1]  # noqa: E731 - scipy wants attributes on the function
            turn.terminal, turn.direction = to_the_turn, -heading[cell]
            done = solve_ivp(
                rates, (0.0, end), state[:, cell], method=method, events=turn, args=tuple(constants[:, cell]),
                rtol=max(tolerance, 3e-14), atol=tolerance * 1e-2,
            )  # fmt: skip
            if to_the_turn or done.y_events[0].size:
                peak = done.y[0, -1] if to_the_turn else done.y_events[0][0, 0]
                found[cell] = max(found[cell], abs(peak))
        return np.asarray(found)

    return timed(solve)


_OCTAVE = """
1;
function dy = rates (t, y, k)
  pull = y(3) * tan (y(1));
  dy = [y(2); k(1) * (sin (y(1)) + y(3) * (k(2) * y(4) - k(3) * pull)); ...
        y(2) * (pull - 2 * y(4)); -k(4) * y(2) * y(3)];
end
function [value, stop, direction] = turn (t, y, heading)
  value = y(2); stop = 1; direction = -heading;
end
cells = [%s];
began = cputime ();
for i = 1:rows (cells)
  c = cells(i,:);
  o = odeset ("RelTol", %g, "AbsTol", %g, "Events", @(t, y) turn (t, y, c(9)));
  [t, y, te, ye] = ode45 (@(t, y) rates (t, y, c(5:8)), [0, %g], c(1:4)', o);
  peak(i) = max (abs ([y(1,1), ye(end,1)]));
end
printf ("%%.17g\\n", cputime () - began, peak);
"""


def _octave() -> Solve:
    program = shutil.which("octave-cli") or shutil.which("octave")
    if program is None:
        raise OSError("octave is not installed")

    def solve(given: Array, tolerance: float) -> tuple[float, Array]:
        rows = np.concatenate([*scaled(given), headings(given)[None]]).T
        cells = ";".join(",".join(f"{number:.17g}" for number in row) for row in rows)
        text = _OCTAVE % (cells, tolerance, tolerance * 1e-2, longest(given))
        command = [program, "--no-gui", "--quiet", "--no-init-file", "--eval", text]
        said = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()
        return float(said[0]), np.array(said[1:], dtype=np.float64)

    return solve


@contextmanager
def _one_cpu() -> Iterator[None]:
    """Restrict new threads to one processor: JAX has no other way to limit them."""
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(before)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


def _diffrax(name: str) -> Solve:
    with _one_cpu():
        import diffrax
        import jax
        import jax.numpy as jnp
        import optimistix

        jax.config.update("jax_enable_x64", True)
        jnp.zeros(8).sum().block_until_ready()

    def rates(_t: Any, y: Any, k: Any) -> Any:
        tilt, w, o, s = y
        pull = o * jnp.tan(tilt)
        return jnp.stack(
            [w, k[0] * (jnp.sin(tilt) + o * (k[1] * s - k[2] * pull)), w * (pull - 2.0 * s), -k[3] * w * o]
        )

    def turn(t: Any, y: Any, args: Any, **_: Any) -> Any:
        # below zero on the way, so that the rest at which the cell starts is no event
        return jnp.where(t > 0.0, args[4] * y[1], 1.0)

    def peak(y: Any, args: Any, end: float, tolerance: float) -> Any:
        event = diffrax.Event(
            turn, optimistix.Newton(rtol=1e-10, atol=1e-12, norm=optimistix.rms_norm), direction=False
        )
        done = diffrax.diffeqsolve(
            diffrax.ODETerm(rates), getattr(diffrax, name)(), 0.0, end, 0.02, y, args, event=event,
            stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=tolerance * 1e-2),
            saveat=diffrax.SaveAt(t1=True), max_steps=100_000, throw=False,
        )  # fmt: skip
        return jnp.maximum(jnp.abs(done.ys[0, 0]), jnp.abs(y[0]))

    many = jax.jit(jax.vmap(peak, in_axes=(0, 0, None, None)))

    def solve(given: Array, tolerance: float) -> Array:
        state, constants = scaled(given)
        arguments = np.concatenate([constants, headings(given)[None]])
        return np.asarray(many(state.T, arguments.T, longest(given), tolerance))

    return timed(solve)


def contenders(quick: bool) -> list[Contender]:
    """Return the general integrators; preparing one that is not installed raises an error."""
    few = 6 if quick else 24
    batch = 256 if quick else 4096
    found = [
        Contender(f"SciPy {name}", "rtol", _TOLERANCES, few, partial(_scipy, name))
        for name in ("RK45", "DOP853", "LSODA")
    ]
    found += [
        Contender("SciPy LSODA, 10 s", "rtol", _TOLERANCES, few, partial(_scipy, "LSODA", to_the_turn=False))
    ]
    found += [
        Contender(f"diffrax {name}", "rtol", _TOLERANCES, batch, partial(_diffrax, name))
        for name in ("Tsit5", "Dopri8")
    ]
    return [*found, Contender("Octave ode45", "RelTol", (1e-6, 1e-9, 1e-12), 2 if quick else 8, _octave)]
