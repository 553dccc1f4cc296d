"""The axes of a panel: parameters in the units of their labels, rates squared, scaled or as speeds too; ticks."""

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
from sweep.model.quantity import Array, Input, Quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis

#: Ratio of the ends beyond which values that are evenly spaced in the logarithm are drawn on a logarithmic axis.
_MANY = 3.0

#: Largest over smallest value beyond which a linear axis would squeeze the small ones.
SQUEEZED = 20.0

#: Ratio of the ends of a logarithmic axis below which its ticks are even, and above which they are powers of ten.
_EVEN, _POWERS = 4.0, 300.0

#: Cells, or share of an axis, that it may be continued to zero: beyond, the first cells would stand for others.
_TO_ZERO_CELLS, _TO_ZERO = 1.0, 0.01


#: Numbers on a linear axis at most, their distance over a power of ten, and the least distance of two [sizes of their
#: letters].
_MOST_TICKS, _STEPS = 7, (1.0, 2.0, 2.5, 5.0, 10.0)
_APART = {"x": 0.7, "y": 0.4}

#: Numbers with which a bar of colours can be read.
_LEAST_NUMBERS = 3


#: Lengths below these [m] -> their unit, and how many of it are a metre.
_SHORT = ((2e-3, "\u00b5m", 1e6), (0.1, "mm", 1e3))

#: Speeds from this one on [m/s] -> their unit, and how many of it are a metre per second.
_SPEEDS = ((1.0, "m", 1.0), (0.01, "cm", 1e2), (0.0, "mm", 1e3))


@dataclass(frozen=True)
class Speed:
    """A rate as a speed: the word for it, its symbol in mathtext, and the factor from the rate to it, in SI."""

    name: str
    symbol: str
    factor: float


@dataclass(frozen=True)
class Scale:
    """One axis of a panel: a parameter in the units of its label, or a rate squared, scaled or as a speed.

    `values` are those of the cells, `borders` lie between and around them, `ends` are the ends of the axis, which is
    full of cells. `rate` is one of `RATES`, `unit` that of `Model.unit_of_square` or None; `speed` belongs to a rate
    drawn as one. `factor` leads from SI to what is drawn, of a square or of the value; `units` are those of the label,
    in mathtext, nothing for a pure number. `second` are factor and label of a second axis, on which the same values are
    pure numbers, or None.
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


def unit_of_label(quantity: Quantity) -> str:
    """Return the unit in the label of a quantity, in mathtext; nothing for a pure number."""
    return quantity.plot_label.rpartition(" (")[2].rstrip(")") if quantity.units != "1" else ""


def _words_of_axis(
    quantity: Input, rate: str, unit: tuple[float, str] | None, speed: Speed | None, largest: float
) -> dict[str, Any]:
    """Return label, units, factor and second axis of a scale whose largest value is `largest` [SI]."""
    name, symbol = quantity.name.replace("_", " "), quantity.symbol
    if rate == SQUARED:
        # each unit of a CF units string with twice its power: rad s-1 becomes rad^2 s^-2
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
    label, units, factor = quantity.plot_label, unit_of_label(quantity), quantity.plot_scale
    if speed is not None:
        word, times = next((word, n) for least, word, n in _SPEEDS if largest * speed.factor >= least)
        units, factor = f"{word} s$^{{-1}}$", speed.factor * times
        label = f"{speed.name} ${speed.symbol}$ ({units})"
    pure = scaled and (scaled[0] / factor, scaled[1])
    return {"label": label, "units": units, "factor": factor, "second": pure}


@dataclass(frozen=True, kw_only=True)
class _Short(Input):
    """A length that figures show in a smaller unit than the metre; its values are in m."""

    unit: str
    times: float

    @property
    def shown_units(self) -> str:
        """The unit, in ASCII."""
        return self.unit.replace("\u00b5", "u")

    @property
    def plot_label(self) -> str:
        """Label of an axis."""
        return super().plot_label.replace("(m)", f"({self.unit})")

    @property
    def plot_scale(self) -> float:
        """How many of the unit are a metre."""
        return self.times


def readable(quantity: Input, largest: float) -> Input:
    """Return a quantity as figures show it whose values have this size at most [SI]: short lengths in mm or less."""
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
    """Return the axis of a parameter.

    Parameters
    ----------
    quantity : Input
        A parameter of the model; no cell reaches beyond what it allows.
    values : array, shape (n,)
        Values of the cells [SI], increasing, at least two.
    rate : {"linear", "squared", "scaled", "speed"}
        What to show of a rate; linear for other parameters.
    unit : (float, str), optional
        What a square is measured in to be a pure number, and its name in mathtext.
    speed : Speed, optional
        What a rate is as a speed.
    from_zero : bool
        Whether values that begin near zero, and not below it, are shown from zero on: the first cell is drawn larger.

    Raises
    ------
    RequestError
        If the square of the values is asked for and some are negative, or the scaled rate and there is no unit.
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
            f"Squares have no sign: {quantity.name} has values from {values[0]:g} {quantity.units}, and those below 0 "
            "would lie on others.",
            f"Draw the rate as it is ({LINEAR}), or {SCALED}.",
            f"rate={SQUARED}",
        )
    if rate == SCALED and unit is None:
        raise RequestError(
            f"A scaled rate needs one unit for all cells; {quantity.name} has none here: the cells differ in it, "
            "or the model has no such unit.",
            f"Draw the rate as it is ({LINEAR}), or {SQUARED}.",
            f"rate={SCALED}",
        )


def check_rate_is_drawn(rate: str, axes: Sequence[str], controls: Sequence[str]) -> None:
    """Refuse a way to draw rates, one of `RATES`, where no axis is a rate."""
    if rate != LINEAR and not controls:
        raise RequestError(
            f"There is no rate to draw {rate}: the axes are {' and '.join(axes)}.",
            "Leave the rate out.",
            f"rate={rate}" if rate in RATES else "rate",
        )


def _is_logarithmic(values: Array) -> bool:
    """Return whether positive values are spaced evenly in the logarithm, or too far to be seen on a linear axis."""
    ratios = np.diff(np.log(values))
    if values[-1] > SQUEEZED * values[0]:
        return True
    return bool(len(values) > 2 and values[-1] > _MANY * values[0] and np.ptp(ratios) <= 1e-6 * ratios[0])


def _borders(values: Array) -> Array:
    middles = 0.5 * (values[1:] + values[:-1])
    return np.concatenate(([2.0 * values[0] - middles[0]], middles, [2.0 * values[-1] - middles[-1]]))


def _last_allowed(quantity: Input, value: float, border: float) -> float:
    """Return a border, or the last number from a value of the cells to it that the parameter allows.

    Every rule is an interval, so bisection finds its end.
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
    """Add an axis on the other side, on which the same values are pure numbers, where the scale has one."""
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
    """Put plain numbers on a logarithmic axis whose ends have the ratio `ratio`."""
    if ratio < _EVEN:
        axis.set_major_locator(MaxNLocator(5))
        axis.set_minor_locator(NullLocator())
    else:
        axis.set_major_locator(LogLocator(subs=(1.0,) if ratio > _POWERS else (1.0, 2.0, 5.0), numticks=10))
    axis.set_major_formatter(FuncFormatter(_plain_number))
    axis.set_minor_formatter(NullFormatter())


def thin_ticks(axes: "Axes", most: int = _MOST_TICKS, steps: Sequence[float] = _STEPS) -> None:
    """Keep so many of the numbers on the axes of a panel that none touches its neighbour, in the present size.

    Those of linear axes are at most so many, and their distance is one of `steps` times a power of ten.
    """
    for each in (axes, *axes.child_axes):
        for which in ("x", "y"):
            axis = getattr(each, f"{which}axis")
            if axis.get_visible():
                _thin(axis, which, most, steps)


def name_ends(axes: "Axes") -> None:
    """Put numbers at both ends of a bar of colours that has fewer than three, and leave out those that touch them."""
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
    """Take the most numbers that do not touch: round ones on a linear axis, powers of ten on a logarithmic one."""
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
    # a scale with one number says nothing: two are left, even if they touch
    choices = [choice for choice in choices if len(choice) > 1]
    kept = next(
        (choice for choice in choices if _are_apart(choice, which)), choices[-1] if choices else numbers
    )
    if len(kept) < len(numbers):
        axis.set_major_locator(FixedLocator([place for place, _, _ in kept]))


def _numbers(axis: "Axis", which: str) -> list[tuple[float, float, float]]:
    """Return the place of each number on an axis, and both ends of the number along it [sizes of its letters]."""
    # this brings all numbers to their places
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
    """Return a number as people write it: 0.001, 10; as a power of ten where that is shorter."""
    if 1e-3 <= abs(value) < 1e6 or value == 0.0:
        return f"{value:.6g}"
    digits, _, power = f"{value:.3e}".partition("e")
    times = "" if float(digits) == 1.0 else rf"{float(digits):g}\times "
    return f"${times}10^{{{int(power)}}}$"
