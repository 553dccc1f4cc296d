"""The figure of regimes: one well or two, on one side of upright or across it, with the curve of folds."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from sweep.errors import RequestError
from sweep.figures.drawing import HALO, INK, hatch, name_regions
from sweep.figures.plots import STYLE, add_legend
from sweep.figures.regimes import NAMES, Regimes, regimes
from sweep.figures.ticks import add_scaled_axis, set_scale

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

#: Size of a panel [in], axes and what stands below them.
_WIDTH, _HEIGHT, _LEGEND = 3.6, 3.0, 0.85

#: Panels side by side: rows of a pair compare best.
_IN_ROW = 2

#: Okabe and Ito's blue and orange in two strengths: hue tells the wells, strength the crossing, also in grey.
_COLOURS = ("#dcecf6", "#7fb9dc", "#fbe3bd", "#e69f00")
_FALLS: dict[str, Any] = {"facecolor": "0.92", "hatch": "...."}
_SEPARATRIX = "#b3261e"


def figure(datasets: "Sequence[xr.Dataset]") -> Figure:
    """Draw the regimes of atlases, a panel each.

    Parameters
    ----------
    datasets : sequence of xarray.Dataset
        Atlases of two axes, or selections from atlases.

    Returns
    -------
    matplotlib.figure.Figure
        On an Agg canvas. The curve of folds is drawn over the tilt and the only rate that is not zero, from theory;
        the colours and the separatrix are from the reduction.

    Raises
    ------
    RequestError
        If there is no atlas, or one of them has not two axes.
    """
    if not datasets:
        raise RequestError("nothing to draw", "a figure has a panel or more", "no atlas", "give an atlas")
    panels = [regimes(dataset) for dataset in datasets]
    columns = min(len(panels), _IN_ROW)
    rows = -(-len(panels) // columns)
    with matplotlib.rc_context(STYLE):
        drawn = Figure(figsize=(columns * _WIDTH, rows * (_HEIGHT + _LEGEND)))
        FigureCanvasAgg(drawn)
        drawn.set_layout_engine("constrained", h_pad=0.1)
        for axes, each in zip(drawn.subplots(rows, columns, squeeze=False).flat, panels, strict=False):
            _draw(axes, each)
        for axes in drawn.axes[len(panels) : rows * columns]:
            axes.set_visible(False)
    return drawn


def _draw(axes: "Axes", each: Regimes) -> None:
    panel = each.panel
    assert panel.y is not None
    shown = np.ma.masked_less(each.regime, 0)
    axes.pcolormesh(
        panel.x.borders, panel.y.borders, shown, cmap=ListedColormap(_COLOURS), vmin=-0.5, vmax=len(NAMES) - 0.5,
        rasterized=True, zorder=0,
    )  # fmt: skip
    set_scale(axes, "x", panel.x)
    set_scale(axes, "y", panel.y)
    hatch(axes, panel, each.fell, "", **_FALLS)
    hatch(axes, panel, each.unknown, each.lost, facecolor="0.7", hatch="xxxx")
    for x, y in each.folds:
        axes.plot(
            x,
            y,
            color=INK,
            linewidth=1.4,
            path_effects=HALO,
            label="fold: one well above, two below (theory)",
        )
    _draw_separatrix(axes, each)
    _explain(axes, name_regions(axes, panel, each.regions(), lines=2, width=5.5))
    if panel.in_g_over_r is not None:
        add_scaled_axis(axes, "y", panel.y, panel.in_g_over_r)
    axes.set_title(panel.title)
    add_legend(axes, axes, each.caption)


def _explain(axes: "Axes", regions: list[str]) -> None:
    """Put regions that are too small for their names into the legend."""
    for name in regions:
        look = (
            {"facecolor": _COLOURS[NAMES.index(name)]} if name in NAMES else {"edgecolor": "0.25", **_FALLS}
        )
        axes.add_patch(Rectangle((0.0, 0.0), 0.0, 0.0, label=name.replace("\n", ", "), linewidth=0.0, **look))


def _draw_separatrix(axes: "Axes", each: Regimes) -> None:
    """Draw where a motion just reaches the saddle of its potential."""
    panel = each.panel
    assert panel.y is not None
    known = each.separatrix[np.isfinite(each.separatrix)]
    if not known.size or known.min() >= 0.0 or known.max() <= 0.0:
        return
    contour = axes.contour(panel.x.values, panel.y.values, np.ma.masked_invalid(each.separatrix), [0.0])
    # where cells are masked matplotlib leaves segments without points
    segments = [segment for segment in contour.allsegs[0] if len(segment) > 1]
    contour.remove()
    # as lines, which the legend shows and the names of the regions make room for
    for i, segment in enumerate(segments):
        label = "separatrix: just reaches the saddle" if i == 0 else None
        axes.plot(*segment.T, color=_SEPARATRIX, linewidth=1.2, linestyle="--", zorder=3, label=label)
