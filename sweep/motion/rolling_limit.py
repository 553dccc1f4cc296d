"""When rolling without slipping becomes impossible: the disk would slip, or lift off the plane."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kernels.disk import arrays
from sweep.errors import RequestError
from sweep.model.quantity import Array, Truths
from sweep.motion.disk_tables import LIFTS
from sweep.motion.kind import TIME
from sweep.motion.request import TrajectorySpec
from sweep.motion.sampling import closely_sampled, kind_of, request_of
from sweep.motion.trajectory import simulate

if TYPE_CHECKING:
    import xarray as xr

#: Samples between two samples of the motion when a moment is sought between them.
_BETWEEN = 400


@dataclass(frozen=True)
class RollingLimit:
    """Where a motion stops being one of a real disk; what has no such moment is None.

    `slips` is the time [s] from which rolling needs more than the friction coefficient, `lifts_off` the one from which
    the plane would have to pull. `needed` is the largest friction coefficient that is needed before the disk lifts off.
    """

    slips: float | None
    lifts_off: float | None
    needed: float

    @property
    def time(self) -> float:
        """The first moment [s] at which rolling is impossible; infinite if there is none."""
        return min((each for each in (self.slips, self.lifts_off) if each is not None), default=math.inf)

    @staticmethod
    def when(moment: float, start: float, digits: int = 4) -> str:
        """Return a moment [s] in words, of a motion that starts at `start`."""
        return f"at {moment:.{digits}g} s" if moment > start else "from the start"

    def words(self, start: float, friction: float) -> str:
        """Return what happens to a disk, and when; empty if it rolls all the time.

        Parameters
        ----------
        start : float
            The first moment of the motion [s].
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
    """Find when a motion needs more friction than there is, and when the normal force vanishes.

    Parameters
    ----------
    dataset : xarray.Dataset
        A motion, or a stretch of it in time, with samples as far apart as they like.

    Returns
    -------
    RollingLimit

    Raises
    ------
    RequestError
        If it is no motion.

    Notes
    -----
    The moments are sought among close samples, and then between two of them in a motion that begins at the first. A
    motion with losses ends where the disk slips or lifts off: all of it is possible.
    """
    motion = closely_sampled(dataset)
    needed = motion["friction_needed"].values
    if "contact" not in kind_of(motion).variables:
        return RollingLimit(None, None, float(np.nanmax(needed, initial=0.0)))
    friction = float(motion["friction"])
    lifted = motion["contact"].values == LIFTS
    slips = _moment(motion, lifted | (needed > friction), friction)
    lifts_off = _moment(motion, lifted, math.inf)
    # a disk that lifts off at once has needed nothing before
    return RollingLimit(
        None if slips == lifts_off else slips,
        lifts_off,
        math.inf if lifts_off is not None else float(np.nanmax(needed, initial=0.0)),
    )


def _moment(motion: "xr.Dataset", beyond: Truths, friction: float) -> float | None:
    """Return the time [s] at which a motion first goes beyond a limit, which `beyond` says of each sample."""
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
        # a stretch too short to be computed: the sample is the answer
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
    """Return what changes its sign from - to + where a motion goes beyond a limit: horizontal force less friction."""
    normal = motion["normal_force"].values
    if math.isinf(friction):
        return np.asarray(-normal)
    horizontal = np.hypot(motion["friction_across"].values, motion["friction_along"].values)
    return np.asarray(horizontal - friction * normal)


def _between(motion: "xr.Dataset", at: int, time: float) -> "xr.Dataset":
    """Return the motion from one of its samples on, for a time [s], with close samples."""
    words = request_of(motion).words() | {name: float(motion[name][at]) for name in arrays.STATE}
    return simulate(TrajectorySpec.read(**words | {"duration": time, "interval": time / _BETWEEN}))
