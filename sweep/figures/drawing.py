"""Draw a panel on matplotlib axes: map, strip or profile, boundary, lines of theory, hatching."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Colormap, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch, Rectangle
from matplotlib.path import Path as Outline
from matplotlib.patheffects import AbstractPathEffect, withStroke
from matplotlib.ticker import LogLocator, MaxNLocator

from sweep.errors import RequestError
from sweep.figures.look import Look
from sweep.figures.panels import MIXED, Edge, Panel
from sweep.figures.room import HALO
from sweep.figures.scales import add_second_axis, set_log_ticks, set_scale
from sweep.figures.shade import COLOURS, LEAST, Shade, common_norm, flag_colours, is_wide
from sweep.figures.texts import number
from sweep.model.quantity import Array, Truths, with_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes


#: Largest number of drawn points of a measured boundary, and of drawn cells of a profile: more would merge.
MOST_POINTS, _MOST_CELLS = 24, 60

#: Largest distance of boundary / analytic line from 1 at which a strip shows both.
_NEAR_LINE = 0.5

INK = "black"

#: Suffix in the legend for a line of theory that is not on the map.
OUTSIDE = " (outside the map)"

LINES: dict[str, dict[str, Any]] = {
    "analytic": {"color": INK, "linewidth": 1.3, "zorder": 3},
    "predicted": {"color": "#c8380a", "linewidth": 1.4, "linestyle": (0, (4, 2)), "zorder": 4},
}
_POINTS: dict[str, Any] = {
    "linestyle": "",
    "color": INK,
    "markersize": 3.4,
    "markerfacecolor": "white",
    "markeredgewidth": 0.8,
    "elinewidth": 0.9,
    # caps would fill a marker that is larger than its bracket
    "capsize": 0.0,
    "zorder": 5,
}
_MARKERS = {"upper": "o", "lower": "s"}
_VERDICTS = {"stable": ("o", "white"), "unstable": ("o", INK), "undecided": ("x", INK)}

#: Hatching of cells: no result, no value of the quantity, no verdict, marked, mixed verdicts.
_LOST: dict[str, Any] = {"facecolor": "0.85", "hatch": "xxxx"}
_ABSENT: dict[str, Any] = {"facecolor": "0.95", "hatch": "\\\\\\\\"}
_UNDECIDED: dict[str, Any] = {"facecolor": (1.0, 1.0, 1.0, 0.7), "hatch": "////"}
_MARKED: dict[str, Any] = {"facecolor": (1.0, 1.0, 1.0, 0.3), "hatch": "...."}
_MIXED: dict[str, Any] = {"facecolor": (1.0, 1.0, 1.0, 0.3), "hatch": "ooo"}

#: Contour lines: white between black edges, so that they are visible on every colour and differ from all other lines.
_CONTOUR: dict[str, Any] = {"colors": "white", "linewidths": 0.9, "linestyles": "solid", "zorder": 2.5}
CONTOUR_EDGE: list[AbstractPathEffect] = [withStroke(linewidth=2.0, foreground="0.2")]

#: Colour of hatching.
_EDGE = "0.25"


@dataclass(frozen=True)
class Colouring:
    """The mapping from values to colours, shared by panels: colour map, norm, and levels of contour lines."""

    colours: Colormap
    norm: Normalize
    levels: tuple[float, ...] = ()


def draw_map(axes: "Axes", panel: Panel, colouring: Colouring, second: bool = True) -> None:
    """Draw a panel of two axes; `second` says whether rates get a second axis in pure numbers."""
    assert panel.y is not None
    values, norm = panel.shade.values, colouring.norm
    if panel.shade.quantity.flags is None:
        values = np.clip(values, norm.vmin, norm.vmax)
    draw_cells(axes, panel, np.ma.masked_invalid(values), second, norm=norm, cmap=colouring.colours)
    missing = np.isnan(panel.shade.values)
    hatch(axes, panel, panel.no_result & missing, panel.lost, **_LOST)
    hatch(axes, panel, panel.shade.absent, panel.shade.absence, **_ABSENT)
    if panel.shade.quantity.flags is None:
        hatch(axes, panel, panel.undecided & ~missing, "undecided", **_UNDECIDED)
    hatch(axes, panel, panel.marked, panel.marking, **_MARKED)
    # a map of endings shows these borders by its colours
    has_outline = not panel.has_line and panel.shade.quantity.name != "ending"
    if has_outline and panel.shade.quantity.flags is None:
        hatch(axes, panel, panel.mixed, f"{MIXED}: stable and unstable cells alternate", **_MIXED)
    if colouring.levels:
        _draw_contours(axes, panel, colouring.levels)
    _draw_flags(axes, panel, colouring)
    if panel.edges:
        _draw_edges(axes, panel)
    if has_outline:
        _draw_outline(axes, panel)


def draw_cells(axes: "Axes", panel: Panel, colours: Any, second: bool = True, **look: Any) -> None:
    """Draw the colours of the cells of a map, and set its axes; `second` as in `draw_map`."""
    assert panel.y is not None
    axes.pcolormesh(panel.x.borders, panel.y.borders, colours, rasterized=True, zorder=0, **look)
    set_scale(axes, "x", panel.x)
    set_scale(axes, "y", panel.y)
    if second:
        add_second_axis(axes, "y", panel.y)


def explain_colour(axes: "Axes", colour: Any, label: str) -> None:
    """Add a colour to the legend."""
    axes.add_patch(
        Rectangle((0.0, 0.0), 0.0, 0.0, facecolor=colour, edgecolor=INK, linewidth=0.4, label=label)
    )


def draw_ratio(axes: "Axes", panel: Panel) -> None:
    """Draw the ratio of the boundary to the analytic line, which differ too little to be seen on a map."""
    axes.axhline(1.0, **LINES["analytic"])
    for edge in panel.edges:
        _draw_points(axes, edge.name, edge.x, edge.ratio, edge.ratio_error)
        axes.plot(edge.fine_x, edge.predicted_ratio, **LINES["predicted"])
    axes.set_ylim(*_ratio_ends(panel))
    axes.yaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10]))
    axes.set_ylabel("boundary\n/ analytic")


def draw_profile(axes: "Axes", panel: Panel) -> None:
    """Draw a panel of one axis: the quantity with the verdicts, and the boundary as vertical lines."""
    x, values = panel.x.values, panel.shade.values
    flags = panel.shade.quantity.flags
    axes.plot(x, values, color="0.6", zorder=1, drawstyle="default" if flags is None else "steps-mid")
    for name, cells in (*panel.verdicts(), ("undecided", panel.undecided)):
        some = _choose_cells(cells & np.isfinite(values))
        if some.size:
            marker, face = _VERDICTS[name]
            axes.plot(
                x[some], values[some], marker, color=INK, markersize=3.5, markerfacecolor=face, label=name
            )
    if panel.marked.any():
        some = _choose_cells(panel.marked & np.isfinite(values))
        axes.plot(x[some], values[some], "+", color="#c8380a", markersize=5.0, label=panel.marking)
    set_scale(axes, "x", panel.x)
    _span(axes, panel, panel.no_result & np.isnan(values), panel.lost, **_LOST)
    _span(axes, panel, panel.shade.absent, panel.shade.absence, **_ABSENT)
    for edge in panel.edges:
        for low, high in zip(edge.measured - edge.error[0], edge.measured + edge.error[1], strict=True):
            label = f"bracket of the {panel.method} boundary"
            axes.axvspan(low, high, facecolor="0.8", edgecolor="0.6", linewidth=0.8, zorder=0, label=label)
        for place in edge.critical[np.isfinite(edge.critical)]:
            axes.axvline(place, label=f"analytic: {panel.line}", **LINES["analytic"])
        for place in edge.predicted[np.isfinite(edge.predicted)]:
            axes.axvline(place, label=panel.predicted, **LINES["predicted"])
    # do not stretch the axis to lines of theory outside the atlas
    axes.set_xlim(*panel.x.ends)
    _set_height(axes, panel)
    add_second_axis(axes, "x", panel.x)


def _choose_cells(cells: Truths) -> Any:
    """Return the indices of the cells to draw, including the first and the last of every run."""
    places = np.flatnonzero(cells)
    step = -(-len(cells) // _MOST_CELLS)
    _, first, last = _runs(cells[:, np.newaxis])
    return np.union1d(places[places % step == 0], np.concatenate((first, last - 1)))


def _runs(cells: Truths) -> tuple[Any, Any, Any]:
    """Return the runs of cells in the columns of a map: columns, first rows, and the rows after their last."""
    ends = np.diff(np.pad(cells.astype(int), ((1, 1), (0, 0))), axis=0).T
    columns, first = np.nonzero(ends == 1)
    return columns, first, np.nonzero(ends == -1)[1]


def _span(axes: "Axes", panel: Panel, cells: Truths, label: str, **look: Any) -> None:
    """Hatch runs of cells of a profile from bottom to top."""
    _, first, last = _runs(cells[:, np.newaxis])
    for low, high in zip(panel.x.borders[first], panel.x.borders[last], strict=True):
        axes.axvspan(low, high, label=label, edgecolor=_EDGE, linewidth=0.0, zorder=0, **look)


def _set_height(axes: "Axes", panel: Panel) -> None:
    """Set the y axis of a profile."""
    quantity, values = panel.shade.quantity, panel.shade.values
    axes.set_ylabel(quantity.plot_label)
    if quantity.flags is not None:
        codes = panel.shade.codes
        axes.set_yticks(codes, [quantity.flag(code) for code in codes])
        axes.set_ylim(min(codes, default=0) - 0.5, max(codes, default=0) + 0.5)
    elif is_wide(values):
        positive = values[np.isfinite(values) & (values > LEAST)]
        axes.set_yscale("log", nonpositive="clip")
        set_log_ticks(axes.yaxis, positive.max() / positive.min())
    elif not np.isfinite(values).any():
        axes.set_yticks([])


def _ratio_ends(panel: Panel) -> tuple[float, float]:
    """Return the ends of a strip: they show about 60 % of the boundary, the part nearest to the line.

    If most of the boundary is far from the line, the strip shows only the boundary, and the line too if some of it is
    near.
    """
    low = np.concatenate([edge.ratio - edge.ratio_error[0] for edge in panel.edges])
    high = np.concatenate([edge.ratio + edge.ratio_error[1] for edge in panel.edges])
    distance = np.maximum(1.0 - low, high - 1.0)
    if np.nanquantile(distance, 0.6) > _NEAR_LINE:
        # a few points where the analytic rate is almost zero would flatten the rest
        ends = [np.nanmin(low), min(np.nanmax(high), 3.0 * np.nanquantile(high, 0.6))]
        ends += [1.0] if np.nanmin(distance) <= _NEAR_LINE else []
        margin = max(0.1 * (max(ends) - min(ends)), 0.02 * abs(max(ends)))
        return min(ends) - margin, max(ends) + margin
    window = np.clip(1.5 * np.nanquantile(distance, 0.6), 0.005, _NEAR_LINE)
    lowest, highest = max(1.0 - window, np.nanmin(low)), min(1.0 + window, np.nanmax(high))
    return min(lowest, 1.0) - 0.2 * window, max(highest, 1.0) + 0.2 * window


def _draw_edges(axes: "Axes", panel: Panel) -> None:
    several = sum(edge.measured.size > 0 for edge in panel.edges) > 1
    for edge in panel.edges:
        label = f"{panel.method} boundary with its bracket" + (f", {edge.name}" if several else "")
        # do not clip a point in the first column
        _draw_points(axes, edge.name, edge.x, edge.measured, edge.error, label, clip_on=False)
        _draw_line(axes, panel, "predicted", edge.fine_x, edge.predicted, panel.predicted)
    ends = f", from {panel.joined[0]} to {panel.joined[1]}" if panel.joined else ""
    for x, y in analytic_lines(panel):
        _draw_line(axes, panel, "analytic", x, y, f"analytic: {panel.line}{ends}")
    if panel.joined is not None and panel.y is not None:
        for height in (each for each in joined_heights(panel) if each is not None):
            axes.plot(0.0, height, "D", color=INK, markersize=4.5, clip_on=False, zorder=7)


def analytic_lines(panel: Panel) -> list[tuple[Array, Array]]:
    """Return the analytic line of every edge, or a single curve where both edges are one."""
    lines = [(edge.fine_x, edge.critical) for edge in panel.edges]
    if panel.joined:
        # along one edge to its end, then back along the other
        (x, fast), (back, slow) = ((x[np.isfinite(y)], y[np.isfinite(y)]) for x, y in lines)
        return [(np.concatenate((x, back[::-1])), np.concatenate((fast, slow[::-1])))]
    return lines


def joined_heights(panel: Panel) -> list[float | None]:
    """Return the heights at which the joined curve meets zero of the coordinate; None for one outside the map."""
    assert panel.y is not None
    low, high = panel.y.ends
    ends = analytic_lines(panel)[0][1][[0, -1]]
    return [float(height) if low <= height <= high else None for height in ends]


def _draw_line(axes: "Axes", panel: Panel, kind: str, x: Array, y: Array, name: str) -> None:
    finite = y[np.isfinite(y)]
    if panel.y is None or not finite.size:
        return
    low, high = panel.y.ends
    seen = np.any((finite >= low) & (finite <= high))
    label = name + ("" if seen else OUTSIDE)
    axes.plot(x, y, label=label, path_effects=HALO, **LINES[kind])


def _draw_points(
    axes: "Axes", edge: str, x: Array, y: Array, error: Array, label: str = "", **look: Any
) -> None:
    if not x.size:
        return
    some = evenly(x.size)
    words = {
        "label": f"{label}{_thinning(x.size)}" if label else None,
        "marker": _MARKERS[edge],
        **_POINTS,
        **look,
    }
    # draws brackets above markers, so that one shorter than its marker is visible
    axes.errorbar(x[some], y[some], yerr=error[:, some], barsabove=True, **words)


def _step(count: int) -> int:
    """Return the distance, in points, between two points that are drawn."""
    return max(1, -(-(count - 1) // (MOST_POINTS - 1)))


def evenly(count: int) -> Any:
    """Return the indices of the points to draw: `_step` apart, including the first and the last."""
    step = _step(count)
    places = np.arange(0, count, step)
    rest = count - 1 - places[-1]
    if 2 * rest > step:
        return np.append(places, count - 1)
    # two neighbours at the end would look like a pair
    places[-1] = count - 1
    return places


#: The suffix that `_thinning` adds to a label.
_THINNED = re.compile(r", every \d+[a-z]+$")


def _thinning(count: int) -> str:
    """Return the suffix in the legend for points that are not all drawn."""
    step = _step(count)
    ending = "th" if step % 100 in range(11, 14) else {1: "st", 2: "nd", 3: "rd"}.get(step % 10, "th")
    return f", every {step}{ending}" if step > 1 else ""


def joined(named: Mapping[str, Any]) -> dict[str, Any]:
    """Return the entries of a legend, with those that differ only in their thinning merged into one."""
    groups: dict[str, list[str]] = {}
    for label in named:
        groups.setdefault(_THINNED.sub("", label), []).append(label)
    return {
        labels[0] if len(labels) == 1 else f"{base}, not every one": named[labels[0]]
        for base, labels in groups.items()
    }


def thinning(edges: Sequence[Edge]) -> str:
    """Return the suffix in the legend for edges that share one entry and whose points are not all drawn."""
    found = {_thinning(edge.x.size) for edge in edges}
    return found.pop() if len(found) == 1 else ", not every one" if any(found) else ""


def draw_points(axes: "Axes", edge: Edge, **look: Any) -> None:
    """Draw the measured boundary of one edge with its bracket, in the given look."""
    _draw_points(axes, edge.name, edge.x, edge.measured, edge.error, **look)


def _draw_contours(axes: "Axes", panel: Panel, levels: Sequence[float]) -> None:
    """Draw contour lines of the quantity through the centres of the cells."""
    assert panel.y is not None
    values = np.ma.masked_invalid(panel.shade.values)
    drawn = axes.contour(panel.x.values, panel.y.values, values, levels, **_CONTOUR)
    drawn.set_path_effects(CONTOUR_EDGE)
    quantity = panel.shade.quantity
    values_text = with_unit(", ".join(map(number, levels)), quantity.plot_units)
    label = f"{quantity.name.replace('_', ' ')} of {values_text}"
    axes.plot([], [], color="white", linewidth=0.9, path_effects=CONTOUR_EDGE, label=label)


def _draw_flags(axes: "Axes", panel: Panel, colouring: Colouring) -> None:
    """Add every flag of a map to the legend."""
    for code in panel.shade.codes:
        name = f"{panel.shade.quantity.name.replace('_', ' ')}: {panel.shade.quantity.flag(code)}"
        explain_colour(axes, colouring.colours(colouring.norm(code)), name)


def _draw_outline(axes: "Axes", panel: Panel) -> None:
    """Draw the borders of the unstable cells, for a map that lacks a measured boundary or a line of theory."""
    assert panel.y is not None
    x, y, found = panel.x.borders, panel.y.borders, panel.borders
    rows, columns = found.upright
    upright = np.stack((np.tile(x[columns + 1], (2, 1)), [y[rows], y[rows + 1]])).T
    rows, columns = found.level
    level = np.stack(([x[columns], x[columns + 1]], np.tile(y[rows + 1], (2, 1)))).T
    if not len(upright) + len(level):
        return
    drawn = LineCollection(
        [*upright, *level], colors=INK, linewidths=1.0, capstyle="projecting", zorder=3,
        label="border of the unstable cells",
    )  # fmt: skip
    axes.add_collection(drawn, autolim=False)


def hatch(axes: "Axes", panel: Panel, cells: Truths, label: str, **look: Any) -> None:
    """Hatch cells with a single path: a rectangle for every run of cells in a column."""
    if not cells.any():
        return
    assert panel.y is not None
    x, y = panel.x.borders, panel.y.borders
    corners = [
        Outline([(x[i], y[a]), (x[i + 1], y[a]), (x[i + 1], y[b]), (x[i], y[b]), (x[i], y[a])], closed=True)
        for i, a, b in zip(*_runs(cells), strict=True)
    ]
    shape = Outline.make_compound_path(*corners)
    axes.add_patch(PathPatch(shape, label=label, edgecolor=_EDGE, linewidth=0.0, zorder=1, **look))


def check_same_quantity(panels: Sequence[Panel]) -> None:
    """Raise an error if the quantity is a flag in only some panels: all panels share one colour bar."""
    flags = {each.shade.quantity.flags is not None for each in panels}
    if len(flags) > 1:
        raise RequestError(
            f"{panels[0].shade.quantity.name} is a flag in one atlas and a number in another.",
            "Draw the atlases in two figures.",
            "quantity",
        )


def colours_of(panels: Sequence[Panel], look: Look) -> Colouring:
    """Return the colours of the maps of a figure, the same for all panels, and the levels of their contour lines."""
    maps = [each.shade for each in panels if each.y is not None]
    quantity = panels[0].shade.quantity
    if look.contours is not None and (len(maps) < len(panels) or quantity.flags is not None):
        raise RequestError(
            "Contour lines need two axes and a numeric quantity; "
            + (
                f"{quantity.name} is a flag." if quantity.flags is not None else "an atlas has only one axis."
            ),
            "Leave the contour lines out.",
            "contours",
        )
    if not maps:
        return Colouring(COLOURS, common_norm([panels[0].shade], ""))
    if quantity.flags is not None:
        colours, norm, _ = flag_colours(maps)
        return Colouring(colours, norm)
    scale = common_norm(maps, panels[0].peak)
    return Colouring(COLOURS, scale, () if look.contours is None else _levels(maps, scale, look))


def _levels(maps: Sequence[Shade], scale: Normalize, look: Look) -> tuple[float, ...]:
    """Return the levels of contour lines; at least one is within the range of the values."""
    quantity, low, high = maps[0].quantity, float(scale.vmin or 0.0), float(scale.vmax or 0.0)
    levels = look.levels(quantity) or _automatic(maps, low, high)
    if not any(low <= level <= high for level in levels):
        unit = f" {quantity.shown_units}".rstrip()
        raise RequestError(
            f"No contour line lies on the map: {quantity.name} ranges from {low:.4g} to {high:.4g}{unit} there; got "
            f"{', '.join(f'{level:.4g}{unit}' for level in levels) or 'none'}.",
            f"Give a level in this range; a bare number is in {quantity.units}."
            if quantity.units != "1"
            else "",
            "contours",
        )
    return levels


def _automatic(maps: Sequence[Shade], low: float, high: float) -> tuple[float, ...]:
    """Return round levels for contour lines between the smallest and the largest value."""
    if all(is_wide(each.values) for each in maps):
        found = LogLocator(subs=(1.0,) if high > 1e3 * low else (1.0, 2.0, 5.0)).tick_values(low, high)
    else:
        found = MaxNLocator(6, steps=[1, 2, 5, 10]).tick_values(low, high)
    return tuple(float(each) for each in found if low < each < high)


@dataclass(frozen=True)
class Bar:
    """A colour bar: colours, label and levels of contour lines; `whole` says that the values are integers."""

    colours: ScalarMappable
    label: str
    extend: str = "neither"
    whole: bool = False
    levels: tuple[float, ...] = ()

    def draw(self, drawn: Figure, *, horizontal: bool = False, beside: "Axes | None" = None) -> "Axes":
        """Draw the bar, horizontal with numbers above, or vertical.

        Parameters
        ----------
        drawn : Figure
            Gets new axes for the bar, unless `beside` is given.
        horizontal : bool
            Whether the bar is horizontal.
        beside : Axes, optional
            Axes of a caller, next to which the bar is drawn.
        """
        place: dict[str, Any] = (
            {"cax": drawn.add_axes((0.9, 0.2, 0.02, 0.6))} if beside is None else {"ax": beside}
        )
        direction = ("horizontal", "top") if horizontal else ("vertical", "right")
        axes: Axes = drawn.colorbar(
            self.colours, label=self.label, extend=self.extend, orientation=direction[0],
            ticklocation=direction[1], **place,
        ).ax  # fmt: skip
        axis, norm = axes.xaxis if horizontal else axes.yaxis, self.colours.norm
        if isinstance(norm, LogNorm):
            set_log_ticks(axis, float(norm.vmax or 1.0) / float(norm.vmin or 1.0))
        elif self.whole:
            axis.set_major_locator(MaxNLocator(6, integer=True))
        for level in self.levels:
            (axes.axvline if horizontal else axes.axhline)(
                level, color="white", linewidth=0.9, path_effects=CONTOUR_EDGE
            )
        return axes


def bar_of(panels: Sequence[Panel], colouring: Colouring) -> Bar | None:
    """Return the colour bar of maps; None for flags and profiles."""
    quantity = panels[0].shade.quantity
    maps = [each.shade for each in panels if each.y is not None]
    if quantity.flags is not None or not any(np.isfinite(each.values).any() for each in maps):
        return None
    cut = any((each.values < float(colouring.norm.vmin or 0.0)).any() for each in maps)
    return Bar(
        ScalarMappable(colouring.norm, colouring.colours),
        quantity.plot_label,
        "min" if cut else "neither",
        quantity.dtype.startswith("i"),
        colouring.levels,
    )
