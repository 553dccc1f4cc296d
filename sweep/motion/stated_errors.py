"""Stated errors of a motion of a body, from the differences of two integrations with different steps."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.errors import NoMotionError
from sweep.model.quantity import Array
from sweep.motion.request import MotionRequest
from sweep.request.words import MOST_STEPS

#: Most repetitions of the integration, each with half the step, and the error at which they stop, in rad, radii, m g,
#: m g R and units of sqrt(g/R). They also stop when the error no longer decreases.
_MOST_REFINEMENTS, _ALLOWED = 6, 4e-10

#: Largest ratio of successive errors at which halving the step is worth it: with fourth order it is a sixteenth.
_BETTER = 0.5

#: Stated error over the difference of two integrations, and the rounding error that both share. With a short enough
#: step the true error is a fifteenth of the difference; with far too long a step it was up to 2.2 times the difference.
_SAFETY, _ROUNDING = 4.0, 1e-12

#: Rounding of the start: next to a pole its spin is the small difference of two rates.
_OF_RATES = 2.0**-50


@dataclass(frozen=True)
class Found:
    """One integration.

    Attributes
    ----------
    names : sequence of str
        The names of the rows of the samples.
    times : array, shape (m,)
        In seconds.
    samples : array, shape (len(names), m)
    ending : int
        The code of the ending.
    """

    names: Sequence[str]
    times: Array
    samples: Array
    ending: int

    def at(self, times: Array) -> dict[str, Array]:
        """Return the samples at the times of another integration, extrapolated at the end, where the times differ."""
        samples = self.samples[:, np.minimum(np.arange(times.size), self.times.size - 1)]
        place = min(times.size, self.times.size) - 1
        step = self.times[place] - self.times[place - 1]
        late = (times[place:] - self.times[place]) / step
        samples[:, place:] += np.multiply.outer(self.samples[:, place] - self.samples[:, place - 1], late)
        return dict(zip(self.names, samples, strict=True))


def settled(
    spec: MotionRequest, once: Callable[[int], Found | None], energies: Sequence[str] = ()
) -> tuple[Found, dict[str, Array]]:
    """Halve the step until a motion converges; return the motion and its errors, scaled, shape (m,) each.

    Parameters
    ----------
    spec : MotionRequest
    once : callable
        (number of halvings of the step) -> one integration, or None if it was not resolved.
    energies : sequence of str
        Energies over m g R among the samples, for `energy_error`.

    Raises
    ------
    NoMotionError
        If no two successive integrations were resolved and ended in the same way.
    """
    before, best = once(0), None
    for refinement in range(1, _MOST_REFINEMENTS + 1):
        found = once(refinement)
        if found is None:
            break
        if before is not None and before.ending == found.ending:
            errors = _differences(spec, before, found, energies)
            largest = max(float(error[-1]) for error in errors.values())
            if best is not None and not largest < _BETTER * best[2]:
                return best[:2]
            best = found, errors, largest
            if largest <= _ALLOWED:
                return best[:2]
        before = found
    if best is not None:
        return best[:2]
    raise unresolved(spec)


def unresolved(spec: MotionRequest, until: float = math.nan) -> NoMotionError:
    """Return the error of a motion that could not be resolved; `until` is the time [s] that it reached, if any."""
    reached = f"it was followed until {spec.kind.time.spell(until, 6)}"
    where = reached if until > 0.0 else "it fails from its start on"
    rolling = getattr(spec, "rolling_friction", 0.0) > 0.0
    brink = "rolling friction must clearly hold it or let it go, " if rolling else ""
    other = "another rolling_friction, " if rolling else ""
    return NoMotionError(
        f"This motion could not be resolved: its state must stay finite, {brink}and it may take at most "
        f"{MOST_STEPS} steps; {where}.",
        hint=f"Give {other}a shorter step or duration, slower rates, or a smaller {spec.kind.largest_tilt}.",
    )


def _differences(spec: MotionRequest, one: Found, other: Found, energies: Sequence[str]) -> dict[str, Array]:
    """Return the largest differences of two integrations up to each sample of the second one, scaled.

    Notes
    -----
    The difference of the orientations is the angle between them, independent of the split into heading and roll angle
    next to a pole. The difference of the angular velocities, hypot(d tilt_rate, cos(tilt) d precession_rate,
    d roll_rate + sin(tilt) d precession_rate), is regular there too.
    """
    first, second = one.at(other.times), other.at(other.times)
    unit, radius = math.sqrt(spec.radius / spec.gravity), spec.radius
    sin, cos = np.sin(second["tilt"]), np.cos(second["tilt"])
    tilting, turning, rolling = (
        second[name] - first[name] for name in ("tilt_rate", "precession_rate", "roll_rate")
    )

    def distance(*names: str) -> Array:
        return np.asarray(np.sqrt(sum((second[name] - first[name]) ** 2 for name in names)))

    contact, centre = distance("contact_x", "contact_y"), distance("centre_x", "centre_y", "centre_z")
    differences = {
        "orientation_error": turned_between(first, second),
        "path_error": np.maximum(contact, centre) / radius,
        "rate_error": unit * np.sqrt(tilting**2 + (cos * turning) ** 2 + (rolling + sin * turning) ** 2),
        "force_error": distance("normal_force", "friction_across", "friction_along"),
    }
    if energies:
        changes = [np.abs(second[name] - first[name]) for name in energies]
        differences["energy_error"] = np.asarray(np.max(changes, axis=0))
    start = unit * max(abs(float(second[name][0])) for name in ("precession_rate", "roll_rate"))
    rounding = _ROUNDING + _OF_RATES * start * (1.0 + other.times / unit)
    # differences vanish where the motions cross, but the errors do not: keep the largest difference so far
    return {name: _SAFETY * np.maximum.accumulate(values) + rounding for name, values in differences.items()}


def turned_between(first: Mapping[str, Array], second: Mapping[str, Array]) -> Array:
    """Return the angles [rad] between the orientations of two sets of samples, from tilt, heading and roll angle.

    Notes
    -----
    They are computed from unit quaternions, because at a pole the sum or the difference of heading and roll angle is
    not defined.
    """

    def quaternions(of: Mapping[str, Array]) -> Array:
        half = 0.25 * math.pi - 0.5 * of["tilt"]
        more, less = (0.5 * (of["heading"] + sign * of["roll_angle"]) for sign in (1.0, -1.0))
        near, far = np.cos(half), np.sin(half)
        return np.stack([near * np.cos(more), near * np.sin(more), far * np.cos(less), far * np.sin(less)])

    one, other = quaternions(first), quaternions(second)
    chord = np.minimum(np.linalg.norm(one - other, axis=0), np.linalg.norm(one + other, axis=0))
    return np.asarray(4.0 * np.arcsin(0.5 * chord))


def in_si(spec: MotionRequest, errors: dict[str, Array], mass: float) -> dict[str, npt.NDArray[Any]]:
    """Return scaled errors in the units of the file, for a body with a mass [kg]."""
    weight = mass * spec.gravity
    scale = {
        "path_error": spec.radius,
        "rate_error": math.sqrt(spec.gravity / spec.radius),
        "force_error": weight,
        "energy_error": weight * spec.radius,
    }
    return {name: (scale.get(name, 1.0) * error).astype(np.float32) for name, error in errors.items()}
