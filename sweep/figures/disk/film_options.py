"""What can be asked of a film, read and refused before anything is computed or drawn."""

import math
import re
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from sweep.errors import RequestError, shown
from sweep.request.suggestions import suggestion

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
    ending = Path(path).suffix.lower().removeprefix(".")
    name = Path(path).stem or "disk"
    if ending not in _RATES:
        raise RequestError(
            f"The name of a film ends in {' or '.join(f'.{each}' for each in _RATES)}; got {path}.",
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


def _read_speed(raw: object) -> float:
    low, high = _SPEEDS
    # not bool, which is an int to Python
    if isinstance(raw, int | float) and not isinstance(raw, bool) and low <= raw <= high:
        return float(raw)
    raise RequestError(
        f"The speed of a film is a number from {low:g} to {high:g}: seconds of the motion in a second of the film; "
        f"got {_given(raw)}.",
        hint="Write 1 for real time, 0.1 for a film that is ten times slower.",
        where="film speed",
    )


def _read_rate(raw: object, most: int, ending: str) -> int:
    if isinstance(raw, int) and not isinstance(raw, bool) and 1 <= raw <= most:
        return raw
    raise RequestError(
        f"The frames per second of a film are a whole number, of {ending} from 1 to {most}; got fps={_given(raw)}.",
        hint=f"Write {min(25, most)}, or {most} for a smoother one.",
        where="film fps",
    )


def _read_size(raw: object, ending: str) -> tuple[int, int]:
    numbers = _two_numbers(raw)
    wrong = ""
    if numbers is None:
        wrong = "The size of a film is WIDTHxHEIGHT in dots"
    elif not all(_SMALLEST <= each <= _LARGEST for each in numbers):
        wrong = f"Width and height of a film are from {_SMALLEST} to {_LARGEST} dots"
    elif ending == "mp4" and any(each % 2 for each in numbers):
        even = "x".join(str(each + each % 2) for each in numbers)
        raise RequestError(
            f"Width and height of an mp4 are even numbers of dots; got {_given(raw)}.",
            hint=f"Write {even}, or make a gif.",
            where="film size",
        )
    if numbers is None or wrong:
        raise RequestError(f"{wrong}; got {_given(raw)}.", hint="Write 1280x720.", where="film size")
    return numbers


def _two_numbers(raw: object) -> tuple[int, int] | None:
    if isinstance(raw, str):
        found = re.fullmatch(r"([0-9]{1,6})x([0-9]{1,6})", raw)
        return (int(found[1]), int(found[2])) if found else None
    if isinstance(raw, tuple | list) and len(raw) == 2 and all(type(each) is int for each in raw):
        return raw[0], raw[1]
    return None


def _read_camera(raw: object) -> str:
    if isinstance(raw, str) and raw in CAMERAS:
        return raw
    meanings = ", ".join(f"{name} ({what})" for name, what in CAMERAS.items())
    raise RequestError(
        f"The camera of a film is one of {meanings}; got {_given(raw)}.",
        hint=suggestion(raw, tuple(CAMERAS)) or "Write follow, or leave it out.",
        where="film camera",
    )


def _given(raw: object) -> str:
    """Return what was given, numbers short."""
    return f"{raw:g}" if isinstance(raw, float) and math.isfinite(raw) else shown(raw)
