"""Draw the disk in three dimensions: the positions of its points, and their projection by a camera.

Uses a pinhole camera instead of a 3-D toolkit: true perspective with equal axes. Camera and disk are above the plane,
so nothing on the floor hides the disk: the floor is drawn first.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from matplotlib.patheffects import withStroke

from sweep.model.quantity import Array
from sweep.motion.sampling import kind_of, request_of
from sweep.motion.tables import TIME

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

#: Colours of the two faces of the disk: safe for the colour-blind, and one light and one dark in greyscale.
FACES = ("#f4c95d", "#5a86b8")

#: Colours of the faces where rolling is impossible.
GREY = ("#d9d5cd", "#a5a9ae")

#: Colours of the edge of the disk, of its painted radius and the path of the contact point, of the squares of the
#: floor, and of the shadow.
INK, TRACE, FLOOR, SHADOW = "#222222", "#c8380a", "0.86", "0.3"

#: Opacity of shadow and face: both let the floor show through a little.
SHADOW_STRENGTH, FACE_STRENGTH = 0.18, 0.92

_CORNERS = 96

#: Distance of the camera, in radii of the scene: near enough for a visible perspective.
_DISTANCE = 3.4

#: Longest path, in radii, for which the default camera does not move.
_WHOLE = 20.0

#: Azimuth of the camera, relative to the direction in which the disk starts [deg]: behind it and to the right, so that
#: a path runs across the picture and a little into it.
_BEHIND = -118.0

#: A roll rate below this, in units of sqrt(g/R), is rounding error and gives no direction.
_ROUNDING = 1e-9

#: A following camera sees at least this many radii to each side.
_AROUND = 2.6

#: Default height of the text of a picture [in], at the top and the bottom; and the least share of the height that
#: remains for the disk, however much text there is.
_ROOM, _LEAST_SHARE = (0.62, 0.55), 0.3

#: Size of the reference picture and its dots per inch; larger pictures have larger lines and text in proportion. With
#: fewer dots per inch than the last number, text would be illegible.
_WIDTH, _HEIGHT, _DOTS_PER_INCH, _LEAST_DOTS = 640, 480, 100.0, 60.0

#: Free margin around the disk, as a share of the picture.
_MARGIN = 0.04


@dataclass(frozen=True)
class Pose:
    """One position of the disk: tilt, heading, roll angle [rad], contact point [m], radius [m]."""

    tilt: float
    heading: float
    roll_angle: float
    x: float
    y: float
    radius: float

    def _frame(self) -> tuple[Array, Array, Array]:
        """Return the centre, and the unit vectors from it to the contact point and along the track."""
        across = np.array([np.cos(self.heading), np.sin(self.heading), 0.0])
        along = np.array([-np.sin(self.heading), np.cos(self.heading), 0.0])
        down = -(np.sin(self.tilt) * across + np.cos(self.tilt) * np.array([0.0, 0.0, 1.0]))
        return np.array([self.x, self.y, 0.0]) - self.radius * down, down, along

    def centre(self) -> Array:
        """Centre of the disk, shape (3,)."""
        return self._frame()[0]

    def rim(self) -> Array:
        """Points of the rim, shape (n, 3)."""
        centre, down, along = self._frame()
        angle = np.linspace(0.0, 2.0 * np.pi, _CORNERS)[:, None]
        return np.asarray(centre + self.radius * (np.cos(angle) * down + np.sin(angle) * along))

    def painted(self) -> Array:
        """Centre and rim end of the painted radius, shape (2, 3); at roll angle 0, it points to the plane."""
        centre, down, along = self._frame()
        # relative to the centre, the lowest point of a disk that rolls forward moves backward
        direction = np.cos(self.roll_angle) * down - np.sin(self.roll_angle) * along
        return np.array([centre, centre + self.radius * direction])

    def draw(self, axes: "Axes", camera: "Camera", strength: float = 1.0, *, believed: bool = True) -> None:
        """Draw the disk in this position; see `draw_disk`."""
        draw_disk(axes, camera, self, strength, believed=believed)

    def faces(self, eye: Array) -> bool:
        """Return whether the face on the side of cross(down, along) is visible from a point `eye`."""
        centre, down, along = self._frame()
        return bool(np.cross(down, along) @ (eye - centre) > 0.0)


@dataclass(frozen=True)
class Camera:
    """A pinhole camera: its position, its target, and the right of its picture, each of shape (3,)."""

    eye: Array
    target: Array
    right: Array

    @classmethod
    def on(cls, centre: Array, size: float, azimuth: float, elevation: float = 24.0) -> "Camera":
        """Return a camera that looks at a scene of radius `size`, from an azimuth and an elevation [deg]."""
        a, e = np.radians([azimuth, elevation])
        ray = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
        return cls(centre + _DISTANCE * size * ray, centre, np.array([-np.sin(a), np.cos(a), 0.0]))

    def at(self, target: Array) -> "Camera":
        """Return the camera moved to another target, which it sees from the same side."""
        return Camera(self.eye + (target - self.target), target, self.right)

    def project(self, points: Array) -> Array:
        """Return points, shape (..., 3), in the picture plane through the target, shape (..., 2), in m."""
        ahead = self.target - self.eye
        distance = float(np.linalg.norm(ahead))
        ahead = ahead / distance
        seen = points - self.eye
        depth = seen @ ahead
        return (
            np.stack([seen @ self.right, seen @ np.cross(self.right, ahead)], axis=-1)
            * (distance / depth)[..., None]
        )


def draw_floor(axes: "Axes", camera: Camera, centre: Array, reach: float, spacing: float) -> None:
    """Draw a grid of squares on the plane, around a centre, out to the distance `reach` [m]."""
    count = int(np.floor(reach / spacing))
    x0, y0 = np.round(centre[:2] / spacing) * spacing
    ticks = np.arange(-count, count + 1) * spacing
    # a round patch: the corners of a square one could be behind the camera
    ends = np.sqrt(np.maximum(reach**2 - ticks**2, 0.0))
    level = [[[x0 - end, y0 + t, 0.0], [x0 + end, y0 + t, 0.0]] for t, end in zip(ticks, ends, strict=True)]
    upright = [[[x0 + t, y0 - end, 0.0], [x0 + t, y0 + end, 0.0]] for t, end in zip(ticks, ends, strict=True)]
    lines = camera.project(np.array(level + upright))
    axes.add_collection(LineCollection(list(lines), colors=FLOOR, linewidths=0.5, zorder=0), autolim=False)


def draw_trace(axes: "Axes", camera: Camera, x: Array, y: Array, **look: Any) -> None:
    """Draw the path of the contact point on the plane."""
    seen = camera.project(np.stack([x, y, np.zeros_like(x)], axis=-1))
    shown: dict[str, Any] = {"color": TRACE, "linewidth": 1.1, "zorder": 2} | look
    axes.plot(seen[:, 0], seen[:, 1], **shown)


def draw_trail(axes: "Axes", camera: Camera, x: Array, y: Array, strength: Array) -> None:
    """Draw the path of the contact point, with a strength from 0 to 1 for each point, shape (n,)."""
    seen = camera.project(np.stack([x, y, np.zeros_like(x)], axis=-1))
    colours = np.zeros((max(x.size - 1, 0), 4))
    colours[:, :3] = to_rgb(TRACE)
    colours[:, 3] = 0.5 * (strength[1:] + strength[:-1])
    pieces = np.stack([seen[:-1], seen[1:]], axis=1)
    axes.add_collection(
        LineCollection(list(pieces), colors=colours, linewidths=1.8, capstyle="butt", zorder=2), autolim=False
    )


def draw_disk(
    axes: "Axes", camera: Camera, pose: Pose, strength: float = 1.0, *, believed: bool = True
) -> None:
    """Draw the disk with its shadow and its painted radius.

    It is fainter if `strength` is below 1, and grey unless it is `believed`.
    """
    rim = pose.rim()
    axes.fill(
        *camera.project(rim * [1.0, 1.0, 0.0]).T,
        color=SHADOW,
        alpha=SHADOW_STRENGTH * strength,
        linewidth=0,
        zorder=1,
    )
    # above the trace, and above disks that are farther away
    nearer = 2.5 + 0.5 / (1.0 + float(np.linalg.norm(camera.eye - rim.mean(axis=0))) / pose.radius)
    outline = camera.project(rim)
    faces = FACES if believed else GREY
    face = faces[0] if pose.faces(camera.eye) else faces[1]
    axes.fill(
        *outline.T, facecolor=face, alpha=FACE_STRENGTH - 0.67 * (1.0 - strength), linewidth=0, zorder=nearer
    )
    axes.plot(*outline.T, color=INK, linewidth=1.0, alpha=0.3 + 0.7 * strength, zorder=nearer)
    axes.plot(
        *camera.project(pose.painted()).T,
        color=TRACE,
        linewidth=1.8,
        alpha=0.3 + 0.7 * strength,
        solid_capstyle="round",
        path_effects=[withStroke(linewidth=3.0, foreground="white")],
        zorder=nearer,
    )


class Placed(Protocol):
    """A body in one position, as a picture needs it: see `Pose`, and `sweep.figures.disk.body_3d.BodyPose`."""

    @property
    def x(self) -> float:
        """The x coordinate of the contact point [m]."""

    @property
    def y(self) -> float:
        """The y coordinate of the contact point [m]."""

    @property
    def radius(self) -> float:
        """Outer radius [m]."""

    def centre(self) -> Array:
        """Return the centre of mass [m], shape (3,)."""

    def rim(self) -> Array:
        """Return points that show the extent of the body [m], shape (n, 3)."""

    def draw(self, axes: "Axes", camera: Camera, strength: float = 1.0, *, believed: bool = True) -> None:
        """Draw the body; see `draw_disk`."""


def frame_picture(axes: "Axes", low: Array, high: Array) -> None:
    """Show a rectangle of the picture plane with equal scales, without axes."""
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect("equal")
    axes.set_axis_off()


@dataclass(frozen=True)
class View:
    """The view of a film: a camera for every frame, and the rectangle of their picture planes [m], shape (2,) each.

    `reach` is the radius of the scene around a camera's target [m].
    """

    cameras: Sequence[Camera]
    low: Array
    high: Array
    reach: float


def azimuth_at_start(dataset: "xr.Dataset") -> float:
    """Return the azimuth [deg] from which a motion is seen: behind its first direction, to the right.

    It follows from the start instead of the path, so that motions from similar starts are seen from the same side.
    """
    unit = math.sqrt(float(dataset["gravity"]) / float(dataset["radius"]))
    backwards = float(dataset["roll_rate"][0]) < -_ROUNDING * unit
    # the track of a disk of heading 0 is the y axis
    track = math.degrees(float(dataset["heading"][0])) + 90.0
    return track + _BEHIND + 180.0 * backwards


def goes_far(dataset: "xr.Dataset") -> bool:
    """Return whether a motion would travel far if it continued as it starts, along a circle or a line.

    Similar starts have similar circles, but the paths of unstable motions differ.
    """
    radius = float(dataset["radius"])
    times = dataset[TIME.name].values
    roll_rate, precession_rate = (abs(float(dataset[name][0])) for name in ("roll_rate", "precession_rate"))
    if kind_of(dataset).rolls_on(request_of(dataset)):
        # a ball also rolls end over end
        roll_rate = math.hypot(roll_rate, float(dataset["tilt_rate"][0]))
    way = radius * roll_rate * float(times[-1] - times[0])
    # the circle has the radius R |roll rate / precession rate|
    return way > _WHOLE * radius and 2.0 * roll_rate > _WHOLE * precession_rate


def view(
    dataset: "xr.Dataset",
    poses: Sequence[Placed],
    size: tuple[int, int],
    camera: str | None,
    room: tuple[float, float] = _ROOM,
) -> View:
    """Return the view of a film.

    Parameters
    ----------
    dataset : xarray.Dataset
        The motion; its start determines from which side it is seen.
    poses : sequence of Placed
        The disk in every frame.
    size : (int, int)
        Width and height of the picture [pixels].
    camera : str or None
        One of `sweep.figures.disk.film_options.CAMERAS`; None follows a disk that `goes_far`.
    room : (float, float)
        Height of the text at the top and the bottom [in].
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
        # include the floor around the disk, so that the trail is visible
        seen.append(cameras[0].project(cameras[0].target * [1.0, 1.0, 0.0] + 0.7 * corners))
    points = np.concatenate(seen)
    return View(cameras, *_fit_frame(points.min(axis=0), points.max(axis=0), size, room), reach)


def dots_per_inch(size: tuple[int, int]) -> float:
    """Return the dots per inch of a picture of this size, which determine the size of its text."""
    return max(_LEAST_DOTS, _DOTS_PER_INCH * min(size[0] / _WIDTH, size[1] / _HEIGHT))


def _following(poses: Sequence[Placed], azimuth: float) -> tuple[list[Camera], float]:
    """Return cameras that follow the centre of the disk at constant height, and the radius of the scene."""
    radius = poses[0].radius
    reach = _AROUND * radius
    height = 0.5 * max(pose.centre()[2] for pose in poses)
    targets = [np.array([*pose.centre()[:2], height]) for pose in poses]
    first = Camera.on(targets[0], reach, azimuth)
    return [first.at(target) for target in targets], reach


def _standing(rims: Array, azimuth: float | None) -> tuple[list[Camera], float]:
    """Return a camera that sees all rims, shape (frames, n, 3), repeated for each frame, and the radius of the scene.

    Without an azimuth, it looks down from above.
    """
    low, high = rims.min(axis=(0, 1)), rims.max(axis=(0, 1))
    centre = 0.5 * (low + high)
    reach = float(np.linalg.norm(rims - centre, axis=-1).max())
    if azimuth is None:
        # x to the right and y upward, as on a map
        camera = Camera.on(centre, reach, azimuth=-90.0, elevation=90.0)
    else:
        camera = Camera.on(centre, reach, azimuth)
    return [camera] * len(rims), reach


def _fit_frame(
    low: Array, high: Array, size: tuple[int, int], room: tuple[float, float]
) -> tuple[Array, Array]:
    """Return the rectangle with the picture's shape that contains another one between the texts."""
    above, below = (each * dots_per_inch(size) / size[1] for each in room)
    free = np.array([1.0 - 2.0 * _MARGIN, max(_LEAST_SHARE, 1.0 - above - below)])
    scale = float(((high - low) / (free * size)).max())
    whole = scale * np.array(size, dtype=np.float64)
    # the centre of the scene is the centre of the space between the texts
    bottom = 0.5 * (low + high) - 0.5 * whole - np.array([0.0, 0.5 * (below - above) * whole[1]])
    return bottom, bottom + whole
