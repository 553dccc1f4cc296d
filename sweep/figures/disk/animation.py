"""A film of one motion: the disk with its painted radius in perspective, and the trail of the contact point."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from sweep.figures.disk.captions import nice_length
from sweep.figures.disk.disk_3d import Camera, Pose, draw_disk, draw_floor, draw_trail, frame_picture
from sweep.figures.disk.film_files import write_gif, write_mp4
from sweep.figures.disk.film_options import FilmOptions
from sweep.figures.disk.film_timing import Timing, timing
from sweep.figures.disk.film_words import FilmWords
from sweep.figures.disk.motion_plots import SHADE, poses_at
from sweep.figures.disk.view import dots_per_inch, view
from sweep.figures.drawing import styled
from sweep.files.publish import published
from sweep.model.quantity import Array
from sweep.motion.contact import rolling_limit
from sweep.motion.sampling import closely_sampled
from sweep.motion.tables import TIME

if TYPE_CHECKING:
    import xarray as xr

#: Called with the number of frames that are drawn, and of all frames.
Progress = Callable[[int, int], None]

#: The trail of the contact point fades in this time of the film [s].
_TRAIL = 4.0

#: Side of the squares of the floor at most, and how far it is drawn, over the radius of the scene.
_SQUARE, _FLOOR = 0.25, 2.4


def save(
    dataset: "xr.Dataset", path: str | Path, options: FilmOptions, progress: Progress | None = None
) -> Timing:
    """Draw the film of a motion, frames evenly spaced in time; the file appears only when it is complete.

    Parameters
    ----------
    dataset : xarray.Dataset
        A motion, as `sweep.simulate` returns it, or a stretch of it in time. One whose samples are too far apart to be
        drawn through is computed again with closer ones.
    path : str or Path
        mp4 or gif; a file of the same name is replaced.
    options : FilmOptions
        Of this path.
    progress : callable, optional
        Called with (frames done, frames in all) after every frame.

    Returns
    -------
    Timing
        How fast it plays, and how much of the motion is in it.

    Raises
    ------
    RequestError
        If the dataset is no motion, or the file cannot be written.
    """
    motion = closely_sampled(dataset)
    times = timing(motion, options)
    with published(Path(path)) as unfinished:
        frames = _frames(motion, times, options, progress)
        if options.ending == "mp4":
            write_mp4(frames, options.size, times.fps, unfinished)
        else:
            write_gif(frames, times.moments.size, times.fps, unfinished)
    return times


def _frames(
    dataset: "xr.Dataset", times: Timing, options: FilmOptions, progress: Progress | None = None
) -> Iterator[Array]:
    """Yield the pictures of a film as arrays of dots, shape (height, width, 4), uint8."""
    poses = poses_at(dataset, times.moments)
    limit = rolling_limit(dataset)
    trail = _Trail(dataset, _TRAIL * times.speed)
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
            _draw_frame(axes, pose, camera, shot.reach, spacing, trail.until(moment, pose))
            words.write(moment)
            canvas.draw()  # type: ignore[no-untyped-call]  # matplotlib types only a part
            yield np.array(canvas.buffer_rgba())  # type: ignore[no-untyped-call]  # likewise
            if progress is not None:
                progress(done, len(poses))


def _sheet(size: tuple[int, int]) -> Figure:
    """Return an empty figure of so many dots: larger pictures show the same, with thicker lines and larger words."""
    dots = dots_per_inch(size)
    # a hundredth of a dot more, because matplotlib cuts the product of inches and dots per inch off
    return Figure(figsize=((size[0] + 0.01) / dots, (size[1] + 0.01) / dots), dpi=dots)


def _draw_frame(
    axes: Any, pose: Pose, camera: Camera, reach: float, spacing: float, trail: tuple[Array, Array, Array]
) -> None:
    """Draw the disk on a floor of squares, with the trail of its contact point: x, y [m] and strength."""
    far = _FLOOR * reach
    draw_floor(axes, camera, camera.target, far, spacing)
    # points behind the camera cannot be projected, and points far from the scene are not in the picture
    x, y, strength = trail
    near = np.hypot(x - camera.target[0], y - camera.target[1]) < far
    draw_trail(axes, camera, np.where(near, x, np.nan), np.where(near, y, np.nan), strength)
    draw_disk(axes, camera, pose)


class _Trail:
    """The path of the contact point in the last seconds of a motion, fading with its age."""

    def __init__(self, dataset: "xr.Dataset", age: float) -> None:
        """Take a motion and the time [s] in which a trail fades."""
        self._times, self._x, self._y = (
            dataset[name].values for name in (TIME.name, "contact_x", "contact_y")
        )
        self._age = age

    def until(self, moment: float, pose: Pose) -> tuple[Array, Array, Array]:
        """Return x, y [m] and strength, from 0 to 1, of the points up to a moment [s], when the disk is at `pose`."""
        first, last = np.searchsorted(self._times, [moment - self._age, moment])
        age = np.append(moment - self._times[first:last], 0.0)
        return (
            np.append(self._x[first:last], pose.x),
            np.append(self._y[first:last], pose.y),
            np.clip(1.0 - age / self._age, 0.0, 1.0),
        )
