"""The table of a boundary stored as curves: a contiguous ragged array, as CF-1.11 (section 9.3.3) has it."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from sweep.schema import PARAMETERS, Quantity, Tolerance, table

#: Dimensions: the curves, and the points of all curves one after the other.
CURVES, POINTS = "curve", "curve_point"

_COUNTED = Tolerance(0.0, 0.0, "the same curves have the same points")


def curve_quantities() -> Mapping[str, Quantity]:
    """Return what is stored of each curve."""
    return table(
        Quantity("curve_point_count", "", "1", "number of points of the curve", _COUNTED,
                 "the points of a curve follow on those of the one before", "i4"),
        Quantity("curve_closed", "", "1", "whether the curve is closed", _COUNTED,
                 "open: it ends at the border of the grid or at undecided cells", "i1",
                 MappingProxyType({0: "open", 1: "closed"})),
    )  # fmt: skip


def point_quantities(axes: Sequence[str]) -> Mapping[str, Quantity]:
    """Return what is stored of each point of a curve: its place along every axis of the atlas, and the half-widths."""
    rows = []
    for axis in axes:
        along, words = PARAMETERS[axis], axis.replace("_", " ")
        tolerance = Tolerance(2e-8, 1e-9, "a point is bisected to the width that the atlas records")
        rows += [
            Quantity(f"curve_{axis}", along.symbol, along.units, f"{words} of a point on the boundary", tolerance),
            Quantity(f"curve_{axis}_halfwidth", along.symbol, along.units,
                     f"half-width of the bracket around the {words}", tolerance, "0 where the point lies on the grid"),
        ]  # fmt: skip
    return table(*rows)
