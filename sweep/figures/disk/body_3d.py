"""Draw a body of revolution in three dimensions: its facets, lit from near the eye, from far to near."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.collections import PathCollection, PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.path import Path
from scipy.spatial import ConvexHull, QhullError
from scipy.spatial.transform import Rotation, Slerp

from sweep.figures.disk.disk_3d import FACES, GREY, INK, SHADOW, SHADOW_STRENGTH, TRACE, Camera
from sweep.figures.disk.solid import Solid
from sweep.model.bodies.shape import body_of
from sweep.model.quantity import Array
from sweep.motion.sampling import request_of
from sweep.motion.tables import TIME

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

#: Colour of the edge of a coin, normally and where rolling is impossible.
_EDGE, _GREY_EDGE = "#c9c3b8", "#c4c2bd"

#: Brightness of the darkest facet relative to the lightest, and of a darker sector relative to its neighbours.
_DARKEST, _BAND = 0.62, 0.9

#: Offset of the light from the eye, to the left and upward, relative to its distance ahead.
_LIGHT = (-0.5, 0.9)

#: Depth offset of lines, in radii: keeps visible lines in front of their facets without showing hidden ones.
_OUTLINE_NEARER, _CASING_NEARER, _PAINT_NEARER = 0.16, 0.17, 0.26

#: Number of shades of each colour in a gif, which has at most 256 colours.
_SHADES = 14

#: Width [points] of the outline of each facet, which closes the gaps between facets.
_SEAM = 0.35


@dataclass(frozen=True)
class BodyPose:
    """One position of a body: its shape and its placement.

    Attributes
    ----------
    solid : Solid
    frame : array, shape (3, 3)
        The painted direction, the direction a quarter of a turn further, and the axis, as columns.
    middle : array, shape (3,)
        Centre of mass [m].
    x, y : float
        Contact point [m].
    scale : float
        Outer radius [m].
    """

    solid: Solid
    frame: Array
    middle: Array
    x: float
    y: float
    scale: float

    @property
    def radius(self) -> float:
        """Distance of the farthest point from the centre of mass [m]."""
        return self.scale * self.solid.reach

    def centre(self) -> Array:
        """Return the centre of mass, shape (3,)."""
        return self.middle

    def placed(self, points: Array) -> Array:
        """Return points of the body in space [m], shape (..., 3)."""
        return np.asarray(self.middle + self.scale * points @ self.frame.T)

    def rim(self) -> Array:
        """Return points that show the extent of the body, shape (n, 3)."""
        return self.placed(self.solid.extent())

    def draw(self, axes: "Axes", camera: Camera, strength: float = 1.0, *, believed: bool = True) -> None:
        """Draw the body with its shadow; see `sweep.figures.disk.disk_3d.draw_disk`."""
        _draw_shadow(axes, camera, self, strength)
        # above the trace, and above bodies that are farther away
        nearer = 2.5 + 0.5 / (1.0 + float(np.linalg.norm(camera.eye - self.middle)) / self.radius)
        facets, colours, edges, widths, away = _facets(self, camera, believed)
        pieces = [*camera.project(facets)]
        for lines, colour, width, offset in _lines(self, camera):
            pieces += [*camera.project(lines)]
            count = len(lines)
            colours = np.concatenate([colours, np.zeros((count, 4))])
            edges = np.concatenate([edges, np.tile([*to_rgb(colour), 1.0], (count, 1))])
            widths = np.concatenate([widths, np.full(count, width)])
            distance = np.linalg.norm(lines.mean(axis=1) - camera.eye, axis=-1)
            away = np.concatenate([away, distance - offset * self.scale])
        order = np.argsort(-away, kind="stable")
        # with antialiasing, pixels shared by two facets would be lighter than both
        smooth = np.arange(len(pieces)) >= len(facets)
        pale = 0.75 * (1.0 - strength)
        colours[:, :3] += pale * (1.0 - colours[:, :3])
        edges[:, :3] += pale * (1.0 - edges[:, :3])
        axes.add_collection(
            PolyCollection(
                [pieces[i] for i in order],
                facecolors=colours[order], edgecolors=edges[order], linewidths=widths[order],
                antialiaseds=smooth[order], joinstyle="round", capstyle="round", closed=False, zorder=nearer,
            ),
            autolim=False,
        )  # fmt: skip


def shades() -> Array:
    """Return the colours of bodies and of lines on them in a gif, red, green and blue from 0 to 1, shape (n, 3)."""
    bases = np.array([to_rgb(each) for each in (*FACES, _EDGE)])
    shaded = np.linspace(_BAND * _DARKEST, 1.0, _SHADES)[:, None, None] * bases
    flat = shaded.reshape(-1, 3)
    return np.concatenate([flat, *(0.5 * (flat + to_rgb(line)) for line in (INK, TRACE))])


def _facets(pose: BodyPose, camera: Camera, believed: bool) -> tuple[Array, Array, Array, Array, Array]:
    """Return the visible facets, with their colours, outline colours and widths, and distances."""
    solid = pose.solid
    corners, normals = pose.placed(solid.corners), solid.normals @ pose.frame.T
    middles = corners.mean(axis=2)
    ray = camera.eye - middles
    seen = np.einsum("ijk,ijk->ij", normals, ray) > 0.0
    ahead = camera.target - camera.eye
    ahead = ahead / np.linalg.norm(ahead)
    light = -ahead + _LIGHT[0] * camera.right + _LIGHT[1] * np.cross(camera.right, ahead)
    bright = np.clip(normals @ (light / np.linalg.norm(light)), 0.0, 1.0)
    shade = (_DARKEST + (1.0 - _DARKEST) * bright) * np.where(solid.bands, _BAND, 1.0)
    bases = np.array([to_rgb(each) for each in ((*FACES, _EDGE) if believed else (*GREY, _GREY_EDGE))])
    colours = shade[..., None] * bases[solid.shown][:, None, :]
    colours = np.concatenate([colours, np.ones_like(shade)[..., None]], axis=-1)[seen]
    distance = np.linalg.norm(ray, axis=-1)[seen]
    return corners[seen], colours, colours.copy(), np.full(len(colours), _SEAM), distance


def _lines(pose: BodyPose, camera: Camera) -> list[tuple[Array, str, float, float]]:
    """Return the lines to draw: pieces, shape (n, 2, 3), colour, width [points], depth offset."""
    solid = pose.solid
    # the visible side of a body without a hole hides none of its lines
    above = 0.0 if solid.tube is not None else 2.0 * solid.reach
    vertices = pose.placed(solid.vertices)
    normals = solid.normals @ pose.frame.T
    seen = np.einsum("ijk,ijk->ij", normals, camera.eye - pose.placed(solid.corners).mean(axis=2)) > 0.0
    found = []
    painted = np.stack([vertices[:-1, 0], vertices[1:, 0]], axis=1)[seen[:, 0] | seen[:, -1]]
    found.append((painted, "white", 3.0, _CASING_NEARER + above))
    found.append((painted, TRACE, 1.8, _PAINT_NEARER + 2.0 * above))
    for point in solid.creases:
        ring = np.stack([vertices[point, :-1], vertices[point, 1:]], axis=1)
        beside = seen[point - 1] | seen[min(point, len(seen) - 1)]
        found.append((ring[beside], INK, 0.8, _OUTLINE_NEARER))
    for line in solid.contours((camera.eye - pose.middle) @ pose.frame / pose.scale):
        contour = pose.placed(line)
        found.append((np.stack([contour[:-1], contour[1:]], axis=1), INK, 1.0, _OUTLINE_NEARER))
    # the outer outline of a ring is also that of its convex hull
    points = vertices.reshape(-1, 3)
    hull = _corners(camera.project(points))
    outline = points[np.append(hull, hull[0])]
    found.append((np.stack([outline[:-1], outline[1:]], axis=1), INK, 1.0, 6.0 * solid.reach))
    return found


def _draw_shadow(axes: "Axes", camera: Camera, pose: BodyPose, strength: float) -> None:
    """Draw the shadow of a light directly above; the shadow of a ring has a hole if the light can pass through it."""
    flat = pose.placed(pose.solid.vertices).reshape(-1, 3) * [1.0, 1.0, 0.0]
    pieces = [flat[_corners(flat[:, :2])]]
    if pose.solid.tube is not None:
        pieces += _hole(pose)
    whole: Any = Path.make_compound_path(*(Path(camera.project(each), closed=False) for each in pieces))
    axes.add_collection(
        PathCollection(
            [whole], facecolors=SHADOW, alpha=SHADOW_STRENGTH * strength, linewidths=0.0, zorder=1
        ),
        autolim=False,
    )


def _corners(places: Array) -> Array:
    """Return the indices of the corners of the convex hull of points in a plane, shape (n, 2); for a line, its ends."""
    try:
        return np.asarray(ConvexHull(places).vertices)
    except QhullError:
        along = places[:, np.ptp(places, axis=0).argmax()]
        return np.array([along.argmin(), along.argmax()])


def _hole(pose: BodyPose) -> list[Array]:
    """Return the hole in the shadow of a ring: points farther from its tube's centre than the tube's radius."""
    assert pose.solid.tube is not None
    core, height, radius = pose.solid.tube
    angle = np.linspace(0.0, 2.0 * np.pi, 145)[:-1]
    middle = pose.placed(np.column_stack([core * np.cos(angle), core * np.sin(angle), 0.0 * angle + height]))[
        :, :2
    ]
    along = np.roll(middle, -1, axis=0) - np.roll(middle, 1, axis=0)
    length = np.maximum(np.linalg.norm(along, axis=-1, keepdims=True), 1e-300)
    inwards = np.column_stack([-along[:, 1], along[:, 0]]) / length
    if np.sum((middle.mean(axis=0) - middle) * inwards) < 0.0:
        inwards = -inwards
    inner = middle + radius * pose.scale * inwards
    apart = np.linalg.norm(inner[:, None] - middle[None], axis=-1).min(axis=1)
    inner = inner[apart >= (1.0 - 1e-3) * radius * pose.scale]
    if len(inner) < 3:
        return []
    # in the opposite direction to the outline, so that the hole is not filled
    x, y = inner.T
    area = float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
    points = np.column_stack([inner, np.zeros(len(inner))])
    return [points[::-1] if area > 0.0 else points]


def poses_of_body(dataset: "xr.Dataset", moments: Array) -> list[BodyPose]:
    """Return the positions of a body of revolution at given times [s], shape (n,).

    Interpolates by an even rotation about one axis between two samples: near a pole, heading and roll angle are uneven.
    """
    times, radius = dataset[TIME.name].values, float(dataset["radius"])
    turned = Slerp(times, Rotation.from_matrix(_frames(dataset)))(moments).as_matrix()
    names = ("centre_x", "centre_y", "centre_z", "contact_x", "contact_y")
    columns = [np.interp(moments, times, dataset[name].values) for name in names]
    solid = solid_of(dataset)
    return [
        BodyPose(solid, frame, np.array(place[:3]), place[3], place[4], radius)
        for frame, place in zip(turned, np.stack(columns, axis=-1).tolist(), strict=True)
    ]


def solid_of(dataset: "xr.Dataset") -> Solid:
    """Return the shape of the body of a motion."""
    request = request_of(dataset)
    start = {name: dataset[name].values.flat[0] for name in request.kind.model.parameters}
    core, shift, edge, square, *_ = (float(each) for each in body_of(request, start))
    return Solid.of(request.body, core, shift, edge, square)


def _frames(dataset: "xr.Dataset") -> Array:
    """Return the painted direction, the one a quarter of a turn further, and the axis, as columns, shape (n, 3, 3)."""
    tilt, heading, angle = (dataset[name].values for name in ("tilt", "heading", "roll_angle"))
    sin, cos, none = np.sin(tilt), np.cos(tilt), 0.0 * tilt
    aside = np.stack([np.cos(heading), np.sin(heading), none], axis=-1)
    ahead = np.stack([-np.sin(heading), np.cos(heading), none], axis=-1)
    up = np.array([0.0, 0.0, 1.0])
    axis = sin[:, None] * up - cos[:, None] * aside
    down = -(sin[:, None] * aside + cos[:, None] * up)
    # at roll angle 0 it points to the plane; the lowest point of a body that rolls forward moves backward
    painted = np.cos(angle)[:, None] * down - np.sin(angle)[:, None] * ahead
    return np.stack([painted, np.cross(axis, painted), axis], axis=-1)
