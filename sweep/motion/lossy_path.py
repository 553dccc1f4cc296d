"""Integration of one motion with losses, with samples that get closer towards its end, and its stated errors."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from kernels.bodies import shapes
from kernels.disk.arrays import STATE
from kernels.lossy_disk import arrays
from kernels.lossy_disk.endings import FLAT, HORIZON, REST, SLIP, UNRESOLVED
from sweep.errors import NoMotionError
from sweep.model.kernel import Kernel
from sweep.model.quantity import Array
from sweep.motion.free_path import check_edge
from sweep.motion.lossy_tables import HELD_ROLL, HELD_TILT, LOSSY_ERRORS
from sweep.motion.request import MotionRequest
from sweep.motion.stated_errors import Found, in_si, settled, unresolved
from sweep.request.words import AUTOMATIC

_DISK = Kernel("kernels.lossy_disk.trajectory", "trajectory", seconds=3.0)
_BODY = Kernel("kernels.lossy_bodies.trajectory", "trajectory", seconds=12.0)

#: Largest imbalance of the energy over m g R with an automatic step; above it, the motion is integrated again with half
#: the step, which divides the imbalance by sixteen.
_IMBALANCE = 1e-9
_RELATIVE_STEP, _MOST_REFINEMENTS = 0.1, 6

#: With interval=auto: the wanted change [rad] of tilt, heading and roll angle between two samples, and the least and
#: the largest number of samples. Within the excess that `_ENOUGH` allows, no change is over 0.2, and there are 1000.
_TURN, _LEAST_SAMPLES, _MOST_SAMPLES = 0.18, 1150, 200_000

#: Number of samples while the remaining time shrinks by a factor e, and the smallest remaining time, over the length of
#: the motion, for which this holds.
_TOWARDS_END, _NEAREST = 60.0, 1e-5

#: Most integrations with closer samples, each laid out from the turns in the one before; they stop when the wanted
#: number of samples in each gap is at most this.
_PASSES, _ENOUGH = 5, 1.1

#: Samples cover this multiple of the end time: a shorter step finds another end time.
_LATER = 1.001


@dataclass(frozen=True)
class Sampled:
    """One motion.

    Attributes
    ----------
    times : array, shape (n,)
        In seconds.
    samples : array, shape (len(kernels.lossy_disk.arrays.SAMPLES), n)
    ending : int
        A code of `kernels.lossy_disk.endings`.
    end : float
        Time of the ending [s]; NaN if it is the duration.
    refinement : int
        Number of times that the step was halved.
    """

    times: Array
    samples: Array
    ending: int
    end: float
    refinement: int


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
        If the motion is too fast to be resolved, or ends where it begins.
    """
    check_edge(spec)
    motion = _sample(spec, start)
    if motion.end == 0.0:
        # a body at rest needs no further integration
        zeros = dict.fromkeys(LOSSY_ERRORS, np.zeros(motion.times.size, np.float32))
        return motion.times, _variables(spec, start, motion) | zeros
    motion, errors = _with_errors(spec, start, motion)
    return motion.times, _variables(spec, start, motion) | errors


def _with_errors(
    spec: MotionRequest, start: Array, rough: Sampled
) -> tuple[Sampled, dict[str, npt.NDArray[Any]]]:
    """Return a motion at the same times with shorter steps, and its errors, estimated from two lengths of the step."""
    times = _later(rough.times, rough.ending)

    def again(refinement: int) -> Found | None:
        ending, moments, samples = _once(spec, start, times, rough.refinement + refinement)
        return None if ending == UNRESOLVED else Found(arrays.SAMPLES, moments, samples, ending)

    settled_motion, errors = settled(spec, again, (*arrays.LOSSES, "energy"))
    settled_motion.samples[: len(STATE), 0] = start[: len(STATE)]
    ending, times = settled_motion.ending, settled_motion.times
    end = math.nan if ending == HORIZON else float(times[-1])
    mass = float(start[list(spec.kind.model.parameters).index("mass")])
    motion = Sampled(times, settled_motion.samples, ending, end, rough.refinement)
    return motion, in_si(spec, errors, mass)


def _sample(spec: MotionRequest, start: Array) -> Sampled:
    """Integrate one start, with samples close enough to draw a curve through; raises as `follow`."""
    found = _integrate(spec, start, spec.times)
    if found.times[-1] == 0.0:
        _check_at_rest(spec, found.ending)
        # a disk that friction holds from its start is shown at rest for the duration
        still = np.repeat(found.samples[:, :1], spec.times.size, axis=1)
        return Sampled(spec.times, still, REST, 0.0, found.refinement)
    for _ in range(_PASSES if spec.interval == AUTOMATIC else 0):
        wanted = _wanted_samples(found)
        if wanted.max(initial=0.0) <= _ENOUGH:
            break
        found = _integrate(spec, start, _closer_times(found, wanted))
    # if dry friction lets go at the start, the kernels begin slightly past it
    found.samples[: len(STATE), 0] = start[: len(STATE)]
    return found


def _check_at_rest(spec: MotionRequest, ending: int) -> None:
    """Refuse a motion that ends where it begins, unless it is at rest."""
    if ending != REST:
        event = "slips" if ending == SLIP else "lifts off"
        raise NoMotionError(
            f"This motion ends where it begins: the {spec.kind.called} {event}, and the model with losses ends there.",
            hint="Give a larger friction coefficient, or leave it out."
            if ending == SLIP
            else "Give slower rates.",
        )


def _once(spec: MotionRequest, start: Array, times: Array, refinement: int) -> tuple[int, Array, Array]:
    """Integrate one start with a step halved `refinement` times; return ending, times and samples."""
    samples = np.empty((len(arrays.SAMPLES), times.size))
    step = 0.0 if isinstance(spec.step, str) else spec.step / 2**refinement
    law: int = spec.kind.words["air_law"].choices.index(spec.air_law)
    settings, kernel = [step, _RELATIVE_STEP / 2**refinement, spec.flat_tilt, law], _DISK
    if "body" in spec.kind.words:
        settings, kernel = [*settings, shapes.NAMES.index(spec.body)], _BODY
    ending, filled, last, _ = kernel.load()(start[:, np.newaxis].copy(), np.array(settings), times, samples)
    return int(ending), np.append(times[: filled - 1], last), samples[:, :filled]


def _integrate(spec: MotionRequest, start: Array, times: Array) -> Sampled:
    """Integrate one start with a step that balances the energy."""
    for refinement in range(_MOST_REFINEMENTS + 1):
        ending, moments, samples = _once(spec, start, times, refinement)
        if ending == UNRESOLVED:
            continue
        imbalance = np.abs(_imbalance(samples)).max()
        if imbalance <= _IMBALANCE or not isinstance(spec.step, str) or refinement == _MOST_REFINEMENTS:
            end = math.nan if ending == HORIZON else float(moments[-1])
            return Sampled(moments, samples, ending, end, refinement)
    raise unresolved(spec, float(moments[-1]))


def _wanted_samples(found: Sampled) -> Array:
    """Return the wanted number of samples in each gap between two samples, from the changes of angles in it."""
    times, samples = found.times, found.samples
    length, gaps = times[-1], np.diff(times)
    angles = samples[[arrays.TILT, arrays.SAMPLE_HEADING, arrays.SAMPLE_ROLL_ANGLE]]
    turns, rates = np.abs(np.diff(angles)).max(axis=0), np.abs(samples[arrays.TILT_RATE])
    # a swing of the tilt between two samples does not show in their difference
    turns = np.maximum(turns, np.maximum(rates[1:], rates[:-1]) * gaps)
    wanted = np.maximum(turns / _TURN, gaps / length * _LEAST_SAMPLES)
    if found.ending in (FLAT, REST):
        left = length - times + _NEAREST * length
        wanted = np.maximum(wanted, _TOWARDS_END * np.log(left[:-1] / left[1:]))
    return np.asarray(wanted)


def _closer_times(found: Sampled, wanted: Array) -> Array:
    """Return times with the wanted number of samples in each gap of a motion, evenly spaced within the gap."""
    total = np.concatenate([[0.0], np.cumsum(wanted)])
    count = math.ceil(min(total[-1], _MOST_SAMPLES))
    times = np.interp(np.linspace(0.0, total[-1], count + 1), total, found.times)
    return _later(times, found.ending)


def _later(times: Array, ending: int) -> Array:
    """Return times of samples with the last one moved past the end, because another step finds another end time."""
    moved = times.copy()
    if ending != HORIZON:
        moved[-1] *= _LATER
    return moved


def _losses(samples: Array) -> dict[str, Array]:
    return {name: samples[arrays.SAMPLES.index(name)] for name in arrays.LOSSES}


def _imbalance(samples: Array) -> Array:
    kept = samples[arrays.SAMPLE_ENERGY] + sum(_losses(samples).values())
    return np.asarray(kept - kept[0])


def _variables(spec: MotionRequest, start: Array, found: Sampled) -> dict[str, npt.NDArray[Any]]:
    """Return the variables of the file without the stated errors."""
    samples, parameters = found.samples, dict(zip(spec.kind.model.parameters, start.tolist(), strict=True))
    values = dict(zip(arrays.SAMPLES, samples, strict=True))
    weight = parameters["mass"] * parameters["gravity"]
    normal, across, along = (values[name] for name in ("normal_force", "friction_across", "friction_along"))
    with np.errstate(divide="ignore", invalid="ignore"):
        needed = np.where(normal > 0.0, np.hypot(across, along) / normal, np.nan)
    held = values["held"].astype(np.int8)
    # friction that holds tilt and roll also holds the roll rate at the rim
    held = np.where(held & HELD_TILT, held & ~HELD_ROLL, held).astype(np.int8)
    energies = {**_losses(samples), "energy": values["energy"]}
    return (
        values
        | {name: weight * parameters["radius"] * energy for name, energy in energies.items()}
        | {
            "inclination": 0.5 * math.pi - np.abs(values["tilt"]),
            "energy_imbalance": _imbalance(samples),
            "normal_force": weight * normal,
            "friction_across": weight * across,
            "friction_along": weight * along,
            "friction_needed": needed,
            "held": held,
            "ending": np.array(found.ending, np.int8),
            "end_time": np.array(found.end),
        }
    )
