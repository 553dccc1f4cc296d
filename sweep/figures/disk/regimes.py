"""The map of regimes: how many wells the potential of each start has, and whether its motion crosses upright.

Both follow from the exact reduction; only the starts of an atlas are used.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from sweep.engine.compute import use_threads
from sweep.engine.grid import whole
from sweep.figures.drawing import INK, draw_cells, explain_colour, hatch
from sweep.figures.layout import Block, figure_of
from sweep.figures.look import Look, columns_of
from sweep.figures.panels import Panel, drawn_spec, file_names, fixed_parameters, map_panel
from sweep.figures.room import HALO
from sweep.model.disk.exact import ExactReduction
from sweep.model.disk.model import DISK
from sweep.model.disk.theory import saddle_node_rates
from sweep.model.quantity import Array, Truths
from sweep.request.sources import Values
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

#: Names of the regimes: one or two wells, on one side of upright or crossing it.
NAMES = ("one well\none side", "one well\ncrosses", "two wells\none side", "two wells\ncrosses")

#: Width and least width of a panel [in]; panels in a row.
_WIDTHS, _IN_ROW = (3.6, 2.2), 2

#: Okabe and Ito's blue and orange, each in two strengths: the hue shows the wells, the strength shows the crossing,
#: also in greyscale.
_COLOURS = ("#dcecf6", "#7fb9dc", "#fbe3bd", "#e69f00")
_FALLS: dict[str, Any] = {"facecolor": "0.92", "hatch": "...."}
_SEPARATRIX = "#b3261e"

#: Endings of cells without a regime, in addition to falls.
_LOST = ("edge_change", "unresolved", "invalid")

#: Largest number of wells that has a name.
_MOST_WELLS = 2

#: Number of points on a curve of theory.
_FINE = 400


@dataclass(frozen=True)
class Regimes:
    """Everything that is drawn of one atlas; arrays have the shape (rows of y, columns of x).

    `regime` is an index into `NAMES`, -1 where the disk falls (`fell`) or the reduction has no result (`unknown`);
    `lost` names the endings of the unknown cells. `separatrix` is the nearest maximum of the potential minus the
    energy, NaN where there is no maximum. `folds` are curves in the units of the scales.
    """

    panel: Panel
    caption: tuple[str, ...]
    regime: npt.NDArray[np.int8]
    fell: Truths
    unknown: Truths
    lost: str
    separatrix: Array
    folds: tuple[tuple[Array, Array], ...]

    def regions(self) -> list[tuple[str, Truths]]:
        """Return the name and the cells of each regime, and of the falls."""
        named = [(name, self.regime == code) for code, name in enumerate(NAMES)]
        return [*named, ("falls", self.fell)]


def regimes(dataset: "xr.Dataset", look: Look | None = None) -> Regimes:
    """Return the regimes of the starts of an atlas of two axes, or of a selection from one; raises as `figure` does."""
    drawn = map_panel(dataset, look, "regimes")
    assert drawn.y is not None
    spec = drawn_spec(dataset)
    spec = spec.replace(**{name: Values(tuple(dataset[name].values.tolist())) for name in spec.axes})
    use_threads(None)
    reference, endings = spec.model.exact, spec.model.endings
    assert isinstance(reference, ExactReduction)
    exact = {
        name: column.reshape(spec.shape) for name, column in reference.with_wells(spec, whole(spec)).items()
    }
    if spec.axes[0] != drawn.y.quantity.name:
        exact = {name: grid.T for name, grid in exact.items()}
    ending = {name: exact["ending"] == endings.code(name) for name in endings.flags.values()}
    across = (exact["tilt_min"] < 0.0) & (exact["tilt_max"] > 0.0)
    known = (ending["bounded"] | ending["steady"]) & (exact["wells"] > 0) & (exact["wells"] <= _MOST_WELLS)
    return Regimes(
        panel=drawn,
        caption=(fixed_parameters(spec), "stays on one side of upright, or crosses it"),
        regime=np.where(known, 2 * (exact["wells"] - 1) + across, -1).astype(np.int8),
        fell=ending["fell"],
        unknown=~known & ~ending["fell"],
        lost=", ".join(name.replace("_", " ") for name in _LOST if name in ending and ending[name].any()),
        separatrix=exact["separatrix"],
        folds=tuple(_folds(spec, drawn)),
    )


def _folds(spec: SweepSpec, drawn: Panel) -> list[tuple[Array, Array]]:
    """Return the curve of folds, if the axes are the tilt and the only nonzero rate."""
    assert drawn.y is not None
    axis, tilts = drawn.y.quantity.name, spec.tilt
    still = {"roll_rate": "precession_rate", "precession_rate": "roll_rate"}.get(axis)
    if spec.model is not DISK:
        return []
    if not isinstance(tilts, Values) or still is None or getattr(spec, still) != 0.0:
        return []
    alpha, radius, gravity = spec.alpha, spec.radius, spec.gravity
    assert isinstance(alpha, float)
    assert isinstance(radius, float)
    assert isinstance(gravity, float)
    first, last = tilts.values[0], tilts.values[-1]
    tilt = np.geomspace(first, last, _FINE) if drawn.x.log else np.linspace(first, last, _FINE)
    rate = saddle_node_rates(tilt, axis, alpha) * np.sqrt(gravity / radius)
    shown = drawn.x.shown(tilt)
    return [
        (shown, drawn.y.shown(sign * rate)) for sign in ((1.0,) if drawn.y.values[0] >= 0.0 else (1.0, -1.0))
    ]


def figure(datasets: "Sequence[xr.Dataset]", look: Look | None = None) -> Figure:
    """Draw the regimes of atlases of two axes, or of selections from atlases, one panel each.

    The curve of folds is drawn over the tilt and the only nonzero rate, from theory; the colours and the separatrix are
    from the reduction.

    Raises
    ------
    RequestError
        If an atlas does not have two axes.
    """
    look = look or Look()
    panels = [regimes(dataset, look) for dataset in datasets]
    columns = min(_IN_ROW, columns_of(len(panels), look, *_WIDTHS))
    return figure_of(panels, _block, look, _WIDTHS, columns=columns, files=file_names(datasets))


def _block(axes: "Axes", each: Regimes) -> Block:
    panel = each.panel
    shown = np.ma.masked_less(each.regime, 0)
    draw_cells(axes, panel, shown, cmap=ListedColormap(_COLOURS), vmin=-0.5, vmax=len(NAMES) - 0.5)
    for code, (name, colour) in enumerate(zip(NAMES, _COLOURS, strict=True)):
        if (each.regime == code).any():
            explain_colour(axes, colour, name.replace("\n", ", "))
    hatch(axes, panel, each.fell, "falls", **_FALLS)
    hatch(axes, panel, each.unknown, each.lost, facecolor="0.7", hatch="xxxx")
    for x, y in each.folds:
        label = "fold: one well above, two below (theory)"
        axes.plot(x, y, color=INK, linewidth=1.4, path_effects=HALO, label=label)
    _draw_separatrix(axes, each)
    return Block(axes, panel, panel.title, each.caption, regions=each.regions())


def _draw_separatrix(axes: "Axes", each: Regimes) -> None:
    """Draw the separatrix, where a motion just reaches the saddle of its potential."""
    panel = each.panel
    assert panel.y is not None
    known = each.separatrix[np.isfinite(each.separatrix)]
    if not known.size or known.min() >= 0.0 or known.max() <= 0.0:
        return
    contour = axes.contour(panel.x.values, panel.y.values, np.ma.masked_invalid(each.separatrix), [0.0])
    # matplotlib leaves segments without points where cells are masked
    segments = [segment for segment in contour.allsegs[0] if len(segment) > 1]
    contour.remove()
    # draws lines instead, because the legend shows them and region names keep clear of them
    for i, segment in enumerate(segments):
        label = "separatrix: just reaches the saddle" if i == 0 else None
        axes.plot(*segment.T, color=_SEPARATRIX, linewidth=1.2, linestyle="--", zorder=3, label=label)
