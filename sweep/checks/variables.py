"""The variables of two atlases: of what kind each is, which one atlas may lack, and how far its values may differ.

The rule of a quantity is its `sweep.model.quantity.Tolerance`; what an atlas states is the tolerance of its spec, the
errors of its cells, the half-widths of its brackets and its method.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.atlas.cf_metadata import EDGES, curve_quantities, edge_quantities, point_quantities
from sweep.checks.alignment import Pair
from sweep.errors import RequestError, shown
from sweep.model.cells import magnitude, stated_error
from sweep.model.description import Starts
from sweep.model.quantity import BRACKET, DECISION, HALFWIDTH, PROMISED, STEP_COUNT, Array, Quantity
from sweep.request.spec import SweepSpec
from sweep.request.start_list import START
from sweep.request.suggestions import suggestion
from sweep.request.values import read_number

#: Kinds of variables: those of the grid itself, of every cell, of every row along a control, of curves, and others.
COORDINATE, CELL, EDGE, CURVE, FOREIGN = "coordinate", "cell", "edge", "curve", "foreign"


@dataclass(frozen=True)
class Variable:
    """A variable of either atlas: its quantity, what kind it is, and the axis that an edge lies on."""

    quantity: Quantity
    kind: str
    axis: str = ""

    @property
    def name(self) -> str:
        """The name of the variable."""
        return self.quantity.name

    @property
    def has_tolerance(self) -> bool:
        """Whether its differences are measured: it is no decision, and known."""
        return self.kind not in (COORDINATE, FOREIGN) and self.quantity.flags is None


def variables(pair: Pair) -> Iterator[Variable]:
    """Yield the variables that either atlas holds, coordinates first."""
    model, both = pair.spec.model, (pair.new, pair.reference)
    held = list(dict.fromkeys(str(name) for atlas in both for name in atlas.variables))
    per_cell = [name for name in model.parameters if any(name in atlas.data_vars for atlas in both)]
    known = [Variable(each, COORDINATE) for each in model.parameters.values() if each.name not in per_cell]
    known += [Variable(each, CELL) for each in pair.cell_variables.values()]
    known += [Variable(model.parameters[name], CELL) for name in per_cell]
    known += [Variable(START, COORDINATE)]
    axes = [axis for axis in pair.axes if axis in model.parameters]
    for axis in axes:
        for edge in EDGES:
            edges = edge_quantities(model, axis, edge)
            known += [Variable(each, EDGE, axis) for each in edges.values()]
    points = point_quantities(model.parameters, axes)
    known += [Variable(each, CURVE) for each in (*curve_quantities().values(), *points.values())]
    yield from (each for each in known if each.name in held)
    for name in sorted(set(held) - {each.name for each in known}):
        units = next(str(atlas[name].attrs.get("units", "1")) for atlas in both if name in atlas)
        yield Variable(Quantity(name, "", units, "", DECISION), FOREIGN)


def lacking(name: str, pair: Pair) -> str:
    """Return which atlas lacks a variable; empty if both have it."""
    if name in pair.new.variables and name in pair.reference.variables:
        return ""
    return f"the {'reference' if name in pair.new.variables else 'new'} atlas does not have it"


def may_lack(variable: Variable, pair: Pair) -> bool:
    """Return whether one atlas may lack a variable: the reference what a version has added, both what is foreign."""
    if variable.kind in (COORDINATE, FOREIGN):
        return True
    added = variable.kind == CELL or (variable.kind == EDGE and variable.quantity.flags is not None)
    return added and variable.name in pair.new


def cut_along(variable: Variable, pair: Pair) -> str:
    """Return that a variable needs a whole axis of which only a part is common; empty if it does not."""
    needs = {EDGE: [variable.axis], CURVE: pair.axes}.get(variable.kind, ())
    along = sorted(pair.cut.intersection(needs))
    return f"only a part of {', '.join(along)} is common" if along else ""


_HALFWIDTH = "_halfwidth"


@dataclass(frozen=True)
class Stated:
    """What one atlas states of cells: its spec, and its columns, all of one shape."""

    spec: SweepSpec
    columns: Mapping[str, npt.NDArray[Any]]


def allowed(quantity: Quantity, pair: Pair) -> Array:
    """Return how far each value of a variable may differ, in its units, of the shape that the reference has.

    Parameters
    ----------
    quantity : Quantity
        A variable that both atlases hold, of one shape.
    pair : Pair
    """
    rule = quantity.tolerance
    if quantity.name in pair.cell_variables:
        new, reference = stated(pair)
        return allowed_of_cells(quantity, new, reference, starts_of_cells(pair))
    rounding = rule.absolute + rule.relative * magnitude(pair.reference[quantity.name].values)
    if rule.stated == BRACKET:
        return np.asarray(rounding + _brackets(quantity.name, pair))
    if rule.stated == HALFWIDTH:
        return np.asarray(rounding + _open_in_halfwidth(quantity, pair))
    return np.asarray(rounding)


def allowed_of_cells(quantity: Quantity, new: Stated, reference: Stated, starts: Starts) -> Array:
    """Return how far each value of a variable of the cells may differ, in its units.

    Parameters
    ----------
    quantity : Quantity
    new, reference : Stated
        With `quantity`, the extremes and their error.
    starts : mapping of str to array
        Starts of the cells, in SI, of the shape of the columns.
    """
    columns = reference.columns
    if quantity.tolerance == STEP_COUNT and new.spec.method == reference.spec.method == "exact":
        # which takes no steps
        return np.zeros(columns[quantity.name].shape)
    # rules that do not use the errors do without them
    errors = _extreme_errors(new) + _extreme_errors(reference) if quantity.tolerance.stated else 0.0
    own = new.columns.get(quantity.tolerance.stated)
    found = stated_error(quantity, reference.spec, starts, columns, errors)
    return found if own is None else found + PROMISED * magnitude(own)


def stated(pair: Pair) -> tuple[Stated, Stated]:
    """Return what the two atlases state of their cells, the new one first."""
    model = pair.spec.model
    names = {*model.extremes, model.error_name, *pair.cell_variables}
    return tuple(  # type: ignore[return-value]  # of a generator over two
        Stated(spec, {name: atlas[name].values for name in names if name in atlas})
        for spec, atlas in zip(pair.specs, (pair.new, pair.reference), strict=True)
    )


def starts_of_cells(pair: Pair) -> Starts:
    """Return the starts of the cells that the reference gives as coordinates, of the shape of the grid."""
    ending = pair.reference["ending"]
    return {
        str(name): values.broadcast_like(ending).transpose(*pair.axes).values
        for name, values in pair.reference.coords.items()
        if name in pair.spec.model.parameters
    }


def _extreme_errors(atlas: Stated) -> Array:
    """Return how far [unit of the coordinate] the extremes of each cell may be from the true ones."""
    spec, found = atlas.spec, atlas.columns.get(atlas.spec.model.error_name)
    if found is None:
        return np.asarray(spec.tolerance)
    # no cell is resolved with a larger error than its tolerance: a file that states one is damaged
    doubled = np.minimum(PROMISED * found.astype(np.float64), PROMISED * spec.tolerance)
    if spec.method == "exact":
        # no steps: the tolerance only says where a cell counts as unresolved
        return np.where(np.isnan(doubled), spec.tolerance, doubled)
    return np.fmax(doubled, spec.tolerance)


def _brackets(name: str, pair: Pair) -> Array | float:
    if pair.boundaries == ("grid", "grid") and not name.startswith("curve_"):
        return 0.0
    return _known(f"{name}{_HALFWIDTH}", pair)


def _known(name: str, pair: Pair) -> Array | float:
    """Return the sum of a variable of both, 0 where one has none."""
    sides = [np.nan_to_num(atlas[name].values) for atlas in (pair.new, pair.reference) if name in atlas]
    if len({each.shape for each in sides}) != 1:
        return 0.0
    return np.asarray(sum(sides))


def _open_in_halfwidth(quantity: Quantity, pair: Pair) -> Array:
    """Return what may differ in half-widths: all brackets have ends that are known to rounding.

    A bracket that is wider than asked for ends where the estimated errors leave a verdict open. Each side is found to a
    quarter of the width; other kernels or steps have other errors.
    """
    sides = [atlas[quantity.name].values for atlas in (pair.new, pair.reference)]
    name = quantity.name.removesuffix(_HALFWIDTH)
    middle = pair.reference[name].values if name in pair.reference else np.zeros_like(sides[1])
    ends = quantity.tolerance.relative * np.abs(np.nan_to_num(middle))
    widths = [spec.boundary_width for spec in pair.specs if spec.boundary_width is not None]
    if len(widths) < len(pair.specs):
        return np.asarray(ends)
    with np.errstate(invalid="ignore"):
        stopped = np.any(
            [side > 0.5 * width * (1.0 + 1e-9) for side, width in zip(sides, widths, strict=True)], axis=0
        )
    other = np.nan_to_num(sides[1]) if pair.other_errors else 0.0
    return np.asarray(ends + np.where(stopped, max(widths) + other, 0.0))


def read_limits(given: Mapping[str, float | str], known: Mapping[str, Quantity]) -> dict[str, float]:
    """Return the largest differences that a caller allows, in SI.

    Parameters
    ----------
    given : mapping of str to float or str
        Variable -> a number in SI, or text with a unit.
    known : mapping of str to Quantity
        The variables that have a tolerance.

    Raises
    ------
    RequestError
        If there is no such variable, it is a decision or a coordinate, or the value is negative or no number.
    """
    limits = {}
    for name, raw in given.items():
        place = f"{name}={shown(raw)}"
        if name not in known:
            raise RequestError(
                f"There is no variable {name} whose differences are measured in these atlases; there are "
                f"{', '.join(known)}.",
                hint=suggestion(name, tuple(known)) or "Name one of these.",
                where=place,
            )
        limit = read_number(raw, known[name])
        if limit < 0.0:
            raise RequestError(
                f"A tolerance must be 0 or more; got {shown(raw)}.",
                hint=f"Write {name}=1e-9, or use --exact for equal bits.",
                where=place,
            )
        limits[name] = limit
    return limits
