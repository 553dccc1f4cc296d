"""Figures of lists of starts: one point for every start, in the plane of two parameters, coloured by its verdict."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from sweep.atlas.boundary import theory_lines
from sweep.atlas.dataset import require, spec_named
from sweep.atlas.share import Share, unstable_share
from sweep.errors import RequestError, are, counted, plain_text
from sweep.figures.drawing import LINES
from sweep.figures.layout import Block, figure_of
from sweep.figures.look import LINEAR, Look
from sweep.figures.panels import file_names, fixed_parameters, formula
from sweep.figures.room import HALO
from sweep.figures.scales import SQUEEZED, set_log_ticks
from sweep.model.quantity import FAILED, MISSING, STABLE, UNDECIDED, UNSTABLE, Array, Input, Quantity
from sweep.request.sources import Range
from sweep.request.spec import SweepSpec
from sweep.request.start_list import WORDS

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

#: Width of a panel with its labels, and its least width [in].
_WIDTHS = 3.9, 2.6

#: Largest number of points that are drawn: more cover each other.
_MOST_POINTS = 20_000

#: Area of a point [points squared], if there are few and if there are many.
_LARGEST, _SMALLEST = 9.0, 1.2

#: Largest area at which points are drawn without antialiasing: their edge is invisible, but would make a png four times
#: as large.
_SMOOTH = 4.0

#: Number of points on a line of theory.
_FINE = 1000

#: Verdict -> name, colour and marker; the colours are those of small and large peaks on maps.
_VERDICTS: dict[int, tuple[str, str, str]] = {
    STABLE: ("stable", "#6ccd5a", "o"),
    UNSTABLE: ("unstable", "#453781", "o"),
    UNDECIDED: ("undecided", "0.45", "x"),
}
_FAILED = ("failed", "#c8380a", "+")


@dataclass(frozen=True)
class Plane:
    """The two quantities in whose plane the starts of a list are drawn.

    Attributes
    ----------
    x, y : Quantity
        Two parameters that vary; `y` is the peak if only one varies.
    hidden : tuple of str
        Further parameters that vary and are not visible.
    """

    x: Quantity
    y: Quantity
    hidden: tuple[str, ...]


def plane_of(spec: SweepSpec) -> Plane:
    """Return the plane of a list: its two varying parameters, or the first control and the coordinate if more vary.

    The control is on the y axis. Another parameter replaces a coordinate that does not vary.
    """
    model, listed = spec.model, spec.listed
    parameters = model.parameters
    if len(listed) == 1:
        return Plane(parameters[listed[0]], model.variables[model.peak], ())
    controls = model.controls(listed)
    up = controls[0] if controls else next(name for name in listed if name != model.coordinate)
    others = [name for name in (model.coordinate, *controls, *listed) if name in listed and name != up]
    return Plane(parameters[others[0]], parameters[up], tuple(n for n in listed if n not in (up, others[0])))


def figure(datasets: Sequence["xr.Dataset"], look: Look, axes: "Axes | None" = None) -> Figure:
    """Draw lists of starts side by side, one panel each.

    Parameters
    ----------
    datasets : sequence of Atlas
        Atlases of lists of starts, or selections from such atlases.
    look : Look
        The sizes; options that belong to maps raise an error.
    axes : matplotlib.axes.Axes, optional
        Axes into which the only atlas is drawn.

    Returns
    -------
    matplotlib.figure.Figure
        The figure of `axes`; without them, a new one on an Agg canvas, not registered with pyplot.

    Raises
    ------
    RequestError
        If an atlas is a grid, or the look is for maps.
    """
    _check_look(look)
    if grids := [
        plain_text(each.attrs.get("title", "")) for each in datasets if not spec_named(each).is_list
    ]:
        raise RequestError(
            f"A figure can show grids or lists of starts, but not both; {grids[0]!r} is a grid.",
            hint="Draw the atlases in two figures.",
        )
    return figure_of(datasets, _block, look, _WIDTHS, axes=axes, files=file_names(datasets))


def _check_look(look: Look) -> None:
    of_maps = {"family": look.family, "contours": look.contours, "quantity": look.quantity}
    if given := [name for name, value in of_maps.items() if value]:
        raise RequestError(
            f"{given[0]} is an option for maps; a list of starts is drawn as points.",
            hint="Leave it out, or give an atlas with axes.",
        )
    if look.rate != LINEAR:
        raise RequestError(
            f"A list of starts always has a linear rate axis; got rate={look.rate}.",
            hint="Leave out rate.",
        )


def _block(axes: "Axes", dataset: "xr.Dataset") -> Block:
    spec = spec_named(dataset)
    plane = plane_of(spec)
    require(dataset, (plane.x.name, plane.y.name, "stability", "ending"))
    count = dataset["stability"].shape[0]
    some = np.unique(np.linspace(0, count - 1, min(count, _MOST_POINTS)).round().astype(np.intp))
    x, y = (dataset[each.name].values[some] * each.plot_scale for each in (plane.x, plane.y))
    codes, endings = dataset["stability"].values[some], dataset["ending"].values[some]
    failed = np.logical_or(*(spec.model.endings.have(role, endings) for role in (FAILED, MISSING)))
    signs = _draw_points(axes, x, y, codes, failed)
    for which, values, quantity in (("x", x, plane.x), ("y", y, plane.y)):
        _set_scale(axes, which, values, quantity, spec)
    _draw_theory(axes, spec, plane, y if spec.model.controls([plane.y.name]) else x)
    caption = _caption(spec, plane, unstable_share(dataset), some.size, count)
    return Block(axes, title=spec.short_title, caption=caption, signs=signs)


def _draw_points(
    axes: "Axes", x: Array, y: Array, codes: npt.NDArray[np.integer], failed: npt.NDArray[np.bool_]
) -> list[Line2D]:
    """Draw the points in the order of the starts, so that no verdict covers the others; return the legend's handles."""
    area = float(np.clip(2e4 / max(x.size, 1), _SMALLEST, _LARGEST))
    kinds = [(*_VERDICTS[code], ~failed & (codes == code)) for code in _VERDICTS] + [(*_FAILED, failed)]
    round_ones = np.zeros(x.size, bool)
    colours = np.full(x.size, "none", object)
    handles = []
    for name, colour, marker, which in kinds:
        if not which.any():
            continue
        handles.append(Line2D([], [], linestyle="", color=colour, marker=marker, markersize=4.0, label=name))
        colours[which] = colour
        round_ones |= which if marker == "o" else False
        if marker != "o":
            axes.scatter(
                x[which], y[which], s=16.0, c=colour, marker=marker, linewidths=0.8, rasterized=True, zorder=2
            )
    axes.scatter(
        x[round_ones], y[round_ones], s=area, c=colours[round_ones].tolist(), marker="o", linewidths=0.0,
        antialiased=area > _SMOOTH, rasterized=True, zorder=1,
    )  # fmt: skip
    return handles


def _set_scale(axes: "Axes", which: str, values: Array, quantity: Quantity, spec: SweepSpec) -> None:
    """Label an axis, and make it logarithmic if a linear one would squeeze intended small values."""
    axes.set(**{f"{which}label": quantity.plot_label})
    known = values[np.isfinite(values)]
    if not known.size or known.min() == known.max():
        return
    given = getattr(spec, quantity.name) if quantity.name in spec.listed else None
    even = getattr(given, "kind", "") in ("uniform", "normal")
    if not even and known.min() > 0.0 and known.max() > SQUEEZED * known.min():
        getattr(axes, f"set_{which}scale")("log")
        set_log_ticks(getattr(axes, f"{which}axis"), known.max() / known.min())
        return
    # a margin, so that no point is clipped
    margin = 0.02 * (known.max() - known.min())
    getattr(axes, f"set_{which}lim")(known.min() - margin, known.max() + margin)


def _draw_theory(axes: "Axes", spec: SweepSpec, plane: Plane, values_of_control: Array) -> None:
    """Draw the lines of theory, which are meaningful only if no third parameter varies."""
    control = next(iter(spec.model.controls(spec.listed)), None)
    # not the ends of the axis: theory has other edges where rates of both signs are possible
    low, high = float(values_of_control.min()), float(values_of_control.max())
    if plane.hidden or control is None or not low < high:
        return
    upward = control == plane.y.name
    ends = {which: getattr(axes, f"get_{which}lim")() for which in "xy"}
    across = _across(axes, plane.x) if upward else np.zeros(0)
    grid = _grid(spec, control, (low, high), plane.x.name, across)
    scale = spec.model.parameters[control].plot_scale
    labels = (
        f"analytic: ${' = '.join(formula(spec, control, low < 0.0))}$",
        spec.model.line_words.label.format(spec.criterion.label(spec.model)),
    )
    for edge in theory_lines(grid, control).values():
        for label, look, line in zip(labels, LINES.values(), edge, strict=True):
            values = np.atleast_1d(line) * scale
            if not np.any((values >= low) & (values <= high)):
                continue
            if upward:
                x = across * plane.x.plot_scale
                axes.plot(x, values, path_effects=HALO, label=label, **look)
            else:
                axes.axvline(values[0], label=label, **look)
    axes.set(xlim=ends["x"], ylim=ends["y"])


def _across(axes: "Axes", quantity: Quantity) -> Array:
    """Return values [SI] along the whole x axis, as far as the parameter allows them."""
    spaced = np.geomspace if axes.get_xscale() == "log" else np.linspace
    values = spaced(*axes.get_xlim(), _FINE) / quantity.plot_scale
    return values[quantity.allows(values)] if isinstance(quantity, Input) else values


def _grid(spec: SweepSpec, control: str, ends: tuple[float, float], name: str, across: Array) -> SweepSpec:
    """Return a grid in the plane of a list for which theory gives the lines along the control."""
    words = {word: value for word, value in spec.words().items() if word not in WORDS}
    scale = spec.model.parameters[control].plot_scale
    axes: dict[str, Any] = {control: Range(ends[0] / scale, ends[1] / scale, 2)}
    if across.size:
        axes[name] = across.tolist()
    return SweepSpec(**{"model": spec.model, **words, **axes})


def _caption(spec: SweepSpec, plane: Plane, share: Share, drawn: int, count: int) -> tuple[str, ...]:
    lines = [f"unstable: {spec.criterion.caption(spec.model)}", fixed_parameters(spec)]
    if share.decided:
        value, low, high = share.percentages()
        lines.append(f"{value} % of {share.decided} unstable (95 %: {low} to {high} %)")
    if drawn < count:
        lines.append(f"{counted(drawn, 'start', count)} {are(drawn)} drawn")
    if plane.hidden:
        verb = are(len(plane.hidden), "varies", "vary")
        lines.append(f"not visible: {' and '.join(plane.hidden)} {verb} too")
    return tuple(filter(None, lines))
