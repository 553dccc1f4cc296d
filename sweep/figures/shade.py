"""The variable that colours a map and gives a profile its height, and the colours of its values."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm, Normalize

from sweep.atlas.dataset import in_order
from sweep.errors import RequestError, printable, shown
from sweep.figures.scales import SQUEEZED
from sweep.model.quantity import DECISION, OF_THE_RUN, Array, Quantity, Truths
from sweep.request.spec import SweepSpec
from sweep.request.suggestions import suggestion

if TYPE_CHECKING:
    import xarray as xr

#: Values this large are neither rates nor angles.
_LARGEST = 1e30

#: Positive values up to this one get the first colour: a logarithmic scale starting there would overflow.
LEAST = 1e-30

#: Part of viridis that is used, from the light end: perceptually uniform, safe for the colour-blind, and black lines
#: stay visible.
_PART = 0.86

#: Colour map of numbers, light for small values.
COLOURS = ListedColormap(colormaps["viridis_r"](np.linspace(0.0, _PART, 256)), name="peak_tilt")

#: Largest number of flags that have distinguishable colours.
_MOST_FLAGS = 12

#: Flags of cells without a definite answer, and their colour.
_OPEN, _GREY = ("undecided", "sensitive"), "#d4d4d4"


@dataclass(frozen=True)
class Shade:
    """A variable of the cells of a panel.

    `values` are in the units of the label of `quantity`, NaN where there is no value; shape (rows of y, columns of x),
    or (columns of x). `absent` marks the cells that have a result but no value; `absence` is their label.
    """

    quantity: Quantity
    values: Array
    absent: Truths
    absence: str

    @property
    def codes(self) -> list[int]:
        """The codes that occur, if the variable is enumerated."""
        if self.quantity.flags is None:
            return []
        return [int(code) for code in np.unique(self.values[np.isfinite(self.values)])]

    def regions(self) -> list[tuple[str, Truths]]:
        """Return the name and the cells of every code that occurs."""
        return [(self.quantity.flag(code), np.asarray(self.values == code)) for code in self.codes]


def shade(
    dataset: "xr.Dataset", spec: SweepSpec, order: tuple[str, ...], name: str | None, lost: Truths
) -> Shade:
    """Return a variable in the form in which it is drawn.

    Parameters
    ----------
    dataset : xarray.Dataset
    spec : SweepSpec
        The spec of the atlas or of the selection.
    order : tuple of str
        Dimensions of the panel.
    name : str or None
        The variable; None for the model's default.
    lost : array of bool
        Cells without a reliable number, in the shape of the panel.

    Raises
    ------
    RequestError
        If the atlas has no such variable of its cells.
    """
    quantity = _quantity(dataset, spec, name or spec.model.drawn_of(spec))
    values = in_order(dataset[quantity.name], order)
    if quantity.flags is not None:
        numbers = np.asarray(values, np.float64)
    else:
        numbers = drawable(values) * quantity.plot_scale
        # a variable that rates the result is valid even without a result
        if quantity.tolerance not in OF_THE_RUN:
            numbers = np.where(lost, np.nan, numbers)
    return Shade(quantity, numbers, np.isnan(numbers) & ~lost, f"no {quantity.name.replace('_', ' ')}")


def variables_of_cells(dataset: "xr.Dataset") -> list[str]:
    """Return the names of the variables that have one number for every cell."""
    dims = set(dataset["ending"].dims)
    return [
        str(name)
        for name, variable in dataset.variables.items()
        if set(variable.dims) == dims and variable.dtype.kind in "iuf" and name not in dims
    ]


def _quantity(dataset: "xr.Dataset", spec: SweepSpec, name: str) -> Quantity:
    known = variables_of_cells(dataset)
    if name not in known:
        raise RequestError(
            f"The atlas has no variable {shown(printable(str(name)))} of its cells; it has "
            f"{', '.join(map(printable, known))}.",
            suggestion(name, known) or "Give one of these.",
            "quantity",
        )
    told: dict[str, Quantity] = {**spec.model.parameters, **spec.model.cell_variables(spec)}
    return told[name] if name in told else _declared_quantity(name, dataset[name])


def _declared_quantity(name: str, variable: "xr.DataArray | xr.Variable") -> Quantity:
    """Return the quantity that the attributes of a variable declare, for variables that the model does not define."""
    attrs = variable.attrs
    values, names = np.atleast_1d(attrs.get("flag_values", [])), str(attrs.get("flag_meanings", "")).split()
    flags = dict(zip((int(code) for code in values), names, strict=False)) if names else None
    units = str(attrs.get("units", "1"))
    return Quantity(name, "", units, str(attrs.get("long_name", name)), DECISION, flags=flags)


def drawable(values: Array) -> Array:
    """Return values, with NaN for those that a damaged file has made too large to draw: their squares overflow."""
    return np.asarray(np.where(np.abs(values) < _LARGEST, values, np.nan))


def common_norm(shades: Sequence[Shade], peak: str) -> Normalize:
    """Return the common colour scale of several panels: logarithmic for the peak, and where numbers span decades.

    `peak` is the first panel's variable if it is the peak of its model.
    """
    values = np.concatenate([each.values[np.isfinite(each.values)] for each in shades])
    positive = values[values > LEAST]
    if shades[0].quantity.name == peak:
        low, high = (positive.min(), positive.max()) if positive.size else (1.0, 90.0)
        return LogNorm(low, high if high > 1.01 * low else 1.01 * low)
    if not values.size:
        return Normalize(0.0, 1.0)
    if is_wide(values):
        return LogNorm(positive.min(), positive.max())
    low, high = values.min(), values.max()
    least = max(abs(low), abs(high)) * 1e-3 or 1.0
    return Normalize(low, high) if high - low > least else Normalize(low - least, high + least)


def is_wide(values: Array) -> bool:
    """Return whether nonnegative numbers span too much for a linear scale to show the small ones."""
    known = values[np.isfinite(values)]
    positive = known[known > LEAST]
    return bool(positive.size and known.min() >= 0.0 and positive.max() > SQUEEZED * positive.min())


def flag_colours(shades: Sequence[Shade]) -> tuple[ListedColormap, BoundaryNorm, list[int]]:
    """Return the colours of all codes that occur in several panels, from light to dark, with their norm and the codes.

    Raises
    ------
    RequestError
        If there are too many to be distinguishable.
    """
    codes = sorted({code for each in shades for code in each.codes})
    if len(codes) > _MOST_FLAGS:
        raise RequestError(
            f"A map has colours for {_MOST_FLAGS} flags; {shades[0].quantity.name} has {len(codes)} here.",
            "Draw another quantity.",
            "quantity",
        )
    names = shades[0].quantity.flags or {}
    open_ = [names.get(code) in _OPEN for code in codes]
    known = len(codes) - sum(open_)
    parts = iter(np.linspace(0.0, _PART, known) if known > 1 else [0.3])
    looks = [_GREY if is_open else tuple(colormaps["viridis_r"](next(parts))) for is_open in open_]
    # a norm needs two borders, even if there are no values
    edges = [code - 0.5 for code in codes] + [(codes[-1] if codes else 0) + 0.5]
    colours = ListedColormap(looks or ["white"])
    return colours, BoundaryNorm(edges if codes else [-0.5, 0.5], max(len(codes), 1)), codes
