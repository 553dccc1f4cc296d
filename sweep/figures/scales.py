"""The axes of a panel: parameters in the units of their labels, and rates also squared, scaled or as speeds; ticks."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, MaxNLocator, NullFormatter, NullLocator

from sweep.errors import RequestError
from sweep.figures.look import LINEAR, RATES, SCALED, SQUARED
from sweep.model.quantity import Array, Input

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis

#: Least ratio of the ends for a logarithmic axis, if the values are evenly spaced in the logarithm.
_MANY = 3.0

#: Ratio of the largest to the smallest value beyond which a linear axis would squeeze the small ones.
SQUEEZED = 20.0

#: Ratio of the ends of a logarithmic axis below which its ticks are evenly spaced, and above which they are powers of
#: ten.
_EVEN, _POWERS = 4.0, 300.0

#: Largest extension of an axis to zero, in cells and as a share of the axis: a longer one would misrepresent the first
#: cells.
_TO_ZERO_CELLS, _TO_ZERO = 1.0, 0.01


#: Largest number of numbers on a linear axis, their spacings divided by a power of ten, and the least gap between two
#: numbers [letter sizes].
_MOST_TICKS, _STEPS = 7, (1.0, 2.0, 2.5, 5.0, 10.0)
_APART = {"x": 0.7, "y": 0.4}

#: Least number of numbers that make a colour bar readable.
_LEAST_NUMBERS = 3


#: Lengths below each value [m] -> their unit, and how many of it make a metre.
_SHORT = ((2e-3, "\u00b5m", 1e6), (0.1, "mm", 1e3))

#: Speeds from each value on [m/s] -> their unit of length, and how many of it make a metre.
_SPEEDS = ((1.0, "m", 1.0), (0.01, "cm", 1e2), (0.0, "mm", 1e3))


@dataclass(frozen=True)
class Speed:
    """A rate as a speed: its name, its symbol in mathtext, and the factor from the rate to the speed, in SI."""

    name: str
    symbol: str
    factor: float


@dataclass(frozen=True)
class Scale:
    """One axis of a panel: a parameter in the units of its label, or a rate squared, scaled or as a speed.

    `values` are the values of the cells, `borders` are between and around them, `ends` are the ends of the axis, which
    the cells fill. `rate` is one of `RATES`, `unit` is the result of `Model.unit_of_square` or None, and `speed` is set
    for a rate drawn as a speed. `factor` converts the value, or its square, from SI to what is drawn; `units` are the
    units of the label, in mathtext, empty for a pure number. `second` contains factor and label of a second axis that
    shows the same values as pure numbers, or is None.
    """

    quantity: Input
    values: Array
    borders: Array
    ends: tuple[float, float]
    log: bool
    rate: str
    unit: tuple[float, str] | None
    speed: Speed | None
    label: str
    units: str
    factor: float
    second: tuple[float, str] | None

    def shown(self, values: Array) -> Array:
        """Return values [SI] as the axis shows them."""
        return (values**2 if self.rate == SQUARED else values) * self.factor


def _words_of_axis(
    quantity: Input, rate: str, unit: tuple[float, str] | None, speed: Speed | None, largest: float
) -> dict[str, Any]:
    """Return label, units, factor and second axis of a scale whose largest value is `largest` [SI]."""
    name, symbol = quantity.name.replace("_", " "), quantity.symbol
    if rate == SQUARED:
        # double the power of each unit: rad s-1 becomes rad^2 s^-2
        units = re.sub(
            r"([A-Za-z]+)(-?\d*)", lambda each: f"{each[1]}$^{{{2 * int(each[2] or 1)}}}$", quantity.units
        )
        pure = unit and (1.0 / unit[0], f"${symbol}^2\\,/\\,({unit[1]})$")
        return {
            "label": f"{name} squared ${symbol}^2$ ({units})",
            "units": units,
            "factor": 1.0,
            "second": pure,
        }
    scaled = unit and (1.0 / math.sqrt(unit[0]), f"${symbol}\\,/\\sqrt{{{unit[1]}}}$")
    if rate == SCALED and scaled:
        return {"label": f"{name} {scaled[1]}", "units": "", "factor": scaled[0], "second": None}
    label, units, factor = quantity.plot_label, quantity.plot_units, quantity.plot_scale
    if speed is not None:
        word, times = next((word, n) for least, word, n in _SPEEDS if largest * speed.factor >= least)
        units, factor = f"{word} s$^{{-1}}$", speed.factor * times
        label = f"{speed.name} ${speed.symbol}$ ({units})"
    pure = scaled and (scaled[0] / factor, scaled[1])
    return {"label": label, "units": units, "factor": factor, "second": pure}


@dataclass(frozen=True, kw_only=True)
class _Short(Input):
    """A length that figures show in a unit smaller than the metre; its values are in m."""

    unit: str
    times: float

    @property
    def shown_units(self) -> str:
        """The unit, in ASCII."""
        return self.unit.replace("\u00b5", "u")

    @property
    def plot_units(self) -> str:
        """The unit, as figures write it."""
        return self.unit

    @property
    def plot_scale(self) -> float:
        """How many of the unit make a metre."""
        return self.times


def readable(quantity: Input, largest: float) -> Input:
    """Return a quantity as figures show it if its largest value is `largest` [SI]: short lengths in mm or less."""
    if quantity.units != "m" or not largest > 0.0:
        return quantity
    found = next(((unit, times) for below, unit, times in _SHORT if largest < below), None)
    if found is None:
        return quantity
    words = {each.name: getattr(quantity, each.name) for each in fields(quantity)}
    return _Short(**words, unit=found[0], times=found[1])


def scale(
    quantity: Input,
    values: Array,
    *,
    rate: str = LINEAR,
    unit: tuple[float, str] | None = None,
    speed: Speed | None = None,
    from_zero: bool = False,
) -> Scale:
    """Return the scale of a parameter.

    Parameters
    ----------
    quantity : Input
        A parameter of the model; cells do not extend beyond its allowed range.
    values : array, shape (n,)
        Values of the cells [SI], increasing, at least two.
    rate : {"linear", "squared", "scaled", "speed"}
        How to show a rate; linear for other parameters.
    unit : (float, str), optional
        The unit that makes a square a pure number, and its name in mathtext.
    speed : Speed, optional
        The speed that belongs to a rate.
    from_zero : bool
        Whether the axis starts at zero if the values start near zero and are not negative; this enlarges the first
        cell.

    Raises
    ------
    RequestError
        If the squared rate is asked for and some values are negative, or the scaled rate and there is no unit.
    """
    _check_rate(quantity, values, rate, unit)
    gaps = np.diff(values)
    even = np.allclose(gaps, gaps[0], rtol=1e-6, atol=0.0)
    log = bool(not even and values[0] > 0.0 and _is_logarithmic(values))
    borders = np.exp(_borders(np.log(values))) if log else _borders(values)
    borders[0] = _last_allowed(quantity, values[0], borders[0])
    borders[-1] = _last_allowed(quantity, values[-1], borders[-1])
    if values[0] >= 0.0 and (from_zero or rate == SQUARED):
        borders[0] = max(borders[0], 0.0)
        reach = max(_TO_ZERO_CELLS * gaps[0], _TO_ZERO * values[-1]) * (1.0 + 1e-9)
        if from_zero and not log and values[0] <= reach:
            borders[0] = 0.0
    largest = float(np.abs(values).max())
    quantity = readable(quantity, largest)
    words = _words_of_axis(quantity, rate, unit, speed, largest)
    bare = Scale(quantity, values, borders, (0.0, 0.0), log, rate, unit, speed, **words)
    borders = bare.shown(borders)
    return replace(bare, values=bare.shown(values), borders=borders, ends=(borders[0], borders[-1]))


def _check_rate(quantity: Input, values: Array, rate: str, unit: tuple[float, str] | None) -> None:
    if rate == SQUARED and values[0] < 0.0:
        raise RequestError(
            f"Squares have no sign: {quantity.name} starts at {values[0]:g} {quantity.units}, and values below 0 "
            "would cover those above.",
            f"Draw the rate as it is ({LINEAR}), or {SCALED}.",
            f"rate={SQUARED}",
        )
    if rate == SCALED and unit is None:
        raise RequestError(
            f"A scaled rate needs the same unit in all cells; {quantity.name} has none here: the cells differ in it, "
            "or the model does not define one.",
            f"Draw the rate as it is ({LINEAR}), or {SQUARED}.",
            f"rate={SCALED}",
        )


def check_rate_is_drawn(rate: str, axes: Sequence[str], controls: Sequence[str]) -> None:
    """Raise an error if `rate` is set but no axis is a rate."""
    if rate != LINEAR and not controls:
        raise RequestError(
            f"No axis is a rate that can be drawn {rate}; the axes are {' and '.join(axes)}.",
            "Leave out rate.",
            f"rate={rate}" if rate in RATES else "rate",
        )


def _is_logarithmic(values: Array) -> bool:
    """Return whether positive values are evenly spaced in the logarithm, or too squeezed on a linear axis."""
    ratios = np.diff(np.log(values))
    if values[-1] > SQUEEZED * values[0]:
        return True
    return bool(len(values) > 2 and values[-1] > _MANY * values[0] and np.ptp(ratios) <= 1e-6 * ratios[0])


def _borders(values: Array) -> Array:
    middles = 0.5 * (values[1:] + values[:-1])
    return np.concatenate(([2.0 * values[0] - middles[0]], middles, [2.0 * values[-1] - middles[-1]]))


def _last_allowed(quantity: Input, value: float, border: float) -> float:
    """Return a border, or the last number between a cell's value and the border that the parameter allows.

    Every rule allows an interval, so bisection finds its end.
    """
    if not quantity.allows(np.array([value]))[0] or quantity.allows(np.array([border]))[0]:
        return border
    while (middle := 0.5 * (value + border)) not in (value, border):
        if quantity.allows(np.array([middle]))[0]:
            value = middle
        else:
            border = middle
    return value


def set_scale(axes: "Axes", which: str, scale: Scale) -> None:
    """Show a scale on the x or y axis: label, ends, ticks."""
    axes.set(**{f"{which}label": scale.label})
    low, high = scale.ends
    if scale.log:
        getattr(axes, f"set_{which}scale")("log")
        set_log_ticks(getattr(axes, f"{which}axis"), high / low)
    getattr(axes, f"set_{which}lim")(low, high)


def add_second_axis(axes: "Axes", which: str, scale: Scale) -> None:
    """Add an axis on the opposite side that shows the same values as pure numbers, if the scale has one."""
    if scale.second is None:
        return
    factor, label = scale.second

    functions = (lambda values: np.asarray(values) * factor, lambda values: np.asarray(values) / factor)
    side = {"x": "top", "y": "right"}[which]
    other = getattr(axes, f"secondary_{which}axis")(side, functions=functions)
    other.set(**{f"{which}label": label})
    if scale.log:
        set_log_ticks(getattr(other, f"{which}axis"), scale.ends[1] / scale.ends[0])


def set_log_ticks(axis: "Axis", ratio: float) -> None:
    """Put plain numbers on a logarithmic axis; `ratio` is the ratio of its ends."""
    if ratio < _EVEN:
        axis.set_major_locator(MaxNLocator(5))
        axis.set_minor_locator(NullLocator())
    else:
        axis.set_major_locator(LogLocator(subs=(1.0,) if ratio > _POWERS else (1.0, 2.0, 5.0), numticks=10))
    axis.set_major_formatter(FuncFormatter(_plain_number))
    axis.set_minor_formatter(NullFormatter())


def thin_ticks(axes: "Axes", most: int = _MOST_TICKS, steps: Sequence[float] = _STEPS) -> None:
    """Reduce the numbers on the axes of a panel until none touches its neighbour at the present size.

    Linear axes get at most `most` numbers, spaced by one of `steps` times a power of ten.
    """
    for each in (axes, *axes.child_axes):
        for which in ("x", "y"):
            axis = getattr(each, f"{which}axis")
            if axis.get_visible():
                _thin(axis, which, most, steps)


def name_ends(axes: "Axes") -> None:
    """Put numbers at both ends of a colour bar that has fewer than three, and remove those that touch them."""
    which = "x" if axes.bbox.width > axes.bbox.height else "y"
    axis, (low, high) = getattr(axes, f"{which}axis"), getattr(axes, f"get_{which}lim")()
    between = [place for place, _, _ in _numbers(axis, which)]
    if len(between) >= _LEAST_NUMBERS or low == high:
        return
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.3g}"))
    for places in ((low, *between, high), (low, high)):
        axis.set_major_locator(FixedLocator(sorted(set(places))))
        if _are_apart(_numbers(axis, which), which):
            return


def _thin(axis: "Axis", which: str, most: int, steps: Sequence[float]) -> None:
    """Set the most numbers that do not touch: round ones on a linear axis, powers of ten on a logarithmic one."""
    if axis.get_scale() == "linear" and isinstance(axis.get_major_locator(), MaxNLocator):
        whole = getattr(axis.get_major_locator(), "_integer", False)
        for count in range(most, 0, -1):
            axis.set_major_locator(MaxNLocator(count, steps=steps, integer=whole))
            if _are_apart(_numbers(axis, which), which):
                return
    numbers = _numbers(axis, which)
    choices = [numbers]
    if axis.get_scale() == "log":
        choices.append([each for each in numbers if math.log10(each[0]).is_integer()])
    choices += [numbers[::step] for step in range(2, len(numbers))]
    # an axis with one number has no scale: keep two, even if they touch
    choices = [choice for choice in choices if len(choice) > 1]
    kept = next(
        (choice for choice in choices if _are_apart(choice, which)), choices[-1] if choices else numbers
    )
    if len(kept) < len(numbers):
        axis.set_major_locator(FixedLocator([place for place, _, _ in kept]))


def _numbers(axis: "Axis", which: str) -> list[tuple[float, float, float]]:
    """Return the position of each number on an axis, and both ends of its text along the axis [letter sizes]."""
    # this call updates the positions of all numbers
    axis.get_majorticklabels()
    figure = axis.get_figure(root=True)
    assert figure is not None
    low, high = sorted(axis.get_view_interval())
    room, side, found = 1e-9 * (high - low), 0 if which == "x" else 1, []
    for tick in axis.get_major_ticks():
        for label in (tick.label1, tick.label2):
            if low - room <= tick.get_loc() <= high + room and label.get_visible() and label.get_text():
                ends = label.get_window_extent().extents
                letter = float(label.get_fontsize()) * figure.dpi / 72.0
                found.append((float(tick.get_loc()), ends[side] / letter, ends[side + 2] / letter))
    return sorted(found)


def _are_apart(numbers: Sequence[tuple[float, float, float]], which: str) -> bool:
    along = sorted(each[1:] for each in numbers)
    return all(after[0] - before[1] >= _APART[which] for before, after in pairwise(along))


def _plain_number(value: float, _: object = None) -> str:
    """Return a number as people write it: 0.001, 10; or a power of ten where that is shorter."""
    if 1e-3 <= abs(value) < 1e6 or value == 0.0:
        return f"{value:.6g}"
    digits, _, power = f"{value:.3e}".partition("e")
    times = "" if float(digits) == 1.0 else rf"{float(digits):g}\times "
    return f"${times}10^{{{int(power)}}}$"
