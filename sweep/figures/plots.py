"""Figures of atlases: stability maps with the measured boundary, the analytic line and the predicted one.

The same atlases give the same bytes of the file: it holds neither a time nor a random name.
"""

from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator

from sweep.atlas.contents import Atlas
from sweep.atlas.dataset import require, spec_named
from sweep.errors import RequestError
from sweep.figures.arrange import Block, arrange, finish_in, lettered
from sweep.figures.drawing import CONTOUR_EDGE, Colouring, draw_map, draw_profile, draw_ratio, sheet, styled
from sweep.figures.look import Look
from sweep.figures.panels import Panel, drawn_dims, panel
from sweep.figures.scales import set_log_ticks
from sweep.figures.shade import COLOURS, Shade, common_norm, flag_colours, is_wide
from sweep.files.paths import check_format, check_target
from sweep.files.publish import published
from sweep.model.description import Model

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

#: Width of a panel [in] in letters of 8 points, with labels; a journal's column is 3.4 wide. Below the least one,
#: panels of a figure of given width go into another row; below `_SECOND` there is no room for a second axis.
_WIDTH, _LEAST_WIDTH, _SECOND, _BAR = 3.6, 2.2, 2.6, 0.7

#: Panels side by side.
_MOST_IN_ROW = 3

_DOTS_PER_INCH = 200

#: Dots of a figure at most: a png of them takes 400 MB of memory.
_MOST_DOTS, _MOST_SIDE = 10**8, 2**16 - 1

_INCH = 0.0254

#: Format -> the metadata that would record the date and the program, each set to None to leave it out.
_METADATA: Mapping[str, Mapping[str, None]] = {
    "png": {"Software": None},
    "pdf": {"CreationDate": None, "Producer": None, "Creator": None},
    "svg": {"Date": None, "Creator": None},
}


def figure(
    datasets: Sequence[Atlas],
    friction: float | None = None,
    look: Look | None = None,
    axes: "Axes | None" = None,
) -> Figure:
    """Draw atlases side by side.

    Parameters
    ----------
    datasets : sequence of Atlas
        Atlases of one axis or two, or selections from atlases, one panel each; or one atlas of more axes, as small
        multiples or as a family of boundary curves. Friction and `axes` need them as xarray.Dataset.
    friction : float, optional
        Friction coefficient: cells where the disk would need more, or would lift off, are hatched.
    look : Look, optional
        What is drawn, and how large.
    axes : matplotlib.axes.Axes, optional
        Draw the map or the profile of one atlas into these, in the style of their figure, and a bar of colours beside.

    Returns
    -------
    matplotlib.figure.Figure
        That of `axes`; without, a new one on an Agg canvas, not registered with pyplot.

    Raises
    ------
    RequestError
        If there is no atlas, or one of them has no axis, or cannot be drawn as `look` says, or has no contact forces to
        hold `friction` against (made without ``contact=yes``).

    Notes
    -----
    Under a map, a strip shows the boundary over the analytic line.
    """
    look = look or Look()
    if not datasets:
        raise RequestError("There is nothing to draw: a figure has a panel or more.", hint="Give an atlas.")
    for dataset in datasets:
        require(dataset, (spec_named(dataset).model.peak,))
    if axes is not None:
        _check_own(look)
    if look.family or any(len(drawn_dims(dataset)) > 2 for dataset in datasets):
        from sweep.figures import multiples

        return multiples.figure(datasets, friction, look, axes)
    panels = [
        panel(
            dataset, None if friction is None else spec_named(dataset).model.slipping(dataset, friction), look
        )
        for dataset in datasets
    ]
    check_same_quantity(panels)
    if axes is not None:
        return _draw_into(axes, panels, look)
    columns = columns_of(len(panels), look, _WIDTH, _LEAST_WIDTH)
    with sheet(*size_of(columns, look, _WIDTH), look.font_size, "none") as drawn:
        colouring = colours_of(panels, look)
        scale = look.font_size / 8.0
        second = size_of(columns, look, _WIDTH)[0] >= columns * _SECOND * scale + _BAR * scale
        blocks = [_block(drawn, each, colouring, second) for each in panels]
        bar = add_bar(drawn, panels, colouring)
        arrange(drawn, blocks, columns, height=inches(look.height), bar=bar)
    return drawn


def _check_own(look: Look) -> None:
    given = {"width": look.width, "height": look.height, "dpi": look.dpi}
    if names := [name for name, value in given.items() if value is not None]:
        raise RequestError(
            f"Axes belong to a figure that has a size and dots already; got ax with {' and '.join(names)}.",
            f"Leave {' and '.join(names)} out, or ax.",
            "ax",
        )


def inches(length: float | None) -> float | None:
    """Return a length [m] in inches."""
    return None if length is None else length / _INCH


def columns_of(count: int, look: Look, width: float, least: float) -> int:
    """Return how many of `count` panels, of a width and at least so wide [in], stand side by side."""
    most = min(count, _MOST_IN_ROW)
    if look.width is None:
        return most
    scale = look.font_size / 8.0
    return max(1, min(most, int((look.width / _INCH - _BAR * scale) / (least * scale))))


def size_of(columns: int, look: Look, width: float) -> tuple[float, float]:
    """Return width and height [in] of a figure; its height changes when it is laid out, if it was not given."""
    scale = look.font_size / 8.0
    wide = inches(look.width) or (columns * width + _BAR) * scale
    return wide, inches(look.height) or wide


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


def _block(drawn: Figure, each: Panel, colouring: Colouring, second: bool) -> Block:
    axes = drawn.add_axes((0.2, 0.2, 0.6, 0.6))
    block = Block(axes, each, each.title, each.caption, regions=regions_of(each), explained=explained(each))
    if each.y is None:
        draw_profile(axes, each)
        return block
    draw_map(axes, each, colouring, second)
    if each.has_ratio:
        block.strip = drawn.add_axes((0.2, 0.1, 0.6, 0.1), sharex=axes)
        draw_ratio(block.strip, each)
        block.strip.set_xlabel(axes.get_xlabel())
        axes.set_xlabel("")
        axes.tick_params(axis="x", which="both", labelbottom=False)
    return block


def regions_of(each: Panel) -> list[tuple[str, Any]]:
    """Return names and cells of the regions of a map: of its verdicts, or of its flags."""
    if each.shade.quantity.flags is not None:
        return each.shade.regions()
    return [*each.verdicts(), ("undecided", each.undecided)]


def explained(each: Panel) -> list[str]:
    """Return the regions that the legend of a map explains in any case."""
    return (
        [name for name, _ in each.shade.regions()] if each.shade.quantity.flags is not None else ["undecided"]
    )


def _draw_into(axes: "Axes", panels: Sequence[Panel], look: Look) -> Figure:
    """Draw one panel into the axes of a caller."""
    if len(panels) != 1:
        raise RequestError(
            f"Axes hold one panel; got {len(panels)} atlases.", "Draw each into axes of its own.", "ax"
        )
    each, drawn = panels[0], axes.get_figure(root=True)
    assert drawn is not None
    with lettered(look):
        colouring = colours_of(panels, look)
        block = Block(
            axes, each, each.title, each.caption, regions=regions_of(each), explained=explained(each)
        )
        if each.y is None:
            draw_profile(axes, each)
        else:
            draw_map(axes, each, colouring)
            add_bar(drawn, panels, colouring, beside=axes)
    return finish_in(block, look)


def save(drawn: Figure, path: str | Path, dpi: int | None = None) -> None:
    """Write a figure; the file appears only when it is complete, and replaces one of the same name.

    Parameters
    ----------
    drawn : Figure
    path : str or Path
    dpi : int, optional
        Dots per inch; 200 if not given.

    Raises
    ------
    RequestError
        If the name's ending is none of png, pdf, svg, or the folder does not exist or cannot be written, or the figure
        would have too many dots.
    """
    path, dpi = Path(path), dpi or _DOTS_PER_INCH
    ending = check_format(path)
    check_target(path, overwrite=True)
    dots = [int(side * dpi) for side in drawn.get_size_inches()]
    if max(dots) > _MOST_SIDE or dots[0] * dots[1] > _MOST_DOTS:
        raise RequestError(
            f"A figure has at most {_MOST_DOTS:.0e} dots, {_MOST_SIDE} along a side; got {dots[0]} x {dots[1]} with "
            f"{dpi} per inch.",
            "Give a smaller width, height or dpi.",
            "dpi",
        )
    with styled(), published(path) as unfinished:
        drawn.savefig(unfinished, format=ending, dpi=dpi, metadata=_METADATA[ending])


def regimes(datasets: "Sequence[xr.Dataset]", look: Look) -> Figure:
    """Draw the kinds of motion of atlases, as the model of each does."""
    draw = [of_the_model(spec_named(each).model, "regimes", "--regimes") for each in datasets]
    drawn: Figure = draw[0](datasets, look)
    return drawn


def of_the_model(model: Model, name: str, option: str) -> Callable[..., Figure]:
    """Return the function of a model that draws its ``trajectory`` or ``regimes``, or refuse the option by name."""
    module, _, function = str(getattr(model, name)).partition(":")
    if not module:
        raise RequestError(f"The model {model.name} has no {name} to draw.", hint=f"Leave {option} out.")
    found: Callable[..., Figure] = getattr(import_module(module), function)
    return found
