"""Small panels of one motion over time: heading, axes, ticks and legends, for all models."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from sweep.figures.scales import thin_ticks
from sweep.figures.texts import wrapped
from sweep.model.quantity import Array
from sweep.motion.tables import TIME

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

MOTION: dict[str, Any] = {"color": "black", "linewidth": 1.1}

#: Height of the two lines above a figure, and of each further line [in].
_HEAD, _LINE = 0.42, 0.17

#: Largest number of ticks on an axis of a small panel, and their spacings divided by a power of ten.
_TICKS, _STEPS = 5, (1.0, 2.0, 5.0, 10.0)

#: Colour of times at which the motion is unreliable.
SHADE = "#f3e3da"


def write_head(drawn: Figure, title: str, words: str) -> None:
    """Write the title and, below it, what is shown."""
    width, height = drawn.get_size_inches()
    engine = drawn.get_layout_engine()
    assert engine is not None
    title, words = wrapped(title, 10.0, width - 0.2), wrapped(words, 8.0, width - 0.2, "normal")
    below = 0.26 + _LINE * title.count("\n")
    head = _HEAD + _LINE * (title.count("\n") + words.count("\n"))
    engine.set(rect=(0.0, 0.0, 1.0, 1.0 - head / height))  # type: ignore[call-arg]  # of the constrained layout
    look: dict[str, Any] = {"va": "top", "parse_math": False}
    drawn.text(0.01, 1.0 - 0.06 / height, title, fontsize=10.0, fontweight="bold", **look)
    drawn.text(0.01, 1.0 - below / height, words, fontsize=8.0, **look)


def thin_panels(panels: "Sequence[Axes]") -> None:
    """Remove numbers on axes that touch, at the sizes that the layout gives the panels."""
    for axes in panels:
        figure = axes.get_figure(root=True)
        assert figure is not None
        figure.draw_without_rendering()
        thin_ticks(axes, _TICKS, _STEPS)


def widened(times: Array) -> tuple[float, float]:
    """Return the ends of an axis for these times, with a margin."""
    margin = 0.03 * float(times[-1] - times[0])
    return float(times[0]) - margin, float(times[-1]) + margin


def label_times(axes: "Axes", dataset: "xr.Dataset", ylabel: str) -> None:
    """Label the axes of a panel over time; all panels of a motion have the same time axis."""
    axes.set_xlim(*widened(dataset[TIME.name].values))
    label_axes(axes, TIME.plot_label, ylabel)


def label_axes(axes: "Axes", xlabel: str, ylabel: str) -> None:
    """Label linear axes, and put the legend above them if there is one."""
    axes.set(xlabel=xlabel, ylabel=ylabel)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(_TICKS, steps=_STEPS))
    # shows small numbers with an exponent at the end of the axis: there is no room for all their digits
    axes.ticklabel_format(axis="x", scilimits=(-3, 5))
    if axes.get_legend_handles_labels()[1]:
        legend_above(axes)


def legend_above(axes: "Axes") -> None:
    """Put the legend above a panel, where it covers nothing."""
    axes.legend(
        loc="lower left", alignment="left", bbox_to_anchor=(0.0, 1.0), frameon=False,
        borderaxespad=0.1, handlelength=1.8, labelspacing=0.15, fontsize=7.0,
    )  # fmt: skip
