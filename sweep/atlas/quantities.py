"""The quantities of a boundary: its edges along a control parameter, and its curves through the planes of a grid.

Curves are stored as a contiguous ragged array, as CF-1.11 (section 9.3.3) has it.
"""

from collections.abc import Mapping, Sequence

from sweep.model.quantity import BOUNDARY, Input, Quantity, Tolerance, table

#: Dimensions: the curves, and the points of all curves one after the other.
CURVES, POINTS = "curve", "curve_point"

#: The two edges of the unstable band: stable above, stable below.
EDGES = ("upper", "lower")

_COUNTED = Tolerance(0.0, 0.0, "the same curves have the same points")
_POINT = Tolerance(2e-8, 1e-9, "a point is bisected to the width that the atlas records")


def edge_names(axis: str, edge: str = "upper") -> tuple[str, str, str, str]:
    """Return the names of one edge along an axis: measured, its half-width, predicted, critical."""
    side = f"lower_{axis}" if edge == "lower" else axis
    return f"boundary_{side}", f"boundary_{side}_halfwidth", f"predicted_{side}", f"critical_{side}"


def edge_quantities(along: Input, edge: str = "upper") -> Mapping[str, Quantity]:
    """Return the quantities of one edge of the unstable band along a parameter.

    Parameters
    ----------
    along : Input
        A control parameter of the model.
    edge : {"upper", "lower"}
        The edge above which, or below which, the motion is stable.

    Returns
    -------
    Mapping of str to Quantity
        Those of `edge_names`, all in the units of the parameter.
    """
    words, side = along.name.replace("_", " "), "below" if edge == "lower" else "above"
    meanings = (
        f"{words} {side} which the motion is stable, as measured",
        f"half-width of the bracket around the measured {words}",
        f"{words} at which theory puts the boundary for this criterion and perturbation",
        f"analytic critical {words}, the limit of a vanishing perturbation",
    )
    return table(
        *(
            Quantity(name, along.symbol, along.units, meaning, BOUNDARY)
            for name, meaning in zip(edge_names(along.name, edge), meanings, strict=True)
        )
    )


def curve_quantities() -> Mapping[str, Quantity]:
    """Return what is stored of each curve."""
    return table(
        Quantity("curve_point_count", "", "1", "number of points of the curve", _COUNTED,
                 "the points of a curve follow on those of the one before", "i4"),
        Quantity("curve_closed", "", "1", "whether the curve is closed", _COUNTED,
                 "open: it ends at the border of the grid or at undecided cells", "i1", {0: "open", 1: "closed"}),
    )  # fmt: skip


def point_quantities(parameters: Mapping[str, Input], axes: Sequence[str]) -> Mapping[str, Quantity]:
    """Return what is stored of each point of a curve: its place along every axis of the atlas, and the half-widths."""
    rows = []
    for axis in axes:
        along, words = parameters[axis], axis.replace("_", " ")
        rows += [
            Quantity(f"curve_{axis}", along.symbol, along.units, f"{words} of a point on the boundary", _POINT),
            Quantity(f"curve_{axis}_halfwidth", along.symbol, along.units,
                     f"half-width of the bracket around the {words}", _POINT, "0 where the point lies on the grid"),
        ]  # fmt: skip
    return table(*rows)
