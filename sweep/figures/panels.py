"""The contents of a panel: the arrays, labels and words that are drawn of an atlas."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from sweep.atlas.boundary import theory_lines
from sweep.atlas.cf_metadata import EDGES, edge_names
from sweep.atlas.contents import Atlas
from sweep.atlas.dataset import edge_status, in_order, require, spec_named
from sweep.atlas.row_status import in_words
from sweep.errors import RequestError
from sweep.figures.scales import Scale, scale
from sweep.model.description import FAILED, MISSING
from sweep.model.quantity import STABLE, UNDECIDED, UNSTABLE, Array, Quantity, Truths
from sweep.request.axes import Values
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr

#: Points on a line of theory: a curve looks smooth, whatever the grid.
_FINE = 400

#: Values from here on are no rates and no angles.
_LARGEST = 1e30

#: First value of the coordinate on lines that end at zero, where their motions do not exist.
_NEAR_ZERO = 1e-6

#: Largest number of fixed parameters in a line of the caption: more would be wider than the panel.
_MOST_IN_LINE = 4


@dataclass(frozen=True)
class Edge:
    """One edge of the unstable band: measured, with its bracket, and both lines of theory.

    `x`, `measured` and `error`, shape (2, n), have a value for every column that has an edge; `fine_x`, `critical` and
    `predicted` one for every point of a smooth line, or a single one where the rate is the only axis. The ratios are
    squares of rates over squares of the analytic critical ones.
    """

    name: str
    x: Array
    measured: Array
    error: Array
    ratio: Array
    ratio_error: Array
    fine_x: Array
    critical: Array
    predicted: Array
    predicted_ratio: Array


@dataclass(frozen=True)
class Panel:
    """All that is drawn of one atlas.

    `peak`, in the units of the label of `peak_quantity`, `stability` and `no_result` have the shape (rows of y, columns
    of x), or (columns of x) where `y` is None. `line` is the analytic line as a formula in mathtext, `lost` names the
    endings behind `no_result`, `unit` is that of `Model.scaled_square` where a square is drawn. `joined` names the two
    ends of the line where both edges are one curve (`Model.joined_edges`). `method` is how the cells were computed.
    `marked` are the cells that were asked to be hatched; `marking` says why.
    """

    title: str
    caption: str
    criterion: str
    line: str
    x: Scale
    y: Scale | None
    peak: Array
    peak_quantity: Quantity
    stability: npt.NDArray[np.integer]
    no_result: Truths
    lost: str
    edges: tuple[Edge, ...]
    unit: tuple[float, str] | None
    joined: tuple[str, str] | None
    method: str
    marked: Truths
    marking: str

    @property
    def undecided(self) -> Truths:
        """Cells that have a peak but no verdict."""
        return np.asarray((self.stability == UNDECIDED) & ~self.no_result)

    @property
    def has_ratio(self) -> bool:
        """Whether a map has a measured boundary and an analytic line to compare it with."""
        return self.y is not None and any(np.isfinite(edge.ratio).any() for edge in self.edges)

    def verdicts(self) -> tuple[tuple[str, Truths], ...]:
        """Return the name and the cells of the two verdicts."""
        return tuple(
            (name, (self.stability == code) & ~self.no_result)
            for name, code in (("stable", STABLE), ("unstable", UNSTABLE))
        )


def panel(dataset: Atlas, marked: "xr.DataArray | None" = None) -> Panel:
    """Return what is drawn of an atlas.

    Parameters
    ----------
    dataset : Atlas
        An atlas, or a selection from one; axes of a single value are left out.
    marked : xarray.DataArray of bool, optional
        Cells to be hatched, on the dimensions of the atlas; its name says what they are.

    Returns
    -------
    Panel

    Raises
    ------
    RequestError
        If the atlas has no axis or more than two.
    """
    spec = drawn_spec(dataset)
    model = spec.model
    require(dataset, (model.peak, "stability"))
    control = next((name for name in model.controls(spec.axes) if edge_names(name)[0] in dataset), None)
    joined = model.joined_edges(spec)
    dims = _drawn_dims(dataset)
    # y is the control that has a boundary, else the first axis of the atlas
    y_name = (control or dims[0]) if len(dims) > 1 else None
    x_name = next(name for name in dims if name != y_name)

    def axis(name: str, from_zero: bool = False) -> Scale:
        values = dataset[name].values
        return scale(model.parameters[name], values, squares=name == control, from_zero=from_zero)

    x, y = axis(x_name, joined is not None and x_name == model.coordinate), axis(y_name) if y_name else None
    order = tuple(filter(None, (y_name, x_name)))
    quantity = model.variables[model.peak]
    values, stability, ending = (
        in_order(dataset[name], order) for name in (model.peak, "stability", "ending")
    )
    peak = _drawable(values) * quantity.plot_scale
    lost = [each for each in model.endings if each.role in (MISSING, FAILED) and np.any(ending == each.code)]
    up, across = (y, x) if y else (x, None)
    whole_curve = joined is not None and x_name == model.coordinate and x.ends[0] == 0.0 and up.squared
    return Panel(
        title=spec.headline.partition(":")[0],
        caption="\n".join(
            (
                f"unstable: {spec.criterion.caption(model)}",
                fixed_parameters(spec),
                *(_row_notes(dataset, control) if control else ()),
            )
        ),
        criterion=spec.criterion.label(model),
        line=_line(spec, control, up),
        x=x,
        y=y,
        peak=peak,
        peak_quantity=quantity,
        stability=stability,
        no_result=np.isin(ending, [each.code for each in lost]) | ~np.isfinite(peak),
        lost=", ".join(each.name for each in lost).replace("_", " ") or "no peak",
        edges=tuple(_edges(dataset, spec, control, up, across)) if control else (),
        unit=model.scaled_square(spec, control) if control and up.squared else None,
        joined=joined if whole_curve else None,
        method={"rk4": "RK4"}.get(spec.method, spec.method),
        marked=np.zeros(ending.shape, bool) if marked is None else in_order(marked, order),
        marking="" if marked is None else str(marked.name),
    )


def _row_notes(dataset: Atlas, control: str) -> list[str]:
    """Return why columns have no boundary; once if both edges are missing for the same reasons."""
    found = {
        edge: edge_status(dataset, control, edge) for edge in EDGES if edge_names(control, edge)[0] in dataset
    }
    first = next(iter(found.values()))
    if all(np.array_equal(each, first) for each in found.values()):
        return in_words(first, "columns")
    return [note for edge, status in found.items() for note in in_words(status, "columns", edge)]


def _line(spec: SweepSpec, control: str | None, up: Scale) -> str:
    """Return the formula of the analytic line, in mathtext: of the square where a square is drawn."""
    label = spec.model.line_label(spec, control) if control else ""
    if "=" in label or up.squared or not label:
        return f"${label}$" if label else "theory"
    return f"${up.quantity.symbol}^2 = {label}$".replace("_0", "")


def _drawn_dims(dataset: Atlas) -> list[str]:
    """Return the dimensions of the cells along which there is more than one."""
    ending = dataset["ending"]
    return [name for name, count in zip(ending.dims, ending.shape, strict=True) if count > 1]


def drawn_spec(dataset: Atlas) -> SweepSpec:
    """Return the spec of an atlas or of a selection from one.

    Raises
    ------
    RequestError
        If it has no axis or more than two.
    """
    dims = _drawn_dims(dataset)
    if len(dims) > 2:
        raise RequestError(
            f"A figure shows an atlas of one axis or two; this one has {len(dims)}: {', '.join(dims)}.",
            hint=f"Select one value of {' and of '.join(dims[2:])}, e.g. atlas.isel({dims[-1]}=0) in Python.",
        )
    if not dims:
        raise RequestError(
            "A figure shows an atlas of one axis or two; this one is a single cell.",
            hint="Give a parameter a range, start:stop:count.",
        )
    spec = spec_named(dataset)
    return spec.replace(**{name: dataset[name].values.item() for name in spec.axes if name not in dims})


def _edges(dataset: Atlas, spec: SweepSpec, control: str, up: Scale, across: Scale | None) -> list[Edge]:
    """Return the edges of the unstable band along a control, which is the scale `up`."""
    fine = _fine(dataset, across) if across else np.zeros(1)
    smooth = spec.replace(**{across.quantity.name: Values(tuple(fine))}) if across else spec
    lines = theory_lines(smooth, control)
    nothing = np.full(fine.shape, np.nan)
    kept = (across.quantity.name,) if across else ()
    edges = []
    for name in EDGES:
        measured_name, halfwidth_name, _, critical_name = edge_names(control, name)
        if measured_name not in dataset:
            continue
        measured, half, analytic = (
            np.atleast_1d(_drawable(in_order(dataset[each], kept)))
            for each in (measured_name, halfwidth_name, critical_name)
        )
        has = np.isfinite(measured) & np.isfinite(half)
        middle, low, high = measured[has], (measured - half)[has], (measured + half)[has]
        critical, predicted = (np.atleast_1d(line) for line in lines.get(name, (nothing, nothing)))
        # where the analytic rate is zero (circling upright) there is nothing to compare with
        with np.errstate(divide="ignore", invalid="ignore"):
            ratios = [(each / analytic[has]) ** 2 for each in (low, middle, high)]
            predicted_ratio = (predicted / critical) ** 2
        edge = Edge(
            name=name,
            x=across.values[has] if across else np.zeros(middle.shape),
            measured=up.shown(middle),
            error=_spread(*map(up.shown, (low, middle, high))),
            ratio=ratios[1],
            ratio_error=_spread(*ratios),
            fine_x=across.shown(fine) if across else fine,
            critical=up.shown(critical),
            predicted=up.shown(predicted),
            predicted_ratio=predicted_ratio,
        )
        edges.append(edge)
    return edges


def _drawable(values: Array) -> Array:
    """Return values that a damaged file has made too large to be drawn as NaN: their squares overflow."""
    return np.asarray(np.where(np.abs(values) < _LARGEST, values, np.nan))


def _spread(low: Array, middle: Array, high: Array) -> Array:
    """Return error bars, shape (2, n): squaring swaps the ends of a bracket where rates are negative."""
    ends = np.sort([low, high], axis=0)
    # infinite ends of a damaged file have no middle
    with np.errstate(invalid="ignore", over="ignore"):
        return np.maximum([middle - ends[0], ends[1] - middle], 0.0)


def _fine(dataset: Atlas, across: Scale) -> Array:
    start, stop = dataset[across.quantity.name].values[[0, -1]]
    if across.log:
        return np.geomspace(start, stop, _FINE)
    return np.linspace(_NEAR_ZERO if across.ends[0] == 0.0 and start > 0.0 else start, stop, _FINE)


def fixed_parameters(spec: SweepSpec) -> str:
    """Return the parameters that are the same in every cell and not zero, in mathtext."""
    parts = []
    # the system before its start: parameters of the start are zero by default
    for name in sorted(spec.fixed, key=lambda name: spec.model.parameters[name].default == 0.0):
        fixed, quantity = getattr(spec, name), spec.model.parameters[name]
        if fixed != 0.0:
            unit = quantity.plot_label.rpartition(" (")[2].rstrip(")") if quantity.units != "1" else ""
            parts.append(f"${quantity.symbol} = {fixed * quantity.plot_scale:.4g}$ {unit}".rstrip())
    lines = [", ".join(parts[i : i + _MOST_IN_LINE]) for i in range(0, len(parts), _MOST_IN_LINE)]
    return "\n".join(lines)
