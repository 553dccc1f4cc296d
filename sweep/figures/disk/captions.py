"""Words on figures and films of motions: what is shown, in one line, and lengths in a unit that suits them."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

from sweep.figures.texts import number
from sweep.model.disk.tables import PARAMETERS
from sweep.motion.tables import TIME

if TYPE_CHECKING:
    import xarray as xr

#: Lengths below [m] -> unit and how many of it are a metre.
_UNITS = ((1e-4, "\u00b5m", 1e6), (0.1, "mm", 1e3), (1e4, "m", 1.0), (math.inf, "km", 1e-3))

_RATES = ("tilt_rate", "precession_rate", "roll_rate")

_ROUNDING = 1e-12


def length_unit(extent: float) -> tuple[str, float]:
    """Return the unit in which lengths of this size [m] are read, and the factor from metres to it."""
    return next((unit, factor) for below, unit, factor in _UNITS if abs(extent) < below)


def spell_length(value: float) -> str:
    """Return a length [m] with the unit that suits it."""
    unit, factor = length_unit(value)
    return f"{number(value * factor)} {unit}"


def nice_length(most: float) -> float:
    """Return the largest length of one digit, 1, 2 or 5, that is not above the one given [m]."""
    decade = 10.0 ** math.floor(math.log10(most))
    return decade * max(each for each in (1.0, 2.0, 5.0) if each * decade <= most * (1.0 + 1e-9))


def caption(dataset: "xr.Dataset") -> str:
    """Return which disk a motion is of, and how it starts: in one line, plain text.

    Parameters
    ----------
    dataset : xarray.Dataset
        A motion, or a stretch of it in time; that one starts with its first sample.
    """
    fixed = {name: float(dataset[name]) for name in ("alpha", "radius", "gravity")}
    first = {name: float(dataset[name][0]) for name in ("tilt", *_RATES)}
    return _line(fixed | first, float(dataset[TIME.name][0]))


def caption_of_start(start: Mapping[str, float]) -> str:
    """Return the caption of a motion from its start, a value for every parameter of the disk in SI."""
    return _line(start, 0.0)


def _line(start: Mapping[str, float], time: float) -> str:
    disk = [f"R = {spell_length(start['radius'])}", f"\u03b1 = {number(start['alpha'])}"]
    if start["gravity"] != PARAMETERS["gravity"].default:
        disk.append(f"g = {number(start['gravity'])} m/s\u00b2")
    tilt = PARAMETERS["tilt"]
    state = [f"tilt {number(start['tilt'] * tilt.plot_scale)} {tilt.shown_units}"]
    # a rate that is zero comes back from the coordinates of the kernels with rounding
    least = _ROUNDING * (
        math.sqrt(start["gravity"] / start["radius"]) + max(abs(start[name]) for name in _RATES)
    )
    moving = [name for name in _RATES if abs(start[name]) > least]
    state += [f"{name.replace('_', ' ')} {number(start[name])} rad/s" for name in moving] or ["at rest"]
    when = "start" if time == 0.0 else f"from {number(time)} {TIME.units} on"
    return f"{', '.join(disk)}; {when}: {', '.join(state)}"
