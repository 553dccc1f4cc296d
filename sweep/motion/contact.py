"""The extremes of the contact forces of one cell, from its motion in time: what `explain` holds an atlas against."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from kernels.disk.endings import BOUNDED, FELL, HORIZON
from kernels.disk.motion_arrays import CONTACT
from sweep.errors import RequestError
from sweep.motion.request import MotionRequest, TrajectorySpec
from sweep.motion.trajectory import simulate
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr

_STATE = ("tilt", "tilt_rate", "precession_rate", "roll_rate")

#: Samples of each way from the start to its end, and how often the surroundings of an extreme are sampled anew.
_SAMPLES, _CLOSER = 2000, 2

#: Error of the forces of a motion in time, over their largest one: its energy is kept to 1e-11.
_ERROR = 1e-8


def contact_in_time(
    spec: SweepSpec, start: Mapping[str, float], stored: Mapping[str, float]
) -> dict[str, tuple[float, float]]:
    """Follow one cell in time and sample its contact forces.

    Parameters
    ----------
    spec : SweepSpec
    start : mapping of str to float
        Every parameter of the cell, in SI.
    stored : mapping of str to float
        Its measures in the atlas: the ending, and the times that belong to it.

    Returns
    -------
    dict of str to (value, error)
        ``least_normal_force`` and ``friction_needed`` [1], NaN where the disk lifts off, and how far each may be off.
        Empty where there is no motion, where it cannot be followed, and for an atlas without contact forces.

    Notes
    -----
    The start is followed forward to where it turns, falls or runs out of time, and backward from the start if it
    turned. Beyond a turn nothing new comes, but a maximum of the potential that the disk might miss.
    """
    if spec.contact != "yes" or stored["ending"] not in (BOUNDED, FELL, HORIZON):
        return {}
    time = _duration(spec, stored)
    # a motion that began flat has nothing to follow
    if not time > 0.0:
        return {}
    try:
        forward = _until_turn(simulate(_request(spec, start, time)))
        ways = [forward]
        if start["tilt_rate"] != 0.0 and _turned(forward):
            elapsed = float(forward["elapsed_time"][-1])
            rest = time if stored["ending"] != HORIZON else time - 2.0 * elapsed
            back = {**start, **{name: -start[name] for name in _STATE[1:]}}
            if rest > 0.0:
                ways.append(_until_turn(simulate(_request(spec, back, rest))))
        found = [_extremes(spec, start, way, _CLOSER) for way in ways]
    except RequestError:
        return {}
    normal, needed = min(least for least, _ in found), max(most for _, most in found)
    weight = start["gravity"]
    error = _ERROR * max(1.0, max(float(np.abs(way["normal_force"]).max()) for way in ways) / weight)
    if not normal > 0.0:
        needed = math.nan
    return dict(
        zip(CONTACT, ((normal, error), (needed, error * (1.0 + needed) / max(normal, error))), strict=True)
    )


def _duration(spec: SweepSpec, stored: Mapping[str, float]) -> float:
    """Return a time [s] in which the motion has gone through its tilts on either side of its start."""
    if stored["ending"] == BOUNDED:
        return 0.51 * stored["nutation_period"]
    return 1.01 * stored["fall_time"] if stored["ending"] == FELL else float(spec.duration)


def _request(
    spec: SweepSpec, start: Mapping[str, float], time: float, samples: int = _SAMPLES
) -> MotionRequest:
    return TrajectorySpec.read(
        **{**start, "duration": time, "interval": time / samples, "fall_tilt": spec.fall_tilt}
    )


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
    """Return the least normal force over the weight and the largest coefficient, sampled ever closer about both."""
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
