"""Ten systems with random starts, two chaotic ones, and heyoka on the same right-hand sides.

Each of the ten has one event, at `level`, and two measures; `bare` removes them.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from bench.problem import Array
from sweep.model.system.definition import Constant, Definition, Node, Symbol, symbols
from sweep.systems import System, cos, sin, system, tan

R3 = 0.8660254037844386


@system(duration="5", ends={"above": "x > level"}, measures={"top": "max y", "product": "last x*y"})
def lorenz(x=1.0, y=1.0, z=20.0, *, s=10.0, r=28.0, b=8 / 3, level=1e3):
    """Lorenz (1963), convection."""
    return s * (y - x), x * (r - z) - y, x * y - b * z


@system(duration="30", ends={"above": "x > level"}, measures={"top": "max y", "product": "last x*y"})
def driven_pendulum(x=0.2, y=0.0, *, damping=0.5, torque=0.9, drive=2 / 3, level=1e3, t):
    """A damped pendulum with a periodic torque."""
    return y, torque * cos(drive * t) - damping * y - sin(x)


@system(duration="50", ends={"above": "x > level"}, measures={"top": "max y", "product": "last x*y"})
def henon_heiles(x=0.0, y=0.0, u=0.1, v=0.1, *, level=1e3):
    """Hénon and Heiles (1964), a star in a galaxy."""
    return u, v, -x - 2 * x * y, -y - x * x + y * y


@system(duration="20", ends={"above": "x > level"}, measures={"top": "max y", "product": "last x*y"})
def thomas(x=1.0, y=0.5, z=0.2, *, b=0.2, level=1e3):
    """Thomas (1999), cyclic symmetry."""
    return sin(y) - b * x, sin(z) - b * y, sin(x) - b * z


@system(duration="10", ends={"above": "x > level"}, measures={"top": "max y", "product": "last x*y"})
def magnets(x=0.4, y=0.3, u=0.0, v=0.0, *, k=0.5, damping=0.2, height=0.25, level=1e3):
    """A pendulum above three magnets."""
    east = ((x - 1) ** 2 + y**2 + height**2) ** -1.5
    north = ((x + 0.5) ** 2 + (y - R3) ** 2 + height**2) ** -1.5
    south = ((x + 0.5) ** 2 + (y + R3) ** 2 + height**2) ** -1.5
    pull_x = (x - 1) * east + (x + 0.5) * (north + south)
    pull_y = y * east + (y - R3) * north + (y + R3) * south
    return u, v, -k * x - damping * u - pull_x, -k * y - damping * v - pull_y


@system(duration="30", ends={"above": "x > level"}, measures={"top": "max y", "product": "last x*y"})
def duffing(x=1.0, y=0.0, *, damping=0.25, force=0.2, drive=1.0, level=1e3, t):
    """Duffing, two wells and a periodic force."""
    return y, x - x**3 - damping * y + force * cos(drive * t)


@system(duration="20", ends={"above": "x > level"}, measures={"top": "max y", "product": "last x*y"})
def van_der_pol(x=1.0, y=0.0, *, mu=1.0, level=1e3):
    """Van der Pol."""
    return y, mu * (1 - x * x) * y - x


@system(duration="10", ends={"above": "x > level"}, measures={"top": "max y", "product": "last x*y"})
def kapitza(x=0.1, y=0.0, *, length=0.2, amplitude=0.02, shake=120.0, gravity=9.81, level=1e3, t):
    """Kapitza (1951), a pendulum whose pivot shakes."""
    lift = gravity - amplitude * shake**2 * cos(shake * t)
    return y, lift / length * sin(x)


@system(duration="20", ends={"above": "x > level"}, measures={"top": "max y", "product": "last x*y"})
def roessler(x=1.0, y=1.0, z=0.0, *, a=0.2, b=0.2, c=5.7, level=1e3):
    """Rössler (1976)."""
    return -y - z, x + a * y, b + z * (x - c)


@system(duration="10", ends={"above": "x > level"}, measures={"top": "max y", "product": "last x*y"})
def double_pendulum(x=0.5, y=0.5, u=0.0, v=0.0, *, gravity=9.81, level=1e3):
    """Two equal pendulums, one below the other."""
    sine = sin(x - y)
    cosine = cos(x - y)
    weight = 2 - cosine * cosine
    first = (-2 * gravity * sin(x) + gravity * sin(y) * cosine - sine * (v * v + u * u * cosine)) / weight
    second = (2 * gravity * (sin(x) * cosine - sin(y)) + sine * (2 * u * u + v * v * cosine)) / weight
    return u, v, first, second


@system(duration="150", label={"east": "x > 0.5", "north": "y > 0.4", "south": "y < -0.4"})
def slow_magnets(x=0.4, y=0.3, u=0.0, v=0.0, *, k=0.5, damping=0.04, height=0.25):
    """A pendulum above three magnets, long enough to settle."""
    east = ((x - 1) ** 2 + y**2 + height**2) ** -1.5
    north = ((x + 0.5) ** 2 + (y - R3) ** 2 + height**2) ** -1.5
    south = ((x + 0.5) ** 2 + (y + R3) ** 2 + height**2) ** -1.5
    pull_x = (x - 1) * east + (x + 0.5) * (north + south)
    pull_y = y * east + (y - R3) * north + (y + R3) * south
    return u, v, -k * x - damping * u - pull_x, -k * y - damping * v - pull_y


@system(
    duration="300",
    ends={"top": "y > 1.2", "left": "x - 1.7320508*y > 2.4", "right": "-x - 1.7320508*y > 2.4"},
)
def gaps(x=0.0, y=0.0, u=0.1, v=0.1):
    """Hénon and Heiles, until it leaves through a gap."""
    return u, v, -x - 2 * x * y, -y - x * x + y * y


@system(duration="5")
def thin_disk(tilt=0.05, w=0.0, o=0.0, s=1.0, *, alpha=0.5):
    """The thin disk in scaled variables, as in docs/theory.md."""
    pull = o * tan(tilt)
    push = o * ((1 + alpha) * s - alpha / 2 * pull)
    return w, (sin(tilt) + push) / (1 + alpha / 2), w * (pull - 2 * s), -w * o / (1 + alpha)


#: System -> ranges of its states and parameters; all others have their defaults.
RANGES: Mapping[System, Mapping[str, tuple[float, float]]] = {
    lorenz: {"x": (-10, 10), "y": (-10, 10), "z": (15, 30), "r": (20, 30)},
    driven_pendulum: {"x": (-2, 2), "y": (-1, 1), "damping": (0.3, 0.6), "torque": (0.2, 0.9)},
    henon_heiles: dict.fromkeys("xyuv", (-0.25, 0.25)),
    thomas: {**dict.fromkeys("xyz", (-2, 2)), "b": (0.18, 0.3)},
    magnets: dict.fromkeys("xy", (-1.5, 1.5)),
    duffing: {**dict.fromkeys("xy", (-1.5, 1.5)), "force": (0.1, 0.4), "damping": (0.1, 0.4)},
    van_der_pol: {**dict.fromkeys("xy", (-3, 3)), "mu": (0.5, 1.5)},
    kapitza: {"x": (-0.5, 0.5), "y": (-1, 1), "shake": (110, 150)},
    roessler: {"x": (-5, 5), "y": (-5, 5), "z": (0, 1), "c": (4, 6)},
    double_pendulum: {**dict.fromkeys("xy", (-1, 1)), **dict.fromkeys("uv", (-1, 1))},
}


def random_starts(chosen: System, count: int, rng: np.random.Generator) -> Array:
    """Return states and parameters of random cells, in the order of the definition, shape (rows, count)."""
    ranges = RANGES[chosen]
    return np.array([
        rng.uniform(*ranges[each.name], count) if each.name in ranges else np.full(count, each.default)
        for each in (*chosen.definition.states, *chosen.definition.parameters)
    ])  # fmt: skip


def bare(definition: Definition) -> Definition:
    """Return a system without events and measures, to time only the integration."""
    return replace(definition, ends=(), measures=())


class _Summits(list[Any]):
    """Values of the second state where its rate falls through zero.

    Heyoka calls this object, and copies what it calls.
    """

    def __call__(self, own: Any, time: Any, _: Any) -> None:
        own.update_d_output(time)
        self.append(own.d_output[1])

    def __deepcopy__(self, _: Any) -> "_Summits":
        return self


class Heyoka:
    """heyoka on the right-hand side of a definition.

    Parameters
    ----------
    definition : Definition
    tolerance : float
    kind : type
        Type of the numbers: ``float``, or ``numpy.longdouble``, whose rounding error is 2,000 times smaller.
    batch : int
        Number of cells that are integrated together; 0 for one cell, with its ending and the greatest value of its
        second state.
    """

    def __init__(self, definition: Definition, tolerance: float, kind: Any = float, batch: int = 0) -> None:
        import heyoka

        self._heyoka, self._definition, self._kind = heyoka, definition, kind
        names = [each.name for each in definition.states]
        self._states = dict(zip(names, heyoka.make_vars(*names), strict=True))
        self._pars = {each.name: number for number, each in enumerate(definition.parameters)}
        self._known: dict[int, Any] = {}
        rates = [self._expression(each) for each in definition.rates]
        equations = list(zip(self._states.values(), rates, strict=True))
        self._batch, self._tops, count, given = batch, _Summits(), len(equations), self._given()
        if batch:
            self._own = heyoka.taylor_adaptive_batch(
                equations, state=np.full((count, batch), 0.1), pars=np.ones((given, batch)), tol=tolerance
            )
            return
        up, down = heyoka.event_direction.positive, heyoka.event_direction.negative
        ends = [
            heyoka.t_event(self._expression(each), direction=up, fp_type=kind)
            for event in definition.ends
            for each in event.any_positive
        ]
        tops = [heyoka.nt_event(rates[1], self._tops, direction=down, fp_type=kind)] * bool(
            definition.measures
        )
        self._own = heyoka.taylor_adaptive(
            equations, state=np.full(count, 0.1, kind), pars=np.ones(given, kind), tol=kind(tolerance), fp_type=kind,
            t_events=ends, nt_events=tops,
        )  # fmt: skip

    def _given(self) -> int:
        """Return how many parameters heyoka needs: all up to the last one that is used."""
        found = self._definition
        used = [*found.rates, *(each for event in found.ends for each in event.any_positive)]
        names = {name for each in used for name in symbols(each)}
        return max((number + 1 for name, number in self._pars.items() if name in names), default=0)

    def _expression(self, node: Node) -> Any:
        if isinstance(node, Constant):
            return self._heyoka.expression(self._kind(node.value))
        if isinstance(node, Symbol):
            if node.name in self._states:
                return self._states[node.name]
            number = self._pars.get(node.name)
            return self._heyoka.time if number is None else self._heyoka.par[number]
        if id(node) not in self._known:
            self._known[id(node)] = _OPERATIONS.get(node.name, _call_function)(
                self._heyoka, node.name, *map(self._expression, node.arguments)
            )
        return self._known[id(node)]

    def ends(self, starts: Array) -> Array:
        """Return the states of cells at the end of the duration, shape (states, n), batch by batch, without events."""
        count, own, width = len(self._states), self._own, self._batch
        found = np.empty((count, starts.shape[1]))
        for first in range(0, starts.shape[1], width):
            own.set_time(0.0)
            cells = starts[:, first : first + width]
            own.state[:], own.pars[:] = cells[:count], cells[count : count + len(own.pars)]
            own.propagate_until(self._definition.duration)
            found[:, first : first + width] = own.state
        return found

    def motions(self, starts: Array) -> tuple[Array, Array, Array, Array]:
        """Return states at the end, times, endings (index of the event's expression, or -1) and greatest values."""
        return tuple(map(np.array, zip(*self._motions(starts), strict=True)))  # type: ignore[return-value]

    def _motions(self, starts: Array) -> Iterator[tuple[Any, ...]]:
        own, count = self._own, len(self._states)
        for cell in starts.T.astype(self._kind):
            self._tops[:] = [cell[1]]
            if self._definition.ends:
                own.reset_cooldowns()
            own.time, own.state[:], own.pars[:] = (
                self._kind(0.0),
                cell[:count],
                cell[count : count + len(own.pars)],
            )
            outcome = int(own.propagate_until(self._kind(self._definition.duration))[0])
            self._tops.append(own.state[1])
            yield own.state.copy(), own.time, -outcome - 1 if outcome > -1000 else -1, max(self._tops)


def _call_function(heyoka: Any, name: str, argument: Any) -> Any:
    return getattr(heyoka, name)(argument)


_OPERATIONS: Mapping[str, Any] = {
    "+": lambda _, __, one, other: one + other,
    "-": lambda _, __, one, other: one - other,
    "*": lambda _, __, one, other: one * other,
    "/": lambda _, __, one, other: one / other,
    "**": lambda _, __, one, other: one**other,
    "neg": lambda _, __, one: -one,
}
