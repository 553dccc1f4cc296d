"""Draw a panel on matplotlib axes: map, strip or profile, boundary, lines of theory, names and legend."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib import colormaps
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap, LogNorm
from matplotlib.container import ErrorbarContainer
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import ScaledTranslation

from sweep.figures.distance import distance_to_outside
from sweep.figures.panels import Panel
from sweep.figures.scales import SQUEEZED, add_scaled_axis, set_log_ticks, set_scale
from sweep.model.quantity import Array, Quantity, Truths

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: matplotlib settings of every figure of this package.
STYLE: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 8.0,
    "axes.titlesize": 9.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 8.0,
    "xtick.labelsize": 7.5,
    "ytick.labelsize": 7.5,
    "legend.fontsize": 7.5,
    "legend.title_fontsize": 7.0,
    "hatch.linewidth": 0.6,
    "axes.linewidth": 0.7,
    "pdf.fonttype": 42,
    "svg.hashsalt": "eulerdisk",
}

#: All settings: matplotlib's own defaults where the style says nothing. The backend is the program's.
_SETTINGS = {
    name: value for name, value in matplotlib.rcParamsDefault.items() if not name.startswith("backend")
} | STYLE

#: Largest number of points of the measured boundary that are drawn: more would merge into a thick line.
MOST_POINTS = 24

#: Colour map of the peak tilt: perceptually uniform, colour-blind safe, light for small tilts.
COLOURS = ListedColormap(colormaps["viridis_r"](np.linspace(0.0, 0.86, 256)), name="peak_tilt")

INK = "black"
HALO = [withStroke(linewidth=2.4, foreground="white")]

_LINES: dict[str, dict[str, Any]] = {
    "analytic": {"color": INK, "linewidth": 1.3, "zorder": 3},
    "predicted": {"color": "#c8380a", "linewidth": 1.4, "linestyle": (0, (4, 2)), "zorder": 4},
}
_POINTS: dict[str, Any] = {
    "linestyle": "",
    "color": INK,
    "markersize": 3.4,
    "markerfacecolor": "white",
    "markeredgewidth": 0.8,
    "elinewidth": 0.8,
    "capsize": 1.6,
    "zorder": 5,
}
_MARKERS = {"upper": "o", "lower": "s"}
_VERDICTS = {"stable": ("o", "white"), "unstable": ("o", INK), "undecided": ("x", INK)}

#: Distance [in] of the legend below the axes: there the labels end.
_BELOW = 0.5

#: Side of the raster of points on which a place for a word is sought, and width over height of the word.
_RASTER, _WORD = 80, 4.0

#: Samples between two corners of a line, to find the points of the raster that it covers.
_DENSE = 20

#: Least distance [points of the raster] between the middle of a word and the next region or line.
_ROOM = 2.4


@contextmanager
def styled() -> Iterator[None]:
    """Draw in the style of this package alone, whatever matplotlib was told by files or programs."""
    with matplotlib.rc_context(_SETTINGS):
        yield


@contextmanager
def sheet(width: float, height: float) -> Iterator[Figure]:
    """Give an empty figure [in] in the style of this package: on an Agg canvas, not registered with pyplot."""
    with styled():
        drawn = Figure(figsize=(width, height), layout="constrained")
        FigureCanvasAgg(drawn)
        yield drawn


def draw_map(axes: "Axes", panel: Panel, norm: LogNorm) -> None:
    """Draw a panel of two axes."""
    assert panel.y is not None
    peak = np.ma.masked_where(panel.no_result, np.clip(panel.peak, norm.vmin, norm.vmax))
    axes.pcolormesh(
        panel.x.borders, panel.y.borders, peak, norm=norm, cmap=COLOURS, rasterized=True, zorder=0
    )
    set_scale(axes, "x", panel.x)
    set_scale(axes, "y", panel.y)
    hatch(axes, panel, panel.no_result, panel.lost, facecolor="0.85", hatch="xxxx")
    hatch(axes, panel, panel.undecided, "undecided", facecolor=(1.0, 1.0, 1.0, 0.45), hatch="////")
    hatch(axes, panel, panel.marked, panel.marking, facecolor=(1.0, 1.0, 1.0, 0.3), hatch="....")
    if panel.edges:
        _draw_edges(axes, panel)
    if not any(edge.measured.size and np.isfinite(edge.critical).any() for edge in panel.edges):
        _draw_outline(axes, panel)
    name_regions(axes, panel, panel.verdicts())
    if panel.unit is not None:
        add_scaled_axis(axes, "y", panel.y, panel.unit)


def draw_ratio(axes: "Axes", panel: Panel) -> None:
    """Draw the ratio of the boundary to the analytic line, which a map is too coarse to show."""
    axes.axhline(1.0, **_LINES["analytic"])
    for edge in panel.edges:
        _draw_points(axes, edge.name, edge.x, edge.ratio, edge.ratio_error)
        axes.plot(edge.fine_x, edge.predicted_ratio, **_LINES["predicted"])
    axes.set_ylim(*_ratio_ends(panel))
    axes.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    axes.set_ylabel("rate$^2$ / analytic", fontsize=7.0)


def draw_profile(axes: "Axes", panel: Panel) -> None:
    """Draw a panel of one axis: the peak tilt with the verdicts, and the boundary as vertical lines."""
    peak = np.where(panel.no_result, np.nan, panel.peak)
    axes.plot(panel.x.values, peak, color="0.6", zorder=1)
    for name, cells in (*panel.verdicts(), ("undecided", panel.undecided)):
        if cells.any():
            marker, face = _VERDICTS[name]
            axes.plot(
                panel.x.values[cells],
                peak[cells],
                marker,
                color=INK,
                markersize=3.5,
                markerfacecolor=face,
                label=name,
            )
    if panel.marked.any():
        axes.plot(
            panel.x.values[panel.marked],
            peak[panel.marked],
            "x",
            color="#c8380a",
            markersize=5.0,
            label=panel.marking,
        )
    set_scale(axes, "x", panel.x)
    for edge in panel.edges:
        for low, high in zip(edge.measured - edge.error[0], edge.measured + edge.error[1], strict=True):
            axes.axvspan(low, high, color="0.8", zorder=0, label=f"bracket of the {panel.method} boundary")
        for place in edge.critical[np.isfinite(edge.critical)]:
            axes.axvline(place, label=f"analytic: {panel.line}", **_LINES["analytic"])
        for place in edge.predicted[np.isfinite(edge.predicted)]:
            axes.axvline(place, label=f"predicted, {panel.criterion}", **_LINES["predicted"])
    _set_peak_scale(axes, peak, panel.peak_quantity)
    if panel.unit is not None:
        add_scaled_axis(axes, "x", panel.x, panel.unit)


def _ratio_ends(panel: Panel) -> tuple[float, float]:
    """Return the ends of a strip: they show the part of the boundary that lies nearest to the line, about 60 %."""
    low = np.concatenate([edge.ratio - edge.ratio_error[0] for edge in panel.edges])
    high = np.concatenate([edge.ratio + edge.ratio_error[1] for edge in panel.edges])
    window = np.clip(1.5 * np.nanquantile(np.maximum(1.0 - low, high - 1.0), 0.6), 0.005, 0.5)
    lowest, highest = max(1.0 - window, np.nanmin(low)), min(1.0 + window, np.nanmax(high))
    return min(lowest, 1.0) - 0.2 * window, max(highest, 1.0) + 0.2 * window


def _draw_edges(axes: "Axes", panel: Panel) -> None:
    several = sum(edge.measured.size > 0 for edge in panel.edges) > 1
    lines = [(edge.fine_x, edge.critical) for edge in panel.edges]
    if panel.joined:
        # both edges are one curve: out along one, back along the other
        (x, fast), (back, slow) = ((x[np.isfinite(y)], y[np.isfinite(y)]) for x, y in lines)
        lines = [(np.concatenate((x, back[::-1])), np.concatenate((fast, slow[::-1])))]
    for edge in panel.edges:
        label = f"{panel.method} boundary with its bracket" + (f", {edge.name}" if several else "")
        _draw_points(axes, edge.name, edge.x, edge.measured, edge.error, label)
        _draw_line(axes, panel, "predicted", edge.fine_x, edge.predicted, f", {panel.criterion}")
    for x, y in lines:
        _draw_line(axes, panel, "analytic", x, y, f": {panel.line}")
    if panel.joined:
        _name_ends(axes, panel, *lines[0][1][[0, -1]])
    else:
        _name_line(axes, panel, lines[0][1])


def _draw_line(axes: "Axes", panel: Panel, kind: str, x: Array, y: Array, words: str) -> None:
    finite = y[np.isfinite(y)]
    if panel.y is None or not finite.size:
        return
    low, high = panel.y.ends
    seen = np.any((finite >= low) & (finite <= high))
    label = f"{kind}{words}" + ("" if seen else " (outside the map)")
    axes.plot(x, y, label=label, path_effects=HALO, **_LINES[kind])


def _draw_points(axes: "Axes", edge: str, x: Array, y: Array, error: Array, label: str = "") -> None:
    if not x.size:
        return
    some = np.unique(np.linspace(0, x.size - 1, min(x.size, MOST_POINTS)).round().astype(int))
    axes.errorbar(
        x[some], y[some], yerr=error[:, some], label=label or None, marker=_MARKERS[edge], **_POINTS
    )


def _draw_outline(axes: "Axes", panel: Panel) -> None:
    """Draw the borders of the unstable cells, for a map without a boundary along an axis and a line of theory."""
    assert panel.y is not None
    x, y, unstable = panel.x.borders, panel.y.borders, dict(panel.verdicts())["unstable"]
    rows, columns = np.nonzero(unstable[:, 1:] != unstable[:, :-1])
    upright = np.stack((np.tile(x[columns + 1], (2, 1)), [y[rows], y[rows + 1]])).T
    rows, columns = np.nonzero(unstable[1:] != unstable[:-1])
    level = np.stack(([x[columns], x[columns + 1]], np.tile(y[rows + 1], (2, 1)))).T
    borders = LineCollection([*upright, *level], colors=INK, linewidths=1.0, capstyle="projecting", zorder=3)
    axes.add_collection(borders, autolim=False)


def hatch(axes: "Axes", panel: Panel, cells: Truths, label: str, **look: Any) -> None:
    """Hatch cells, with one path: a rectangle for every run of cells in a column."""
    if not cells.any():
        return
    assert panel.y is not None
    x, y = panel.x.borders, panel.y.borders
    ends = np.diff(np.pad(cells.astype(int), ((1, 1), (0, 0))), axis=0)
    columns, first = np.nonzero(ends.T == 1)
    last = np.nonzero(ends.T == -1)[1]
    corners = [
        Outline([(x[i], y[a]), (x[i + 1], y[a]), (x[i + 1], y[b]), (x[i], y[b]), (x[i], y[a])], closed=True)
        for i, a, b in zip(columns, first, last, strict=True)
    ]
    shape = Outline.make_compound_path(*corners)
    axes.add_patch(PathPatch(shape, label=label, edgecolor="0.25", linewidth=0.0, zorder=1, **look))


def name_regions(
    axes: "Axes", panel: Panel, regions: Iterable[tuple[str, Truths]], lines: int = 1, width: float = _WORD
) -> list[str]:
    """Write the name of each region where it has most room, so that a map can be read without colours.

    `regions` holds names and cells; each name has `lines` lines and is `width` times as wide as a line is high.
    Returns the names that had no room.
    """
    left_out = []
    assert panel.y is not None
    middles = (np.arange(_RASTER) + 0.5) / _RASTER
    across, up = np.meshgrid(middles, middles)
    to_data = axes.transAxes + axes.transData.inverted()
    x, y = to_data.transform(np.column_stack((across.ravel(), up.ravel()))).T
    column = np.searchsorted(panel.x.borders, x) - 1
    row = np.searchsorted(panel.y.borders, y) - 1
    inside = (column >= 0) & (column < len(panel.x.values)) & (row >= 0) & (row < len(panel.y.values))
    free = inside.reshape(_RASTER, _RASTER) & ~_covered(axes)
    column, row = column.clip(0, len(panel.x.values) - 1), row.clip(0, len(panel.y.values) - 1)
    for name, cells in regions:
        region = np.pad(cells[row, column].reshape(_RASTER, _RASTER) & free, 1)
        room = distance_to_outside(region, (1.0 / lines, 1.0 / width))[1:-1, 1:-1]
        if room.max() >= _ROOM:
            place = np.unravel_index(np.argmax(room), room.shape)
            axes.text(
                middles[place[1]], middles[place[0]], name, transform=axes.transAxes, ha="center", va="center",
                weight="bold", path_effects=HALO, zorder=6,
            )  # fmt: skip
        elif cells.any():
            left_out.append(name)
    return left_out


def _covered(axes: "Axes") -> Truths:
    """Return the points of the raster that a line or a word covers, shape (_RASTER, _RASTER)."""
    covered = np.zeros((_RASTER, _RASTER), dtype=bool)
    for line in axes.get_lines():
        corners = (axes.transData + axes.transAxes.inverted()).transform(line.get_xydata()) * _RASTER
        along = np.linspace(0.0, len(corners) - 1.0, _DENSE * len(corners))
        x, y = (np.interp(along, np.arange(len(corners)), column) for column in corners.T)
        on = np.isfinite(x) & np.isfinite(y) & (np.minimum(x, y) >= 0) & (np.maximum(x, y) < _RASTER)
        covered[y[on].astype(int), x[on].astype(int)] = True
    for word in axes.texts:
        box = word.get_window_extent().transformed(axes.transAxes.inverted())
        left, bottom, right, top = (np.array(box.extents) * _RASTER).astype(int).clip(0)
        covered[bottom : top + 1, left : right + 1] = True
    return covered


def _name_line(axes: "Axes", panel: Panel, line: Array) -> None:
    """Write the formula beside an analytic line that is horizontal and inside the map."""
    assert panel.y is not None
    low, high = panel.y.ends
    if np.isfinite(line).all() and np.ptp(line) <= 1e-9 * abs(line[0]) and low < line[0] < high:
        axes.annotate(
            panel.line, (1.0, line[0]), (-3.0, 3.0), xycoords=("axes fraction", "data"),
            textcoords="offset points", ha="right", va="bottom", path_effects=HALO, zorder=6,
        )  # fmt: skip


def _name_ends(axes: "Axes", panel: Panel, *ends: float) -> None:
    """Name the two ends of a curve that both edges form, where it meets zero of the coordinate."""
    assert panel.y is not None
    assert panel.joined is not None
    for height, name, offset in zip(ends, panel.joined, ((14.0, 17.0), (45.0, 9.0)), strict=True):
        if panel.y.ends[0] <= height <= panel.y.ends[1]:
            axes.plot(0.0, height, "D", color=INK, markersize=4.5, clip_on=False, zorder=7)
            axes.annotate(
                name, (0.0, height), offset, textcoords="offset points", fontsize=7.0, ha="left", va="center",
                arrowprops={"arrowstyle": "-", "linewidth": 0.6, "shrinkB": 3.0}, path_effects=HALO, zorder=6,
            )  # fmt: skip


def _set_peak_scale(axes: "Axes", peak: Array, quantity: Quantity) -> None:
    axes.set_ylabel(quantity.plot_label)
    positive = peak[np.isfinite(peak) & (peak > 1e-30)]
    if positive.size and positive.max() > SQUEEZED * positive.min():
        axes.set_yscale("log")
        set_log_ticks(axes.yaxis, positive.max() / positive.min())


def add_legend(axes: "Axes", lowest: "Axes", caption: str) -> None:
    """Put the legend of `axes` below `lowest`, where it covers nothing; `caption` is its title."""
    handles, labels = axes.get_legend_handles_labels()
    named = dict(zip(labels, handles, strict=True))
    # the measurement first
    order = sorted(named, key=lambda label: not isinstance(named[label], ErrorbarContainer))
    below = lowest.transAxes + ScaledTranslation(0.0, -_BELOW, lowest.figure.dpi_scale_trans)
    lowest.legend(
        [named[label] for label in order], order, title=caption, loc="upper left", bbox_to_anchor=(0.0, 0.0),
        bbox_transform=below, alignment="left", frameon=False, borderpad=0.0, borderaxespad=0.0, handlelength=2.4,
    )  # fmt: skip
