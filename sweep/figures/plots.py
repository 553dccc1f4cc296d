"""Figures of atlases: stability maps with the measured boundary, the analytic line and the predicted one.

The same atlases give the same bytes: the file contains neither a time nor a random name.
"""

from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sweep.atlas.dataset import require, spec_named
from sweep.errors import RequestError, as_path, shown
from sweep.figures import scatter
from sweep.figures.drawing import bar_of, check_same_quantity, colours_of, draw_map, draw_profile, draw_ratio
from sweep.figures.layout import Block, figure_of
from sweep.figures.look import BAR, DPI, Look, check_friction, columns_of, size_of
from sweep.figures.multiples import figure as figure_of_many
from sweep.figures.panels import Panel, drawn_dims, file_names, panel
from sweep.figures.sheet import styled
from sweep.files.paths import check_format, check_target
from sweep.files.publish import published
from sweep.model.description import Model
from sweep.motion.sampling import check_motion, kind_of

if TYPE_CHECKING:
    import xarray as xr

#: Width of a panel with its labels, and its least width [in], in letters of 8 points; a journal's column is 3.4 wide.
#: In a figure of given width, panels that would be narrower move to another row. Below `_SECOND` there is no room for a
#: second axis.
_WIDTHS, _SECOND = (3.6, 2.2), 2.6

#: Largest number of dots of a figure, and of dots along a side: a png of this size takes 400 MB of memory.
_MOST_DOTS, _MOST_SIDE = 10**8, 2**16 - 1

#: Format -> the metadata that would record the date and the program; None omits an entry.
_METADATA: Mapping[str, Mapping[str, None]] = {
    "png": {"Software": None},
    "pdf": {"CreationDate": None, "Producer": None, "Creator": None},
    "svg": {"Date": None, "Creator": None},
}


def figure(
    datasets: Sequence["xr.Dataset"],
    friction: float | None = None,
    look: Look | None = None,
    axes: "Axes | None" = None,
) -> Figure:
    """Draw atlases side by side.

    Parameters
    ----------
    datasets : sequence of Atlas
        Atlases of one or two axes, or selections from atlases, one panel each; or one atlas of more axes, drawn as
        small multiples or as a family of boundary curves. `friction` and `axes` need xarray.Dataset objects.
    friction : float, optional
        Friction coefficient: cells where the disk would need more friction, or would lift off, are hatched.
    look : Look, optional
        What is drawn, and how large.
    axes : matplotlib.axes.Axes, optional
        Axes into which the map or the profile of one atlas is drawn, in the style of their figure, with a colour bar
        next to them.

    Returns
    -------
    matplotlib.figure.Figure
        The figure of `axes`; without them, a new one on an Agg canvas, not registered with pyplot.

    Raises
    ------
    RequestError
        If there are no atlases, or one has no axis, or cannot be drawn as `look` asks, or has no contact forces to
        compare with `friction` (made without ``contact=yes``).

    Notes
    -----
    Under a map, a strip shows the boundary divided by the analytic line.
    """
    look = look or Look()
    check_friction(friction)
    if axes is not None and not isinstance(axes, Axes):
        raise RequestError(
            f"This must be a matplotlib Axes, as from plt.subplots(); got {shown(axes)}.",
            hint="Leave it out for a new figure.",
            where="ax",
        )
    _check_any(datasets)
    for dataset in datasets:
        require(dataset, (spec_named(dataset).model.peak,))
    if any(spec_named(dataset).is_list for dataset in datasets):
        if friction is not None:
            _refuse_lists("friction hatches the cells of a map")
        return scatter.figure(datasets, look, axes)
    if axes is not None:
        _check_own(look)
    if look.family or any(len(drawn_dims(dataset)) > 2 for dataset in datasets):
        return figure_of_many(datasets, friction, look, axes)
    panels = [
        panel(
            dataset, None if friction is None else spec_named(dataset).model.slipping(dataset, friction), look
        )
        for dataset in datasets
    ]
    check_same_quantity(panels)
    columns, colouring = columns_of(len(panels), look, *_WIDTHS), colours_of(panels, look)
    room = (size_of(columns, look, _WIDTHS[0])[0] * 8.0 / look.font_size - BAR) / columns

    def block(own: Axes, each: Panel) -> Block:
        found = Block(own, each, each.title, each.caption, regions=each.regions())
        if each.y is None:
            draw_profile(own, each)
            return found
        draw_map(own, each, colouring, second=axes is not None or room >= _SECOND)
        if each.has_ratio and axes is None and "strip" not in look.without:
            found.strip = own.figure.add_axes((0.2, 0.1, 0.6, 0.1), sharex=own)
            draw_ratio(found.strip, each)
            found.strip.set_xlabel(own.get_xlabel())
            own.set_xlabel("")
            own.tick_params(axis="x", which="both", labelbottom=False)
        return found

    return figure_of(
        panels, block, look, _WIDTHS, columns=columns, bar=bar_of(panels, colouring), axes=axes,
        files=file_names(datasets),
    )  # fmt: skip


def _check_any(datasets: Sequence["xr.Dataset"]) -> None:
    if not datasets:
        raise RequestError(
            "There is nothing to draw: a figure needs at least one atlas.", hint="Give an atlas."
        )


def _check_own(look: Look) -> None:
    given = {"width": look.width, "height": look.height, "dpi": look.dpi}
    if names := [name for name, value in given.items() if value is not None]:
        raise RequestError(
            f"The figure of ax already has a size and a resolution; got ax with {' and '.join(names)}.",
            f"Leave out {' and '.join(names)}, or leave out ax.",
            "ax",
        )


def save(drawn: Figure, path: str | Path, dpi: int | None = None) -> None:
    """Write a figure. The file appears only when it is complete, and replaces one of the same name.

    Parameters
    ----------
    drawn : Figure
    path : str or Path
    dpi : int, optional
        Dots per inch; 200 if not given.

    Raises
    ------
    RequestError
        If the name does not end in png, pdf or svg, or the folder does not exist or is not writable, or the figure
        would have too many dots.
    """
    path, dpi = as_path(path, "rolling.png"), dpi or DPI
    ending = check_format(path)
    check_target(path, overwrite=True)
    dots = [int(side * dpi) for side in drawn.get_size_inches()]
    if max(dots) > _MOST_SIDE or dots[0] * dots[1] > _MOST_DOTS:
        raise RequestError(
            f"A figure can have at most {_MOST_DOTS:.0e} dots, {_MOST_SIDE} along a side; got {dots[0]} x {dots[1]} "
            f"with {dpi} per inch.",
            "Give a smaller width, height or dpi.",
            "dpi",
        )
    with styled(), published(path) as unfinished:
        drawn.savefig(unfinished, format=ending, dpi=dpi, metadata=_METADATA[ending])


def motion_figure(dataset: "xr.Dataset") -> Figure:
    """Draw one motion over time with its model's function.

    Raises
    ------
    RequestError
        If the dataset is not a motion.
    """
    check_motion(dataset)
    drawn: Figure = _import_function(kind_of(dataset).figure)(dataset)
    return drawn


def regimes(datasets: "Sequence[xr.Dataset]", look: Look) -> Figure:
    """Draw the kinds of motion of atlases with their model's function."""
    return _draw_by_model("regimes", datasets, look)


def losses(datasets: "Sequence[xr.Dataset]", look: Look) -> Figure:
    """Draw how long the motions of atlases last and which loss took most, with their model's function."""
    return _draw_by_model("losses", datasets, look)


def _draw_by_model(what: str, datasets: "Sequence[xr.Dataset]", look: Look) -> Figure:
    """Draw maps with the function that the model names in the attribute `what`, which is also the option's name."""
    _check_any(datasets)
    if any(spec_named(each).is_list for each in datasets):
        _refuse_lists(f"--{what} draws maps")
    draw = [of_the_model(spec_named(each).model, what, f"--{what}") for each in datasets]
    drawn: Figure = draw[0](datasets, look)
    return drawn


def _refuse_lists(what: str) -> NoReturn:
    raise RequestError(
        f"{what}, and a list of starts is drawn as points.",
        hint="Leave the option out, or give an atlas with axes.",
    )


def of_the_model(model: Model, name: str, option: str) -> Callable[..., Figure]:
    """Return the drawing function that a model names in an attribute, or raise an error that names the option."""
    if not getattr(model, name):
        raise RequestError(f"The model {model.name} has no {name} to draw.", hint=f"Leave {option} out.")
    return _import_function(getattr(model, name))


def _import_function(place: str) -> Callable[..., Figure]:
    """Return the function that ``module:function`` names."""
    module, _, function = place.partition(":")
    found: Callable[..., Figure] = getattr(import_module(module), function)
    return found
