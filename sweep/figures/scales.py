"""The axes of a panel: parameters in the units of their labels, rates squared, with the borders between cells."""

from dataclasses import dataclass, replace

import numpy as np

from sweep.schema import PARAMETERS, Array, Quantity

#: Ratio of the ends beyond which values that are not evenly spaced are drawn on a logarithmic axis.
_MANY = 3.0

#: Share of an axis below which it begins at zero.
_NEAR_ZERO = 0.2


@dataclass(frozen=True)
class Scale:
    """One axis of a panel: a parameter, or the square of a rate, in the units of its label.

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
        return rf"{self.quantity.name.replace('_', ' ')} squared {self.symbol} (rad$^2$ s$^{{-2}}$)"

    @property
    def symbol(self) -> str:
        """The symbol of what is drawn, in mathtext."""
        return f"${self.quantity.symbol}^2$" if self.squared else f"${self.quantity.symbol}$"

    def shown(self, values: Array) -> Array:
        """Return values [SI] as the axis shows them."""
        return values**2 if self.squared else values * self.quantity.plot_scale


def scale(name: str, values: Array, *, squares: bool, from_zero: bool = False) -> Scale:
    """Return the axis of a parameter.

    Parameters
    ----------
    name : str
        A parameter of `schema.PARAMETERS`.
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
    bare = Scale(PARAMETERS[name], values, borders, (low, high), log, squared)
    return replace(
        bare,
        values=bare.shown(values),
        borders=bare.shown(borders),
        ends=tuple(bare.shown(np.array([low, high]))),
    )


def _borders(values: Array) -> Array:
    middles = 0.5 * (values[1:] + values[:-1])
    return np.concatenate(([2.0 * values[0] - middles[0]], middles, [2.0 * values[-1] - middles[-1]]))
