"""Draw the disk in three dimensions: the positions of its points, and their projection by a camera.

A pinhole camera instead of a 3-D toolkit: true perspective with equal axes. Camera and disk are above the plane, so
nothing on the floor hides the disk: the floor is drawn first.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from matplotlib.patheffects import withStroke

from sweep.model.quantity import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Colours of the two faces of the disk: the colour-blind can tell them apart, and one is light and one dark in grey.
FACES = ("#f4c95d", "#5a86b8")

#: The faces where the disk could not be where it is drawn.
_GREY = ("#d9d5cd", "#a5a9ae")

#: Edge of the disk, its painted radius and the path of the contact point, squares of the floor, and shadow.
INK, TRACE, FLOOR, SHADOW = "#222222", "#c8380a", "0.86", "0.3"

#: How strong shadow and face are drawn: the floor is seen a little through both.
SHADOW_STRENGTH, FACE_STRENGTH = 0.18, 0.92

_CORNERS = 96

#: Distance of the camera over the radius of the scene: near enough for a visible perspective.
_DISTANCE = 3.4


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
        """Return the centre, and unit vectors from it to the contact point and along the track."""
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
        """Centre and rim end of the painted radius, shape (2, 3); it points to the plane at roll angle 0."""
        centre, down, along = self._frame()
        # relative to the centre, the lowest point of a disk that rolls forwards moves backwards
        direction = np.cos(self.roll_angle) * down - np.sin(self.roll_angle) * along
        return np.array([centre, centre + self.radius * direction])

    def faces(self, eye: Array) -> bool:
        """Return whether the face on the side of cross(down, along) is visible from a point `eye`."""
        centre, down, along = self._frame()
        return bool(np.cross(down, along) @ (eye - centre) > 0.0)


@dataclass(frozen=True)
class Camera:
    """A pinhole camera: its position, the point that it is directed at, the right of its picture; shape (3,) each."""

    eye: Array
    target: Array
    right: Array

    @classmethod
    def on(cls, centre: Array, size: float, azimuth: float, elevation: float = 24.0) -> "Camera":
        """Return a camera that looks at a scene of a given radius, from an azimuth and an elevation in degrees."""
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
    """Draw a grid of squares on the plane, about a centre, as far as `reach` [m]."""
    count = int(np.floor(reach / spacing))
    x0, y0 = np.round(centre[:2] / spacing) * spacing
    ticks = np.arange(-count, count + 1) * spacing
    # a round patch: the corners of a square one could lie behind the camera
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
    """Draw the path of the contact point, each point as strong as `strength` says, from 0 to 1, shape (n,)."""
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
    """Draw the disk with its shadow and its painted radius; `strength` below 1 is fainter, grey is not `believed`."""
    rim = pose.rim()
    axes.fill(
        *camera.project(rim * [1.0, 1.0, 0.0]).T,
        color=SHADOW,
        alpha=SHADOW_STRENGTH * strength,
        linewidth=0,
        zorder=1,
    )
    # over the trace, and over disks that are farther away
    nearer = 2.5 + 0.5 / (1.0 + float(np.linalg.norm(camera.eye - rim.mean(axis=0))) / pose.radius)
    outline = camera.project(rim)
    faces = FACES if believed else _GREY
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


def frame_picture(axes: "Axes", low: Array, high: Array) -> None:
    """Show a rectangle of the picture plane, equal scales, without axes."""
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect("equal")
    axes.set_axis_off()
