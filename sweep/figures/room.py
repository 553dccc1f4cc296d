"""Free places for text in a panel, at its present size, clear of lines, markers and other text."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import rcParams
from matplotlib.contour import ContourSet
from matplotlib.patheffects import withStroke
from matplotlib.text import Text

from sweep.figures.panels import Panel
from sweep.model.quantity import Array, Truths

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.transforms import Bbox

#: Side of the raster of points on which places for text are sought.
_RASTER = 120

#: Distance [points] of a text from anything that it must not touch, and from the line that it names.
_CLEAR, _BESIDE = 2.0, 3.0

#: Largest number of parts of a region that show its name: those with most room.
_MOST_NAMES = 4

#: Least and largest distance [points] between the end of a line and its name.
_NEAR, _FAR = 12.0, 60.0

HALO = [withStroke(linewidth=2.4, foreground="white")]

#: Background of formulas: a halo, drawn for each glyph separately, would hide dots and bars.
_BOX: dict[str, Any] = {"boxstyle": "round,pad=0.12", "facecolor": "white", "edgecolor": "none", "alpha": 0.8}


class Room:
    """A raster over laid-out axes: which points are covered, and where a text fits.

    Parameters
    ----------
    axes : Axes
        Axes in their final size.
    """

    def __init__(self, axes: "Axes") -> None:
        self.axes = axes
        self._box = axes.get_window_extent()
        self.dots = axes.figure.dpi / 72.0
        self.covered = np.zeros((_RASTER, _RASTER), bool)
        with np.errstate(invalid="ignore", divide="ignore"):
            for line in axes.get_lines():
                self._cover(line.get_transform().transform_path(line.get_path()).vertices, _width(line))
            for each in axes.collections:
                if isinstance(each, ContourSet) or each.get_zorder() > 2.0:
                    for path in each.get_paths():
                        for corners in axes.transData.transform_path(path).to_polygons(closed_only=False):
                            self._cover(corners, 1.0)

    def put(self, word: Text, allowed: Truths, preference: Array, region: Truths | None = None) -> bool:
        """Put a text where it covers nothing, or remove it if there is no such place; return whether it fits.

        Parameters
        ----------
        word : Text
            Drawn anywhere; gets a position in the coordinates of the axes.
        allowed : array of bool
            The points of the raster on which the centre of the text may be.
        preference : array
            Of the possible points, the one with the largest value is taken.
        region : array of bool, optional
            The points within which the whole text has to be.
        """
        good = allowed & self._places(word, region)
        if not good.any():
            word.remove()
            return False
        row, column = np.unravel_index(np.argmax(np.where(good, preference, -np.inf)), good.shape)
        word.set_position(((float(column) + 0.5) / _RASTER, (float(row) + 0.5) / _RASTER))
        left, bottom, right, top = box_of(word).extents
        across, up = self.middles()
        self.covered |= (across >= left) & (across <= right) & (up >= bottom) & (up <= top)
        return True

    def _places(self, word: Text, region: Truths | None) -> Truths:
        """Return the points on which the centre of a text can be."""
        free = ~self.covered if region is None else ~self.covered & region
        box = box_of(word)
        reach = np.array([box.height, box.width]) / 2.0 + _CLEAR * self.dots
        up, across = np.ceil(reach / self.steps()[::-1]).astype(int)
        if 2 * max(up, across) >= _RASTER:
            return np.zeros_like(free)
        sums = np.pad(np.cumsum(np.cumsum(~free, axis=0), axis=1), ((1, 0), (1, 0)))
        rows = sums[2 * up + 1 :] - sums[: -2 * up - 1]
        inner = rows[:, 2 * across + 1 :] - rows[:, : -2 * across - 1]
        return np.pad(inner == 0, ((up, up), (across, across)))

    def cells(self, panel: Panel, cells: Truths) -> Truths:
        """Return the points of the raster that are on selected cells of a map."""
        assert panel.y is not None
        middles = (np.arange(_RASTER) + 0.5) / _RASTER
        across, up = np.meshgrid(middles, middles)
        to_data = self.axes.transAxes + self.axes.transData.inverted()
        x, y = to_data.transform(np.column_stack((across.ravel(), up.ravel()))).T
        column, row = (np.searchsorted(each.borders, at) - 1 for each, at in ((panel.x, x), (panel.y, y)))
        inside = (column >= 0) & (column < len(panel.x.values)) & (row >= 0) & (row < len(panel.y.values))
        column, row = column.clip(0, len(panel.x.values) - 1), row.clip(0, len(panel.y.values) - 1)
        return np.asarray((cells[row, column] & inside).reshape(_RASTER, _RASTER))

    def steps(self) -> Array:
        """Return width and height [dots] of a raster cell."""
        return np.array([self._box.width, self._box.height]) / _RASTER

    def middles(self) -> tuple[Array, Array]:
        """Return both coordinates [dots] of all points of the raster."""
        middles = (np.arange(_RASTER) + 0.5) * self.steps()[:, np.newaxis]
        across, up = np.meshgrid(*middles)
        return across + self._box.x0, up + self._box.y0

    def _cover(self, corners: Any, width: float) -> None:
        """Cover a line through points [dots], interrupted by NaN, and `width` [points] on either side."""
        corners = np.asarray(corners, float)
        if not len(corners):
            return
        corners = np.clip(corners, -1e6, 1e6) - [self._box.x0, self._box.y0]
        ends = np.concatenate((corners, corners[-1:]))
        span = np.abs(np.diff(ends, axis=0)) / self.steps()
        longest = np.nanmax(np.where(np.isfinite(span), span, 0.0).clip(0.0, 3.0 * _RASTER), initial=0.0)
        along = np.linspace(0.0, 1.0, int(longest) + 2)[:, np.newaxis, np.newaxis]
        points = (ends[:-1] + along * np.diff(ends, axis=0)).reshape(-1, 2)
        reach = width * self.dots
        for shift in ((0.0, 0.0), (reach, 0.0), (-reach, 0.0), (0.0, reach), (0.0, -reach)):
            column, row = np.floor((points + shift) / self.steps()).T
            on = (np.minimum(column, row) >= 0) & (np.maximum(column, row) < _RASTER)
            self.covered[row[on].astype(int), column[on].astype(int)] = True


def box_of(word: Text) -> "Bbox":
    """Return the box [dots] of a text, without the arrow of an annotation."""
    # an annotation updates its position only in its own method, which includes the arrow in the box
    word.get_window_extent()
    return Text.get_window_extent(word)


def _width(line: Any) -> float:
    """Return how far [points] a line or its markers extend to either side."""
    marker = line.get_markersize() / 2.0 if line.get_marker() not in {None, "", "None", "none"} else 0.0
    return float(max(marker, line.get_linewidth() / 2.0))


def name_regions(room: Room, panel: Panel, regions: Iterable[tuple[str, Truths]]) -> None:
    """Write the name of each region where it has most room, so that a map can be read without colours."""
    left = [(name, room.cells(panel, cells)) for name, cells in regions if cells.any()]
    # place each name once before any name is repeated
    for _ in range(_MOST_NAMES):
        left = [(name, rest) for name, region in left if (rest := _name_region(room, name, region)).any()]


def _name_region(room: Room, name: str, region: Truths) -> Truths:
    """Write a name where a region has most room; return the region without the connected part that now has the name."""
    word = room.axes.text(
        0.5, 0.5, name, transform=room.axes.transAxes, ha="center", va="center", weight="bold",
        path_effects=HALO, zorder=6,
    )  # fmt: skip
    box, steps = box_of(word), room.steps()
    around = np.pad(region & ~room.covered, 1)
    distance = distance_to_outside(around, (steps[1] / box.height, steps[0] / box.width))[1:-1, 1:-1]
    if not room.put(word, region, distance, region):
        return np.zeros_like(region)
    across, up = (int(part * _RASTER) for part in word.get_position())
    return region & ~_find_connected(region, up, across)


def _find_connected(region: Truths, row: int, column: int) -> Truths:
    """Return the points of a region that are connected to one of its points."""
    part, size = np.zeros(np.add(region.shape, 2), bool), 0
    part[row + 1, column + 1] = True
    while size < (size := int(part.sum())):
        part[1:-1, 1:-1] |= region & (part[2:, 1:-1] | part[:-2, 1:-1] | part[1:-1, 2:] | part[1:-1, :-2])
    return part[1:-1, 1:-1]


def name_line(room: Room, text: str, height: float) -> None:
    """Write a formula above or below a level line at a height of the axes, as far to the right as possible."""
    low, high = room.axes.get_ylim()
    if not text or not low < height < high:
        return
    word = room.axes.text(
        0.5, 0.5, text, transform=room.axes.transAxes, ha="center", va="center", bbox=_BOX, zorder=6
    )
    (across, up), step = room.middles(), room.steps()[1]
    above = up - room.axes.transData.transform((room.axes.get_xlim()[0], height))[1]
    gap = box_of(word).height / 2.0 + _BESIDE * room.dots + step
    room.put(word, abs(abs(above) - gap) <= step, across + np.where(above > 0.0, 2.0 * np.ptp(across), 0.0))


def name_end(room: Room, text: str, at: tuple[float, float]) -> None:
    """Write the name of the end of a line, a point in the units of the axes, at a small distance from it."""
    word = room.axes.annotate(
        text, at, (0.5, 0.5), textcoords="axes fraction", ha="center", va="center",
        fontsize=0.875 * rcParams["font.size"],
        arrowprops={"arrowstyle": "-", "linewidth": 0.6, "shrinkB": 3.0}, bbox=_BOX, zorder=6,
    )  # fmt: skip
    assert word.arrow_patch is not None
    word.arrow_patch.set_visible(False)
    (x, y), (across, up), box = room.axes.transData.transform(at), room.middles(), box_of(word)
    beside = np.maximum(np.abs(across - x) - box.width / 2.0, 0.0)
    distance = np.hypot(beside, np.maximum(np.abs(up - y) - box.height / 2.0, 0.0)) / room.dots
    if room.put(word, (distance > _NEAR) & (distance < _FAR), -distance):
        word.arrow_patch.set_visible(True)


def distance_to_outside(region: Truths, spacing: tuple[float, float]) -> Array:
    """Return the distance of each point of a region from the nearest point outside.

    `scipy.ndimage.distance_transform_edt` does the same for rasters of any size, but loading it takes as long as
    drawing a map.

    Parameters
    ----------
    region : array of bool, shape (n, m)
        False along all four sides, so that every row and column has points outside.
    spacing : (float, float)
        Distance between two rows, and between two columns.

    Returns
    -------
    array, shape (n, m)
        Euclidean distances; 0 outside.

    Notes
    -----
    The nearest point outside is found first along each column, then among all columns of each row: the squares of the
    two distances add up. Memory: 8 n m^2 bytes.
    """
    rows, columns = (np.arange(count, dtype=float) for count in region.shape)
    places = rows[:, np.newaxis]
    above = np.maximum.accumulate(np.where(region, -np.inf, places), axis=0)
    below = np.minimum.accumulate(np.where(region, np.inf, places)[::-1], axis=0)[::-1]
    up = (np.minimum(places - above, below - places) * spacing[0]) ** 2
    across = ((columns[:, np.newaxis] - columns) * spacing[1]) ** 2
    return np.asarray(np.sqrt((up[:, np.newaxis, :] + across).min(axis=-1)))
