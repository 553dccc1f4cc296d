"""How one motion of the disk with losses is integrated, and when it is sampled: ever closer towards its end."""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from kernels.disk.arrays import STATE
from kernels.lossy_disk import arrays
from kernels.lossy_disk.endings import FLAT, HORIZON, REST, SLIP, UNRESOLVED
from sweep.errors import NoMotionError
from sweep.model.kernel import Kernel
from sweep.model.quantity import Array
from sweep.motion.request import MotionRequest
from sweep.motion.tables import HELD_ROLL, HELD_TILT, LOSSY_MOTION
from sweep.request.words import AUTOMATIC, MOST_STEPS

_TRAJECTORY = Kernel(LOSSY_MOTION.kernels, "trajectory", seconds=3.0)

#: All that `follow` calls.
KERNELS = (_TRAJECTORY,)

#: Largest imbalance of the energy over m g R with an automatic step; beyond it, the motion is integrated again with
#: half the step, which is a sixteenth of the imbalance.
_IMBALANCE = 1e-9
_RELATIVE_STEP, _MOST_REFINEMENTS = 0.1, 6

#: With interval=auto: the angle [rad] by which tilt, heading and roll angle should change between two samples, the
#: least and the largest number of samples. With what `_ENOUGH` allows no angle is over 0.2, and there are 1000 samples.
_TURN, _LEAST_SAMPLES, _MOST_SAMPLES = 0.18, 1150, 200_000

#: Samples for each factor e by which the time that is left of a motion shrinks, down to this share of its length.
_TOWARDS_END, _NEAREST = 60.0, 1e-5

#: Integrations of which each takes the turns between its samples from the one before, and how many samples too few it
#: may have in a gap to be the last.
_PASSES, _ENOUGH = 5, 1.1

#: Samples are laid out for an end this much later than it was found: a shorter step finds it at another moment.
_LATER = 1.001


def follow(spec: MotionRequest, start: Array) -> tuple[Array, dict[str, npt.NDArray[Any]]]:
    """Return the times of the samples [s], shape (n,), and the variables of the file.

    Parameters
    ----------
    spec : MotionRequest
    start : array
        That of `start_of`.

    Raises
    ------
    RequestError
        If the motion is too fast to be resolved, or ends where it begins.
    """
    times, samples, ending = _integrated(spec, start, spec.times)
    if times[-1] == 0.0:
        _check_goes_on(ending)
        # a disk that friction holds from its start is seen to stand
        return _held(spec.times, start, samples)
    for _ in range(_PASSES if spec.interval == AUTOMATIC else 0):
        wanted = _wanted(times, samples, ending)
        if wanted.max(initial=0.0) <= _ENOUGH:
            break
        times, samples, ending = _integrated(spec, start, _closer(times, wanted, ending))
    # where dry friction lets go the kernels start the motion a little beyond its start
    samples[: len(STATE), 0] = start[: len(STATE)]
    return times, _variables(start, samples) | _ended(ending, np.nan if ending == HORIZON else times[-1])


def _check_goes_on(ending: int) -> None:
    """Refuse a motion that ends where it begins, unless it is at rest."""
    if ending != REST:
        what = "slips" if ending == SLIP else "lifts off"
        raise NoMotionError(
            f"This motion ends where it begins: the disk {what}, and the model with losses ends there.",
            hint="Give a larger friction coefficient, or leave it out."
            if ending == SLIP
            else "Give slower rates.",
        )


def _held(times: Array, start: Array, samples: Array) -> tuple[Array, dict[str, npt.NDArray[Any]]]:
    """Return the samples of a disk that is at rest at its start, and so for all time."""
    return times, _variables(start, np.repeat(samples[:, :1], times.size, axis=1)) | _ended(REST, 0.0)


def _ended(ending: int, time: float) -> dict[str, npt.NDArray[Any]]:
    return {"ending": np.array(ending, np.int8), "end_time": np.array(time)}


def _integrated(spec: MotionRequest, start: Array, times: Array) -> tuple[Array, Array, int]:
    """Return times, samples and ending of one start, with a step that keeps the balance of the energy."""
    samples = np.empty((len(arrays.SAMPLES), times.size))
    step = 0.0 if isinstance(spec.step, str) else spec.step
    law: int = spec.kind.words["air_law"].choices.index(spec.air_law)
    for refinement in range(_MOST_REFINEMENTS + 1):
        settings = np.array([step, _RELATIVE_STEP / 2**refinement, spec.flat_tilt, law])
        ending, filled, last, _ = _TRAJECTORY.load()(start, settings, times, samples)
        if ending == UNRESOLVED:
            continue
        found = samples[:, :filled]
        imbalance = np.abs(_imbalance(start, found)).max()
        if imbalance <= _IMBALANCE or step > 0.0 or refinement == _MOST_REFINEMENTS:
            moments = times[:filled].copy()
            moments[-1] = last
            return moments, found, int(ending)
    raise NoMotionError(
        "This motion could not be resolved: its state must stay finite, and it may take at most "
        f"{MOST_STEPS} steps; gave up at {last:.6g} s.",
        hint="Give a shorter step or duration, slower rates, or a smaller flat_tilt.",
    )


def _wanted(times: Array, samples: Array, ending: int) -> Array:
    """Return how many samples there should be in the place of each gap between two, by what turns in it."""
    length, gaps = times[-1], np.diff(times)
    turning = samples[[arrays.TILT, arrays.SAMPLE_HEADING, arrays.SAMPLE_ROLL_ANGLE]]
    turns = np.abs(np.diff(turning)).max(axis=0)
    # a swing of the tilt between two samples is not seen in their difference
    rates = np.abs(samples[arrays.TILT_RATE])
    turns = np.maximum(turns, np.maximum(rates[1:], rates[:-1]) * gaps)
    wanted = np.maximum(turns / _TURN, gaps / length * _LEAST_SAMPLES)
    if ending in (FLAT, REST):
        left = length - times + _NEAREST * length
        wanted = np.maximum(wanted, _TOWARDS_END * np.log(left[:-1] / left[1:]))
    return np.asarray(wanted)


def _closer(times: Array, wanted: Array, ending: int) -> Array:
    """Return times with so many samples in each gap between those of the same motion, spread evenly over it."""
    counted = np.concatenate([[0.0], np.cumsum(wanted)])
    count = math.ceil(min(counted[-1], _MOST_SAMPLES))
    found = np.interp(np.linspace(0.0, counted[-1], count + 1), counted, times)
    if ending != HORIZON:
        found[-1] *= _LATER
    return found


def _energy(start: Array, samples: Array) -> Array:
    """Return the energy over m g R of samples."""
    alpha, unit = start[arrays.ALPHA], math.sqrt(start[arrays.RADIUS] / start[arrays.GRAVITY])
    tilt, tilting, turning, rolling = samples[: len(STATE)]
    w, o = unit * tilting, unit * turning * np.cos(tilt)
    s = unit * (rolling + turning * np.sin(tilt))
    motion = (1.0 + 0.5 * alpha) * w**2 + 0.5 * alpha * o**2 + (1.0 + alpha) * s**2
    return np.asarray(np.cos(tilt) + 0.5 * motion)


def _losses(samples: Array) -> dict[str, Array]:
    return {name: samples[arrays.SAMPLES.index(name)] for name in arrays.LOSSES}


def _imbalance(start: Array, samples: Array) -> Array:
    kept = _energy(start, samples) + sum(_losses(samples).values())
    return np.asarray(kept - kept[0])


def _variables(start: Array, samples: Array) -> dict[str, npt.NDArray[Any]]:
    values = dict(zip(arrays.SAMPLES, samples, strict=True))
    radius, weight = start[arrays.RADIUS], start[arrays.MASS] * start[arrays.GRAVITY]
    lean = radius * np.sin(values["tilt"])
    normal, across, along = (values[name] for name in ("normal_force", "friction_across", "friction_along"))
    with np.errstate(divide="ignore", invalid="ignore"):
        needed = np.where(normal > 0.0, np.hypot(across, along) / normal, np.nan)
    held = values["held"].astype(np.int8)
    # what holds tilt and roll holds the roll rate at the rim
    held = np.where(held & HELD_TILT, held & ~HELD_ROLL, held).astype(np.int8)
    return (
        values
        | {name: weight * radius * loss for name, loss in _losses(samples).items()}
        | {
            "centre_x": values["contact_x"] + lean * np.cos(values["heading"]),
            "centre_y": values["contact_y"] + lean * np.sin(values["heading"]),
            "centre_z": radius * np.cos(values["tilt"]),
            "energy": weight * radius * _energy(start, samples),
            "inclination": 0.5 * math.pi - np.abs(values["tilt"]),
            "energy_imbalance": _imbalance(start, samples),
            "normal_force": weight * normal,
            "friction_across": weight * across,
            "friction_along": weight * along,
            "friction_needed": needed,
            "held": held,
        }
    )
