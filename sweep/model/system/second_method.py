"""Integration of several cells of a system together by SciPy's DOP853, with their greatest values and moments.

It has only the definition of the system in common with the kernels: its functions are those of NumPy. SciPy chooses its
steps from the rates so far and would step over a short push. So no step is longer than a function needs to grow from
nothing to something (`kernels.system.hidden` lists such functions and their limits).
"""

import math
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from kernels.system.hidden import CHANGE, HIGH, NOTHING, SATURATED
from sweep.model.description import Starts
from sweep.model.quantity import Array, Truths
from sweep.model.system.cell_values import Expressions
from sweep.model.system.definition import TIME, Constant, Definition, Moment, Node, Operation

Places = npt.NDArray[np.intp]

#: Most evaluations of the rates, some seconds: a stiff system would take forever.
MOST_EVALUATIONS = 200_000

#: Points of a step at which expressions are evaluated; number of times that the two intervals around the greatest value
#: are divided again before a parabola is fitted. The error of a maximum is then 1e-11.
_POINTS, _ZOOMS = np.linspace(0.0, 1.0, 9)[:, np.newaxis], 4

#: Points of a step between which conditions change and values turn; number of times that the interval around such a
#: place is halved; distance of points for a slope, over the step. Of the fourth order, its error is below 1e-11.
_FINE, _HALVINGS, _APART = np.linspace(0.0, 1.0, 33)[:, np.newaxis], 45, 3e-3

#: Step of finite differences over the last step, and its least value; the least value of a bound of a step.
_NEAR, _NEAREST, _LEAST_STEP = 1e-4, 1e-7, 1e-5


class _Motions:
    """Motions of several cells, each over a time scaled to run from 0 to 1; their states form one flat array."""

    def __init__(self, definition: Definition, tops: Sequence[Node], starts: Starts, times: Array) -> None:
        names = [state.name for state in definition.states]
        self._integrals = [f"integral {number}" for number in range(len(definition.integrands))]
        self.first = np.array(
            [starts[name] for name in names] + [np.zeros(times.size)] * len(self._integrals)
        )
        self.greatest = np.full((len(tops), times.size), -np.inf)
        self.evaluations, self._times = 0, times

        def expressions(nodes: Sequence[Node]) -> Expressions:
            return Expressions(nodes, [*names, *self._integrals, TIME], starts)

        self.moments = [
            _Moment(
                measure.moment,
                expressions(measure.moment.expressions),
                expressions(measure.expressions),
                times.size,
            )
            for measure in definition.measures
            if measure.moment
        ]
        self._rates, self._tops = (
            expressions((*definition.rates, *definition.integrands)),
            [expressions([node]) for node in tops],
        )
        watched = [
            node for measure in definition.measures if measure.moment for node in measure.moment.expressions
        ]
        self._hidden = list(_hiding((*definition.rates, *definition.integrands, *tops, *watched)))
        self._arguments = expressions([node for _, _, node in self._hidden])

    def _values(self, expressions: Expressions, share: Any, states: Array) -> list[Any]:
        """Return the values of expressions; `states` has the shape (states, ..., cells)."""
        return expressions.values([*states, share * self._times])

    def rates(self, share: float, flat: Array) -> Array:
        """Return the rates of all states."""
        self.evaluations += 1
        rates = np.empty(self.first.shape)
        for row, values in enumerate(self._values(self._rates, share, flat.reshape(rates.shape))):
            rates[row] = values
        return (rates * self._times).ravel()

    def longest_step(self, share: float, flat: Array, last: float) -> float:
        """Return the longest step in which no function can hide, from the arguments to second order in the step."""
        if not self._hidden:
            return math.inf
        d, rate = max(_NEAR * last, _NEAREST), self.rates(share, flat)
        bend = self.rates(share + d, flat + d * rate) - self.rates(share - d, flat - d * rate)
        places = []
        for step in (-d, 0.0, d):
            states = flat + step * rate + 0.25 * step * step / d * bend
            places.append(self._values(self._arguments, share + step, states.reshape(self.first.shape)))
        bounds = []
        for (way, power, _), before, value, after in zip(self._hidden, *places, strict=True):
            slope, curvature = (after - before) / (2.0 * d), (after - 2.0 * value + before) / (2.0 * d * d)
            bounds.append(_longest(way, power, value, slope, curvature))
        return max(min(bounds), _LEAST_STEP)

    def see(self, dense: Any) -> None:
        """Update the greatest values with a step, which SciPy interpolates."""
        share = np.broadcast_to(_POINTS, (len(_POINTS), self._times.size))
        times, states = self._within(dense, share)
        for row, expressions in enumerate(self._tops):
            values = self._known(expressions, times, states)
            place, greatest, summit = _summit(values)
            if (summit > np.maximum(greatest, self.greatest[row])).any():
                summit = self._zoom(expressions, dense, share, place)
            self.greatest[row] = np.maximum(self.greatest[row], summit)
        for moment in self.moments:
            moment.see(lambda share: self._within(dense, share))

    def _zoom(self, expressions: Expressions, dense: Any, share: Array, place: Places) -> Array:
        """Return the greatest value of an expression near a point of a step."""
        for _ in range(_ZOOMS):
            least, most = (np.take_along_axis(share, place + to, 0) for to in (-1, 1))
            share = least + (most - least) * _POINTS
            place, _, summit = _summit(self._known(expressions, *self._within(dense, share)))
        return summit

    def _known(self, expressions: Expressions, times: Array, states: Array) -> Array:
        """Return the values of one expression, shape (points, cells); minus infinity where it is not defined."""
        (values,) = expressions.values([*states, times])
        return np.broadcast_to(np.where(np.isnan(values), -np.inf, values), times.shape)

    def _within(self, dense: Any, share: Array) -> tuple[Array, Array]:
        """Return times and states at shares of a step, shapes (points, cells) and (states, points, cells)."""
        # SciPy's interpolation: a polynomial in the basis x, x (1 - x), x^2 (1 - x), x^2 (1 - x)^2, ...
        basis = np.empty((len(dense.F), *share.shape))
        basis[::2], basis[1::2] = share, 1.0 - share
        terms = dense.F.reshape(len(dense.F), *self.first.shape)
        states = np.einsum("jpn,jsn->spn", np.cumprod(basis, axis=0), terms)
        states += dense.y_old.reshape(self.first.shape)[:, np.newaxis]
        return (dense.t_old + dense.h * share) * self._times, states


def follow(
    definition: Definition,
    tops: Sequence[Node],
    starts: Starts,
    times: Array,
    tolerance: float,
    *,
    sizes: Array | None = None,
    deadline: float = math.inf,
) -> Array:
    """Return the states of several cells, each at its own time, and greatest values until then; NaN if it gives up.

    Parameters
    ----------
    definition : Definition
    tops : sequence of Node
        Expressions whose greatest values are needed.
    starts : mapping of str to array, shape (n,)
        States and parameters.
    times : array, shape (n,)
        Positive.
    tolerance : float
        Relative tolerance of all states together.
    sizes : array, shape (states, n), optional
        Lower bounds of the largest values of the states: they limit the accuracy of a state that begins at zero.
    deadline : float
        Time of `time.monotonic` at which it gives up.

    Returns
    -------
    array, shape (states + integrals + tops + 3 moments, n)
        Of each moment: how often the condition became true, NaN if this is not certain; the time, and the value then.
    """
    # this module is imported with the model, but SciPy is needed only by `verify`
    from scipy.integrate import DOP853

    with np.errstate(all="ignore"):
        motions = _Motions(definition, tops, starts, times)
        first = motions.first
        size = np.abs(first) + np.abs(motions.rates(0.0, first.ravel())).reshape(first.shape)
        scale = np.broadcast_to(size.max(axis=1, keepdims=True), first.shape)
        if sizes is not None:
            # a wrong size affects only its own cell
            scale = np.fmax(scale, np.where(np.isfinite(sizes), sizes, 0.0))
        least = 1e-4 * tolerance * scale.ravel() + 1e-300
        solver = DOP853(motions.rates, 0.0, first.ravel(), 1.0, rtol=tolerance, atol=least)
        while solver.status == "running":
            if motions.evaluations > MOST_EVALUATIONS or time.monotonic() > deadline:
                break
            solver.max_step = motions.longest_step(solver.t, solver.y, solver.h_abs)
            solver.step()
            if (tops or motions.moments) and solver.status != "failed":
                motions.see(solver.dense_output())
    if solver.status != "finished":
        return np.full((len(first) + len(tops) + 3 * len(motions.moments), times.size), np.nan)
    return np.concatenate([
        solver.y.reshape(first.shape), motions.greatest,
        *([moment.counted, moment.time, moment.value] for moment in motions.moments),
    ])  # fmt: skip


#: Shares of a step -> times and states there.
_Within = Callable[[Array], tuple[Array, Array]]


class _Moment:
    """A moment of several cells: the points of a step show where it is, and halving finds its place."""

    def __init__(self, moment: Moment, watched: Expressions, measured: Expressions, count: int) -> None:
        self._moment, self._watched, self._measured = moment, watched, measured
        self.counted, self.time, self.value = np.zeros(count), np.full(count, np.nan), np.full(count, np.nan)
        self._side, self._greatest = np.zeros(count), np.full(count, -np.inf)

    def see(self, within: _Within) -> None:
        """Update the moment with a step."""
        share = np.broadcast_to(_FINE, (len(_FINE), self.counted.size))
        values = self._level(within, share)
        (self._see_condition if self._moment.is_of_condition else self._see_value)(within, share, values)

    def _level(self, within: _Within, share: Array) -> Array:
        """Return what is positive where the condition is true, or the value."""
        times, states = within(share)
        values = [np.broadcast_to(each, share.shape) for each in self._watched.values([*states, times])]
        values = [np.where(np.isnan(each), -np.inf, each) for each in values]
        if self._moment.kind == "min":
            return -values[0]
        return np.min(values, axis=0) if self._moment.every else np.max(values, axis=0)

    def _see_condition(self, within: _Within, share: Array, values: Array) -> None:
        sides = np.where(values > 0.0, 1.0, -1.0)
        # at its limit to rounding, a motion starts on the side to which it goes; later sides go on from step to step
        start = np.where(np.abs(values[0]) < 1e-13 * np.abs(values).max(axis=0), sides[1], sides[0])
        sides[0] = np.where(self._side == 0.0, start, self._side)
        self._side = sides[-1]
        rises = sides[1:] > sides[:-1]
        self.counted += rises.sum(axis=0)
        # between three points there may be an excursion across the limit
        before, middle, after = values[:-2], values[1:-1], values[2:]
        bend = before - 2.0 * middle + after
        with np.errstate(divide="ignore", invalid="ignore"):
            turn = middle - (after - before) ** 2 / (8.0 * bend)
            missed = (np.abs(after - before) <= 2.0 * np.abs(bend)) & ((turn > 0.0) != (middle > 0.0))
            missed |= np.abs(turn) < 1e-2 * np.abs(bend)
        self.counted[(missed & (sides[:-2] == sides[1:-1]) & (sides[1:-1] == sides[2:])).any(axis=0)] = np.nan
        if self._moment.kind == "first":
            wanted, place = rises.any(axis=0) & np.isnan(self.time), rises.argmax(axis=0)
        else:
            wanted, place = rises.any(axis=0), len(rises) - 1 - rises[::-1].argmax(axis=0)
        if wanted.any():
            self._write(
                within, wanted, self._halve(within, _FINE[place, 0], _FINE[place + 1, 0], self._level)
            )

    def _see_value(self, within: _Within, share: Array, values: Array) -> None:
        # a maximum at an end of the step, or at a turning point between its points
        for end in (0, -1):
            self._write(within, values[end] > self._greatest, share[end])
        (place,), _, summit = _summit(values)
        if (summit > self._greatest).any():
            low, high = _FINE[place - 1, 0], _FINE[place + 1, 0]
            turn = self._halve(within, low, high, lambda within, share: -self._slope(within, share))
            inside = (low < turn) & (turn < high)
            self._write(within, inside & (self._level(within, turn[np.newaxis])[0] > self._greatest), turn)

    def _slope(self, within: _Within, share: Array) -> Array:
        far = (self._level(within, share + sign * 2.0 * _APART) for sign in (1.0, -1.0))
        near = (self._level(within, share + sign * _APART) for sign in (1.0, -1.0))
        (two, minus_two), (one, minus_one) = far, near
        return 8.0 * (one - minus_one) - (two - minus_two)

    def _halve(
        self, within: _Within, low: Array, high: Array, level: Callable[[_Within, Array], Array]
    ) -> Array:
        """Return the share of a step from which on a level is positive."""
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            above = level(within, middle[np.newaxis])[0] > 0.0
            low, high = np.where(above, low, middle), np.where(above, middle, high)
        return high

    def _write(self, within: _Within, wanted: Truths, share: Array) -> None:
        times, states = within(share[np.newaxis])
        self.time = np.where(wanted, times[0], self.time)
        for value in self._measured.values([*states, times]):
            self.value = np.where(wanted, np.broadcast_to(value, times.shape)[0], self.value)
        if not self._moment.is_of_condition:
            level = self._level(within, share[np.newaxis])[0]
            self._greatest = np.where(wanted, level, self._greatest)


def _summit(values: Array) -> tuple[Places, Array, Array]:
    """Return an inner point next to the greatest value of each column, that value, and the maximum of a parabola.

    A maximum between the last two points counts, even if the last point has the greatest value.
    """
    place = np.clip(values.argmax(axis=0), 1, len(values) - 2)[np.newaxis]
    middle, before, after = (np.take_along_axis(values, place + to, 0)[0] for to in (0, -1, 1))
    bend, greatest = 2.0 * middle - before - after, values.max(axis=0)
    inside = (bend > 0.0) & (np.abs(after - before) <= 2.0 * bend) & np.isfinite(bend)
    return place, greatest, np.where(inside, middle + (after - before) ** 2 / (8.0 * bend), greatest)


def _hiding(nodes: Sequence[Node]) -> Iterator[tuple[str, float, Node]]:
    """Yield the functions that may grow unseen: the kind of growth, a power, the argument (`kernels.system.hidden`)."""
    seen = set[int]()
    stack = list(nodes)
    while stack:
        node = stack.pop()
        if not isinstance(node, Operation) or id(node) in seen:
            continue
        seen.add(id(node))
        stack += node.arguments
        if node.name in ("exp", "tanh"):
            yield node.name, 1.0, node.arguments[0]
        elif node.name == "log":
            yield "shrinks", 1.0, node.arguments[0]
        elif node.name == "atan2":
            squares = tuple(Operation("*", (argument, argument)) for argument in node.arguments)
            yield "shrinks", 1.0, Operation("+", squares)
        elif node.name == "/":
            base, power = _power_of(node.arguments[1])
            if power > 0.0 and not isinstance(base, Constant):
                yield "shrinks", power, base
        elif node.name in ("*", "**", "sqrt"):
            base, power = _power_of(node)
            if power > HIGH:
                yield "grows", power, base
            if power < 0.0 or power % 1.0:
                yield "shrinks", max(1.0, -power), base


def _power_of(node: Node) -> tuple[Node, float]:
    """Return the base of a node and its exponent; the node itself and 1 if it is not a power."""
    if isinstance(node, Operation) and node.name in ("**", "sqrt"):
        base, power = _power_of(node.arguments[0])
        exponent = node.arguments[1] if node.name == "**" else Constant(0.5)
        return base, power * exponent.value if isinstance(exponent, Constant) else math.nan
    if isinstance(node, Operation) and node.name == "*":
        (one, first), (other, second) = map(_power_of, node.arguments)
        if one is other or one == other:
            return one, first + second
    return node, 1.0


def _longest(way: str, power: float, value: Array, slope: Array, bend: Array) -> float:
    """Return the longest step in which the argument of a function changes by no more than is allowed, in any cell."""
    size = np.abs(value)
    if way == "exp":
        allowed = np.maximum(NOTHING - value, CHANGE)
    elif way == "grows":
        allowed = np.maximum(math.exp(NOTHING / power) - size, math.expm1(CHANGE / power) * size)
        slope = np.abs(slope)
    else:
        tanh = way == "tanh"
        allowed = np.maximum(size - SATURATED, 0.5 * CHANGE) if tanh else -math.expm1(-CHANGE / power) * size
        slope = np.where(value > 0.0, -slope, slope)
    one, other = slope / allowed, np.abs(bend) / allowed
    step = 2.0 / (one + np.sqrt(one * one + 4.0 * other))
    if way == "shrinks":
        # a divisor may pass through zero where the numerator is zero
        step = np.where(step < _LEAST_STEP, np.inf, step)
    return float(np.min(np.where(step > 0.0, step, np.inf)))
