"""Figures of an atlas of more than two axes: one map for each value of the further axes, or a family of curves."""

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure

from sweep.atlas.cf_metadata import edge_names
from sweep.atlas.dataset import require, spec_named
from sweep.errors import RequestError
from sweep.figures.drawing import (
    INK,
    LINES,
    bar_of,
    check_same_quantity,
    colours_of,
    draw_map,
    draw_points,
    thinning,
)
from sweep.figures.layout import PAGE, Block, figure_of
from sweep.figures.look import SPEED, Look, columns_of
from sweep.figures.panels import (
    Panel,
    drawn_dims,
    drawn_spec,
    fixed_parameters,
    panel,
    shown_formula,
    speed_of,
    value_text,
)
from sweep.figures.scales import add_second_axis, set_scale

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

#: Largest number of maps in a figure, and of distinguishable curves in a family.
_MOST_MAPS, _MOST_CURVES = 12, 8

#: Width and least width of a panel [in]: for small multiples, and for a family of curves.
_WIDTHS, _FAMILY = (2.4, 1.2), (4.2, 4.2)

#: Markers, and the part of viridis, for the curves of a family: they differ in shape, hue and lightness.
_MARKERS, _PART = "os^Dv<>p", 0.85


def figure(
    datasets: Sequence["xr.Dataset"], friction: float | None, look: Look, axes: "Axes | None"
) -> Figure:
    """Draw one atlas of more than two axes, or boundaries as families of curves; see `sweep.figures.plots.figure`.

    Raises
    ------
    RequestError
        If there are too many maps or curves, or no boundary to draw.
    """
    if len(datasets) > 1:
        raise RequestError(
            f"An atlas of more than two axes, or a family of curves, fills a figure; got {len(datasets)} atlases.",
            "Draw each atlas in its own figure.",
        )
    dataset = datasets[0]
    if look.rate == SPEED:
        for name in spec_named(dataset).model.controls(drawn_dims(dataset)):
            speed_of(spec_named(dataset), name)
    if look.family:
        if friction is not None:
            raise RequestError(
                "A family of boundary curves has no cells to hatch; got friction.", "Leave out friction."
            )
        return _family(dataset, look, axes)
    further = _further(dataset)
    if axes is not None:
        raise RequestError(
            f"The axes can show one map; this atlas has {len(drawn_dims(dataset))} axes: "
            f"{', '.join(drawn_dims(dataset))}.",
            f"{_selection(dataset, further)}, or draw the family of its boundaries (family=True).",
            "ax",
        )
    count = math.prod(dataset.sizes[name] for name in further)
    if count > _MOST_MAPS:
        raise RequestError(
            f"An atlas of more than two axes is drawn as one map for each value of {' and '.join(further)}. That is "
            f"{' x '.join(str(dataset.sizes[name]) for name in further)} = {count} maps, and a figure can have at most "
            f"{_MOST_MAPS}.",
            f"{_selection(dataset, further)}.",
        )
    return _multiples(dataset, further, friction, look)


def _multiples(dataset: "xr.Dataset", further: Sequence[str], friction: float | None, look: Look) -> Figure:
    marked = None if friction is None else spec_named(dataset).model.slipping(dataset, friction)
    parts = [
        (part, panel(part, None if marked is None else marked.isel(place), look))
        for place, part in _parts(dataset, further)
    ]
    panels = [_plain(each, dataset) for _, each in parts]
    titles = [_values_text(part, further) for part, _ in parts]
    check_same_quantity(panels)
    count = len(panels)
    columns = dataset.sizes[further[-1]] if len(further) > 1 else 2 if count == 4 else 3
    columns = min(columns, columns_of(count, look, *_WIDTHS)) if columns > 1 else 1
    # move panels that are too narrow for their labels to another row
    for fewer in range(columns, 1, -1):
        try:
            drawn = _maps(dataset, panels, titles, fewer, look)
            break
        except RequestError:
            continue
    else:
        drawn = _maps(dataset, panels, titles, 1, look)
    _check_page(drawn, look, count)
    return drawn


def _maps(
    dataset: "xr.Dataset", panels: Sequence[Panel], titles: Sequence[str], columns: int, look: Look
) -> Figure:
    """Draw maps, `columns` in a row; raise an error if there is no room for them."""
    colouring = colours_of(panels, look)
    # scaled rates of disks with different radii have different ranges
    same = len({each.y.ends for each in panels if each.y}) == 1

    def block(axes: "Axes", i: int) -> Block:
        each = panels[i]
        draw_map(axes, each, colouring, second=False)
        # a row above an incomplete one has numbers below all of its panels
        _hide_inner(axes, i % columns == 0 or not same, (i // columns + 2) * columns > len(panels))
        return Block(axes, each, titles[i], regions=each.regions(), is_mathematics=True)

    return figure_of(
        range(len(panels)), block, look, _WIDTHS, columns=columns, common=_caption(dataset, panels),
        bar=bar_of(panels, colouring), title=panels[0].title,
    )  # fmt: skip


def _caption(dataset: "xr.Dataset", panels: Sequence[Panel]) -> tuple[str, ...]:
    return (panels[0].caption[0], fixed_parameters(spec_named(dataset)), _sides(panels))


def _values_text(part: "xr.Dataset", further: Sequence[str]) -> str:
    """Return the values of the further axes in a part of an atlas, as text."""
    return ", ".join(value_text(drawn_spec(part), name) for name in further)


def _check_page(drawn: Figure, look: Look, count: int) -> None:
    """Raise an error if a narrow width makes the figure higher than a page."""
    wide, high = (25.4 * side for side in drawn.get_size_inches())
    if look.width is None or look.height is not None or high <= 25.4 * PAGE:
        return
    raise RequestError(
        f"{count} maps in a width of {wide:.0f} mm need a height of {high:.0f} mm; a page has {25.4 * PAGE:.0f} mm.",
        "Give a larger width, as in 180mm, a height, or draw fewer values of an axis.",
        "width",
    )


def _family(dataset: "xr.Dataset", look: Look, axes: "Axes | None") -> Figure:
    control, further = _control(dataset), _further(dataset)
    if control is None or not further:
        raise RequestError(
            "A family of boundary curves needs an atlas with a boundary and at least three axes; this one has "
            f"{'the axes ' if drawn_dims(dataset) else 'no axes'}{', '.join(drawn_dims(dataset))}"
            f"{'' if control else ', and no boundary'}.",
            "Leave out family.",
            "family",
        )
    count = math.prod(dataset.sizes[name] for name in further)
    if count > _MOST_CURVES:
        raise RequestError(
            f"A family has one curve for each value of {' and '.join(further)}. That is {count} curves; at most "
            f"{_MOST_CURVES} are distinguishable.",
            f"{_selection(dataset, further)}.",
            "family",
        )
    parts = list(_parts(dataset, further))
    panels = [_plain(panel(part, None, look), dataset) for _, part in parts]
    names = [_values_text(part, further) for _, part in parts]

    def block(own: "Axes", first: Panel) -> Block:
        _draw_family(own, panels, names)
        return Block(own, replace(first, line_name=""), first.title, _caption(dataset, panels))

    return figure_of(panels[:1], block, look, _FAMILY, axes=axes)


def _draw_family(axes: "Axes", panels: Sequence[Panel], names: Sequence[str]) -> None:
    """Draw the boundaries of several maps in one panel, each with its own colour and marker."""
    first = panels[0]
    assert first.y is not None
    colours = colormaps["viridis"](np.linspace(0.0, _PART, len(panels)))
    for each, name, colour, marker in zip(panels, names, colours, _MARKERS, strict=False):
        for edge in each.edges:
            for kind, line in (("analytic", edge.critical), ("predicted", edge.predicted)):
                axes.plot(edge.fine_x, line, **LINES[kind] | {"color": colour, "linewidth": 1.1})
            draw_points(axes, edge, color=colour, marker=marker, markersize=4.0, clip_on=False)
        axes.plot([], [], color=colour, marker=marker, markerfacecolor="white", markersize=4.0, label=name)
    scales = [each.y for each in panels if each.y]
    ends = min(each.ends[0] for each in scales), max(each.ends[1] for each in scales)
    set_scale(axes, "x", first.x)
    set_scale(axes, "y", replace(first.y, ends=ends))
    if len({each.unit for each in scales}) == 1:
        add_second_axis(axes, "y", first.y)
    drawn = [edge for each in panels for edge in each.edges if edge.x.size]
    axes.plot(
        [], [], label=f"{first.method} boundary with its bracket{thinning(drawn)}", linestyle="", marker="o",
        color=INK, markerfacecolor="white", markersize=4.0,
    )  # fmt: skip
    for kind, name in (("analytic", f"analytic: {first.line}"), ("predicted", first.predicted)):
        if any(
            np.isfinite(getattr(edge, "critical" if kind == "analytic" else kind)).any()
            for edge in first.edges
        ):
            axes.plot([], [], label=name, **LINES[kind] | {"color": INK})


def _sides(panels: Sequence[Panel]) -> str:
    """Return on which side of the curves the motion is stable, as text."""
    found = {edge.name for each in panels for edge in each.edges if edge.measured.size}
    if found == {"upper", "lower"}:
        return "unstable between the upper and the lower edge of each curve, stable outside"
    return {
        "upper": "stable above each curve, unstable below",
        "lower": "stable below each curve, unstable above",
    }.get(next(iter(found), ""), "no boundary")


def _plain(each: Panel, dataset: "xr.Dataset") -> Panel:
    """Return a panel as one of several: with the formula of their shared line, and without names for its ends."""
    spec, control = spec_named(dataset), _control(dataset)
    line = "theory"
    if control is not None and each.y is not None:
        left, right = shown_formula(spec, control, each.y)
        line = f"${left} = {right}$" if left else line
    return replace(each, line=line, joined=None)


def _control(dataset: "xr.Dataset") -> str | None:
    controls = spec_named(dataset).model.controls(drawn_dims(dataset))
    return next((name for name in controls if edge_names(name)[0] in dataset), None)


def _further(dataset: "xr.Dataset") -> list[str]:
    """Return the axes of an atlas that are neither the x nor the y axis of its maps."""
    dims, control = drawn_dims(dataset), _control(dataset)
    y = control or next(iter(dims), "")
    rest = [name for name in dims if name != y]
    coordinate = spec_named(dataset).model.coordinate
    x = coordinate if coordinate in rest else next(iter(rest), "")
    return [name for name in rest if name != x]


def _selection(dataset: "xr.Dataset", further: Sequence[str]) -> str:
    """Return a hint how to draw fewer maps or curves."""
    values = [f"{name}={dataset[name].values[0]:.6g}" for name in further]
    return f"Take a part of the atlas, with one value or several, as in {' '.join(values)}"


def _hide_inner(axes: "Axes", is_first: bool, is_last: bool) -> None:
    if not is_first:
        axes.set_ylabel("")
        axes.tick_params(axis="y", which="both", labelleft=False)
    if not is_last:
        axes.set_xlabel("")
        axes.tick_params(axis="x", which="both", labelbottom=False)


def _parts(dataset: "xr.Dataset", further: Sequence[str]) -> Iterator[tuple[dict[str, int], Any]]:
    """Yield the indices along the further axes, and the part of the atlas there."""
    require(dataset, ("stability",))
    for places in itertools.product(*(range(dataset.sizes[name]) for name in further)):
        place = dict(zip(further, places, strict=True))
        yield place, dataset.isel(place)
