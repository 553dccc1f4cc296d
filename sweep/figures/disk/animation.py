"""A film of one motion: the disk with its painted radius in perspective, and the trace of the contact point."""

import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from sweep.errors import RequestError
from sweep.figures.disk.disk_3d import Camera, Pose, draw_disk, draw_floor, draw_trace, frame_picture
from sweep.figures.disk.motion_plots import poses_at
from sweep.figures.drawing import styled
from sweep.files.publish import published
from sweep.model.quantity import Array
from sweep.motion.request import TIME

if TYPE_CHECKING:
    import xarray as xr

#: Called with the number of frames that are drawn, and of all frames.
Progress = Callable[[int, int], None]

#: File name extension -> frames per second. A gif counts time in hundredths of a second, and its frames are large.
_RATES = {"mp4": 25, "gif": 20}

#: Largest number of frames: a longer motion is shown faster than real time. The picture shows the time of the motion.
_MOST_FRAMES = 600

#: Size of the picture [in] and dots per inch: mp4 requires even numbers of dots.
_WIDTH, _HEIGHT, _DOTS_PER_INCH = 6.4, 4.8, 100

#: Extent of a path, in radii, up to which all of it is in the picture; along a longer one the camera follows the disk.
_WHOLE = 6.0


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


def save(dataset: "xr.Dataset", path: str | Path, progress: Progress | None = None) -> None:
    """Draw the film of a motion, frames evenly spaced in time; the file appears only when it is complete.

    Parameters
    ----------
    dataset : xarray.Dataset
        A motion, as `sweep.simulate` returns it.
    path : str or Path
        mp4 or gif; a file of the same name is replaced.
    progress : callable, optional
        Called with (frames done, frames in all) after every frame.

    Raises
    ------
    RequestError
        As in `check_format`, or if the file cannot be written.
    """
    ending = check_format(path)
    length = float(dataset[TIME.name][-1])
    count = max(2, min(_MOST_FRAMES, round(length * _RATES[ending]) + 1))
    with published(Path(path)) as unfinished:
        write = _mp4 if ending == "mp4" else _gif
        write(_frames(dataset, np.linspace(0.0, length, count), progress), unfinished)


def _frames(dataset: "xr.Dataset", moments: Array, progress: Progress | None) -> Iterator[Array]:
    """Yield pictures of the disk as arrays of dots, shape (height, width, 4), uint8."""
    times, x, y = (dataset[name].values for name in (TIME.name, "contact_x", "contact_y"))
    radius = float(dataset["radius"])
    reach = 0.5 * max(float(np.ptp(x)), float(np.ptp(y)))
    follows = reach > _WHOLE * radius
    middle = np.array([0.5 * (x.min() + x.max()), 0.5 * (y.min() + y.max())])
    size = (0.5 * _WHOLE if follows else reach / radius + 1.6) * radius
    with styled():
        drawn = Figure(figsize=(_WIDTH, _HEIGHT), dpi=_DOTS_PER_INCH)
        canvas = FigureCanvasAgg(drawn)
        for i, pose in enumerate(poses_at(dataset, moments)):
            drawn.clear()
            at = np.array([pose.x, pose.y]) if follows else middle
            passed = np.append(x[times < moments[i]], pose.x), np.append(y[times < moments[i]], pose.y)
            _draw_frame(drawn, pose, at, size, passed)
            drawn.text(0.03, 0.04, TIME.spell(round(float(moments[i]), 2)), fontsize=10.0)
            canvas.draw()  # type: ignore[no-untyped-call]  # matplotlib types only a part
            yield np.array(canvas.buffer_rgba())  # type: ignore[no-untyped-call]  # likewise
            if progress is not None:
                progress(i + 1, moments.size)


def _draw_frame(drawn: Figure, pose: Pose, at: Array, size: float, passed: tuple[Array, Array]) -> None:
    axes = drawn.add_axes((0.0, 0.0, 1.0, 1.0))
    centre = np.array([*at, 0.7 * pose.radius])
    camera = Camera.on(centre, size)
    draw_floor(axes, camera, centre, 2.0 * size, pose.radius)
    # points behind the camera cannot be projected, and points far from the scene are not in the picture
    near = np.hypot(passed[0] - at[0], passed[1] - at[1]) < 2.0 * size
    draw_trace(
        axes, camera, np.where(near, passed[0], np.nan), np.where(near, passed[1], np.nan), linewidth=1.6
    )
    draw_disk(axes, camera, pose)
    half = np.array([1.0, _HEIGHT / _WIDTH]) * 1.05 * size
    frame_picture(axes, -half, half)


def _gif(frames: Iterator[Array], unfinished: Path) -> None:
    from PIL import Image

    # without dither, which would flicker from frame to frame and double the size
    pictures = (Image.fromarray(frame[..., :3]).quantize(64, dither=Image.Dither.NONE) for frame in frames)
    # opened here, because Pillow leaves its own file open when the frames end early
    with open(unfinished, "rb+") as file:
        next(pictures).save(
            file, format="GIF", save_all=True, append_images=pictures, duration=1000 // _RATES["gif"], loop=0
        )


def _mp4(frames: Iterator[Array], path: Path) -> None:
    size = f"{round(_WIDTH * _DOTS_PER_INCH)}x{round(_HEIGHT * _DOTS_PER_INCH)}"
    raw = ["-f", "rawvideo", "-pixel_format", "rgba", "-video_size", size, "-framerate", str(_RATES["mp4"])]
    # yuv420p, because many players support no other; the container is named because the temporary name has no extension
    made = ["-pix_fmt", "yuv420p", "-movflags", "+faststart", "-f", "mp4", str(path)]
    command = ["ffmpeg", "-loglevel", "error", "-y", *raw, "-i", "-", *made]
    # not by matplotlib's FFMpegWriter: where Ctrl-C ends ffmpeg too, its error would replace the interruption
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
