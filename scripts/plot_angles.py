"""Draw the disk with its angles, rates and directions: the sketch of docs/theory.md, for light and for dark pages.

python scripts/plot_angles.py -o docs/theory/angles.svg          --dark for the other one
"""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from figure_cli import figure_parser, run_script
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, Polygon

from sweep.figures import plots
from sweep.files.paths import check_format
from sweep.model.quantity import Array

#: A style of lines, and the horizontal alignment of text.
Style = str | tuple[int, tuple[int, int]]
Side = Literal["left", "center", "right"]

#: The pose that is drawn [rad]: tilt, heading, roll angle. The radius is 1.
TILT, HEADING, ROLL = math.radians(28.0), math.radians(28.0), math.radians(55.0)

#: Position of the viewer [rad]: azimuth and elevation.
AZIMUTH, ELEVATION = math.radians(-104.0), math.radians(20.0)

UP = np.array([0.0, 0.0, 1.0])
ACROSS = np.array([math.cos(HEADING), math.sin(HEADING), 0.0])
ALONG = np.array([-math.sin(HEADING), math.cos(HEADING), 0.0])
#: Directions from the contact point to the centre, and along the axis of the disk.
DIAMETER = math.sin(TILT) * ACROSS + math.cos(TILT) * UP
AXIS = math.sin(TILT) * UP - math.cos(TILT) * ACROSS


@dataclass(frozen=True)
class Ink:
    """Colours of a drawing: lines and text, faint lines, the disk, and one for each angle."""

    line: str
    faint: str
    disk: str
    tilt: str
    heading: str
    roll: str


LIGHT = Ink("#1c1e21", "#8b929b", "#b9c6d6", "#c2410c", "#1d63b8", "#1b7f4b")
DARK = Ink("#e8eaed", "#868e99", "#4a5b70", "#ff9d5c", "#7db7ff", "#63d69b")


def main() -> None:
    """Draw, and write the file."""
    parser = figure_parser(__doc__, "angles.svg")
    parser.add_argument("--dark", action="store_true", help="for a dark page")
    given = parser.parse_args()
    check_format(given.output)
    plots.save(figure(DARK if given.dark else LIGHT), given.output)


def figure(ink: Ink) -> Figure:
    """Draw the disk in perspective, and from behind along its track, on a transparent background."""
    drawn = Figure(figsize=(9.6, 4.4))
    drawn.patch.set_alpha(0.0)
    places = ((0.0, 0.0, 0.55, 1.0), (0.56, 0.0, 0.44, 1.0))
    in_space, from_behind = (drawn.add_axes(place) for place in places)
    for axes in (in_space, from_behind):
        axes.set_aspect("equal")
        axes.set_axis_off()
    _draw_in_space(Sheet(in_space, ink))
    _draw_from_behind(Sheet(from_behind, ink))
    in_space.set(xlim=(-1.6, 2.1), ylim=(-0.75, 2.3))
    from_behind.set(xlim=(-1.75, 1.95), ylim=(-0.75, 2.8))
    return drawn


@dataclass(frozen=True)
class Sheet:
    """Axes to draw on, and the ink."""

    axes: Axes
    ink: Ink

    def path(self, points: Array, color: str, width: float = 1.4, style: Style = "-", order: int = 2) -> None:
        """Draw a line through points of the plane, shape (n, 2)."""
        self.axes.plot(*points.T, color=color, lw=width, ls=style, zorder=order, solid_capstyle="round")

    def arrow(self, points: Array, color: str, width: float = 1.6, order: int = 4) -> None:
        """Draw a line through points, shape (n, 2), with a head at its end."""
        self.path(points[:-1] if len(points) > 2 else points, color, width, order=order)
        head = FancyArrowPatch(
            points[-2], points[-1], arrowstyle="-|>", mutation_scale=11, shrinkA=0, shrinkB=0, lw=width,
            color=color, zorder=order,
        )  # fmt: skip
        self.axes.add_patch(head)

    def dot(self, point: Array, words: str, offset: tuple[float, float]) -> None:
        """Draw a point with its name."""
        self.axes.plot(*point, "o", color=self.ink.line, ms=4.5, zorder=6)
        self.words(point + offset, words)

    def words(self, point: Array, words: str, color: str | None = None, ha: Side = "center") -> None:
        """Write text centred at a position, or to one side of it."""
        x, y = point
        color = color or self.ink.line
        self.axes.text(x, y, words, color=color, ha=ha, va="center", fontsize=12.5, zorder=7)


def seen(points: Array) -> Array:
    """Return the projection, shape (..., 2), of points in space, shape (..., 3), seen from afar."""
    right = np.array([-math.sin(AZIMUTH), math.cos(AZIMUTH), 0.0])
    back = np.array([math.cos(AZIMUTH), math.sin(AZIMUTH), 0.0])
    top = math.cos(ELEVATION) * UP - math.sin(ELEVATION) * back
    return np.stack([points @ right, points @ top], axis=-1)


def arc(first: Array, second: Array, end: float, radius: float, start: float = 0.0) -> Array:
    """Return points of an arc around the origin in the plane of two unit vectors, shape (60, n)."""
    angle = np.linspace(start, end, 60)[:, None]
    return radius * (np.cos(angle) * first + np.sin(angle) * second)


def _draw_in_space(sheet: Sheet) -> None:
    ink, origin = sheet.ink, np.zeros(3)
    east, north = np.eye(3)[:2]
    centre, spoke = DIAMETER, DIAMETER - math.cos(ROLL) * DIAMETER - math.sin(ROLL) * ALONG

    track = np.linspace(-1.55, 0.0, 40)[:, None]
    sheet.path(seen(track * ALONG + 0.13 * track**2 * ACROSS), ink.faint, 1.4, (0, (4, 3)), 1)
    sheet.arrow(seen(np.stack([origin, 1.25 * ALONG])), ink.line)
    sheet.words(seen(1.25 * ALONG) + np.array([-0.05, 0.16]), r"$\mathbf{e}_2$, track")

    sheet.path(seen(np.stack([origin, 1.8 * east])), ink.faint, 1.2)
    sheet.words(seen(1.9 * east), "$x$", ink.faint)
    sheet.arrow(seen(np.stack([origin, 1.8 * ACROSS])), ink.line, order=1)
    sheet.words(seen(1.92 * ACROSS), r"$\mathbf{e}_1$")
    sheet.arrow(seen(arc(east, north, HEADING, 1.5)), ink.heading)
    sheet.words(seen(1.64 * arc(east, north, 0.5 * HEADING, 1.0)[-1]), r"$\psi$", ink.heading)

    rim = seen(centre + arc(DIAMETER, ALONG, 2.0 * math.pi, 1.0))
    sheet.axes.add_patch(Polygon(rim, closed=True, fc=ink.disk, ec="none", alpha=0.55, zorder=3))
    sheet.path(np.vstack([rim, rim[:1]]), ink.line, 2.2, order=4)

    sheet.path(seen(np.stack([origin, 2.2 * UP])), ink.faint, 1.2, (0, (4, 3)))
    sheet.path(seen(np.stack([origin, centre])), ink.line, 1.2, order=5)
    sheet.arrow(seen(arc(UP, ACROSS, TILT, 0.62)), ink.tilt, order=5)
    sheet.words(seen(0.76 * arc(UP, ACROSS, 0.55 * TILT, 1.0)[-1]), r"$\theta$", ink.tilt)

    sheet.path(seen(np.stack([centre, spoke])), ink.roll, 1.6, order=5)
    sheet.arrow(seen(centre + arc(-DIAMETER, -ALONG, ROLL, 0.4)), ink.roll, order=5)
    middle = centre + arc(-DIAMETER, -ALONG, 0.5 * ROLL, 0.54)[-1]
    sheet.words(seen(middle), r"$\varphi$", ink.roll)

    turning = 2.05 * UP + arc(ACROSS, ALONG, math.radians(205.0), 0.28, math.radians(-75.0))
    sheet.arrow(seen(turning), ink.heading)
    sheet.words(seen(2.05 * UP) + np.array([0.45, 0.1]), r"$\dot\psi$", ink.heading)
    sheet.dot(seen(centre), "$G$", (0.13, 0.1))
    sheet.dot(seen(origin), "$C$", (-0.13, -0.13))


def _draw_from_behind(sheet: Sheet) -> None:
    """Draw the plane of e1 and the vertical, seen along e2: the disk rolls away from the reader."""
    ink = sheet.ink
    across, up = np.eye(2)
    diameter = math.sin(TILT) * across + math.cos(TILT) * up
    axis = math.sin(TILT) * up - math.cos(TILT) * across
    origin, top = np.zeros(2), 2.0 * diameter

    sheet.path(np.array([[-1.35, 0.0], [1.75, 0.0]]), ink.faint, 1.4, order=1)
    sheet.path(np.stack([origin, 2.3 * up]), ink.faint, 1.2, (0, (4, 3)))
    sheet.path(np.stack([origin, top]), ink.disk, 9.0, order=2)
    sheet.path(np.stack([origin, top]), ink.line, 1.0, order=3)
    sheet.arrow(arc(up, across, TILT, 1.72), ink.tilt)
    sheet.words(1.86 * arc(up, across, 0.5 * TILT, 1.0)[-1], r"$\theta > 0$", ink.tilt)

    sheet.arrow(np.stack([diameter, diameter + 0.8 * axis]), ink.roll)
    sheet.words(
        diameter + 0.86 * axis + np.array([0.1, 0.14]),
        r"$s=\dot\varphi+\dot\psi\,\sin\theta$",
        ink.roll,
        ha="right",
    )
    sheet.arrow(np.stack([top, top + 0.55 * diameter]), ink.heading)
    sheet.words(top + 0.62 * diameter + np.array([0.1, 0.08]), r"$o=\dot\psi\,\cos\theta$", ink.heading)

    sheet.arrow(np.stack([diameter, diameter - 0.62 * up]), ink.line)
    sheet.words(diameter + np.array([0.06, -0.55]), r"$mg$", ha="left")
    sheet.arrow(np.stack([-0.6 * up, -0.06 * up]), ink.line)
    sheet.words(np.array([-0.09, -0.42]), "$N$", ha="right")
    sheet.arrow(np.array([[0.06, -0.18], [0.6, -0.18]]), ink.line)
    sheet.words(np.array([0.72, -0.2]), r"$\lambda_1$")
    sheet.path(np.array([[1.28, 0.0], [1.28, math.cos(TILT)]]), ink.faint, 1.0)
    sheet.path(
        np.array([diameter + np.array([0.12, 0.0]), [1.36, math.cos(TILT)]]), ink.faint, 1.0, (0, (1, 2))
    )
    sheet.words(np.array([1.33, 0.42]), r"$R\,\cos\theta$", ha="left")
    sheet.words(np.array([1.68, -0.16]), r"$\mathbf{e}_1$")
    sheet.dot(diameter, "$G$", (0.15, 0.12))
    sheet.dot(origin, "$C$", (-0.14, 0.13))


if __name__ == "__main__":
    run_script(main)
