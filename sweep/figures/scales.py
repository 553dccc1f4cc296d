"""The axes of a panel: parameters in the units of their labels, controls squared; and their ticks in matplotlib."""

import math
import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, MaxNLocator, NullFormatter

from sweep.model.quantity import Array, Quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis

#: Ratio of the ends beyond which values that are not evenly spaced are drawn on a logarithmic axis.
_MANY = 3.0

#: Largest over smallest value beyond which a linear axis would squeeze the small ones.
SQUEEZED = 20.0

#: Ratio of the ends of a logarithmic axis below which its ticks are even, and above which they are powers of ten.
_EVEN, _POWERS = 4.0, 300.0

#: Share of an axis below which it begins at zero.
_NEAR_ZERO = 0.2


@dataclass(frozen=True)
class Scale:
    """One axis of a panel: a parameter, or its square, in the units of its label.

    `values` are those of the cells, `borders` lie between and around them, `ends` are the ends of the axis.
    """

    quantity: Quantity
    values: Array
    borders: Array
    ends: tuple[float, float]
    log: bool
    squared: bool

    @property
    def label(self) -> str:
        """Label with symbol and unit."""
        if not self.squared:
            return self.quantity.plot_label

        def squared(unit: re.Match[str]) -> str:
            return f"{unit[1]}$^{{{2 * int(unit[2] or 1)}}}$"

        # each unit of a CF units string with twice its power: rad s-1 becomes rad^2 s^-2
        units = re.sub(r"([A-Za-z]+)(-?\d*)", squared, self.quantity.units)
        return f"{self.quantity.name.replace('_', ' ')} squared {self.symbol} ({units})"

    @property
    def symbol(self) -> str:
        """The symbol of what is drawn, in mathtext."""
        return f"${self.quantity.symbol}^2$" if self.squared else f"${self.quantity.symbol}$"

    def shown(self, values: Array) -> Array:
        """Return values [SI] as the axis shows them."""
        return values**2 if self.squared else values * self.quantity.plot_scale


def scale(quantity: Quantity, values: Array, *, squares: bool, from_zero: bool = False) -> Scale:
    """Return the axis of a parameter.

    Parameters
    ----------
    quantity : Quantity
        A parameter of the model.
    values : array, shape (n,)
        Values of the cells [SI], increasing, at least two.
    squares : bool
        Whether to show squares, if no value is negative.
    from_zero : bool
        Whether values that begin near zero, and not below it, are shown from zero on; squares are in any case.
    """
    gaps = np.diff(values)
    even = np.allclose(gaps, gaps[0], rtol=1e-6, atol=0.0)
    log = bool(not even and values[0] > 0.0 and values[-1] > _MANY * values[0])
    squared = squares and bool(values[0] >= 0.0)
    borders = np.exp(_borders(np.log(values))) if log else _borders(values)
    from_zero = from_zero and bool(values[0] >= 0.0)
    if squared or from_zero:
        borders = np.maximum(borders, 0.0)
    low, high = borders[[0, -1]]
    if not log and low > 0.0 and (from_zero or squared) and low < _NEAR_ZERO * high:
        low = 0.0
    bare = Scale(quantity, values, borders, (low, high), log, squared)
    ends = tuple(bare.shown(np.array([low, high])))
    return replace(bare, values=bare.shown(values), borders=bare.shown(borders), ends=ends)


def _borders(values: Array) -> Array:
    middles = 0.5 * (values[1:] + values[:-1])
    return np.concatenate(([2.0 * values[0] - middles[0]], middles, [2.0 * values[-1] - middles[-1]]))


def set_scale(axes: "Axes", which: str, scale: Scale) -> None:
    """Show a scale on the x or y axis: label, ends, ticks."""
    axes.set(**{f"{which}label": scale.label})
    _apply_scale(axes, which, scale, 1.0)


def add_scaled_axis(axes: "Axes", which: str, scale: Scale, unit: tuple[float, str]) -> None:
    """Add a second axis on the other side, on which the same values are pure numbers.

    `unit` holds the factor of the values and its name in mathtext (`Model.scaled_square`).
    """
    other = axes.twinx() if which == "y" else axes.twiny()
    _apply_scale(other, which, scale, unit[0])
    other.set(**{f"{which}label": f"{scale.symbol}$\\,{unit[1]}$"})


def _apply_scale(axes: "Axes", which: str, scale: Scale, factor: float) -> None:
    low, high = scale.ends
    rescale, axis = getattr(axes, f"set_{which}scale"), getattr(axes, f"{which}axis")
    if scale.log:
        rescale("log")
        set_log_ticks(axis, high / low)
    elif scale.squared and low * SQUEEZED < high:
        rescale("function", functions=(_root, np.square))
        roots = MaxNLocator(8, steps=[1, 2, 5, 10]).tick_values(0.0, math.sqrt(factor * high))
        axis.set_major_locator(FixedLocator(np.square(roots).tolist()))
    getattr(axes, f"set_{which}lim")(factor * low, factor * high)


def set_log_ticks(axis: "Axis", ratio: float) -> None:
    """Put plain numbers on a logarithmic axis whose ends have the ratio `ratio`."""
    if ratio < _EVEN:
        axis.set_major_locator(MaxNLocator(5))
    else:
        axis.set_major_locator(LogLocator(subs=(1.0,) if ratio > _POWERS else (1.0, 2.0, 5.0), numticks=10))
    axis.set_major_formatter(FuncFormatter(_plain_number))
    axis.set_minor_formatter(NullFormatter())


def _plain_number(value: float, _: object = None) -> str:
    """Return a number as people write it: 0.001, 10; as a power of ten where that is shorter."""
    if abs(value) >= 1e-3 or value == 0.0:
        return f"{value:.6g}"
    digits, _, power = f"{value:.3e}".partition("e")
    times = "" if float(digits) == 1.0 else rf"{float(digits):g}\times "
    return f"${times}10^{{{int(power)}}}$"


def _root(values: Array) -> Array:
    return np.sqrt(np.maximum(values, 0.0))
