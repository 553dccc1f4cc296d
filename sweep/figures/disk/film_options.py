"""The options of a film, checked before anything is computed or drawn, and the times of its pictures."""

import math
import re
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn, Self

import numpy as np

from sweep.errors import RequestError, as_path, counted, shown
from sweep.model.quantity import Array
from sweep.motion.sampling import end_of, kind_of, request_of
from sweep.motion.tables import TIME
from sweep.request.suggestions import suggestion

if TYPE_CHECKING:
    import xarray as xr


#: File name extension -> frames per second by default, and at most. A gif counts time in hundredths of a second, and
#: programs show a frame of one hundredth for longer.
_RATES = {"mp4": (25, 120), "gif": (25, 50)}

#: Width and height [dots] by default, the least, and the largest.
_SIZE, _SMALLEST, _LARGEST = (640, 480), 200, 4096

#: Camera -> what it does.
CAMERAS = {
    "fixed": "stands still and sees all of the motion",
    "follow": "goes along with the disk",
    "top": "looks down on all of the motion",
}

#: The largest and the smallest speed.
_SPEEDS = (1e-9, 1e9)


@dataclass(frozen=True)
class FilmOptions:
    """A film that is possible. Make one with `read`.

    `ending` is its format, mp4 or gif; `speed` is the time of the motion over that of the film, `fps` are frames a
    second, `size` is width and height [dots], `camera` is one of `CAMERAS`. A speed or camera of None is chosen for the
    motion.
    """

    ending: str
    speed: float | None
    fps: int
    size: tuple[int, int]
    camera: str | None

    @classmethod
    def read(
        cls,
        path: str | Path,
        *,
        speed: object = None,
        fps: object = None,
        size: object = None,
        camera: object = None,
    ) -> Self:
        """Return the options of a film, None for what is chosen for it.

        Parameters
        ----------
        path : str or Path
            Its name, which ends in .mp4 or .gif.
        speed : float, optional
            Seconds of the motion for a second of the film: 0.1 is ten times slower than it is.
        fps : int, optional
            Frames per second.
        size : str or pair of int, optional
            Width and height in dots, ``"1280x720"``; those of an mp4 are even.
        camera : str, optional
            fixed, follow or top.

        Raises
        ------
        RequestError
            If there can be no such film, or it is an mp4 and there is no ffmpeg.
        """
        ending = check_format(path)
        default, most = _RATES[ending]
        return cls(
            ending,
            None if speed is None else _read_speed(speed),
            default if fps is None else _read_rate(fps, most, ending),
            _SIZE if size is None else _read_size(size, ending),
            None if camera is None else _read_camera(camera),
        )


def check_format(path: str | Path) -> str:
    """Return the format of a film from its file name: mp4 or gif.

    Raises
    ------
    RequestError
        If the name has another extension, or it is mp4 and there is no ffmpeg.
    """
    film = as_path(path, "disk.gif")
    ending, name = film.suffix.lower().removeprefix("."), shown(film.stem) or "disk"
    if ending not in _RATES:
        raise RequestError(
            f"The name of a film ends in {' or '.join(f'.{each}' for each in _RATES)}; got {shown(str(path))}.",
            hint=f"Write {name}.gif.",
            where=str(path),
        )
    if ending == "mp4" and shutil.which("ffmpeg") is None:
        raise RequestError(
            "An mp4 needs the program ffmpeg, which was not found; a gif needs nothing.",
            hint=f"Write {name}.gif, or install ffmpeg.",
            where=str(path),
        )
    return ending


def _refuse(problem: str, raw: object, hint: str, option: str) -> NoReturn:
    given = f"{raw:g}" if isinstance(raw, float) and math.isfinite(raw) else shown(raw)
    raise RequestError(f"{problem}{given}.", hint=hint, where=f"film {option}")


def _read_speed(raw: object) -> float:
    low, high = _SPEEDS
    # not bool, which is an int to Python
    if isinstance(raw, int | float) and not isinstance(raw, bool) and low <= raw <= high:
        return float(raw)
    _refuse(
        f"The speed of a film is a number from {low:g} to {high:g}: seconds of the motion in a second of the film; "
        "got ",
        raw, "Write 1 for real time, 0.1 for a film that is ten times slower.", "speed",
    )  # fmt: skip


def _read_rate(raw: object, most: int, ending: str) -> int:
    if isinstance(raw, int | np.integer) and not isinstance(raw, bool) and 1 <= raw <= most:
        return int(raw)
    _refuse(
        f"The frames per second of a film are a whole number, of {ending} from 1 to {most}; got fps=",
        raw, f"Write {min(25, most)}, or {most} for a smoother one.", "fps",
    )  # fmt: skip


def _read_size(raw: object, ending: str) -> tuple[int, int]:
    found = re.fullmatch(r"([0-9]{1,6})x([0-9]{1,6})", raw) if isinstance(raw, str) else None
    numbers = [int(each) for each in found.groups()] if found else raw
    if not isinstance(numbers, tuple | list) or [type(each) for each in numbers] != [int, int]:
        _refuse("The size of a film is WIDTHxHEIGHT in dots; got ", raw, "Write 1280x720.", "size")
    if not all(_SMALLEST <= each <= _LARGEST for each in numbers):
        problem = f"Width and height of a film are from {_SMALLEST} to {_LARGEST} dots; got "
        _refuse(problem, raw, "Write 1280x720.", "size")
    even = [each + each % 2 for each in numbers]
    if ending == "mp4" and even != [*numbers]:
        hint = f"Write {even[0]}x{even[1]}, or make a gif."
        _refuse("Width and height of an mp4 are even numbers of dots; got ", raw, hint, "size")
    return numbers[0], numbers[1]


def _read_camera(raw: object) -> str:
    if isinstance(raw, str) and raw in CAMERAS:
        return raw
    meanings = ", ".join(f"{name} ({what})" for name, what in CAMERAS.items())
    hint = suggestion(raw, tuple(CAMERAS)) or "Write follow, or leave it out."
    _refuse(f"The camera of a film is one of {meanings}; got ", raw, hint, "camera")


#: A film of a motion lasts between these times [s] if the speed is chosen for it.
_SHORTEST, _USUAL = 4.0, 20.0

#: It lasts no longer than this [s] if the motion turns so fast that it must be slow; what is left is not shown.
_LONGEST = 60.0

#: A motion that comes to its end is seen at its end for this time of the film [s].
_HELD = 1.0

#: Share of the time of a motion -> angle [rad] by which the disk may turn in it from one frame to the next: the painted
#: radius of a disk that turns by more than half a turn is seen to turn backwards. The rest are the moments in which a
#: disk that is nearly flat turns its lean round, in one sweep that no frame need show.
_TURNS = {0.9: math.pi / 2.0, 0.98: 2.0 * math.pi / 3.0}

#: Largest number of frames: 4 minutes at 25 a second.
MOST_FRAMES = 6000

#: Speeds that are chosen have one of these digits.
_DIGITS = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)

#: A whole number of frames is one in spite of rounding.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Timing:
    """The times of the pictures of a film.

    `moments` are the times of the frames [s], shape (n,), `speed` is the time of the motion over that of the film,
    `turn` is the angle [rad] by which the disk turns from one frame to the next, except for its fastest fiftieth, and
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
    own = np.abs(roll + precession * np.sin(tilt))
    kind = kind_of(dataset)
    if kind.rolls_on(request_of(dataset)):
        # beside a pole it turns about the vertical with both, and the heading alone says nothing
        rates = np.hypot(own, np.hypot(dataset["tilt_rate"].values, precession * np.cos(tilt)))
    else:
        rates = np.maximum(np.abs(precession), own)
    if not kind.stops:
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
