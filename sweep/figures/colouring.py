"""How values become colours in the maps of a figure: one scale for all, its bar, and the levels of contour lines."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator

from sweep.errors import RequestError
from sweep.figures.drawing import CONTOUR_EDGE, Colouring
from sweep.figures.look import Look
from sweep.figures.panels import Panel
from sweep.figures.scales import set_log_ticks
from sweep.figures.shade import COLOURS, Shade, common_norm, flag_colours, is_wide

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def check_same_quantity(panels: Sequence[Panel]) -> None:
    """Refuse panels whose flags differ: one bar of colours stands for all of them."""
    flags = {each.shade.quantity.flags is not None for each in panels}
    if len(flags) > 1:
        raise RequestError(
            f"{panels[0].shade.quantity.name} is a flag in one atlas and a number in another.",
            "Draw them in two figures.",
            "quantity",
        )


def colours_of(panels: Sequence[Panel], look: Look) -> Colouring:
    """Return the colours of the maps of a figure, the same for all panels, and the levels of their contour lines."""
    maps = [each.shade for each in panels if each.y is not None]
    quantity = panels[0].shade.quantity
    if look.contours is not None and (len(maps) < len(panels) or quantity.flags is not None):
        raise RequestError(
            "Contour lines need two axes and a quantity with numbers; "
            + (
                f"{quantity.name} is a flag."
                if quantity.flags is not None
                else "here is an atlas of one axis."
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
    """Return the levels of contour lines, at least one of them among the values."""
    quantity, low, high = maps[0].quantity, float(scale.vmin or 0.0), float(scale.vmax or 0.0)
    levels = look.levels(quantity) or _automatic(maps, low, high)
    if not any(low <= level <= high for level in levels):
        unit = f" {quantity.shown_units}".rstrip()
        raise RequestError(
            f"No contour line lies on the map: {quantity.name} is {low:.4g} to {high:.4g}{unit} there; got "
            f"{', '.join(f'{level:.4g}{unit}' for level in levels) or 'none'}.",
            f"Give a level between them; a bare number is in {quantity.units}."
            if quantity.units != "1"
            else "",
            "contours",
        )
    return levels


def _automatic(maps: Sequence[Shade], low: float, high: float) -> tuple[float, ...]:
    """Return levels for contour lines: round numbers between the smallest and the largest value."""
    if all(is_wide(each.values) for each in maps):
        found = LogLocator(subs=(1.0,) if high > 1e3 * low else (1.0, 2.0, 5.0)).tick_values(low, high)
    else:
        found = MaxNLocator(6, steps=[1, 2, 5, 10]).tick_values(low, high)
    return tuple(float(each) for each in found if low < each < high)


def add_bar(
    drawn: Figure, panels: Sequence[Panel], colouring: Colouring, beside: Any = None
) -> "Axes | None":
    """Add the bar of colours: in axes of its own, or beside those of a caller; none for flags and profiles."""
    quantity = panels[0].shade.quantity
    maps = [each.shade for each in panels if each.y is not None]
    if quantity.flags is not None or not any(np.isfinite(each.values).any() for each in maps):
        return None
    low, high = float(colouring.norm.vmin or 0.0), float(colouring.norm.vmax or 1.0)
    cut = any((each.values < low).any() for each in maps)
    place: dict[str, Any] = (
        {"cax": drawn.add_axes((0.9, 0.2, 0.02, 0.6))} if beside is None else {"ax": beside}
    )
    bar = drawn.colorbar(
        ScalarMappable(colouring.norm, colouring.colours), label=quantity.plot_label,
        extend="min" if cut else "neither", **place,
    )  # fmt: skip
    if isinstance(colouring.norm, LogNorm):
        set_log_ticks(bar.ax.yaxis, high / low)
    elif quantity.dtype.startswith("i"):
        bar.ax.yaxis.set_major_locator(MaxNLocator(6, integer=True))
    for level in colouring.levels:
        bar.ax.axhline(level, color="white", linewidth=0.9, path_effects=CONTOUR_EDGE)
    found: Axes = bar.ax
    return found
