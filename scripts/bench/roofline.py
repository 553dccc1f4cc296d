"""The lane kernel's speed relative to the machine's rate of multiply-adds, and to a plain loop."""

import statistics
import time
from collections.abc import Callable
from typing import Any, Self

import numba
import numpy as np

from bench.loops import equal_steps
from bench.problem import FALL_TILT, results, starts, use_threads
from kernels.disk import equations as disk
from kernels.disk import rk4
from kernels.disk.arrays import STATE, STEPS
from kernels.native.compiler import KernelCompiler
from sweep.model.disk.model import DISK
from sweep.platforms import most_threads

#: Steps [s]: the first, 0.044 sqrt(R/g), is about the engine's own; with the second, the ends of cells hardly count.
_STEPS = (0.01, 0.001)
_LOOSE = 0.1  # rad: no cell is integrated twice, so that steps can be counted

#: Independent chains per vector, and links per chain, of the measurement; 12 chains hide the latency of two units.
_CHAINS, _LINKS = 12, 40


class _Counted:
    """A number that counts the arithmetic done with it; adding a fresh product is one multiply-add."""

    slots = 0

    def __init__(self, fresh: bool = False) -> None:
        self.fresh = fresh

    def __mul__(self, _other: object) -> "_Counted":
        _Counted.slots += 1
        return _Counted(fresh=True)

    def __add__(self, other: object) -> "_Counted":
        for term in (self, other):
            if isinstance(term, _Counted) and term.fresh:
                term.fresh = False
                return _Counted()
        _Counted.slots += 1
        return _Counted()

    def __neg__(self) -> Self:
        # a sign is part of the multiply-add
        return self

    __rmul__, __sub__, __radd__, __rsub__ = __mul__, __add__, __add__, __add__


def multiply_adds() -> int:
    """Return the multiply-adds of one RK4 step, by running its source on numbers that count."""
    plain = type(rk4.lane_step.py_func)
    parts = {"slopes": disk.slopes.py_func, "_along": rk4._along.py_func, "_summed": rk4._summed.py_func}
    step = plain(rk4.lane_step.py_func.__code__, rk4.lane_step.py_func.__globals__ | parts)
    _Counted.slots = 0
    step(*(_Counted() for _ in range(10)))
    return _Counted.slots


def _probe() -> Callable[..., None]:
    """Return a kernel that consists only of multiply-adds, written out so that it vectorizes over its elements."""
    lines = ["def chains(row, rounds, a, b):", " for _ in range(rounds):", "  for k in range(row.size):"]
    lines += ["   x0 = row[k]", *(f"   x{n} = x0 + {n}.0" for n in range(1, _CHAINS))]
    lines += [f"   x{n} = x{n} * a + b" for _ in range(_LINKS) for n in range(_CHAINS)]
    lines.append("   row[k] = " + " + ".join(f"x{n}" for n in range(_CHAINS)))
    scope: dict[str, Any] = {}
    exec("\n".join(lines), scope)
    # not in the parallel loop itself, whose body Numba compiles in its own way
    chains = numba.njit(pipeline_class=KernelCompiler, fastmath={"contract"}, error_model="numpy")(
        scope["chains"]
    )

    @numba.njit(parallel=True)
    def probe(values, rounds, a, b):
        for task in numba.prange(values.shape[0]):
            chains(values[task], rounds, a, b)

    probe(np.zeros((1, 8)), 1, 0.5, 0.25)
    found: Callable[..., None] = probe
    return found


def _seconds(work: Callable[[], object]) -> float:
    # One thread is timed in processor time, which other work hardly affects. Threads that wait for each other spend
    # processor time too, so several threads are timed by the wall clock.
    clock = time.process_time if numba.get_num_threads() == 1 else time.perf_counter
    began = clock()
    work()
    return clock() - began


def measure(quick: bool, repeats: int) -> list[dict[str, Any]]:
    """Return steps/s of the lane kernel and of the plain loop, multiply-adds/s, and their ratios.

    There is one row for each step, with one thread and with all.
    """
    most = most_threads()
    return [_measure(quick, repeats, threads, step) for threads in sorted({1, most}) for step in _STEPS]


def _measure(quick: bool, repeats: int, threads: int, step: float) -> dict[str, Any]:
    use_threads(threads)
    along, across = (120, 80) if quick else (300, 200)
    given = starts((f"roll_rate=2:4:{along}", f"tilt=0.001deg:5deg:{across}:log"))
    n = given.shape[1]
    settings = np.array([300.0, step, FALL_TILT, _LOOSE])
    (measures, counts), final = results(n), np.empty((len(STATE), n))
    values, rounds = np.zeros((threads, 128)), 2000 if quick else 10000

    def lanes() -> None:
        DISK.integrate.load()(given, settings, measures, counts)

    def plain() -> None:
        equal_steps(given, steps, step, final)

    lanes()
    steps = counts[STEPS].astype(np.int64)
    plain()
    probe = _probe()
    total, done = float(steps.sum()), float(values.size * rounds * _CHAINS * _LINKS)
    rates = [
        (
            total / _seconds(lanes),
            total / _seconds(plain),
            done / _seconds(lambda: probe(values, rounds, 0.5, 0.25)),
        )
        for _ in range(repeats)
    ]
    per_step = multiply_adds()
    ratios = sorted(ours / theirs for ours, theirs, _ in rates)
    return {
        "threads": threads,
        "steps_per_cell": total / n,
        "steps_per_s": statistics.median(ours for ours, _, _ in rates),
        "plain_steps_per_s": statistics.median(theirs for _, theirs, _ in rates),
        "ratio": {"median": statistics.median(ratios), "least": ratios[0], "greatest": ratios[-1]},
        "multiply_adds_per_step": per_step,
        "multiply_adds_per_s": statistics.median(most for _, _, most in rates),
        "share": statistics.median(ours * per_step / most for ours, _, most in rates),
    }
