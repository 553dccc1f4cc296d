"""How scales are put on axes of matplotlib: ends, ticks, and the second axis in units of g/R."""

import math
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, MaxNLocator, NullFormatter

from sweep.figures.scales import Scale
from sweep.schema import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis

#: Largest over smallest value beyond which a linear axis would squeeze the small ones.
SQUEEZED = 20.0

#: Ratio of the ends of a logarithmic axis below which its ticks are even, and above which they are powers of ten.
_FEW, _MANY = 4.0, 300.0


def set_scale(axes: "Axes", which: str, scale: Scale) -> None:
    """Show a scale on the x or y axis: label, ends, ticks."""
    getattr(axes, f"set_{which}label")(scale.label)
    _apply_scale(axes, which, scale, 1.0)


def add_scaled_axis(axes: "Axes", which: str, scale: Scale, factor: float) -> None:
    """Add the axis in units of g/R on the other side: the same scale, as the two are proportional."""
    other = axes.twinx() if which == "y" else axes.twiny()
    _apply_scale(other, which, scale, factor)
    getattr(other, f"set_{which}label")(f"{scale.symbol}$\\,R/g$")


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


def set_log_ticks(axis: "Axis", reach: float) -> None:
    """Put plain numbers on a logarithmic axis whose ends have the ratio `reach`."""
    if reach < _FEW:
        axis.set_major_locator(MaxNLocator(5))
    else:
        axis.set_major_locator(LogLocator(subs=(1.0,) if reach > _MANY else (1.0, 2.0, 5.0), numticks=10))
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
