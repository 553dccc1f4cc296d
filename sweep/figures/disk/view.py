"""Where the cameras of a film stand, and which part of their pictures it shows: the whole disk, in every frame."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sweep.figures.disk.disk_3d import Camera, Pose, azimuth_of
from sweep.model.quantity import Array

#: Extent of a path, in radii, up to which a camera that nobody has chosen stands still.
_WHOLE = 20.0

#: A camera that goes along sees this many radii to each side at least.
_AROUND = 2.6

#: Height of the words of a picture [in], above and below.
_ABOVE, _BELOW = 0.62, 0.55

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


def view(poses: Sequence[Pose], size: tuple[int, int], camera: str | None) -> View:
    """Return the view of a film.

    Parameters
    ----------
    poses : sequence of Pose
        The disk in every frame.
    size : (int, int)
        Width and height of the picture [dots].
    camera : str or None
        One of `sweep.figures.disk.film_options.CAMERAS`; None follows a disk that goes far.
    """
    radius = poses[0].radius
    rims = np.stack([pose.rim() for pose in poses])
    far = max(np.ptp([pose.x for pose in poses]), np.ptp([pose.y for pose in poses])) > _WHOLE * radius
    if camera is None:
        camera = "follow" if far else "fixed"
    if camera == "follow":
        cameras, reach = _following(poses)
    else:
        cameras, reach = _standing(poses, rims, camera == "top", far)
    corners = np.array([[-1, -1, 0], [-1, 1, 0], [1, -1, 0], [1, 1, 0]]) * _AROUND * radius
    seen = [each.project(rim) for each, rim in zip(cameras, rims, strict=True)]
    seen += [each.project(rim * [1.0, 1.0, 0.0]) for each, rim in zip(cameras, rims, strict=True)]
    if camera == "follow":
        # the floor around the disk, so that the trail is seen too
        seen.append(cameras[0].project(cameras[0].target * [1.0, 1.0, 0.0] + 0.7 * corners))
    points = np.concatenate(seen)
    return View(cameras, *_framed(points.min(axis=0), points.max(axis=0), size), reach)


def dots_per_inch(size: tuple[int, int]) -> float:
    """Return how many dots of a picture of this size are an inch, which says how large its words are."""
    return max(_LEAST_DOTS, _DOTS_PER_INCH * min(size[0] / _WIDTH, size[1] / _HEIGHT))


def _following(poses: Sequence[Pose]) -> tuple[list[Camera], float]:
    """Return cameras that go along with the centre of the disk, at one height, and the radius of what they look at."""
    radius = poses[0].radius
    reach = _AROUND * radius
    height = 0.5 * max(pose.centre()[2] for pose in poses)
    targets = [np.array([*pose.centre()[:2], height]) for pose in poses]
    first = Camera.on(targets[0], reach, azimuth_of(*np.array(targets).T[:2]))
    return [first.at(target) for target in targets], reach


def _standing(poses: Sequence[Pose], rims: Array, top: bool, far: bool) -> tuple[list[Camera], float]:
    """Return the one camera that sees all rims, shape (frames, n, 3), once for each frame, and the radius of it all."""
    low, high = rims.min(axis=(0, 1)), rims.max(axis=(0, 1))
    centre = 0.5 * (low + high)
    reach = float(np.linalg.norm(rims - centre, axis=-1).max())
    if top:
        # x to the right and y upwards, as on a map
        camera = Camera.on(centre, reach, azimuth=-90.0, elevation=90.0)
    elif far:
        camera = Camera.on(centre, reach, azimuth_of(*np.array([(pose.x, pose.y) for pose in poses]).T))
    else:
        camera = Camera.on(centre, reach)
    return [camera] * len(poses), reach


def _framed(low: Array, high: Array, size: tuple[int, int]) -> tuple[Array, Array]:
    """Return the rectangle of the shape of the picture that holds another one between the words."""
    above, below = (each * dots_per_inch(size) / size[1] for each in (_ABOVE, _BELOW))
    free = np.array([1.0 - 2.0 * _MARGIN, 1.0 - above - below])
    scale = float(((high - low) / (free * size)).max())
    whole = scale * np.array(size, dtype=np.float64)
    # the middle of what is seen is that of the room between the words
    bottom = 0.5 * (low + high) - 0.5 * whole - np.array([0.0, 0.5 * (below - above) * whole[1]])
    return bottom, bottom + whole
