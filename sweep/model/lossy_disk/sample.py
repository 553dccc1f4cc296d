"""A sample of cells of an atlas with losses, computed again: with half the step, and a few by SciPy's DOP853.

The equations for DOP853 have only the laws in common with the kernels. They use tilt and rates with sines and cosines,
torques about the contact point as in the literature (Leine, Arch. Appl. Mech. 79 (2009) 1063), and signs of dry
friction that are evaluated at every step. They are for motions in which dry friction neither sticks nor reverses.
"""

import math
import secrets
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.model.description import Columns, Request, Starts
from sweep.model.lossy_disk import tables
from sweep.model.lossy_disk.tables import BILDSTEN, LOSSES, MOFFATT
from sweep.model.quantity import Array

#: Relative and absolute tolerance per step of DOP853.
_RELATIVE, _ABSOLUTE = 1e-11, 1e-14

#: Measures from DOP853.
MEASURES = (
    "end_time",
    "tilt_min",
    "tilt_max",
    *(measure for _, measure in LOSSES.values()),
    "heading_turned",
    "path_length",
)


def smooth_motion(spec: Request, start: Mapping[str, float]) -> dict[str, float]:
    """Return `MEASURES` of a motion of the disk that ends flat or after the duration.

    Parameters
    ----------
    spec : Request
    start : mapping of str to float
        Every parameter of the disk with losses [SI].

    Notes
    -----
    Scaled: theta'' = [S + o ((1+alpha) s - alpha o T / 2) + M_t] / (1 + alpha/2), o' = w (o T - 2 s) + 2 M_b / alpha,
    s' = (M_n - w o) / (1+alpha). M_t, M_b, M_n: torques over m g R about the tilt axis, the diameter through the
    contact, and the axis of the disk.
    """
    unit = math.sqrt(start["radius"] / start["gravity"])
    return followed(spec, start, _equations(spec, start, unit))


def followed(
    spec: Request, start: Mapping[str, float], motion: Callable[[float, Any], list[float]]
) -> dict[str, float]:
    """Return `MEASURES` of a motion that ends flat or after the duration.

    Parameters
    ----------
    spec : Request
    start : mapping of str to float
        Every parameter [SI].
    motion : callable
        Derivatives in scaled time of (tilt, w, o, s, energy lost to each law, heading, path), all scaled.
    """
    unit = math.sqrt(start["radius"] / start["gravity"])
    tilt, rates = (
        start["tilt"],
        [start[name] * unit for name in ("tilt_rate", "precession_rate", "roll_rate")],
    )
    first = [tilt, rates[0], rates[1] * math.cos(tilt), rates[2] + rates[1] * math.sin(tilt)]

    def flat(_: float, y: Array) -> float:
        return abs(float(y[0])) - float(spec.flat_tilt)

    def turning(_: float, y: Array) -> float:
        return float(y[1])

    flat.terminal = True  # type: ignore[attr-defined]  # SciPy reads this attribute
    integration = solution(
        motion, [*first, *[0.0] * (len(LOSSES) + 2)], spec.duration / unit, [flat, turning]
    )
    # most extreme tilts lie between steps
    tilts = np.concatenate(
        [integration.y[0, [0, -1]], *(events[:, 0] for events in integration.y_events if len(events))]
    )
    *sums, path = integration.y[4:, -1]
    values = (unit * integration.t[-1], tilts.min(), tilts.max(), *sums, start["radius"] * path)
    return dict(zip(MEASURES, values, strict=True))


def solution(
    motion: Callable[[float, Any], list[float]],
    first: list[float],
    end: float,
    events: list[Callable[[float, Array], float]],
) -> Any:
    """Return the solution of SciPy's DOP853 from a state to a time, with its events."""
    from scipy.integrate import solve_ivp

    return solve_ivp(
        motion, (0.0, end), first, method="DOP853", rtol=_RELATIVE, atol=_ABSOLUTE, events=events
    )


def _equations(spec: Request, start: Mapping[str, float], unit: float) -> Callable[[float, Any], list[float]]:
    """Return the right-hand side for (tilt, w, o, s, loss of each law, heading, path), all scaled."""
    alpha, radius, mass = start["alpha"], start["radius"], start["mass"]
    rolling, pivoting, contour = (
        start[name] / radius for name in ("rolling_friction", "pivoting_friction", "contour_friction")
    )
    damping = start["contour_damping"] * unit / (mass * radius**2)
    film = 0.25 * math.pi * start["air_viscosity"] * radius * unit / mass if spec.air_law == MOFFATT else 0.0
    layer = 0.0
    if spec.air_law == BILDSTEN:
        layer = math.sqrt(0.5 * start["air_viscosity"] * start["air_density"] * unit) * radius**2 / mass
    inertia = 1.0 + 0.5 * alpha

    def right(_: float, y: Any) -> list[float]:
        tilt, w, o, s = (float(value) for value in y[:4])
        sin, cos = math.sin(tilt), math.cos(tilt)
        tan = sin / cos
        along, turning = s - o * tan, o * cos + s * sin
        across = cos * along
        horizontal = math.hypot(w, across) or 1.0
        pull = (sin + o * ((1.0 + alpha) * s - 0.5 * alpha * o * tan)) / inertia
        # the normal force depends on the tilt acceleration, and that, through rolling friction, on the normal force
        share = rolling * w / (horizontal * inertia)
        normal = (1.0 - w * w * cos - sin * pull) / (1.0 - sin * share)
        drag = (film / cos + layer * math.sqrt(abs(along))) * along
        q = -contour * normal * math.copysign(1.0, along) - damping * along - drag
        h = -rolling * normal * across / horizontal
        v = -pivoting * normal * math.copysign(1.0, turning)
        about = -q * tan - h * sin + v * cos
        axial = q + h * cos + v * sin
        return [
            w,
            pull - share * normal,
            w * (o * tan - 2.0 * s) + 2.0 * about / alpha,
            (axial - w * o) / (1.0 + alpha),
            rolling * normal * horizontal,
            pivoting * normal * abs(turning),
            contour * normal * abs(along),
            damping * along * along,
            drag * along,
            o / cos,
            abs(along),
        ]

    return right


#: Most cells integrated with half the step; most of them integrated by DOP853, and most steps of such a cell: some
#: seconds of work in total.
CELLS, _FEW, _MOST_STEPS = 200, 8, 20_000

#: With half the step, a fourth-order method meets a tolerance smaller by this factor; the smallest tolerance that long
#: motions meet in double precision.
_FINER, _LEAST_TOLERANCE = 16.0, 5e-13

#: The variables compared, and the prefixes of their values from half the step and from DOP853.
COMPARED = (
    "ending",
    "end_time",
    "end_tilt",
    "tilt_min",
    "tilt_max",
    *(measure for _, measure in tables.LOSSES.values()),
    "heading_turned",
    "path_length",
    "breach_time",
)
AGAIN, OTHER = "again_", "other_"


class Sample:
    """Random cells of an atlas, and their second computation.

    Parameters
    ----------
    size : int
        Number of cells of the atlas.
    seed : int or None
        Seed of the random cells; a new one if None.
    smooth : callable
        `smooth_motion` of the model.

    Attributes
    ----------
    seed : int
    count : int
        Number of cells drawn.
    others : int
        Number of cells integrated by SciPy so far.
    """

    def __init__(
        self,
        size: int,
        seed: int | None,
        smooth: Callable[[Request, Mapping[str, float]], Mapping[str, float]],
    ) -> None:
        self._smooth = smooth
        self.seed = secrets.randbelow(10**9) if seed is None else seed
        rng = np.random.default_rng(self.seed)
        # in a large atlas a few cells drawn twice do not matter
        drawn = rng.permutation(size) if size <= 10 * CELLS else rng.integers(0, size, CELLS)
        self._places = np.unique(drawn[:CELLS])
        self.count, self.others = self._places.size, 0

    def of(self, spec: Request, starts: Starts, first: int) -> dict[str, npt.NDArray[Any]]:
        """Compute the drawn cells among the n cells from `first` on; `starts` has shape (n,). NaN for other cells."""
        n = starts["tilt"].size
        places = self._places[(self._places >= first) & (self._places < first + n)] - first
        columns = {f"{prefix}{name}": np.full(n, np.nan) for prefix in (AGAIN, OTHER) for name in COMPARED}
        if places.size:
            drawn = {name: values[places] for name, values in starts.items()}
            again = _compute_again(spec, drawn)
            for name in COMPARED:
                columns[AGAIN + name][places] = again[name]
            self._integrate_smooth(spec, drawn, again, places, columns)
        return columns

    def _integrate_smooth(
        self, spec: Request, starts: Starts, again: Columns, places: npt.NDArray[np.intp], columns: Columns
    ) -> None:
        """Integrate the first short motions in which friction never stuck or reversed with `smooth`."""
        ends = spec.model.endings.among(again["ending"], "flat", "horizon")
        smooth = ends & (again["switches"] == 0) & (again["steps"] <= _MOST_STEPS)
        smooth &= np.abs(starts["tilt"]) < spec.flat_tilt
        for k in np.flatnonzero(smooth)[: _FEW - self.others]:
            start = {name: float(values[k]) for name, values in starts.items()}
            for name, value in self._smooth(spec, start).items():
                columns[OTHER + name][places[k]] = value
            self.others += 1


def _compute_again(spec: Request, starts: Starts) -> dict[str, Array]:
    """Return the measures and counts of cells, integrated with half the step."""
    model = spec.model
    rows = np.stack([starts[name] for name in model.parameters])
    settings = model.kernel_settings(spec)
    names = list(model.settings)
    settings[names.index("step")] *= 0.5
    settings[names.index("tolerance")] = max(spec.tolerance / _FINER, _LEAST_TOLERANCE)
    n = rows.shape[1]
    measures, counts = np.empty((len(model.measures), n)), np.zeros((len(model.counts), n), np.int32)
    model.integrator(spec).load()(rows, settings, measures, counts)
    return dict(zip((*model.measures, *model.counts), (*measures, *counts), strict=True))
