"""The shape of a body of revolution for pictures: its meridian, its facets, and its outline for an eye."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np

from sweep.model.quantity import Array

#: Number of facets around the axis, and along half a circle of a meridian.
_AROUND, _ALONG = 72, 18

#: Kinds of facets: on the side at the negative end of the axis, at its positive end, or on the edge.
FRONT, BACK, EDGE = range(3)


@dataclass(frozen=True)
class Solid:
    """A surface of revolution about the axis of a body, in units of its outer radius, with the centre of mass at 0.

    Attributes
    ----------
    meridian : array, shape (k, 2)
        Distance from the axis, and height along it, of points from one end to the other; the outside is on the left.
    shown : array of int, shape (k - 1,)
        FRONT, BACK or EDGE for each segment of the meridian.
    creases : tuple of int
        Indices of points where the meridian has a corner.
    tube : (float, float, float) or None
        For a ring: distance of the centre of its tube from the axis, its height, and the radius of the tube.
    """

    meridian: Array
    shown: Array
    creases: tuple[int, ...] = ()
    tube: tuple[float, float, float] | None = None

    @classmethod
    def of(cls, body: str, core: float, shift: float, edge: float, square: float) -> Self:
        """Return the shape of the body that a word names, with the arc of its meridian (`kernels.bodies.shapes`)."""
        if body == "torus":
            around = np.linspace(math.pi, -math.pi, 2 * _ALONG + 1)
            points = _circle(core, 0.0, edge, around)
            return cls(points, _sides(points, 0.0), (), (core, 0.0, edge))
        if body in ("ball", "spheroid"):
            points = _circle(0.0, 0.0, 1.0, np.linspace(0.5, -0.5, 2 * _ALONG + 1) * math.pi)
            points[:, 1] = math.sqrt(square) * points[:, 1] - shift
            # puts poles on the axis in spite of rounding
            points[[0, -1], 0] = 0.0
            return cls(points, _sides(points, -shift))
        quarter = np.linspace(0.5, 0.0, _ALONG // 2 + 1) * math.pi
        # the arc of a rim, on either edge; a single arc continues to the other side
        upper = _circle(
            core, 0.0 if body == "arc" else abs(shift), edge, quarter if edge > 0.0 else quarter[:1]
        )
        face = [[0.0, upper[0, 1]]]
        points = np.concatenate([face, upper, upper[::-1] * [1.0, -1.0], np.multiply(face, [1.0, -1.0])])
        points[:, 1] -= shift if body == "arc" else 0.0
        shown = np.full(len(points) - 1, EDGE)
        shown[0], shown[-1] = BACK, FRONT
        return cls(points, shown, (1, len(points) - 2))

    @cached_property
    def vertices(self) -> Array:
        """Points of the surface, shape (k, n, 3): along the meridian, and around from the painted direction."""
        angle = np.linspace(0.0, 2.0 * math.pi, _AROUND + 1)
        distance, height = self.meridian.T
        return np.stack(
            [
                np.outer(distance, np.cos(angle)),
                np.outer(distance, np.sin(angle)),
                np.repeat(height[:, None], angle.size, axis=1),
            ],
            axis=-1,
        )

    @cached_property
    def corners(self) -> Array:
        """Corners of the facets, shape (k - 1, n - 1, 4, 3)."""
        v = self.vertices
        return np.stack([v[:-1, :-1], v[1:, :-1], v[1:, 1:], v[:-1, 1:]], axis=2)

    @cached_property
    def normals(self) -> Array:
        """Outward directions of the facets, shape (k - 1, n - 1, 3)."""
        angle = (np.arange(_AROUND) + 0.5) * 2.0 * math.pi / _AROUND
        across, along = np.diff(self.meridian, axis=0).T
        length = np.maximum(np.hypot(across, along), 1e-300)
        out, up = -along / length, across / length
        return np.stack(
            [
                np.outer(out, np.cos(angle)),
                np.outer(out, np.sin(angle)),
                np.repeat(up[:, None], angle.size, axis=1),
            ],
            axis=-1,
        )

    @cached_property
    def bands(self) -> Array:
        """Which facets are drawn slightly darker, shape (k - 1, n - 1): sectors that make the rotation visible."""
        odd = np.arange(_AROUND) // (_AROUND // 12) % 2 == 1
        banded = self.shown == EDGE if EDGE in self.shown else np.ones_like(self.shown, bool)
        return np.asarray(np.logical_and.outer(banded, odd))

    @cached_property
    def reach(self) -> float:
        """Distance of the farthest point from the centre of mass."""
        return float(np.hypot(*self.meridian.T).max())

    def extent(self) -> Array:
        """Some points of the surface that show its extent, shape (m, 3)."""
        return np.asarray(self.vertices[:, ::6].reshape(-1, 3))

    def contours(self, eye: Array) -> Iterator[Array]:
        """Yield the outlines of a ring for an eye, shape (n, 3); parts of them may be hidden.

        A ray from the eye touches the tube where the tube's radius is the projection of the eye's distance from its
        centre.
        """
        if self.tube is None:
            return
        core, height, radius = self.tube
        angle = np.linspace(0.0, 2.0 * math.pi, 4 * _AROUND + 1)
        across = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        out, up = across @ eye[:2] - core, np.full(angle.size, eye[2] - height)
        middle, half = np.arctan2(up, out), np.arccos(np.minimum(radius / np.hypot(out, up), 1.0))
        for place in (middle + half, middle - half):
            yield np.column_stack(
                [(core + radius * np.cos(place))[:, None] * across, height + radius * np.sin(place)]
            )


def _circle(distance: float, height: float, radius: float, angle: Array) -> Array:
    return np.column_stack([distance + radius * np.cos(angle), height + radius * np.sin(angle)])


def _sides(points: Array, middle: float) -> Array:
    return np.where(points[1:, 1] + points[:-1, 1] < 2.0 * middle, FRONT, BACK)
