"""Write the frames of a film to a file: gif by Pillow, mp4 by the program ffmpeg."""

import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.colors import to_rgb

from sweep.figures.disk.disk_3d import FACE_STRENGTH, FACES, FLOOR, INK, SHADOW, SHADOW_STRENGTH, TRACE
from sweep.figures.disk.motion_plots import SHADE
from sweep.model.quantity import Array

#: How long the last frame of a gif is shown [s] before it begins again.
_HELD = 1.5

#: Colour of the words about what is impossible.
WARNING = "#a02c00"

#: What a gif shows over paper and shadow, and over a face of the disk -> in how many strengths: they smooth the edges
#: of lines and words, and let a trail fade. A gif has 256 colours at most.
_OVER_PAPER = {"black": 6, INK: 1, FLOOR: 2, TRACE: 10, WARNING: 4}
_OVER_FACE = {INK: 4, TRACE: 4, "white": 3}


def write_gif(frames: Iterator[Array], count: int, fps: int, unfinished: Path) -> None:
    """Write frames as a gif that begins again.

    Parameters
    ----------
    frames : iterator of array, shape (height, width, 4), uint8
    count : int
        How many there are.
    fps : int
        Frames per second.
    unfinished : Path
        An empty file.
    """
    from PIL import Image

    palette = Image.new("P", (1, 1))
    palette.putpalette(colours().ravel().tolist())
    # the same colours for all frames, and no dither: half the size, a twentieth of the time, and nothing flickers
    pictures = (
        Image.fromarray(frame[..., :3]).quantize(palette=palette, dither=Image.Dither.NONE)
        for frame in frames
    )
    # in whole hundredths of a second, which are rounded so that the film keeps its time
    ends = np.round(100.0 * np.arange(count + 1) / fps) * 10.0
    durations = np.diff(ends).astype(int).tolist()
    durations[-1] += round(1000.0 * _HELD)
    # opened here, because Pillow leaves its own file open when the frames end early
    with open(unfinished, "rb+") as file:
        next(pictures).save(
            file, format="GIF", save_all=True, append_images=pictures, duration=durations, loop=0
        )


def write_mp4(frames: Iterator[Array], size: tuple[int, int], fps: int, path: Path) -> None:
    """Write frames, arrays of shape (height, width, 4), uint8, as an mp4 of a size (width, height) [dots].

    Raises
    ------
    OSError
        If ffmpeg fails, with its words.
    """
    shape = "x".join(map(str, size))
    raw = ["-f", "rawvideo", "-pixel_format", "rgba", "-video_size", shape, "-framerate", str(fps)]
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


def colours() -> npt.NDArray[np.uint8]:
    """Return the colours of a gif, red, green and blue, shape (n, 3): all that are drawn, and what is between them."""
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
