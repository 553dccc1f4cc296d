"""The timing of a film: how fast it plays, which moments its frames show, and how much of the motion."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from sweep.errors import counted
from sweep.figures.disk.film_options import FilmOptions
from sweep.model.quantity import Array
from sweep.motion.sampling import end_of, kind_of
from sweep.motion.tables import TIME

if TYPE_CHECKING:
    import xarray as xr

#: A film of a motion lasts between these times [s] if the speed is chosen for it.
_SHORTEST, _USUAL = 4.0, 20.0

#: It lasts no longer than this [s] if the motion turns so fast that it must be slow; what is left is not shown.
_LONGEST = 60.0

#: A motion that comes to its end is seen at its end for this time of the film [s].
_HELD = 1.0

#: Share of the time of a motion -> angle [rad] by which the disk may turn in it from one frame to the next: the painted
#: radius of a disk that turns by more than half a turn is seen to turn backwards. The rest are the moments in which a
#: disk that is nearly flat turns its lean round, in one sweep that no frame need show.
_TURNS = {0.9: math.pi / 4.0, 0.98: 2.0 * math.pi / 3.0}

#: Largest number of frames: 4 minutes at 25 a second.
MOST_FRAMES = 6000

#: Speeds that are chosen have one of these digits.
_DIGITS = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)

#: A whole number of frames is one in spite of rounding.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Timing:
    """What a film shows when.

    `moments` are the times of the frames [s], shape (n,), `speed` is the time of the motion over that of the film,
    `turn` is the angle [rad] by which the disk turns from one frame to the next, but for its fastest fiftieth, and
    `shown` and `length` are how much of the motion is in the film, and its whole duration [s]; `to_its_end` says that a
    part is the last one, not the first.
    """

    moments: Array
    speed: float
    fps: int
    turn: float
    shown: float
    length: float
    to_its_end: bool = False

    @property
    def whole(self) -> bool:
        """Whether all of the motion is in the film."""
        return self.shown >= self.length

    @property
    def aliased(self) -> bool:
        """Whether the disk turns so far between two frames that it is seen to turn wrongly."""
        return self.turn > max(_TURNS.values()) * (1.0 + _ROUNDING)

    def words(self) -> str:
        """Return what to know of the film in words, for the one who asked for it."""
        speed = "in real time" if self.speed == 1.0 else f"at {self.speed:g} times real time"
        text = f"{counted(self.moments.size, 'frame')}, {self.moments.size / self.fps:.3g} s {speed}"
        if not self.whole:
            text += f"; it shows the {'last' if self.to_its_end else 'first'} {self.shown:.4g} s of {self.length:.4g} s"
        if self.aliased:
            text += (
                f"; the disk turns by {math.degrees(self.turn):.0f} deg from one frame to the next, more than "
                "the eye can follow: give a lower speed or more fps"
            )
        return text


def timing(dataset: "xr.Dataset", options: FilmOptions) -> Timing:
    """Choose the moments of a film.

    Parameters
    ----------
    dataset : xarray.Dataset
        A motion with close samples.
    options : FilmOptions

    Notes
    -----
    What turns is the disk about its own axis, at roll rate + precession rate sin(tilt), and its plane about the
    vertical, at the precession rate.
    """
    times = dataset[TIME.name].values
    length = float(times[-1] - times[0])
    rates = _turning(dataset)
    speed = _speed(length, rates, options.fps) if options.speed is None else options.speed
    longest = MOST_FRAMES if options.speed is not None else min(MOST_FRAMES, round(_LONGEST * options.fps))
    step = speed / options.fps
    count = math.ceil(length / step * (1.0 - _ROUNDING)) + 1
    # two at least, so that a film has a duration
    count = max(2, min(count, longest))
    # the last frame shows the end, although it may be nearer than the others
    moments = np.minimum(times[0] + step * np.arange(count), times[-1])
    stops = kind_of(dataset).stops
    if stops and moments[-1] < times[-1]:
        moments = times[-1] - step * np.arange(count)[::-1]
    if stops and end_of(dataset):
        moments = np.append(moments, np.full(round(_HELD * options.fps), times[-1]))
    shown = float(moments[-1] - moments[0])
    turn = float(np.quantile(rates, max(_TURNS))) * step
    return Timing(moments, speed, options.fps, turn, shown, length, stops)


def _turning(dataset: "xr.Dataset") -> Array:
    """Return how fast the disk turns [rad/s] at moments evenly spaced in time, shape (n,)."""
    tilt, precession, roll = (dataset[name].values for name in ("tilt", "precession_rate", "roll_rate"))
    rates = np.maximum(np.abs(precession), np.abs(roll + precession * np.sin(tilt)))
    if not kind_of(dataset).stops:
        return np.asarray(rates)
    times = dataset[TIME.name].values
    return np.asarray(np.interp(np.linspace(times[0], times[-1], times.size), times, rates))


def _speed(length: float, rates: Array, fps: int) -> float:
    """Return the speed of a film that lasts some seconds and shows the disk turn as it does."""
    wanted = length / _SHORTEST if length < _SHORTEST else max(1.0, length / _USUAL)
    for share, turn in _TURNS.items():
        rate = float(np.quantile(rates, share))
        if wanted * rate > turn * fps:
            wanted = turn * fps / rate
    decade = 10.0 ** math.floor(math.log10(wanted) + _ROUNDING)
    digit = max(each for each in _DIGITS if each * decade <= wanted * (1.0 + _ROUNDING))
    # as it is spelled: 0.3, not 3 * 0.1
    return float(f"{digit * decade:.3g}")
