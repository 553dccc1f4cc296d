"""The contact forces of one motion: their extremes, and the times at which the disk would slip or lift off."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kernels.bodies.arrays import CONTACT
from kernels.disk import arrays
from kernels.disk.endings import BOUNDED, FELL
from sweep.errors import RequestError
from sweep.model.quantity import Array, Truths
from sweep.motion.origin import words_of_start
from sweep.motion.request import MotionRequest, TrajectorySpec
from sweep.motion.sampling import closely_sampled, kind_of, request_of
from sweep.motion.tables import LIFTS, TIME
from sweep.motion.trajectory import simulate
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr


_STATE = ("tilt", "tilt_rate", "precession_rate", "roll_rate")

#: Number of samples in each direction from the start, and number of times that the surroundings of an extreme are
#: sampled again.
_SAMPLES, _CLOSER = 2000, 2

#: Relative error of the forces of a motion in time, over the largest force: its energy is conserved to 1e-11.
_ERROR = 1e-8


def contact_in_time(
    spec: SweepSpec, start: Mapping[str, float], stored: Mapping[str, float]
) -> dict[str, tuple[float, float]]:
    """Return the extremes of the contact forces of one cell, from samples of its motion in time.

    Parameters
    ----------
    spec : SweepSpec
    start : mapping of str to float
        Every parameter of the cell, in SI.
    stored : mapping of str to float
        Its measures in the atlas: the ending and its time.

    Returns
    -------
    dict of str to (value, error)
        ``least_normal_force`` and ``friction_needed`` [1], NaN if the disk lifts off, with their errors. Empty if there
        is no motion, if it did not end or cannot be computed, or if the atlas has no contact forces.

    Notes
    -----
    The motion is computed forward until it turns or falls; if it turned, also backward from the start. Past a turning
    point the motion only repeats itself, and might go wrong at a maximum of the potential.
    """
    if spec.contact != "yes" or stored["ending"] not in (BOUNDED, FELL):
        return {}
    time = 0.51 * stored["nutation_period"] if stored["ending"] == BOUNDED else 1.01 * stored["fall_time"]
    # a motion that began flat has no duration
    if not time > 0.0:
        return {}
    try:
        forward = _until_turn(simulate(_request(spec, start, time)))
        ways = [forward]
        if start["tilt_rate"] != 0.0 and _turned(forward):
            back = {**start, **{name: -start[name] for name in _STATE[1:]}}
            ways.append(_until_turn(simulate(_request(spec, back, time))))
        extremes = [_extremes(spec, start, way, _CLOSER) for way in ways]
    except RequestError:
        return {}
    normal, needed = min(least for least, _ in extremes), max(most for _, most in extremes)
    weight = start["gravity"]
    error = _ERROR * max(1.0, max(float(np.abs(way["normal_force"]).max()) for way in ways) / weight)
    if not normal > 0.0:
        needed = math.nan
    return dict(
        zip(CONTACT, ((normal, error), (needed, error * (1.0 + needed) / max(normal, error))), strict=True)
    )


def _request(
    spec: SweepSpec, start: Mapping[str, float], time: float, samples: int = _SAMPLES
) -> MotionRequest:
    words = {"duration": time, "interval": time / samples, "fall_tilt": spec.fall_tilt}
    return TrajectorySpec.read(**words_of_start(spec, start) | words)


def _turned(motion: "xr.Dataset") -> bool:
    rates = motion["tilt_rate"].values
    return bool(rates[-1] * rates[np.flatnonzero(rates)[0]] < 0.0) if rates.any() else False


def _until_turn(motion: "xr.Dataset") -> "xr.Dataset":
    """Return a motion up to the first sample after its first turn, all of it if it does not turn."""
    rates = motion["tilt_rate"].values
    moving = np.flatnonzero(rates)
    if not moving.size:
        return motion
    turned = np.flatnonzero(rates * rates[moving[0]] < 0.0)
    return motion.isel(elapsed_time=slice(0, int(turned[0]) + 1)) if turned.size else motion


def _extremes(
    spec: SweepSpec, start: Mapping[str, float], motion: "xr.Dataset", closer: int
) -> tuple[float, float]:
    """Return the least normal force over the weight and the largest coefficient, with closer samples around both."""
    normal, needed = motion["normal_force"].values, motion["friction_needed"].values
    least = float(normal.min()) / start["gravity"]
    most = float(np.nanmax(needed)) if np.isfinite(needed).any() else 0.0
    if closer == 0 or normal.size < 2:
        return least, most
    places = {int(normal.argmin())}
    if np.isfinite(needed).any():
        places.add(int(np.nanargmax(needed)))
    times = motion["elapsed_time"].values
    for place in places:
        first, last = max(0, place - 1), min(normal.size - 1, place + 1)
        state = {name: float(motion[name][first]) for name in _STATE}
        near = simulate(_request(spec, {**start, **state}, float(times[last] - times[first]), 200))
        below, above = _extremes(spec, start, near, closer - 1)
        least, most = min(least, below), max(most, above)
    return least, most


#: Number of new samples between two samples, to find a time between them.
_BETWEEN = 400


@dataclass(frozen=True)
class RollingLimit:
    """The times [s] at which a real disk would stop rolling; None if it would not.

    From `slips` on, rolling needs more than the friction coefficient; from `lifts_off` on, the plane would have to
    pull. `needed` is the largest friction coefficient needed before the disk lifts off.
    """

    slips: float | None
    lifts_off: float | None
    needed: float

    @property
    def time(self) -> float:
        """The first time [s] at which rolling is impossible; infinite if there is none."""
        return min((time for time in (self.slips, self.lifts_off) if time is not None), default=math.inf)

    @staticmethod
    def when(moment: float, start: float, digits: int = 4) -> str:
        """Return a time [s] in words, for a motion that starts at `start`."""
        return f"at {moment:.{digits}g} s" if moment > start else "from the start"

    def words(self, start: float, friction: float) -> str:
        """Return what happens to a disk, and when; empty if it rolls all the time.

        Parameters
        ----------
        start : float
            The first time of the motion [s].
        friction : float
            Friction coefficient of disk and plane.
        """
        parts = []
        if self.slips is not None:
            more = f"rolling then needs more than friction={friction:g}"
            parts.append(f"slips {self.when(self.slips, start, 6)} ({more})")
        if self.lifts_off is not None:
            parts.append(f"lifts off {self.when(self.lifts_off, start, 6)} (the normal force vanishes)")
        return " and ".join(parts)


def rolling_limit(dataset: "xr.Dataset") -> RollingLimit:
    """Return the times from which a motion needs more friction than there is, and the normal force vanishes.

    Parameters
    ----------
    dataset : xarray.Dataset
        A motion, or a part of it in time, with samples at any distance.

    Returns
    -------
    RollingLimit

    Raises
    ------
    RequestError
        If the dataset is not a motion.

    Notes
    -----
    The times are found among close samples, and then between two of these, in a motion that begins at the first one. A
    motion with losses ends when the disk slips or lifts off, so all of it is possible.
    """
    motion = closely_sampled(dataset)
    needed = motion["friction_needed"].values
    if "contact" not in kind_of(motion).variables:
        return RollingLimit(None, None, float(np.nanmax(needed, initial=0.0)))
    friction = float(motion["friction"])
    lifted = motion["contact"].values == LIFTS
    slips = _moment(motion, lifted | (needed > friction), friction)
    lifts_off = _moment(motion, lifted, math.inf)
    # a disk that lifts off at the start needs no friction before
    return RollingLimit(
        None if slips == lifts_off else slips,
        lifts_off,
        math.inf if lifts_off is not None else float(np.nanmax(needed, initial=0.0)),
    )


def _moment(motion: "xr.Dataset", beyond: Truths, friction: float) -> float | None:
    """Return the time [s] at which a motion first exceeds a limit; `beyond` marks the samples that do."""
    if not beyond.any():
        return None
    times = motion[TIME.name].values
    at = int(beyond.argmax())
    if at == 0:
        return float(times[0])
    before, after = float(times[at - 1]), float(times[at])
    try:
        near = _between(motion, at - 1, after - before)
    except RequestError:
        # the interval is too short to compute: use the sample
        return after
    excess = _excess(near, friction)
    place = int((excess > 0.0).argmax())
    if not excess[place] > 0.0:
        return after
    if place == 0:
        return before
    start, end = near[TIME.name].values[[place - 1, place]]
    share = -excess[place - 1] / (excess[place] - excess[place - 1])
    return before + float(start + share * (end - start))


def _excess(motion: "xr.Dataset", friction: float) -> Array:
    """Return a quantity that becomes positive where a motion exceeds a limit: horizontal force minus friction."""
    normal = motion["normal_force"].values
    if math.isinf(friction):
        return np.asarray(-normal)
    horizontal = np.hypot(motion["friction_across"].values, motion["friction_along"].values)
    return np.asarray(horizontal - friction * normal)


def _between(motion: "xr.Dataset", at: int, time: float) -> "xr.Dataset":
    """Return the motion from one of its samples on, over a time [s], with close samples."""
    words = request_of(motion).words() | {name: float(motion[name][at]) for name in arrays.STATE}
    return simulate(TrajectorySpec.read(**words | {"duration": time, "interval": time / _BETWEEN}))
