"""Text on figures and films of motions: what is shown, in one line, and lengths in suitable units."""

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from sweep.figures.texts import number
from sweep.model.bodies.tables import CALLED, LENGTHS
from sweep.model.disk.tables import PARAMETERS
from sweep.motion.sampling import is_of_body, kind_of, request_of
from sweep.motion.tables import TIME

if TYPE_CHECKING:
    import xarray as xr

#: Lengths below each value [m] -> unit, and how many of it make a metre.
_UNITS = ((1e-4, "\u00b5m", 1e6), (0.1, "mm", 1e3), (1e4, "m", 1.0), (math.inf, "km", 1e-3))

_RATES = ("tilt_rate", "precession_rate", "roll_rate")

_ROUNDING = 1e-12


def length_unit(extent: float) -> tuple[str, float]:
    """Return the unit in which lengths of this size [m] are shown, and the factor from metres to the unit."""
    return next((unit, factor) for below, unit, factor in _UNITS if abs(extent) < below)


def spell_length(value: float) -> str:
    """Return a length [m] as text in a suitable unit."""
    unit, factor = length_unit(value)
    return f"{number(value * factor)} {unit}"


def nice_length(most: float) -> float:
    """Return the largest length of the form 1, 2 or 5 times a power of ten that is at most `most` [m]."""
    decade = 10.0 ** math.floor(math.log10(most))
    return decade * max(each for each in (1.0, 2.0, 5.0) if each * decade <= most * (1.0 + 1e-9))


def caption(dataset: "xr.Dataset") -> str:
    """Return the disk of a motion and how it starts, in one line of plain text.

    Parameters
    ----------
    dataset : xarray.Dataset
        A motion, or an interval of it, whose start is its first sample.
    """
    kind = kind_of(dataset)
    start = {name: float(dataset[name].values.flat[0]) for name in kind.model.parameters}
    body = request_of(dataset).body if is_of_body(dataset) else ""
    return _line(start, float(dataset[TIME.name][0]), body)


def caption_of_start(start: Mapping[str, float], body: str = "") -> str:
    """Return the caption of a motion from its start: every parameter in SI; `body` names any body but a thin disk."""
    return _line(start, 0.0, body)


def _line(start: Mapping[str, float], time: float, body: str) -> str:
    disk = [f"R = {spell_length(start['radius'])}"]
    if body:
        disk = [CALLED[body], *disk, *_shape(start, body)]
    else:
        disk.append(f"\u03b1 = {number(start['alpha'])}")
    if start["gravity"] != PARAMETERS["gravity"].default:
        disk.append(f"g = {number(start['gravity'])} m/s\u00b2")
    tilt = PARAMETERS["tilt"]
    state = [f"tilt {number(start['tilt'] * tilt.plot_scale)} {tilt.shown_units}"]
    # a zero rate has rounding error after the conversion from the coordinates of the kernels
    least = _ROUNDING * (
        math.sqrt(start["gravity"] / start["radius"]) + max(abs(start[name]) for name in _RATES)
    )
    moving = [name for name in _RATES if abs(start[name]) > least]
    state += [f"{name.replace('_', ' ')} {number(start[name])} rad/s" for name in moving] or ["at rest"]
    when = "start" if time == 0.0 else f"from {number(time)} {TIME.units} on"
    return f"{', '.join(disk)}; {when}: {', '.join(state)}"


def _shape(start: Mapping[str, float], body: str) -> Iterator[str]:
    """Yield the lengths of a body that are not 0, and its flattening."""
    for name in LENGTHS[body]:
        if name == "flattening":
            yield f"{name} {number(start[name])}"
        elif start[name] != 0.0 or name == LENGTHS[body][0]:
            yield f"{name} {spell_length(start[name] * start['radius'])}"
