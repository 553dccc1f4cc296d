"""Integration of one motion without losses, twice: a second time with half the step, for the stated errors."""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from kernels.bodies import motion_arrays as at
from kernels.bodies import shapes
from kernels.disk.arrays import PRECESSION_RATE, ROLL_RATE, STATE, TILT, TILT_RATE
from kernels.disk.endings import HORIZON, UNRESOLVED
from sweep.errors import NoMotionError
from sweep.model.bodies.shape import has_poles
from sweep.model.disk.path import rows_of_disk
from sweep.model.kernel import Kernel
from sweep.model.quantity import Array
from sweep.motion.request import MotionRequest
from sweep.motion.stated_errors import Found, in_si, settled
from sweep.motion.tables import LIFTS, ROLLS, SLIPS
from sweep.request.words import AUTOMATIC

_FLAT = Kernel("kernels.bodies.trajectory", "trajectory", seconds=3.0)
_POLES = Kernel("kernels.bodies.poles.trajectory", "trajectory", seconds=3.0)

#: Step of the first integration times the fastest frequency of the state; each later one has half the step.
_RELATIVE_STEP = 0.01

#: With interval=auto: the largest angle [rad] between two samples, so that a path drawn through the samples is right to
#: half a per cent of its radius; the largest number of samples; and the factor by which another integration may end
#: later.
_TURN, _MOST_SAMPLES, _LATER = 0.2, 200_000, 1.1


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
        If the motion has ended before it starts, or is too fast to be resolved.
    """
    check_edge(spec)
    times = spec.times
    found, errors = _integrate(spec, start, times)
    if spec.interval == AUTOMATIC and (closer := _closer_times(spec, times, found))[1] < times[1]:
        again, refined = _integrate(spec, start, closer)
        if again.ending == found.ending:
            found, errors = again, refined
    # the kernel converts rates to scaled ones and back: the start is stored exactly as it was given
    found.samples[: len(STATE), 0] = start[: len(STATE)]
    values = _variables(spec, found.samples) | in_si(spec, errors, spec.mass)
    values["ending"] = np.array(found.ending, np.int8)
    values["end_time"] = np.array(np.nan if found.ending == HORIZON else found.times[-1])
    return found.times, values


def check_edge(spec: MotionRequest) -> None:
    """Refuse a disk with a rim that starts on both of its edges.

    Raises
    ------
    NoMotionError
    """
    if body_of_request(spec) == "rim" and spec.tilt == 0.0:
        raise NoMotionError(
            "This motion has ended before it starts: upright, a disk with a rim stands on both of its edges; got "
            "tilt=0.",
            hint="Start with a tilt, such as tilt=5deg, or write body=rounded.",
        )


def _closer_times(spec: MotionRequest, times: Array, found: Found) -> Array:
    """Return evenly spaced times, close enough for the fastest rotation in the samples, and up to past an end."""
    turns = float(_turning(spec, found.samples).max()) * times[1]
    end = found.times[-1]
    count = max(times.size - 1, end / times[1] * turns / _TURN)
    count = math.ceil(min(count, _MOST_SAMPLES))
    if found.ending == HORIZON:
        return np.linspace(0.0, times[-1], count + 1)
    # half an interval off, so that no sample coincides with the end, which is a sample of its own
    return np.asarray(end / (count - 0.5) * np.arange(math.ceil(_LATER * count) + 1))


def _turning(spec: MotionRequest, samples: Array) -> Array:
    """Return the largest rate of the body's rotation and of the contact point's motion around it [rad/s]."""
    tilting, turning, rolling = samples[[TILT_RATE, PRECESSION_RATE, ROLL_RATE]]
    about = np.abs(rolling + turning * np.sin(samples[TILT]))
    across = np.hypot(tilting, turning * np.cos(samples[TILT]))
    if has_poles(body_of_request(spec)):
        return np.asarray(np.hypot(about, across))
    return np.asarray(np.maximum(np.maximum(about, across), np.maximum(np.abs(turning), np.abs(rolling))))


def body_of_request(spec: MotionRequest) -> str:
    """Return the body of a request; the thin disk is a torus without a tube."""
    return str(getattr(spec, "body", "torus"))


def _integrate(spec: MotionRequest, start: Array, times: Array) -> tuple[Found, dict[str, Array]]:
    """Integrate one start with a converged step; return it with its errors, scaled, shape (m,) each."""
    return settled(spec, lambda refinement: _once(spec, start, times, refinement))


def _once(spec: MotionRequest, start: Array, times: Array, refinement: int) -> Found | None:
    """Integrate one start with a step halved `refinement` times; None if it was not resolved."""
    samples = np.empty((len(at.SAMPLES), times.size))
    step = 0.0 if isinstance(spec.step, str) else spec.step / 2**refinement
    values = dict(zip(spec.kind.model.parameters, start[:, np.newaxis], strict=True))
    rows = rows_of_disk(values) if "alpha" in values else start[:, np.newaxis].copy()
    body = body_of_request(spec)
    settings = np.array(
        [step, _RELATIVE_STEP / 2**refinement, spec.fall_tilt, float(shapes.NAMES.index(body))]
    )
    kernel = _POLES if has_poles(body) else _FLAT
    ending, filled, last, _ = kernel.load()(rows, settings, times, samples)
    if ending == UNRESOLVED:
        return None
    return Found(at.SAMPLES, np.append(times[: filled - 1], last), samples[:, :filled], int(ending))


def _variables(spec: MotionRequest, samples: Array) -> dict[str, npt.NDArray[Any]]:
    values = dict(zip(at.SAMPLES, samples, strict=True))
    gained = values.pop("momentum_gained")
    momentum, weight = values["vertical_momentum"], spec.mass * spec.gravity
    normal, across, along = (values[name] for name in ("normal_force", "friction_across", "friction_along"))
    with np.errstate(divide="ignore", invalid="ignore"):
        needed = np.where(normal > 0.0, np.hypot(across, along) / normal, np.nan)
    slips = np.where(needed > spec.friction, SLIPS, ROLLS)
    return values | {
        "energy": weight * spec.radius * values["energy"],
        "vertical_momentum": spec.mass * momentum,
        "vertical_momentum_rate": spec.mass * values["vertical_momentum_rate"],
        "vertical_momentum_residual": spec.mass * (momentum - momentum[0] - gained),
        "normal_force": weight * normal,
        "friction_across": weight * across,
        "friction_along": weight * along,
        "friction_needed": needed,
        "contact": np.where(normal > 0.0, slips, LIFTS).astype(np.int8),
    }
