"""A film of one motion: the disk with its painted radius in perspective, and the trail of the contact point."""

import math
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.text import Text

from sweep.errors import plain_text
from sweep.figures.disk.body_3d import shades
from sweep.figures.disk.captions import caption, nice_length, spell_length
from sweep.figures.disk.disk_3d import (
    FACE_STRENGTH,
    FACES,
    FLOOR,
    INK,
    SHADOW,
    SHADOW_STRENGTH,
    TRACE,
    Camera,
    Placed,
    dots_per_inch,
    draw_floor,
    draw_trail,
    frame_picture,
    view,
)
from sweep.figures.disk.film_options import FilmOptions, Timing, timing
from sweep.figures.disk.motion_plots import poses_at
from sweep.figures.panels_in_time import SHADE
from sweep.figures.sheet import styled
from sweep.figures.texts import fitted, wrapped
from sweep.files.publish import published
from sweep.model.quantity import Array
from sweep.motion.contact import RollingLimit, rolling_limit
from sweep.motion.sampling import closely_sampled, is_of_body, kind_of
from sweep.motion.tables import TIME

if TYPE_CHECKING:
    import xarray as xr

#: Function that is called with the number of frames drawn so far, and of all frames.
Progress = Callable[[int, int], None]

#: Film time [s] in which the trail of the contact point fades.
_TRAIL = 4.0

#: Largest side of the squares of the floor, and radius of the floor, in radii of the scene.
_SQUARE, _FLOOR = 0.25, 2.4

#: Time [s] for which a gif shows its last frame before it starts again.
_HELD = 1.5

#: Colour of the warning about impossible rolling.
WARNING = "#a02c00"

#: Colours of a gif on paper and shadow, and on a face of the disk -> number of shades, which smooth the edges of lines
#: and letters and let the trail fade. A gif has at most 256 colours.
_OVER_PAPER = {"black": 6, INK: 1, FLOOR: 2, TRACE: 10, WARNING: 4}
_OVER_FACE = {INK: 4, TRACE: 4, "white": 3}

#: Font sizes [points] of a narrow picture, and of one at least `_WIDE` inches wide. A caption that is too long is
#: written smaller, down to the last factor, and then in several lines.
_WORDS, _WIDE, _SMALLER = (9.0, 12.0), 6.4, 0.8

#: Font size of the title, divided by that of the other text.
_TITLE = 1.1

#: Position of the text [in] from the left, from the top and from the bottom; position of the caption below a one-line
#: title, and the height of a line at the bottom.
_LEFT, _FROM_ABOVE, _FROM_BELOW, _CAPTION, _LINE = 0.16, 0.12, 0.14, 0.36, 0.24

#: Gap between lines of different font sizes, and margin around the text [in].
_GAP = 0.06

#: Least height of the text of a picture [in] at the top and the bottom: most films have the same.
_ROOM = 0.62, 0.55

#: Largest number of lines of a title, a caption or a warning.
_MOST_LINES = 5

#: The longest text that gives the side of the squares of a floor.
_LONGEST_SIDE = "squares of 500 mm"


def save(
    dataset: "xr.Dataset", path: str | Path, options: FilmOptions, progress: Progress | None = None
) -> Timing:
    """Draw the film of a motion, with frames evenly spaced in time. The file appears only when it is complete.

    Parameters
    ----------
    dataset : xarray.Dataset
        A motion, as `sweep.simulate` returns it, or an interval of it. If its samples are too far apart to draw, the
        motion is computed again with closer ones.
    path : str or Path
        An mp4 or gif file; replaces a file of the same name.
    options : FilmOptions
        The options that were read for this path.
    progress : callable, optional
        Called with (frames done, all frames) after every frame.

    Returns
    -------
    Timing
        The speed of the film, and how much of the motion it shows.

    Raises
    ------
    RequestError
        If the dataset is not a motion, or the file cannot be written.
    """
    motion = closely_sampled(dataset)
    times = timing(motion, options)
    with published(Path(path)) as unfinished:
        frames = _frames(motion, times, options, progress)
        if options.ending == "mp4":
            write_mp4(frames, options.size, times.fps, unfinished)
        else:
            more = shades() if is_of_body(motion) else None
            write_gif(frames, times.moments.size, times.fps, unfinished, more)
    return times


def _frames(
    dataset: "xr.Dataset", times: Timing, options: FilmOptions, progress: Progress | None = None
) -> Iterator[Array]:
    """Yield the pictures of a film as arrays of pixels, shape (height, width, 4), uint8."""
    poses = poses_at(dataset, times.moments)
    limit = rolling_limit(dataset)
    with styled():
        drawn = _sheet(options.size)
        canvas = FigureCanvasAgg(drawn)
        axes = drawn.add_axes((0.0, 0.0, 1.0, 1.0))
        words = FilmWords(drawn, dataset, times, limit)
        shot = view(dataset, poses, options.size, options.camera, words.room)
        frame_picture(axes, shot.low, shot.high)
        words.scale(spacing := nice_length(_SQUARE * shot.reach))
        frames = zip(times.moments.tolist(), poses, shot.cameras, strict=True)
        for done, (moment, pose, camera) in enumerate(frames, 1):
            drawn.patch.set_facecolor(SHADE if moment >= limit.time else "white")
            # faster than new axes for every frame
            for artist in [*axes.lines, *axes.collections, *axes.patches]:
                artist.remove()
            _draw_frame(
                axes, pose, camera, shot.reach, spacing, _trail(dataset, moment, pose, _TRAIL * times.speed)
            )
            words.write(moment)
            canvas.draw()  # type: ignore[no-untyped-call]  # matplotlib types only a part
            yield np.array(canvas.buffer_rgba())  # type: ignore[no-untyped-call]  # likewise
            if progress is not None:
                progress(done, len(poses))


def _sheet(size: tuple[int, int]) -> Figure:
    """Return an empty figure of a size [pixels]; larger pictures show the same with thicker lines and larger text."""
    dots = dots_per_inch(size)
    # 0.01 of a pixel more, because matplotlib truncates the product of inches and dots per inch
    return Figure(figsize=((size[0] + 0.01) / dots, (size[1] + 0.01) / dots), dpi=dots)


def _draw_frame(
    axes: Any, pose: Placed, camera: Camera, reach: float, spacing: float, trail: tuple[Array, Array, Array]
) -> None:
    """Draw the disk on a floor of squares, with the trail of its contact point: x, y [m] and strength."""
    far = _FLOOR * reach
    draw_floor(axes, camera, camera.target, far, spacing)
    # points behind the camera cannot be projected, and points far from the scene are not in the picture
    x, y, strength = trail
    near = np.hypot(x - camera.target[0], y - camera.target[1]) < far
    draw_trail(axes, camera, np.where(near, x, np.nan), np.where(near, y, np.nan), strength)
    pose.draw(axes, camera)


def _trail(dataset: "xr.Dataset", moment: float, pose: Placed, age: float) -> tuple[Array, Array, Array]:
    """Return x, y [m] and strength, from 0 to 1, of the path of the contact point up to a moment [s].

    The path ends at the disk at `pose`, and fades over a time `age` [s] of the motion.
    """
    times = dataset[TIME.name].values
    first, last = np.searchsorted(times, [moment - age, moment])
    x, y = (
        np.append(dataset[name].values[first:last], at)
        for name, at in (("contact_x", pose.x), ("contact_y", pose.y))
    )
    return x, y, np.clip(1.0 - (moment - np.append(times[first:last], moment)) / age, 0.0, 1.0)


def write_gif(
    frames: Iterator[Array], count: int, fps: int, unfinished: Path, more: Array | None = None
) -> None:
    """Write frames as a gif that repeats.

    Parameters
    ----------
    frames : iterator of array, shape (height, width, 4), uint8
    count : int
        Number of frames.
    fps : int
        Frames per second.
    unfinished : Path
        An empty file, in which the gif is written.
    more : array, shape (n, 3), optional
        Colours, red, green and blue from 0 to 1, that are drawn in addition to `colours`.
    """
    from PIL import Image

    palette = Image.new("P", (1, 1))
    found = colours()
    if more is not None:
        found = np.unique(np.concatenate([found, np.round(255.0 * more).astype(np.uint8)]), axis=0)
    palette.putpalette(found.ravel().tolist())
    # the same colours for all frames, without dithering: half the size, a twentieth of the time, and no flicker
    pictures = (
        Image.fromarray(frame[..., :3]).quantize(palette=palette, dither=Image.Dither.NONE)
        for frame in frames
    )
    # gifs count hundredths of a second; rounding the sums keeps the film's duration
    ends = np.round(100.0 * np.arange(count + 1) / fps) * 10.0
    durations = np.diff(ends).astype(int).tolist()
    durations[-1] += round(1000.0 * _HELD)
    # opens the file here, because Pillow leaves its own file open when the frames end early
    with open(unfinished, "rb+") as file:
        next(pictures).save(
            file, format="GIF", save_all=True, append_images=pictures, duration=durations, loop=0
        )


def write_mp4(frames: Iterator[Array], size: tuple[int, int], fps: int, path: Path) -> None:
    """Write frames, arrays of shape (height, width, 4), uint8, as an mp4 of a size (width, height) [pixels].

    Raises
    ------
    OSError
        If ffmpeg fails; contains its message.
    """
    shape = "x".join(map(str, size))
    raw = ["-f", "rawvideo", "-pixel_format", "rgba", "-video_size", shape, "-framerate", str(fps)]
    # yuv420p, because many players support nothing else; names the container, because the temporary file has no
    # extension
    made = ["-pix_fmt", "yuv420p", "-movflags", "+faststart", "-f", "mp4", str(path)]
    command = ["ffmpeg", "-loglevel", "error", "-y", *raw, "-i", "-", *made]
    # not matplotlib's FFMpegWriter: if Ctrl-C also ends ffmpeg, its error would replace the interruption
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as encoder:
        assert encoder.stdin is not None
        try:
            for frame in frames:
                encoder.stdin.write(frame.tobytes())
        except BrokenPipeError:
            pass  # ffmpeg has ended: its message is read below
        except BaseException:
            encoder.kill()
            raise
        _, words = encoder.communicate()
    if encoder.returncode != 0:
        raise OSError(f"ffmpeg: {words.decode(errors='replace').strip()}")


def colours() -> npt.NDArray[np.uint8]:
    """Return the colours of a gif and blends between them, red, green and blue, shape (n, 3)."""
    found = []
    for paper in ("white", SHADE):
        for base in (to_rgb(paper), _blend(paper, SHADOW, SHADOW_STRENGTH)):
            found += [base, *_blends(base, _OVER_PAPER)]
        for face in FACES:
            seen = _blend(paper, face, FACE_STRENGTH)
            found += [seen, *_blends(seen, _OVER_FACE)]
    return np.unique(np.round(255.0 * np.array(found)), axis=0).astype(np.uint8)


def _blends(under: Any, over: dict[str, int]) -> Iterator[tuple[float, ...]]:
    for colour, count in over.items():
        for i in range(1, count + 1):
            yield _blend(under, colour, i / count)


def _blend(under: Any, over: Any, share: float) -> tuple[float, ...]:
    return tuple((1.0 - share) * a + share * b for a, b in zip(to_rgb(under), to_rgb(over), strict=True))


class FilmWords:
    """The texts of a film on its sheet.

    Parameters
    ----------
    drawn : Figure
        The sheet of all frames.
    dataset : xarray.Dataset
        The motion.
    times : Timing
    limit : RollingLimit

    Attributes
    ----------
    room : (float, float)
        Height of the texts at the top and the bottom [in], including margins.
    """

    def __init__(self, drawn: Figure, dataset: "xr.Dataset", times: Timing, limit: RollingLimit) -> None:
        self._drawn, self._limit, self._start = drawn, limit, float(dataset[TIME.name][0])
        self._called = kind_of(dataset).called
        self._width, self._height = drawn.get_size_inches()
        self._letter = min(max(_WORDS[0], _WORDS[1] * self._width / _WIDE), _WORDS[1])
        self._speed = "real time" if times.speed == 1.0 else f"{times.speed:g} \u00d7 real time"
        # enough decimals to distinguish one frame from the next
        self._decimals = max(0, math.ceil(-math.log10(times.speed / times.fps) - 1e-9))
        above = self._write_above(plain_text(dataset.attrs.get("title", "")), caption(dataset))
        self.room = above, self._write_below(float(times.moments[-1]))

    def scale(self, spacing: float) -> None:
        """Write the side of the squares of the floor [m]."""
        self._squares.set_text(f"squares of {spell_length(spacing)}")

    def write(self, moment: float) -> None:
        """Write the texts that depend on the moment [s]."""
        self._time.set_text(self._time_text(moment))
        self._impossible.set_text(self._impossible_text(moment))

    def _text(self, x: float, y: float, text: str, size: float, **look: Any) -> Text:
        """Write text [in] from the left, and from the bottom if `y` is above 0, otherwise from the top."""
        up = y if y > 0.0 else self._height + y
        return self._drawn.text(
            x / self._width, up / self._height, text, parse_math=False, fontsize=size, **look
        )

    def _across(self) -> float:
        return float(self._width) - 2.0 * _LEFT

    def _write_above(self, title: str, words: str) -> float:
        """Write title and caption; return their height [in]."""
        size = _TITLE * self._letter
        lines = wrapped(title, size, self._across(), most=_MOST_LINES)
        bold = self._text(_LEFT, -_FROM_ABOVE, lines, size, fontweight="bold", va="top")
        begin = max(_CAPTION, _FROM_ABOVE + self._high(bold) + _GAP)
        size, lines = self._caption(words)
        small = self._text(_LEFT, -begin, lines, size, va="top")
        return max(_ROOM[0], begin + self._high(small) + _GAP)

    def _caption(self, words: str) -> tuple[float, str]:
        """Return the font size of a caption, and its lines."""
        sizes = (self._letter * share for share in (1.0, 0.9, _SMALLER))
        for size in sizes:
            if fitted(words, size, self._across(), "normal") == words:
                return size, words
        return size, wrapped(words, size, self._across(), "normal", _MOST_LINES)

    def _write_below(self, last: float) -> float:
        """Write the constant texts, and reserve space for the others; return the total height [in]."""
        size, up = self._letter, _FROM_BELOW
        beside = f"{self._time_text(last)}   {_LONGEST_SIDE}"
        self._time = self._text(_LEFT, up, "", size)
        if fitted(beside, size, self._across(), "normal") == beside:
            self._squares = self._text(self._width - _LEFT, up, _LONGEST_SIDE, size, ha="right")
        else:
            up += _LINE
            self._squares = self._text(_LEFT, up, _LONGEST_SIDE, size)
        self._impossible = self._text(_LEFT, up + _LINE, "", size, color=WARNING)
        self._impossible.set_text(self._impossible_text(last))
        return max(_ROOM[1], up + _LINE + self._high(self._impossible) + _GAP)

    def _high(self, text: Text) -> float:
        """Return the height of a text [in]."""
        return float(text.get_window_extent().height) / self._drawn.dpi if text.get_text() else 0.0

    def _time_text(self, moment: float) -> str:
        return f"{TIME.symbol} = {moment:.{self._decimals}f} {TIME.units}   ({self._speed})"

    def _impossible_text(self, moment: float) -> str:
        limit, text = self._limit, ""
        if limit.lifts_off is not None and moment >= limit.lifts_off:
            text = f"Impossible: the {self._called} would have lifted off {limit.when(limit.lifts_off, self._start)}"
        elif limit.slips is not None and moment >= limit.slips:
            text = f"Impossible: the {self._called} would have slipped {limit.when(limit.slips, self._start)}"
        return wrapped(text, self._letter, self._across(), "normal", _MOST_LINES)
