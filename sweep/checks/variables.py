"""The variables of two atlases: which there are, of what kind each is, and which one atlas may lack."""

from collections.abc import Iterator
from dataclasses import dataclass

from sweep.atlas.cf_metadata import EDGES, curve_quantities, edge_quantities, point_quantities
from sweep.checks.alignment import Pair
from sweep.model.quantity import DECISION, Quantity
from sweep.request.start_list import START

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
