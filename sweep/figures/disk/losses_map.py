"""The map of losses: how long the disk stays aloft from each start, and which law took most of its energy."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize, to_rgb
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator

from sweep.atlas.dataset import in_order, require
from sweep.figures.drawing import INK, Bar, draw_cells, explain_colour, hatch
from sweep.figures.layout import Block, figure_of
from sweep.figures.look import Look, columns_of
from sweep.figures.panels import Panel, drawn_spec, file_names, fixed_parameters, map_panel
from sweep.figures.shade import common_norm, is_wide
from sweep.model.lossy_disk.tables import ENDINGS, LOSSES, VARIABLES
from sweep.model.quantity import Array, Truths

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes


#: Measure of a loss -> colour, from Okabe and Ito's palette, which is safe for the colour-blind.
COLOURS: Mapping[str, str] = {
    "rolling_loss": "#E69F00",
    "pivoting_loss": "#CC79A7",
    "contour_loss": "#0072B2",
    "damping_loss": "#56B4E9",
    "air_loss": "#009E73",
}


#: Width and least width of a panel [in]; panels in a row.
_WIDTHS, _IN_ROW = (3.6, 2.2), 2

#: Variables that the figure needs.
_NEEDED = ("end_time", "largest_loss", "ending")

#: Strength of a hue at the shortest and at the longest time, the colour of the bar that explains it, and the colour of
#: cells without losses.
_STRENGTH, _GREY, _NONE = (0.18, 0.95), "0.25", "0.6"

#: Background of the numbers of contour lines.
_BESIDE: dict[str, Any] = {
    "boxstyle": "round,pad=0.08",
    "facecolor": "white",
    "alpha": 0.85,
    "linewidth": 0.0,
}

#: Largest number of contour lines, and distance of their numbers from the border, divided by the width or height of a
#: map.
_MOST_LINES, _FROM_BORDER = 6, 0.04

#: Ending -> label of its cells, and their hatching over the hue of the loss.
_ENDS: Mapping[str, tuple[str, dict[str, Any]]] = {
    "horizon": ("aloft at the end of the duration", {"facecolor": "none", "hatch": "...."}),
    "rest": ("held at rest", {"facecolor": "none", "hatch": "\\\\\\\\"}),
    "lift_off": ("lifts off", {"facecolor": "none", "hatch": "////"}),
    "slip": ("slips", {"facecolor": "none", "hatch": "----"}),
}


@dataclass(frozen=True)
class LossesMap:
    """Everything that is drawn of one atlas; arrays have the shape (rows of y, columns of x).

    `times` are in s, NaN where the time aloft is unknown; `loss` is a code of the variable largest_loss; `ended` maps
    each ending of `_ENDS` to its cells.
    """

    panel: Panel
    caption: tuple[str, ...]
    times: Array
    loss: npt.NDArray[np.int8]
    ended: Mapping[str, Truths]

    def regions(self) -> list[tuple[str, Truths]]:
        """Return the name and the cells of each loss."""
        known = np.isfinite(self.times)
        return [
            (name.replace("_", "\n"), known & (self.loss == code))
            for code, name in enumerate(LOSSES, 1)
            if (known & (self.loss == code)).any()
        ]


def in_words(name: str) -> str:
    """Return the label of a loss in the table `sweep.model.lossy_disk.tables.LOSSES`."""
    return name.replace("_", " ")


def losses_map(dataset: "xr.Dataset", look: Look | None = None) -> LossesMap:
    """Return what is drawn of an atlas of two axes, or of a selection from one; raises as `figure` does."""
    require(dataset, _NEEDED)
    drawn = map_panel(dataset, look, "losses")
    assert drawn.y is not None
    order = (drawn.y.quantity.name, drawn.x.quantity.name)
    times, loss, ending = (in_order(dataset[name], order) for name in _NEEDED)
    ended = {name: np.asarray(ending == ENDINGS.code(name)) for name in _ENDS}
    # if the model ends before the motion does, the time aloft is unknown
    unknown = drawn.no_result | ended["lift_off"] | ended["slip"]
    spec = drawn_spec(dataset)
    return LossesMap(
        panel=drawn,
        caption=(fixed_parameters(spec), *_air(spec.air_law)),
        times=np.where(unknown, np.nan, times),
        loss=np.asarray(loss, np.int8),
        ended=ended,
    )


def _air(law: str) -> tuple[str, ...]:
    return () if law == "none" else (f"drag of air: {law.capitalize()}",)


def figure(datasets: "Sequence[xr.Dataset]", look: Look | None = None) -> Figure:
    """Draw the time aloft of atlases of two axes, or of selections from atlases, one panel each.

    The hue of a cell shows which law took most of the energy, its strength shows the time; lines connect equal times.

    Raises
    ------
    RequestError
        If an atlas does not have two axes, or has no losses.
    """
    look = look or Look()
    maps = [losses_map(dataset, look) for dataset in datasets]
    norm = _common_norm(maps)
    columns = min(_IN_ROW, columns_of(len(maps), look, *_WIDTHS))
    return figure_of(
        maps, lambda axes, each: _block(axes, each, norm), look, _WIDTHS, columns=columns,
        bar=_bar(norm), files=file_names(datasets),
    )  # fmt: skip


def _common_norm(maps: Sequence[LossesMap]) -> Normalize:
    shades = [replace(each.panel.shade, quantity=VARIABLES["end_time"], values=each.times) for each in maps]
    return common_norm(shades, "" if not any(is_wide(each.times) for each in maps) else "end_time")


def _block(axes: "Axes", each: LossesMap, norm: Normalize) -> Block:
    panel = each.panel
    draw_cells(axes, panel, _colours(each, norm))
    for name, (words, look) in _ENDS.items():
        hatch(axes, panel, each.ended[name], words, **look)
    hatch(axes, panel, panel.no_result, panel.lost, facecolor="0.85", hatch="xxxx")
    _draw_lines(axes, each)
    for code, name in enumerate(LOSSES, 1):
        if (np.isfinite(each.times) & (each.loss == code)).any():
            explain_colour(axes, COLOURS[LOSSES[name][1]], f"{in_words(name)} took most")
    return Block(axes, panel, panel.title, each.caption, regions=each.regions())


def _colours(each: LossesMap, norm: Normalize) -> Array:
    """Return the colour of every cell, shape (rows, columns, 4): the hue of its loss, stronger for longer times."""
    part = np.asarray(norm(np.where(np.isfinite(each.times), each.times, norm.vmin or 0.0)), np.float64).clip(
        0.0, 1.0
    )
    found = np.ones((*each.times.shape, 4))
    for code, (_, measure) in enumerate([("", ""), *LOSSES.values()]):
        cells = np.isfinite(each.times) & (each.loss == code)
        found[cells, :3] = _mix_with_white(COLOURS.get(measure, _NONE), part[cells])
    found[~np.isfinite(each.times), 3] = 0.0
    return found


def _mix_with_white(colour: str, part: Array) -> Array:
    """Return mixtures of white and a colour, shape (n, 3)."""
    strength = np.interp(part, (0.0, 1.0), _STRENGTH)[:, np.newaxis]
    return np.asarray(1.0 - strength * (1.0 - np.array(to_rgb(colour))))


def _bar(norm: Normalize) -> Bar:
    """Return the bar that shows the time for each strength of a hue, in grey on behalf of all hues."""
    greys = _mix_with_white(_GREY, np.linspace(0.0, 1.0, 256))
    colours = LinearSegmentedColormap.from_list("time", list(map(tuple, greys)))
    return Bar(ScalarMappable(norm, colours), "time aloft (s)")


def _draw_lines(axes: "Axes", each: LossesMap) -> None:
    """Draw lines of equal times with their numbers, among the motions that ended."""
    panel = each.panel
    assert panel.y is not None
    times = np.where(each.ended["horizon"], np.nan, each.times)
    known = times[np.isfinite(times)]
    if known.size < 2:
        return
    levels = _levels(known)
    lines = axes.contour(
        panel.x.values,
        panel.y.values,
        np.ma.masked_invalid(times),
        levels,
        colors=INK,
        linewidths=0.8,
        zorder=3,
    )
    for text in axes.clabel(lines, fmt=lambda level: f"{level:g} s", fontsize="smaller", inline=False):
        text.set_bbox(_BESIDE)
        place = axes.transAxes.inverted().transform(axes.transData.transform(text.get_position()))
        # remove numbers that the border would clip
        if min(*place, *(1.0 - place)) < _FROM_BORDER:
            text.remove()


def _levels(times: Array) -> list[float]:
    """Return round times between the shortest and the longest."""
    low, high = float(times.min()), float(times.max())
    locator = (
        LogLocator(subs=(1.0, 2.0, 5.0)) if is_wide(times) else MaxNLocator(_MOST_LINES, steps=[1, 2, 5, 10])
    )
    found = [float(each) for each in locator.tick_values(low, high) if low < each < high]
    return found[:: -(-len(found) // _MOST_LINES) or 1]
