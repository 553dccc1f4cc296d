"""The variables of two atlases: their kinds, which of them may be missing, and the allowed differences.

The rule of a quantity is its `sweep.model.quantity.Tolerance`. An atlas states the tolerance in its spec, the errors of
its cells, the half-widths of its brackets and its method.
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

#: Kinds of variables: per grid axis, per cell, per row along a control parameter, per curve point, and unknown ones.
COORDINATE, CELL, EDGE, CURVE, FOREIGN = "coordinate", "cell", "edge", "curve", "foreign"


@dataclass(frozen=True)
class Variable:
    """A variable of either atlas: its quantity, its kind, and for an edge its axis."""

    quantity: Quantity
    kind: str
    axis: str = ""

    @property
    def name(self) -> str:
        """The name of the variable."""
        return self.quantity.name

    @property
    def has_tolerance(self) -> bool:
        """Whether its differences are measured: for known variables that are neither decisions nor coordinates."""
        return self.kind not in (COORDINATE, FOREIGN) and self.quantity.flags is None


def variables(pair: Pair) -> Iterator[Variable]:
    """Yield the variables of either atlas, coordinates first."""
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
    """Return whether an atlas may lack a variable.

    The reference may lack variables of the cells; either atlas may lack coordinates and unknown variables.
    """
    if variable.kind in (COORDINATE, FOREIGN):
        return True
    return variable.kind == CELL and variable.name in pair.new


def cut_along(variable: Variable, pair: Pair) -> str:
    """Return a message if a variable needs a whole axis but only part of it is common; otherwise empty."""
    needs = {EDGE: [variable.axis], CURVE: pair.axes}.get(variable.kind, ())
    along = sorted(pair.cut.intersection(needs))
    return f"only part of {', '.join(along)} is common" if along else ""


_HALFWIDTH = "_halfwidth"


@dataclass(frozen=True)
class Stated:
    """Cells of one atlas: the spec, and columns of one shape."""

    spec: SweepSpec
    columns: Mapping[str, npt.NDArray[Any]]


def allowed(quantity: Quantity, pair: Pair) -> Array:
    """Return the allowed differences of a variable without one value per cell, in the shape of the reference."""
    rule = quantity.tolerance
    rounding = rule.absolute + rule.relative * magnitude(pair.reference[quantity.name].values)
    if rule.stated == BRACKET:
        return np.asarray(rounding + _brackets(quantity.name, pair))
    if rule.stated == HALFWIDTH:
        return np.asarray(rounding + _open_in_halfwidth(quantity, pair))
    return np.asarray(rounding)


def allowed_of_cells(quantity: Quantity, new: Stated, reference: Stated, starts: Starts) -> Array:
    """Return the allowed difference of each value of a cell variable, in its units.

    Parameters
    ----------
    quantity : Quantity
    new, reference : Stated
        Their columns include `quantity`, the extremes and their error.
    starts : mapping of str to array
        Starts of the cells, in SI, of the shape of the columns.
    """
    columns = reference.columns
    if quantity.tolerance == STEP_COUNT and new.spec.method == reference.spec.method == "exact":
        # the exact method takes no steps
        return np.zeros(columns[quantity.name].shape)
    # errors are computed only for rules that use them
    errors = _extreme_errors(new) + _extreme_errors(reference) if quantity.tolerance.stated else 0.0
    own = new.columns.get(quantity.tolerance.stated)
    found = stated_error(quantity, reference.spec, starts, columns, errors)
    return found if own is None else found + PROMISED * magnitude(own)


def _extreme_errors(atlas: Stated) -> Array:
    """Return the possible error of the extremes of each cell, in the unit of the coordinate."""
    spec, found = atlas.spec, atlas.columns.get(atlas.spec.model.error_name)
    if found is None:
        return np.asarray(spec.tolerance)
    # a resolved cell never has an error above the tolerance: a file that states one is damaged
    doubled = np.minimum(PROMISED * found.astype(np.float64), PROMISED * spec.tolerance)
    if spec.method == "exact":
        # no steps: the tolerance only decides which cells count as unresolved
        return np.where(np.isnan(doubled), spec.tolerance, doubled)
    return np.fmax(doubled, spec.tolerance)


def _brackets(name: str, pair: Pair) -> Array | float:
    """Return the sum of both half-widths, or 0 if both brackets are cells of the grid; a missing one counts 0."""
    half = f"{name}{_HALFWIDTH}"
    sides = [np.nan_to_num(atlas[half].values) for atlas in (pair.new, pair.reference) if half in atlas]
    of_cells = pair.boundaries == ("grid", "grid") and not name.startswith("curve_")
    if of_cells or len({each.shape for each in sides}) != 1:
        return 0.0
    return np.asarray(sum(sides))


def _open_in_halfwidth(quantity: Quantity, pair: Pair) -> Array | float:
    """Return the allowed difference of half-widths: the rounding of the bracket ends, and more for open brackets.

    A bracket wider than requested ends where the estimated errors leave a verdict open. Each side is located to a
    quarter of the width, and rounding may move it. Different kernels or steps have different errors.
    """
    sides = [np.nan_to_num(atlas[quantity.name].values) for atlas in (pair.new, pair.reference)]
    name = quantity.name.removesuffix(_HALFWIDTH)
    ends: Array | float = 0.0
    if name in pair.reference:
        ends = quantity.tolerance.relative * magnitude(pair.reference[name].values)
    widths = [spec.boundary_width for spec in pair.specs if spec.boundary_width is not None]
    if len(widths) < len(pair.specs):
        return ends
    reached = [side <= 0.5 * width * (1.0 + 1e-9) for side, width in zip(sides, widths, strict=True)]
    apart = max(widths) + sides[1] if pair.other_errors else 0.25 * max(widths)
    return ends + np.where(np.all(reached, axis=0), 0.0, apart)


def read_limits(given: Mapping[str, float | str], known: Mapping[str, Quantity]) -> dict[str, float]:
    """Return the largest differences that the caller allows, in SI.

    Parameters
    ----------
    given : mapping of str to float or str
        Variable -> a number in SI, or text with a unit.
    known : mapping of str to Quantity
        The variables that have a tolerance.

    Raises
    ------
    RequestError
        If a variable is unknown, a decision or a coordinate, or a value is negative or not a number.
    """
    limits = {}
    for name, raw in given.items():
        place = f"{name}={shown(raw)}"
        if name not in known:
            raise RequestError(
                f"No tolerance can be given for {name}: these atlases have no such measured variable. They have "
                f"{', '.join(known)}.",
                hint=suggestion(name, tuple(known)) or "Name one of these variables.",
                where=place,
            )
        limit = read_number(raw, known[name])
        if limit < 0.0:
            raise RequestError(
                f"A tolerance must be 0 or more; got {shown(raw)}.",
                hint=f"Write {name}=1e-9, or ask for equal bits with --exact (in Python exact=True).",
                where=place,
            )
        limits[name] = limit
    return limits
