"""How one motion of a body of revolution is integrated, and how its errors are found: once more, with half the step."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from kernels.bodies import motion_arrays as at
from kernels.bodies import shapes
from kernels.disk.arrays import PRECESSION_RATE, ROLL_RATE, STATE, TILT, TILT_RATE
from kernels.disk.endings import HORIZON, UNRESOLVED
from sweep.errors import NoMotionError
from sweep.model.bodies.shape import has_poles
from sweep.model.kernel import Kernel
from sweep.model.quantity import Array
from sweep.motion.request import MotionRequest
from sweep.motion.tables import LIFTS, ROLLS, SLIPS
from sweep.request.words import AUTOMATIC, MOST_STEPS

_FLAT = Kernel("kernels.bodies.trajectory", "trajectory", seconds=3.0)
_POLES = Kernel("kernels.bodies.poles.trajectory", "trajectory", seconds=3.0)

#: All that `follow` calls.
KERNELS = (_FLAT, _POLES)

#: Step of the first integration times the fastest frequency of the state. Each further one has half the step, until it
#: is as near to the one before as the error that is allowed, in rad, radii and units of sqrt(g/R), or no nearer.
_RELATIVE_STEP, _ALLOWED, _MOST_REFINEMENTS = 0.01, 4e-10, 6

#: Share of the error before at which half the step is still worth it: of fourth order it would be a sixteenth.
_BETTER = 0.5

#: A stated error is so many times the difference of two integrations: it is a fifteenth of it with a step that is short
#: enough, but with one that is far too long up to 2.2 of it was found. And rounding that both have in common.
_SAFETY, _ROUNDING = 4.0, 1e-12

#: Rounding of the start: beside a pole its spin is the small difference of two rates.
_OF_RATES = 2.0**-50

#: As in `sweep.motion.disk_path`: the angle [rad] between two samples, their largest number, how much later a motion
#: may be found to end.
_TURN, _MOST_SAMPLES, _LATER = 0.2, 200_000, 1.1


@dataclass(frozen=True)
class _Found:
    """One integration: times [s], shape (m,), samples, shape (len(SAMPLES), m), and the code of the ending."""

    times: Array
    samples: Array
    ending: int

    def at(self, times: Array) -> Array:
        """Return the samples at the times of another integration; only at its end they may be other ones."""
        found = self.samples[:, np.minimum(np.arange(times.size), self.times.size - 1)]
        place = min(times.size, self.times.size) - 1
        step = self.times[place] - self.times[place - 1]
        late = (times[place:] - self.times[place]) / step
        found[:, place:] += np.multiply.outer(self.samples[:, place] - self.samples[:, place - 1], late)
        return found


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
        If the motion has ended before it starts, or is too fast to be resolved.
    """
    if spec.body == "rim" and spec.tilt == 0.0:
        raise NoMotionError(
            "This motion has ended before it starts: upright, a disk with a rim stands on both of its edges; got "
            "tilt=0.",
            hint="Start with a tilt, as in tilt=5deg, or say body=rounded.",
        )
    times = spec.times
    found, errors = _integrated(spec, start, times)
    if spec.interval == AUTOMATIC and (closer := _closer(spec, times, found))[1] < times[1]:
        again, refined = _integrated(spec, start, closer)
        if again.ending == found.ending:
            found, errors = again, refined
    # the rates of the kernel have gone to scaled ones and back
    found.samples[: len(STATE), 0] = start[: len(STATE)]
    values = _variables(spec, found.samples) | _in_si(spec, errors)
    values["ending"] = np.array(found.ending, np.int8)
    values["end_time"] = np.array(np.nan if found.ending == HORIZON else found.times[-1])
    return found.times, values


def _closer(spec: MotionRequest, times: Array, found: _Found) -> Array:
    """Return evenly spaced times, close enough for the fastest turn that samples show, and as many until an end."""
    turns = float(_turning(spec, found.samples).max()) * times[1]
    end = found.times[-1]
    count = max(times.size - 1, end / times[1] * turns / _TURN)
    count = math.ceil(min(count, _MOST_SAMPLES))
    if found.ending == HORIZON:
        return np.linspace(0.0, times[-1], count + 1)
    # half an interval, so that no sample comes to lie at the end itself, which is one
    return np.asarray(end / (count - 0.5) * np.arange(math.ceil(_LATER * count) + 1))


def _turning(spec: MotionRequest, samples: Array) -> Array:
    """Return how fast the body turns, and the contact point goes round it [rad/s]."""
    tilting, turning, rolling = samples[[TILT_RATE, PRECESSION_RATE, ROLL_RATE]]
    about = np.abs(rolling + turning * np.sin(samples[TILT]))
    across = np.hypot(tilting, turning * np.cos(samples[TILT]))
    if has_poles(spec.body):
        return np.asarray(np.hypot(about, across))
    return np.asarray(np.maximum(np.maximum(about, across), np.maximum(np.abs(turning), np.abs(rolling))))


def _integrated(spec: MotionRequest, start: Array, times: Array) -> tuple[_Found, dict[str, Array]]:
    """Return one start with a step that half of it hardly changes, and its errors: scaled, shape (m,) each."""
    before, best = _once(spec, start, times, 0), None
    for refinement in range(1, _MOST_REFINEMENTS + 1):
        found = _once(spec, start, times, refinement)
        if found is None:
            break
        if before is not None:
            errors = _apart(spec, before, found)
            largest = max(float(each[-1]) for each in errors.values())
            if best is not None and not largest < _BETTER * best[2]:
                return best[:2]
            best = found, errors, largest
            if largest <= _ALLOWED:
                return best[:2]
        before = found
    if best is not None:
        return best[:2]
    raise NoMotionError(
        f"This motion could not be resolved: its state must stay finite, and it may take at most {MOST_STEPS} steps.",
        hint="Give a shorter step or duration, slower rates, or a smaller fall_tilt.",
    )


def _once(spec: MotionRequest, start: Array, times: Array, refinement: int) -> _Found | None:
    """Integrate one start with a step that is halved so many times; None if it was not resolved."""
    samples = np.empty((len(at.SAMPLES), times.size))
    step = 0.0 if isinstance(spec.step, str) else spec.step / 2**refinement
    kind = float(shapes.NAMES.index(spec.body))
    settings = np.array([step, _RELATIVE_STEP / 2**refinement, spec.fall_tilt, kind])
    kernel = _POLES if has_poles(spec.body) else _FLAT
    ending, filled, last, _ = kernel.load()(start[:, np.newaxis].copy(), settings, times, samples)
    if ending == UNRESOLVED:
        return None
    return _Found(np.append(times[: filled - 1], last), samples[:, :filled], int(ending))


def _apart(spec: MotionRequest, one: _Found, other: _Found) -> dict[str, Array]:
    """Return the largest differences of two integrations until each sample of the second one, scaled.

    Notes
    -----
    Of the orientation the difference is hypot(d tilt, cos(tilt) d heading, d roll_angle + sin(tilt) d heading), which
    is regular at a pole where heading and roll angle are not; likewise of the angular velocity.
    """
    first, second = one.at(other.times), other.samples
    unit, radius = math.sqrt(spec.radius / spec.gravity), spec.radius
    sin, cos = np.sin(second[TILT]), np.cos(second[TILT])

    def turned(tilting: int, turning: int, rolling: int) -> Array:
        tilt, heading, angle = (second[row] - first[row] for row in (tilting, turning, rolling))
        return np.asarray(np.sqrt(tilt**2 + (cos * heading) ** 2 + (angle + sin * heading) ** 2))

    def moved(*rows: int) -> Array:
        return np.asarray(np.sqrt(sum((second[row] - first[row]) ** 2 for row in rows)))

    contact, centre = moved(at.CONTACT_X, at.CONTACT_Y), moved(at.CENTRE_X, at.CENTRE_Y, at.CENTRE_Z)
    found = {
        "orientation_error": turned(TILT, at.HEADING, at.ROLL_ANGLE),
        "path_error": np.maximum(contact, centre) / radius,
        "rate_error": unit * turned(TILT_RATE, PRECESSION_RATE, ROLL_RATE),
        "force_error": moved(at.NORMAL, at.ACROSS, at.ALONG),
    }
    start = unit * max(abs(float(second[row, 0])) for row in (PRECESSION_RATE, ROLL_RATE))
    rounding = _ROUNDING + _OF_RATES * start * (1.0 + other.times / unit)
    # differences cross zero where the motions meet: what has been apart is not known better afterwards
    return {name: _SAFETY * np.maximum.accumulate(each) + rounding for name, each in found.items()}


def _in_si(spec: MotionRequest, errors: dict[str, Array]) -> dict[str, npt.NDArray[Any]]:
    scale = {
        "path_error": spec.radius,
        "rate_error": math.sqrt(spec.gravity / spec.radius),
        "force_error": spec.mass * spec.gravity,
    }
    return {name: (scale.get(name, 1.0) * each).astype(np.float32) for name, each in errors.items()}


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
