"""Stated errors of a motion of a body: from how far two integrations with different steps have been apart."""

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

#: A motion is integrated again with half the step, so often at most, until it is as near to the one before as this
#: error, in rad, radii, m g, m g R and units of sqrt(g/R), or no nearer.
_MOST_REFINEMENTS, _ALLOWED = 6, 4e-10

#: Share of the error before at which half the step is still worth it: of fourth order it would be a sixteenth.
_BETTER = 0.5

#: A stated error is so many times the difference of two integrations: it is a fifteenth of it with a step that is short
#: enough, but with one that is far too long up to 2.2 of it was found. And rounding that both have in common.
_SAFETY, _ROUNDING = 4.0, 1e-12

#: Rounding of the start: beside a pole its spin is the small difference of two rates.
_OF_RATES = 2.0**-50


@dataclass(frozen=True)
class Found:
    """One integration.

    Attributes
    ----------
    names : sequence of str
        Of the rows of the samples.
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
        """Return the samples at the times of another integration; only at its end they may be other ones."""
        found = self.samples[:, np.minimum(np.arange(times.size), self.times.size - 1)]
        place = min(times.size, self.times.size) - 1
        step = self.times[place] - self.times[place - 1]
        late = (times[place:] - self.times[place]) / step
        found[:, place:] += np.multiply.outer(self.samples[:, place] - self.samples[:, place - 1], late)
        return dict(zip(self.names, found, strict=True))


def settled(
    spec: MotionRequest, once: Callable[[int], Found | None], energies: Sequence[str] = ()
) -> tuple[Found, dict[str, Array]]:
    """Return a motion with a step that half of it hardly changes, and its errors: scaled, shape (m,) each.

    Parameters
    ----------
    spec : MotionRequest
    once : callable
        Called with how often the step is to be halved; returns one integration, or None if it was not resolved.
    energies : sequence of str
        Samples over m g R, of which `energy_error` is told.

    Raises
    ------
    NoMotionError
        If no two integrations were resolved, and ended likewise.
    """
    before, best = once(0), None
    for refinement in range(1, _MOST_REFINEMENTS + 1):
        found = once(refinement)
        if found is None:
            break
        if before is not None and before.ending == found.ending:
            errors = _apart(spec, before, found, energies)
            largest = max(float(each[-1]) for each in errors.values())
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
    """Return the error of a motion that could not be followed, with the time [s] until which it was.

    A time that is not behind the start says nothing: a motion that has no step fails at once.
    """
    followed = f"it was followed until {spec.kind.time.spell(until, 6)}"
    where = followed if until > 0.0 else "it fails from its start on"
    rolling = getattr(spec, "rolling_friction", 0.0) > 0.0
    brink = "rolling friction must clearly hold it or let it go, " if rolling else ""
    other = "another rolling_friction, " if rolling else ""
    return NoMotionError(
        f"This motion could not be resolved: its state must stay finite, {brink}and it may take at most "
        f"{MOST_STEPS} steps; {where}.",
        hint=f"Give {other}a shorter step or duration, slower rates, or a smaller {spec.kind.largest_tilt}.",
    )


def _apart(spec: MotionRequest, one: Found, other: Found, energies: Sequence[str]) -> dict[str, Array]:
    """Return the largest differences of two integrations until each sample of the second one, scaled.

    Notes
    -----
    Of the orientation the difference is the angle between both, whatever heading and roll angle say of it beside a
    pole. Of the angular velocity it is hypot(d tilt_rate, cos(tilt) d precession_rate, d roll_rate + sin(tilt)
    d precession_rate), which is regular there, too.
    """
    first, second = one.at(other.times), other.at(other.times)
    unit, radius = math.sqrt(spec.radius / spec.gravity), spec.radius
    sin, cos = np.sin(second["tilt"]), np.cos(second["tilt"])
    tilting, turning, rolling = (
        second[name] - first[name] for name in ("tilt_rate", "precession_rate", "roll_rate")
    )

    def moved(*names: str) -> Array:
        return np.asarray(np.sqrt(sum((second[name] - first[name]) ** 2 for name in names)))

    contact, centre = moved("contact_x", "contact_y"), moved("centre_x", "centre_y", "centre_z")
    found = {
        "orientation_error": turned_between(first, second),
        "path_error": np.maximum(contact, centre) / radius,
        "rate_error": unit * np.sqrt(tilting**2 + (cos * turning) ** 2 + (rolling + sin * turning) ** 2),
        "force_error": moved("normal_force", "friction_across", "friction_along"),
    }
    if energies:
        lost = [np.abs(second[name] - first[name]) for name in energies]
        found["energy_error"] = np.asarray(np.max(lost, axis=0))
    start = unit * max(abs(float(second[name][0])) for name in ("precession_rate", "roll_rate"))
    rounding = _ROUNDING + _OF_RATES * start * (1.0 + other.times / unit)
    # differences cross zero where the motions meet: what has been apart is not known better afterwards
    return {name: _SAFETY * np.maximum.accumulate(each) + rounding for name, each in found.items()}


def turned_between(first: Mapping[str, Array], second: Mapping[str, Array]) -> Array:
    """Return the angles [rad] by which bodies are turned from samples to other ones, of tilt, heading and roll angle.

    Notes
    -----
    From their unit quaternions: at a pole the sum or the difference of heading and roll angle has no meaning, and no
    share in them.
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
    """Return scaled errors in the units of the file, of a body with a mass [kg]."""
    weight = mass * spec.gravity
    scale = {
        "path_error": spec.radius,
        "rate_error": math.sqrt(spec.gravity / spec.radius),
        "force_error": weight,
        "energy_error": weight * spec.radius,
    }
    return {name: (scale.get(name, 1.0) * each).astype(np.float32) for name, each in errors.items()}
