"""The contents of a panel: the arrays and texts that are drawn of an atlas."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from sweep.atlas.boundary import theory_lines
from sweep.atlas.cf_metadata import EDGES, edge_names
from sweep.atlas.dataset import edge_status, in_order, require, spec_named
from sweep.atlas.row_edges import in_words
from sweep.errors import RequestError
from sweep.figures.borders import Borders, find_borders
from sweep.figures.look import LINEAR, SCALED, SPEED, SQUARED, Look
from sweep.figures.scales import Scale, Speed, check_rate_is_drawn, readable, scale
from sweep.figures.shade import Shade, drawable, shade
from sweep.figures.texts import number
from sweep.model.quantity import FAILED, MISSING, STABLE, UNDECIDED, UNSTABLE, Array, Truths
from sweep.request.sources import Values
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr

#: Number of points on a line of theory, enough for a smooth curve on any grid.
_FINE = 400

#: First value of the coordinate on lines that end at zero, where their motions do not exist.
_NEAR_ZERO = 1e-6


#: Name of a region in which the verdict changes from cell to cell.
MIXED = "mixed"

#: Least number of columns with a boundary for which a strip is worth its space.
_LEAST_COMPARED = 3


@dataclass(frozen=True)
class Edge:
    """One edge of the unstable band: measured, with its bracket, and both lines of theory.

    `x`, `measured` and `error`, shape (2, n), have one value for every column that has an edge. `fine_x`, `critical`
    and `predicted` have one value for every point of a smooth line, or a single value where the rate is the only axis.
    The ratios divide the values shown on the axis by the analytic critical value shown there.
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
    """Everything that is drawn of one atlas.

    `shade` gives the panel its colours; its values, `stability` and `no_result` have the shape (rows of y, columns of
    x), or (columns of x) where `y` is None. `line` is the analytic line as a formula in mathtext, `line_name` the text
    next to it, `lost` names the endings behind `no_result`. `joined` names the two ends of the line where both edges
    are one curve (`Model.joined_edges`). `method` says how the cells were computed. `marked` are the cells to hatch,
    and `marking` is their label. `predicted` is the label of the predicted line. `peak` is the variable by which the
    model colours maps. `caption` has one text per line.
    """

    title: str
    caption: tuple[str, ...]
    predicted: str
    line: str
    line_name: str
    x: Scale
    y: Scale | None
    shade: Shade
    stability: npt.NDArray[np.integer]
    no_result: Truths
    lost: str
    edges: tuple[Edge, ...]
    joined: tuple[str, str] | None
    method: str
    marked: Truths
    marking: str
    peak: str

    @property
    def undecided(self) -> Truths:
        """Cells with a result but without a verdict."""
        return np.asarray((self.stability == UNDECIDED) & ~self.no_result)

    @property
    def has_ratio(self) -> bool:
        """Whether the map has a boundary measured in several columns and an analytic line to compare it with."""
        compared = sum(int(np.isfinite(edge.ratio).sum()) for edge in self.edges)
        return self.y is not None and compared >= _LEAST_COMPARED

    def regions(self) -> list[tuple[str, Truths]]:
        """Return names and cells of the regions of a map: of its verdicts, or of the flags that colour it."""
        if named := self.shade.regions():
            return named
        verdicts = (*self.verdicts(), ("undecided", self.undecided))
        if self.y is None or self.has_line:
            return list(verdicts)
        return [*((name, cells & ~self.mixed) for name, cells in verdicts), (MIXED, self.mixed)]

    @property
    def has_line(self) -> bool:
        """Whether the map has a measured boundary and an analytic line."""
        return any(edge.measured.size and np.isfinite(edge.critical).any() for edge in self.edges)

    @property
    def mixed(self) -> Truths:
        """Cells of the map where stable and unstable cells alternate."""
        return np.asarray(self.borders.mixed & ~self.no_result)

    @cached_property
    def borders(self) -> Borders:
        """Borders between the stable and the unstable cells of the map."""
        return find_borders(np.where(self.no_result, UNDECIDED, self.stability))

    def verdicts(self) -> tuple[tuple[str, Truths], ...]:
        """Return the name and the cells of the two verdicts."""
        return tuple(
            (name, (self.stability == code) & ~self.no_result)
            for name, code in (("stable", STABLE), ("unstable", UNSTABLE))
        )


def panel(dataset: "xr.Dataset", marked: "xr.DataArray | None" = None, look: Look | None = None) -> Panel:
    """Return the contents of the panel of an atlas.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas, or a selection from one; axes with a single value are ignored.
    marked : xarray.DataArray of bool, optional
        Cells to hatch, on the dimensions of the atlas; its name is their label.
    look : Look, optional
        Which quantity is drawn, and how rates are drawn.

    Returns
    -------
    Panel

    Raises
    ------
    RequestError
        If the atlas has no axis or more than two, or cannot be drawn as `look` asks.
    """
    look = look or Look()
    spec = drawn_spec(dataset)
    model = spec.model
    require(dataset, (model.peak, "stability"))
    control = next((name for name in model.controls(spec.axes) if edge_names(name)[0] in dataset), None)
    joined = model.joined_edges(spec)
    dims = drawn_dims(dataset)
    y_name = model.upward(dims) if len(dims) > 1 else None
    x_name = next(name for name in dims if name != y_name)

    controls = model.controls(dims)
    check_rate_is_drawn(look.rate, dims, controls)

    def axis(name: str, from_zero: bool = False) -> Scale:
        is_rate = name in controls
        return scale(
            model.parameters[name], dataset[name].values, from_zero=from_zero,
            rate=look.rate if is_rate else LINEAR, unit=model.unit_of_square(spec, name) if is_rate else None,
            speed=speed_of(spec, name) if is_rate and look.rate == SPEED else None,
        )  # fmt: skip

    over_coordinate = joined is not None and x_name == model.coordinate and y_name == control
    x = axis(x_name, over_coordinate)
    y = axis(y_name, over_coordinate) if y_name else None
    order = tuple(filter(None, (y_name, x_name)))
    stability, ending = (in_order(dataset[name], order) for name in ("stability", "ending"))
    lost = [each for each in model.endings if each.role in (MISSING, FAILED) and np.any(ending == each.code)]
    up, across = (y, x) if y else (x, None)
    edges = tuple(_edges(dataset, spec, control, up, across)) if control else ()
    # a single branch of steady motions has only one edge, or no line of theory
    has_both = len(edges) > 1 and all(np.isfinite(each.critical).any() for each in edges)
    is_one_curve = has_both and over_coordinate and x.ends[0] == 0.0 and up.values[0] >= 0.0
    line, line_name = _line(spec, control, up, edges) if control else ("theory", "")
    without = np.isin(ending, [each.code for each in lost])
    drawn = shade(dataset, spec, order, look.quantity, without)
    return Panel(
        title=spec.short_title,
        caption=(
            # on a map of flags without unstable cells, this line would say nothing
            ""
            if drawn.codes and not np.any(stability == UNSTABLE)
            else f"unstable: {spec.criterion.caption(model)}",
            fixed_parameters(spec),
            *(_row_notes(dataset, control, x_name) if control else ()),
        ),
        predicted=model.line_words.label.format(spec.criterion.label(model)),
        line=line,
        line_name=line_name,
        x=x,
        y=y,
        shade=drawn,
        stability=stability,
        no_result=without,
        lost=", ".join(each.name for each in lost).replace("_", " "),
        edges=edges,
        joined=joined if is_one_curve else None,
        method={"rk4": "RK4", "taylor": "computed"}.get(spec.method, spec.method),
        marked=np.zeros(ending.shape, bool) if marked is None else in_order(marked, order),
        marking="" if marked is None else str(marked.name),
        peak=model.peak,
    )


def map_panel(dataset: "xr.Dataset", look: Look | None, option: str) -> Panel:
    """Return the panel of a map that shows no verdicts and is named like its option, without the lines of the verdict.

    Raises
    ------
    RequestError
        If the atlas does not have two axes.
    """
    drawn = panel(dataset, look=look)
    if drawn.y is None:
        raise RequestError(
            f"A map of {option} needs two axes; this atlas has one, {drawn.x.quantity.name}.",
            hint=f"Give another axis, or draw it without --{option}.",
        )
    return replace(drawn, edges=(), joined=None)


def _row_notes(dataset: "xr.Dataset", control: str, across: str) -> list[str]:
    """Return where the boundary along a control is missing, and why.

    `across` is the parameter whose values the rows belong to. If both edges have the same notes, they occur only once.
    """
    found = {
        edge: edge_status(dataset, control, edge) for edge in EDGES if edge_names(control, edge)[0] in dataset
    }
    first = next(iter(found.values()))
    if all(np.array_equal(each, first) for each in found.values()):
        return in_words(first, control, across=across)
    return [note for edge, status in found.items() for note in in_words(status, control, edge, across)]


def formula(spec: SweepSpec, control: str, squared: bool) -> tuple[str, str]:
    """Return both sides of the equation of the analytic line, in mathtext without dollars; empty if there is no line.

    The equation is for the rate, or for its square, which is valid for negative rates too.
    """
    label = spec.model.line_label(spec, control)
    if "=" in label:
        left, right = label.split("=")
        return left.strip(), right.strip()
    symbol = spec.model.parameters[control].symbol.replace("_0", "")
    if not label:
        return "", ""
    if squared:
        return f"{symbol}^2", label
    return symbol, rf"\sqrt{{{label}}}"


def shown_formula(spec: SweepSpec, control: str, up: Scale) -> tuple[str, str]:
    """Return both sides of the equation of the analytic line, for the form of the rate on an axis."""
    left, right = formula(spec, control, is_squared(up))
    if up.speed is None or is_squared(up) or "=" in spec.model.line_label(spec, control) or not left:
        return left, right
    factor = up.speed.symbol.removesuffix(up.quantity.symbol)
    return f"{factor}{left}", f"{factor}{right}"


def speed_of(spec: SweepSpec, axis: str) -> Speed:
    """Return the speed that belongs to a rate.

    Raises
    ------
    RequestError
        If the model has no speed for this rate, or its factor differs between the cells.
    """
    model = spec.model
    found = next(
        (each for each in model.substitutes.values() if (each.parameter, each.units) == (axis, "m s-1")), None
    )
    if found is None:
        known = [each.parameter for each in model.substitutes.values() if each.units == "m s-1"]
        raise RequestError(
            f"Only {' and '.join(known) or 'a rate of another model'} can be drawn as a speed (of the contact "
            f"point); got the axis {axis}.",
            f"Draw the rate as it is ({LINEAR}), or {SCALED}.",
            f"rate={SPEED}",
        )
    values = {name: getattr(spec, name) for name in found.needs}
    if varying := [name for name, value in values.items() if not isinstance(value, float)]:
        raise RequestError(
            f"A speed needs cells with one {' and one '.join(found.needs)}; here {' and '.join(varying)} varies.",
            f"Draw one value of {' and of '.join(varying)}, or the rate as it is ({LINEAR}), or {SCALED}.",
            f"rate={SPEED}",
        )
    symbols = "".join(model.parameters[name].symbol for name in found.needs)
    return Speed(found.name, symbols + model.parameters[axis].symbol, found.scale(values))


def is_squared(up: Scale) -> bool:
    """Return whether the formula is for the square, so that the line is at both roots where rates are negative."""
    return up.rate == SQUARED or bool(up.values[0] < 0.0)


def _line(spec: SweepSpec, control: str, up: Scale, edges: Sequence[Edge]) -> tuple[str, str]:
    """Return the analytic line for the legend, and the text next to it where it is level, in mathtext."""
    left, right = shown_formula(spec, control, up)
    if not left:
        return "theory", ""
    equation = f"${left} = {right}$"
    known = np.concatenate([edge.critical[np.isfinite(edge.critical)] for edge in edges] or [np.zeros(0)])
    if not known.size or np.ptp(known) > 1e-9 * abs(known[0]) or up.values[0] < 0.0:
        return equation, equation
    number, scaled = f"{known[0]:.4g}", up.rate == SCALED and up.unit is not None
    unit = rf"$\sqrt{{{up.unit[1]}}}$" if scaled and up.unit else up.units
    # keep number and unit on one line
    valued = f"=\u00a0{number} {unit}".rstrip().replace(" ", "\u00a0")
    return f"{equation} {valued}", number if scaled else f"${right}$"


def file_names(datasets: "Sequence[xr.Dataset]") -> list[str]:
    """Return the names of the files of atlases, empty for an atlas without a file.

    All are empty if the names do not differ.
    """
    names = [Path(str(each.encoding.get("source", ""))).name for each in datasets]
    return names if len(set(names)) > 1 else [""] * len(names)


def drawn_dims(dataset: "xr.Dataset") -> list[str]:
    """Return the dimensions of the cells that have more than one value."""
    ending = dataset["ending"]
    return [str(name) for name, count in zip(ending.dims, ending.shape, strict=True) if count > 1]


def drawn_spec(dataset: "xr.Dataset") -> SweepSpec:
    """Return the spec of an atlas or of a selection from one.

    Raises
    ------
    RequestError
        If it has no axis or more than two.
    """
    dims = drawn_dims(dataset)
    if len(dims) > 2:
        raise RequestError(
            f"A figure needs an atlas of one or two axes; this one has {len(dims)}: {', '.join(dims)}.",
            hint=f"Take one value of {' and of '.join(dims[2:])}, as in {dims[-1]}={dataset[dims[-1]].values[0]:.6g}.",
        )
    if not dims:
        raise RequestError(
            "A figure needs an atlas of one or two axes; this one is a single cell.",
            hint="Give a parameter a range, start:stop:count.",
        )
    spec = spec_named(dataset)
    return spec.replace(**{name: dataset[name].values.item() for name in spec.axes if name not in dims})


def _edges(
    dataset: "xr.Dataset", spec: SweepSpec, control: str, up: Scale, across: Scale | None
) -> list[Edge]:
    """Return the edges of the unstable band along a control, whose scale is `up`."""
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
            np.atleast_1d(drawable(in_order(dataset[each], kept)))
            for each in (measured_name, halfwidth_name, critical_name)
        )
        has = np.isfinite(measured) & np.isfinite(half)
        middle, low, high = measured[has], (measured - half)[has], (measured + half)[has]
        critical, predicted = (np.atleast_1d(line) for line in lines.get(name, (nothing, nothing)))
        # where the analytic rate is zero (circling upright) there is nothing to compare with
        with np.errstate(divide="ignore", invalid="ignore"):
            ratios = [up.shown(each) / up.shown(analytic[has]) for each in (low, middle, high)]
            predicted_ratio = up.shown(predicted) / up.shown(critical)
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


def _spread(low: Array, middle: Array, high: Array) -> Array:
    """Return error bars, shape (2, n); for negative rates, squaring swaps the ends of a bracket."""
    ends = np.sort([low, high], axis=0)
    # infinite ends in a damaged file have no middle
    with np.errstate(invalid="ignore", over="ignore"):
        return np.maximum([middle - ends[0], ends[1] - middle], 0.0)


def _fine(dataset: "xr.Dataset", across: Scale) -> Array:
    start, stop = dataset[across.quantity.name].values[[0, -1]]
    if across.log:
        return np.geomspace(start, stop, _FINE)
    return np.linspace(_NEAR_ZERO if across.ends[0] == 0.0 and start > 0.0 else start, stop, _FINE)


def fixed_parameters(spec: SweepSpec) -> str:
    """Return the parameters that are the same in every cell and not zero, in mathtext."""
    # the system first, then its start: parameters of the start are zero by default
    names = sorted(spec.fixed, key=lambda name: spec.model.parameters[name].default == 0.0)
    return ", ".join(value_text(spec, name) for name in names if getattr(spec, name) != 0.0)


def value_text(spec: SweepSpec, name: str) -> str:
    """Return a parameter that is the same in every cell, with its value, in mathtext."""
    quantity = readable(spec.model.parameters[name], abs(getattr(spec, name)))
    # keep symbol, number and unit on one line
    unit = quantity.plot_units.replace(" ", "\u00a0")
    number = _spell_in_mathtext(getattr(spec, name) * quantity.plot_scale)
    symbol = quantity.symbol or quantity.name.replace("_", r"\_").join((r"\mathrm{", "}"))
    return f"${symbol} = {number}$\u00a0{unit}".rstrip("\u00a0")


def _spell_in_mathtext(value: float) -> str:
    """Return a number in mathtext, as a power of ten if that is shorter."""
    digits, _, power = number(value).partition("e")
    return rf"{digits}\times 10^{{{int(power)}}}" if power else digits
