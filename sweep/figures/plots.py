"""Figures of atlases: stability maps with the measured boundary, the analytic line and the predicted one.

The same atlases give the same bytes of the file: it holds neither a time nor a random name.
"""

from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from sweep.atlas.contents import Atlas
from sweep.atlas.dataset import require, spec_named
from sweep.errors import RequestError
from sweep.figures.drawing import COLOURS, add_legend, draw_map, draw_profile, draw_ratio, sheet, styled
from sweep.figures.panels import Panel, panel
from sweep.figures.scales import set_log_ticks
from sweep.figures.texts import set_title
from sweep.files.paths import check_format, check_target
from sweep.files.publish import published
from sweep.model.description import Model

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

#: Size of a panel [in], axes and their labels; a journal's column is 3.4 wide.
_WIDTH, _HEIGHT, _STRIP, _LEGEND, _BAR = 3.6, 3.2, 1.0, 1.1, 0.7

#: Panels side by side.
_MOST_IN_ROW = 3

_DOTS_PER_INCH = 200

#: Peaks up to here, if a file has them, are drawn in the first colour: a scale from them on would overflow.
_LEAST = 1e-30

#: Format -> the metadata that would record the date and the program, each set to None to leave it out.
_METADATA: Mapping[str, Mapping[str, None]] = {
    "png": {"Software": None},
    "pdf": {"CreationDate": None, "Producer": None, "Creator": None},
    "svg": {"Date": None, "Creator": None},
}


def figure(datasets: Sequence[Atlas], friction: float | None = None) -> Figure:
    """Draw atlases side by side.

    Parameters
    ----------
    datasets : sequence of Atlas
        Atlases of one axis or two, or selections from atlases, one panel each. Friction needs them as xarray.Dataset.
    friction : float, optional
        Friction coefficient: cells where the disk would need more, or would lift off, are hatched.

    Returns
    -------
    matplotlib.figure.Figure
        On an Agg canvas, not registered with pyplot.

    Raises
    ------
    RequestError
        If there is no atlas, or one of them has no axis or more than two, or no contact forces to hold `friction`
        against (made without ``contact=yes``).

    Notes
    -----
    An axis along which there is a boundary shows the square of the parameter, and on the other side the square in the
    unit of the model (for the disk g/R).
    Under a map, a strip shows the boundary over the analytic line.
    """
    if not datasets:
        raise RequestError("There is nothing to draw: a figure has a panel or more.", hint="Give an atlas.")
    for dataset in datasets:
        require(dataset, (spec_named(dataset).model.peak,))
    panels = [
        panel(dataset, None if friction is None else spec_named(dataset).model.slipping(dataset, friction))
        for dataset in datasets
    ]
    columns = min(len(panels), _MOST_IN_ROW)
    rows = -(-len(panels) // columns)
    strip = _STRIP if any(each.has_ratio for each in panels) else 0.0
    with sheet(columns * _WIDTH + _BAR, rows * (_HEIGHT + strip + _LEGEND)) as drawn:
        # a row of maps, and a row of strips below if there are any
        parts = [_HEIGHT, strip] if strip else [_HEIGHT]
        grid = drawn.add_gridspec(len(parts) * rows, columns, height_ratios=parts * rows)
        norm = _norm(panels)
        for i, each in enumerate(panels):
            row, column = len(parts) * (i // columns), i % columns
            if each.has_ratio:
                top = drawn.add_subplot(grid[row, column])
                _draw_with_strip(top, drawn.add_subplot(grid[row + 1, column], sharex=top), each, norm)
            else:
                _draw_alone(drawn.add_subplot(grid[row : row + len(parts), column]), each, norm)
        if any(each.y for each in panels):
            bar = drawn.colorbar(
                ScalarMappable(norm, COLOURS), ax=drawn.axes, label=panels[0].peak_quantity.plot_label,
                pad=0.015, fraction=0.03, aspect=40,
            )  # fmt: skip
            set_log_ticks(bar.ax.yaxis, float(norm.inverse(1.0) / norm.inverse(0.0)))
    return drawn


def save(drawn: Figure, path: str | Path) -> None:
    """Write a figure; the file appears only when it is complete, and replaces one of the same name.

    Raises
    ------
    RequestError
        If the name's ending is none of png, pdf, svg, or the folder does not exist or cannot be written.
    """
    path = Path(path)
    ending = check_format(path)
    check_target(path, overwrite=True)
    with styled(), published(path) as unfinished:
        drawn.savefig(unfinished, format=ending, dpi=_DOTS_PER_INCH, metadata=_METADATA[ending])


def _draw_with_strip(top: "Axes", strip: "Axes", each: Panel, norm: LogNorm) -> None:
    draw_map(top, each, norm)
    draw_ratio(strip, each)
    set_title(top, each.title)
    strip.set_xlabel(top.get_xlabel())
    top.set_xlabel("")
    top.tick_params(axis="x", which="both", labelbottom=False)
    add_legend(top, strip, each.caption)


def _draw_alone(axes: "Axes", each: Panel, norm: LogNorm) -> None:
    if each.y:
        draw_map(axes, each, norm)
    else:
        draw_profile(axes, each)
    set_title(axes, each.title)
    add_legend(axes, axes, each.caption)


def _norm(panels: Sequence[Panel]) -> LogNorm:
    """Return the colour scale of all panels."""
    peaks = np.concatenate([np.where(each.no_result, np.nan, each.peak).ravel() for each in panels])
    peaks = peaks[np.isfinite(peaks) & (peaks > _LEAST)]
    low, high = (peaks.min(), peaks.max()) if peaks.size else (1.0, 90.0)
    return LogNorm(low, high if high > 1.01 * low else 1.01 * low)


def regimes(datasets: "Sequence[xr.Dataset]") -> Figure:
    """Draw the kinds of motion of atlases, as the model of each does."""
    draw = [of_the_model(spec_named(each).model, "regimes", "--regimes") for each in datasets]
    drawn: Figure = draw[0](datasets)
    return drawn


def of_the_model(model: Model, name: str, option: str) -> Callable[..., Figure]:
    """Return the function of a model that draws its ``trajectory`` or ``regimes``, or refuse the option by name."""
    module, _, function = str(getattr(model, name)).partition(":")
    if not module:
        raise RequestError(f"The model {model.name} has no {name} to draw.", hint=f"Leave {option} out.")
    found: Callable[..., Figure] = getattr(import_module(module), function)
    return found
