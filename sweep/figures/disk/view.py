"""Where the cameras of a film stand, and which part of their pictures it shows: the whole disk, in every frame."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from sweep.figures.disk.disk_3d import Camera, Pose
from sweep.model.quantity import Array
from sweep.motion.tables import TIME

if TYPE_CHECKING:
    import xarray as xr

#: Extent of a path, in radii, up to which a camera that nobody has chosen stands still.
_WHOLE = 20.0

#: Azimuth of a camera from the direction in which the disk starts [deg]: behind it, to the right, so that a path runs
#: across the picture and a little into it.
_BEHIND = -118.0

#: A roll rate below this one, in units of sqrt(g/R), is rounding, and no direction.
_ROUNDING = 1e-9

#: A camera that goes along sees this many radii to each side at least.
_AROUND = 2.6

#: Height of the words of a picture [in], above and below, if nothing else is said; and the least share of the height
#: that is left for the disk, however many there are.
_ROOM, _LEAST_SHARE = (0.62, 0.55), 0.3

#: A picture of this size has so many dots per inch; the lines and words of a larger one are larger likewise. With fewer
#: dots than the last number, words could not be read.
_WIDTH, _HEIGHT, _DOTS_PER_INCH, _LEAST_DOTS = 640, 480, 100.0, 60.0

#: What is left free around the disk, as a share of what is seen.
_MARGIN = 0.04


@dataclass(frozen=True)
class View:
    """What a film shows: a camera for every frame, and the rectangle of their picture planes [m], shape (2,) each.

    `reach` is the radius of the scene about the target of a camera [m].
    """

    cameras: Sequence[Camera]
    low: Array
    high: Array
    reach: float


def azimuth_at_start(dataset: "xr.Dataset") -> float:
    """Return the azimuth [deg] from which a motion is seen: behind its first direction, to the right.

    It follows from the start, not from the path, so that motions from like starts are seen from the same side.
    """
    unit = math.sqrt(float(dataset["gravity"]) / float(dataset["radius"]))
    backwards = float(dataset["roll_rate"][0]) < -_ROUNDING * unit
    # the track of a disk of heading 0 is the y axis
    track = math.degrees(float(dataset["heading"][0])) + 90.0
    return track + _BEHIND + 180.0 * backwards


def goes_far(dataset: "xr.Dataset") -> bool:
    """Return whether a motion would go far if it went on as it starts: along a circle, or a line.

    Like starts have like circles; the paths of unstable motions differ.
    """
    radius = float(dataset["radius"])
    times = dataset[TIME.name].values
    roll_rate, precession_rate = (abs(float(dataset[name][0])) for name in ("roll_rate", "precession_rate"))
    way = radius * roll_rate * float(times[-1] - times[0])
    # the circle has the radius R |roll rate / precession rate|
    return way > _WHOLE * radius and 2.0 * roll_rate > _WHOLE * precession_rate


def view(
    dataset: "xr.Dataset",
    poses: Sequence[Pose],
    size: tuple[int, int],
    camera: str | None,
    room: tuple[float, float] = _ROOM,
) -> View:
    """Return the view of a film.

    Parameters
    ----------
    dataset : xarray.Dataset
        The motion, whose start says from which side it is seen.
    poses : sequence of Pose
        The disk in every frame.
    size : (int, int)
        Width and height of the picture [dots].
    camera : str or None
        One of `sweep.figures.disk.film_options.CAMERAS`; None follows a disk that `goes_far`.
    room : (float, float)
        Height of the words above and below [in].
    """
    radius = poses[0].radius
    rims = np.stack([pose.rim() for pose in poses])
    if camera is None:
        camera = "follow" if goes_far(dataset) else "fixed"
    azimuth = azimuth_at_start(dataset)
    if camera == "follow":
        cameras, reach = _following(poses, azimuth)
    else:
        cameras, reach = _standing(rims, None if camera == "top" else azimuth)
    corners = np.array([[-1, -1, 0], [-1, 1, 0], [1, -1, 0], [1, 1, 0]]) * _AROUND * radius
    seen = [each.project(rim) for each, rim in zip(cameras, rims, strict=True)]
    seen += [each.project(rim * [1.0, 1.0, 0.0]) for each, rim in zip(cameras, rims, strict=True)]
    if camera == "follow":
        # the floor around the disk, so that the trail is seen too
        seen.append(cameras[0].project(cameras[0].target * [1.0, 1.0, 0.0] + 0.7 * corners))
    points = np.concatenate(seen)
    return View(cameras, *_framed(points.min(axis=0), points.max(axis=0), size, room), reach)


def dots_per_inch(size: tuple[int, int]) -> float:
    """Return how many dots of a picture of this size are an inch, which says how large its words are."""
    return max(_LEAST_DOTS, _DOTS_PER_INCH * min(size[0] / _WIDTH, size[1] / _HEIGHT))


def _following(poses: Sequence[Pose], azimuth: float) -> tuple[list[Camera], float]:
    """Return cameras that go along with the centre of the disk, at one height, and the radius of what they look at."""
    radius = poses[0].radius
    reach = _AROUND * radius
    height = 0.5 * max(pose.centre()[2] for pose in poses)
    targets = [np.array([*pose.centre()[:2], height]) for pose in poses]
    first = Camera.on(targets[0], reach, azimuth)
    return [first.at(target) for target in targets], reach


def _standing(rims: Array, azimuth: float | None) -> tuple[list[Camera], float]:
    """Return the one camera that sees all rims, shape (frames, n, 3), once for each frame, and the radius of it all.

    Without an azimuth it looks down from above.
    """
    low, high = rims.min(axis=(0, 1)), rims.max(axis=(0, 1))
    centre = 0.5 * (low + high)
    reach = float(np.linalg.norm(rims - centre, axis=-1).max())
    if azimuth is None:
        # x to the right and y upwards, as on a map
        camera = Camera.on(centre, reach, azimuth=-90.0, elevation=90.0)
    else:
        camera = Camera.on(centre, reach, azimuth)
    return [camera] * len(rims), reach


def _framed(low: Array, high: Array, size: tuple[int, int], room: tuple[float, float]) -> tuple[Array, Array]:
    """Return the rectangle of the shape of the picture that holds another one between the words."""
    above, below = (each * dots_per_inch(size) / size[1] for each in room)
    free = np.array([1.0 - 2.0 * _MARGIN, max(_LEAST_SHARE, 1.0 - above - below)])
    scale = float(((high - low) / (free * size)).max())
    whole = scale * np.array(size, dtype=np.float64)
    # the middle of what is seen is that of the room between the words
    bottom = 0.5 * (low + high) - 0.5 * whole - np.array([0.0, 0.5 * (below - above) * whole[1]])
    return bottom, bottom + whole
