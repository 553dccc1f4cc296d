"""The options of a film, checked before anything is computed or drawn, and the times of its frames."""

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


#: File name extension -> default and largest frames per second. A gif counts hundredths of a second, and programs show
#: a frame of one hundredth for longer.
_RATES = {"mp4": (25, 120), "gif": (25, 50)}

#: Default width and height, least, and largest width or height [pixels].
_SIZE, _SMALLEST, _LARGEST = (640, 480), 200, 4096

#: Camera -> what it does.
CAMERAS = {
    "fixed": "stands still and sees the whole motion",
    "follow": "follows the disk",
    "top": "looks down on the whole motion",
}

#: The least and the largest speed.
_SPEEDS = (1e-9, 1e9)


@dataclass(frozen=True)
class FilmOptions:
    """The checked options of a film. Create them with `read`.

    `ending` is the format, mp4 or gif; `speed` is the time of the motion divided by the time of the film, `fps` are
    frames per second, `size` is width and height [pixels], `camera` is one of `CAMERAS`. If speed or camera is None, it
    is chosen for the motion.
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
        """Return the options of a film; None lets an option be chosen automatically.

        Parameters
        ----------
        path : str or Path
            File name, which ends in .mp4 or .gif.
        speed : float, optional
            Seconds of the motion per second of the film: 0.1 is ten times slower than real time.
        fps : int, optional
            Frames per second.
        size : str or pair of int, optional
            Width and height in pixels, ``"1280x720"``; an mp4 needs even numbers.
        camera : str, optional
            fixed, follow or top.

        Raises
        ------
        RequestError
            If an option is invalid, or the film is an mp4 and ffmpeg is missing.
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
        If the name has another extension, or it is mp4 and ffmpeg is missing.
    """
    film = as_path(path, "disk.gif")
    ending, name = film.suffix.lower().removeprefix("."), shown(film.stem) or "disk"
    if ending not in _RATES:
        raise RequestError(
            f"The name of a film must end in {' or '.join(f'.{each}' for each in _RATES)}; got {shown(str(path))}.",
            hint=f"Write {name}.gif.",
            where=str(path),
        )
    if ending == "mp4" and shutil.which("ffmpeg") is None:
        raise RequestError(
            "An mp4 needs the program ffmpeg, which was not found; a gif does not need it.",
            hint=f"Write {name}.gif, or install ffmpeg.",
            where=str(path),
        )
    return ending


def _refuse(problem: str, raw: object, hint: str, option: str) -> NoReturn:
    given = f"{raw:g}" if isinstance(raw, float) and math.isfinite(raw) else shown(raw)
    raise RequestError(f"{problem}{given}.", hint=hint, where=f"film {option}")


def _read_speed(raw: object) -> float:
    low, high = _SPEEDS
    # excludes bool, which is an int in Python
    if isinstance(raw, int | float) and not isinstance(raw, bool) and low <= raw <= high:
        return float(raw)
    _refuse(
        f"The speed of a film must be from {low:g} to {high:g}: seconds of the motion per second of the film; "
        "got ",
        raw, "Write 1 for real time, or 0.1 for a film ten times slower.", "speed",
    )  # fmt: skip


def _read_rate(raw: object, most: int, ending: str) -> int:
    if isinstance(raw, int | np.integer) and not isinstance(raw, bool) and 1 <= raw <= most:
        return int(raw)
    _refuse(
        f"The frames per second of a film must be a whole number from 1 to {most} for {ending}; got fps=",
        raw, f"Write {min(25, most)}, or {most} for a smoother film.", "fps",
    )  # fmt: skip


def _read_size(raw: object, ending: str) -> tuple[int, int]:
    found = re.fullmatch(r"([0-9]{1,6})x([0-9]{1,6})", raw) if isinstance(raw, str) else None
    numbers = [int(each) for each in found.groups()] if found else raw
    if not isinstance(numbers, tuple | list) or [type(each) for each in numbers] != [int, int]:
        _refuse("The size of a film must be WIDTHxHEIGHT in pixels; got ", raw, "Write 1280x720.", "size")
    if not all(_SMALLEST <= each <= _LARGEST for each in numbers):
        problem = f"Width and height of a film must be from {_SMALLEST} to {_LARGEST} pixels; got "
        _refuse(problem, raw, "Write 1280x720.", "size")
    even = [each + each % 2 for each in numbers]
    if ending == "mp4" and even != [*numbers]:
        hint = f"Write {even[0]}x{even[1]}, or make a gif."
        _refuse("Width and height of an mp4 must be even numbers of pixels; got ", raw, hint, "size")
    return numbers[0], numbers[1]


def _read_camera(raw: object) -> str:
    if isinstance(raw, str) and raw in CAMERAS:
        return raw
    meanings = ", ".join(f"{name} ({what})" for name, what in CAMERAS.items())
    hint = suggestion(raw, tuple(CAMERAS)) or "Write follow, or leave it out."
    _refuse(f"The camera of a film must be one of {meanings}; got ", raw, hint, "camera")


#: Least and usual duration of a film [s] if the speed is chosen automatically.
_SHORTEST, _USUAL = 4.0, 20.0

#: Longest film [s] of a motion that turns so fast that it must be slowed down; the rest is not shown.
_LONGEST = 60.0

#: Film time [s] for which a motion that comes to its end is shown at its end.
_HELD = 1.0

#: Share of the time of a motion -> largest angle [rad] by which the disk may turn between two frames in that share. If
#: it turns by more than half a turn, its painted radius seems to turn backward. In the remaining moments, a nearly flat
#: disk swings its lean round in one sweep, which no frame needs to show.
_TURNS = {0.9: math.pi / 2.0, 0.98: 2.0 * math.pi / 3.0}

#: Largest number of frames: 4 minutes at 25 per second.
MOST_FRAMES = 6000

#: Digits of the speeds that are chosen automatically.
_DIGITS = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)

#: Tolerance within which a number of frames counts as whole, because of rounding.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Timing:
    """The times of the frames of a film.

    `moments` are the times of the frames [s], shape (n,). `speed` is the time of the motion divided by the time of the
    film. `turn` is the angle [rad] by which the disk turns between two frames, except in its fastest fiftieth. `shown`
    and `length` are the duration that the film shows and the whole duration of the motion [s]; `to_its_end` says that a
    partial film shows the last part instead of the first.
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
        """Whether the film shows the whole motion."""
        return self.shown >= self.length

    @property
    def aliased(self) -> bool:
        """Whether the disk turns so far between two frames that it seems to turn wrongly."""
        return self.turn > max(_TURNS.values()) * (1.0 + _ROUNDING)

    def words(self) -> str:
        """Return speed and limits of the film in words, for the user."""
        speed = "in real time" if self.speed == 1.0 else f"at {self.speed:g} times real time"
        text = f"{counted(self.moments.size, 'frame')}, {self.moments.size / self.fps:.3g} s {speed}"
        if not self.whole:
            text += f"; it shows the {'last' if self.to_its_end else 'first'} {self.shown:.4g} s of {self.length:.4g} s"
        if self.aliased:
            text += (
                f"; the disk turns by {math.degrees(self.turn):.0f} deg between two frames, more than "
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
    The disk turns about its own axis, at roll rate + precession rate sin(tilt), and its plane turns about the vertical,
    at the precession rate.
    """
    times = dataset[TIME.name].values
    length = float(times[-1] - times[0])
    rates = _turning(dataset)
    speed = _choose_speed(length, rates, options.fps) if options.speed is None else options.speed
    longest = MOST_FRAMES if options.speed is not None else min(MOST_FRAMES, round(_LONGEST * options.fps))
    step = speed / options.fps
    count = math.ceil(length / step * (1.0 - _ROUNDING)) + 1
    # at least two frames, so that a film has a duration
    count = max(2, min(count, longest))
    # the last frame shows the end, even if it is nearer than the others
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
        # near a pole, heading and roll both turn the body about the vertical, so the heading is not enough
        rates = np.hypot(own, np.hypot(dataset["tilt_rate"].values, precession * np.cos(tilt)))
    else:
        rates = np.maximum(np.abs(precession), own)
    if not kind.stops:
        return np.asarray(rates)
    times = dataset[TIME.name].values
    return np.asarray(np.interp(np.linspace(times[0], times[-1], times.size), times, rates))


def _choose_speed(length: float, rates: Array, fps: int) -> float:
    """Return the speed for a film of suitable duration that shows the turning of the disk faithfully."""
    wanted = length / _SHORTEST if length < _SHORTEST else max(1.0, length / _USUAL)
    for share, turn in _TURNS.items():
        rate = float(np.quantile(rates, share))
        if wanted * rate > turn * fps:
            wanted = turn * fps / rate
    decade = 10.0 ** math.floor(math.log10(wanted) + _ROUNDING)
    digit = max(each for each in _DIGITS if each * decade <= wanted * (1.0 + _ROUNDING))
    # rounds to its decimal form: 0.3, not 3 * 0.1
    return float(f"{digit * decade:.3g}")
