"""Integration of one motion of the disk without losses, by the kernels, or by SciPy for comparison."""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from kernels.disk import arrays, motion_arrays
from kernels.disk.endings import FELL, HORIZON, UNRESOLVED
from sweep.errors import RequestError
from sweep.model.kernel import Kernel
from sweep.model.quantity import Array
from sweep.motion.request import MotionRequest
from sweep.motion.stated_errors import unresolved
from sweep.motion.tables import DISK_MOTION, LIFTS, ROLLS, SLIPS
from sweep.request.words import AUTOMATIC

_TRAJECTORY = Kernel(DISK_MOTION.kernels, "trajectory", seconds=2.0)
_DERIVED = Kernel(DISK_MOTION.kernels, "derived", seconds=1.0)

#: The kernels that `follow` calls.
KERNELS = (_TRAJECTORY, _DERIVED)

#: Step times the fastest frequency of the state: the errors of the motions in docs/checked.md are then below 1e-9.
_RELATIVE_STEP = 0.005

#: Largest relative energy drift with an automatic step; above it, the motion is integrated again with half the step.
_DRIFT = 1e-11
_MOST_REFINEMENTS = 6

#: Below this drift, if half the step does not reduce it, it consists of rounding errors, which grow with more steps.
_ROUNDING = 1e-9

#: With interval=auto: the largest change [rad] of tilt, heading and roll angle between two samples, so that a path
#: drawn through the samples is right to half a per cent of its radius; and the largest number of samples.
_TURN, _MOST_SAMPLES = 0.2, 200_000

#: Samples cover this multiple of the fall time: closer samples mean shorter steps, which find another fall time if the
#: requested step is too long.
_LATER = 1.1

#: Relative and absolute tolerance per step of DOP853.
_RELATIVE, _ABSOLUTE = 1e-12, 1e-15


def follow(spec: MotionRequest, start: Array) -> tuple[Array, dict[str, npt.NDArray[Any]]]:
    """Return the times of the samples [s], shape (n,), and the variables of the file.

    Parameters
    ----------
    spec : MotionRequest
    start : array
        As from `start_of`.

    Raises
    ------
    RequestError
        If the motion is too fast to be resolved.
    """
    times = spec.times
    integrate = _by_rk4 if spec.method == "rk4" else _by_dop853
    samples, fall_time = integrate(spec, start, times)
    if spec.interval == AUTOMATIC and (closer := _closer_times(times, samples, fall_time))[1] < times[1]:
        again, fell_at = integrate(spec, start, closer)
        if fall_time is None or fell_at is not None:
            times, samples, fall_time = closer, again, fell_at
    times = times[: samples.shape[1]].copy()
    if fall_time is not None:
        times[-1] = fall_time
    values = _variables(spec, start, samples, _derived(start, samples))
    values["ending"] = np.array(HORIZON if fall_time is None else FELL, np.int8)
    values["fall_time"] = np.array(np.nan if fall_time is None else fall_time)
    return times, values


def _closer_times(times: Array, samples: Array, fall_time: float | None) -> Array:
    """Return evenly spaced times, close enough for the fastest rotation in the samples, and up to past a fall."""
    turning = samples[[arrays.TILT, motion_arrays.HEADING, motion_arrays.ROLL_ANGLE]]
    turns = np.abs(np.diff(turning)).max(initial=0.0)
    last = times[-1] if fall_time is None else fall_time
    count = max(times.size - 1, last / times[1] * turns / _TURN)
    count = math.ceil(min(count, _MOST_SAMPLES))
    if fall_time is None:
        return np.linspace(0.0, times[-1], count + 1)
    # half an interval off, so that no sample coincides with the fall, which is a sample of its own
    return np.asarray(last / (count - 0.5) * np.arange(math.ceil(_LATER * count) + 1))


def _by_rk4(spec: MotionRequest, start: Array, times: Array) -> tuple[Array, float | None]:
    """Integrate one start with the kernels, with a step that conserves the energy.

    Returns the samples, shape (9, m), rows as in `motion_arrays.SAMPLES`, and the fall time [s] of the last sample, or
    None if the disk did not fall.
    """
    samples = np.empty((len(motion_arrays.SAMPLES), times.size))
    step = 0.0 if isinstance(spec.step, str) else spec.step
    before = 0.0
    for refinement in range(_MOST_REFINEMENTS + 1):
        settings = np.array([step, _RELATIVE_STEP / 2**refinement, spec.fall_tilt])
        ending, filled, last, _ = _TRAJECTORY.load()(start, settings, times, samples)
        if ending == UNRESOLVED and last == times[filled - 1]:
            # it took too many steps; shorter steps would be even more
            break
        if ending == UNRESOLVED:
            continue
        drift = np.abs(_derived(start, samples[:, :filled])[motion_arrays.DERIVED_ENERGY_DRIFT]).max()
        rounding = 0.0 < before <= drift < _ROUNDING
        if drift <= _DRIFT or rounding or step > 0.0 or refinement == _MOST_REFINEMENTS:
            return samples[:, :filled], (last if ending == FELL else None)
        before = drift
    raise unresolved(spec, last)


def _by_dop853(spec: MotionRequest, start: Array, times: Array) -> tuple[Array, float | None]:
    """Integrate one start with SciPy, as an independent check of `_by_rk4`.

    It shares no code with the kernels: tilt, rates, heading, roll angle, contact point and gain of vertical momentum
    are integrated together from the textbook equations, with sines and cosines of the tilt.
    """
    from scipy.integrate import solve_ivp

    def fall(_: float, y: Array, *system: float) -> float:
        return abs(float(y[0])) - float(spec.fall_tilt)

    fall.terminal = True  # type: ignore[attr-defined]  # read by solve_ivp
    system = tuple(start[[arrays.ALPHA, arrays.RADIUS, arrays.GRAVITY]])
    first = np.concatenate([start[: len(arrays.STATE)], np.zeros(5)])
    problem = None
    try:
        with np.errstate(over="raise", invalid="raise"):
            run = solve_ivp(
                _slope, (0.0, times[-1]), first, "DOP853", times,
                events=fall, args=system, rtol=_RELATIVE, atol=_ABSOLUTE,
            )  # fmt: skip
        problem = run.message if run.status < 0 else None
    except ArithmeticError as error:
        problem = error
    if problem is not None:
        raise RequestError(
            f"DOP853 could not resolve this motion: {problem}.",
            hint="Give a shorter duration, slower rates, a smaller fall_tilt, or method=rk4.",
        )
    if not run.t_events[0].size:
        return run.y, None
    time = float(run.t_events[0][0])
    return np.column_stack([run.y[:, run.t < time], run.y_events[0][0]]), time


def _slope(_: float, y: Array, alpha: float, radius: float, gravity: float) -> list[float]:
    tilt, tilting, turning, rolling, heading = (float(value) for value in y[:5])
    sin, cos = math.sin(tilt), math.cos(tilt)
    push = 2.0 * gravity * sin + 2.0 * (1.0 + alpha) * radius * rolling * turning * cos
    push += (2.0 + alpha) * radius * turning**2 * sin * cos
    spin_up = tilting * (2.0 * (1.0 + alpha) * rolling * sin - (2.0 + alpha) * turning * cos**2)
    return [
        tilting,
        push / ((2.0 + alpha) * radius),
        -2.0 * rolling * tilting / cos,
        spin_up / ((1.0 + alpha) * cos),
        turning,
        rolling,
        -radius * rolling * math.sin(heading),
        radius * rolling * math.cos(heading),
        radius**2 * rolling * tilting * cos,
    ]


def _derived(start: Array, samples: Array) -> Array:
    results = np.empty((len(motion_arrays.DERIVED), samples.shape[1]))
    _DERIVED.load()(start, np.ascontiguousarray(samples[: len(arrays.STATE)]), results)
    return results


def _variables(
    spec: MotionRequest, start: Array, samples: Array, derived: Array
) -> dict[str, npt.NDArray[Any]]:
    values = dict(zip(motion_arrays.SAMPLES, samples, strict=True))
    gained = values.pop("momentum_gained")
    energy, drift, momentum, momentum_rate, normal, across, along, needed = derived
    radius, weight = spec.radius, spec.mass * spec.gravity
    lean = radius * np.sin(values["tilt"])
    slips = np.where(needed > spec.friction, SLIPS, ROLLS)
    return values | {
        "centre_x": values["contact_x"] + lean * np.cos(values["heading"]),
        "centre_y": values["contact_y"] + lean * np.sin(values["heading"]),
        "centre_z": radius * np.cos(values["tilt"]),
        "energy": weight * radius * energy,
        "energy_drift": drift,
        "vertical_momentum": spec.mass * momentum,
        "vertical_momentum_rate": spec.mass * momentum_rate,
        "vertical_momentum_residual": spec.mass * (momentum - momentum[0] - gained),
        "normal_force": weight * normal,
        "friction_across": weight * across,
        "friction_along": weight * along,
        "friction_needed": needed,
        "contact": np.where(normal > 0.0, slips, LIFTS).astype(np.int8),
    }
