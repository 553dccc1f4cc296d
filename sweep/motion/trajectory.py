"""One motion in time: from a request to an xarray.Dataset with path, invariants and contact forces."""

import json
import math
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from kernels.disk import arrays, motion_arrays
from kernels.disk.endings import FELL, HORIZON, UNRESOLVED
from sweep.atlas.cf_metadata import (
    CITATION,
    COMPRESSION,
    CONTENT,
    CONVENTIONS,
    LICENSE,
    SOFTWARE,
    ascii_text,
    created,
)
from sweep.errors import RequestError
from sweep.model.disk.initial_conditions import complete, computed_rate
from sweep.model.disk.model import DISK
from sweep.model.kernel import Kernel, code_hash
from sweep.model.quantity import FILL, Array, Quantity
from sweep.motion.request import LIFTS, MOTION_INPUTS, ROLLS, SLIPS, TIME, TRAJECTORY, TrajectorySpec
from sweep.request.spec import MOST_STEPS
from sweep.request.words import AUTOMATIC
from sweep.version import __version__

if TYPE_CHECKING:
    import xarray as xr

#: Version of the layout of the file.
FORMAT = 1

_MODULE = "kernels.disk.trajectory"
_TRAJECTORY, _DERIVED = Kernel(_MODULE, "trajectory", seconds=1.0), Kernel(_MODULE, "derived", seconds=1.0)

#: Step times the fastest frequency of the state: the motions of docs/report.md are then within 1e-9 of the exact ones.
_RELATIVE_STEP = 0.005

#: Largest relative energy drift with an automatic step; beyond it, the motion is integrated again with half the step.
_DRIFT = 1e-11
_MOST_REFINEMENTS = 6

#: With interval=auto: the angle [rad] by which tilt, heading and roll angle may change between two samples, so that a
#: path drawn through the samples is within half a per cent of its radius; and the largest number of samples.
_TURN, _MOST_SAMPLES = 0.2, 200_000

#: Samples are laid out for a fall this much later than it was first found: closer samples mean shorter steps, which
#: find it at another moment if the step that was asked for is too long.
_LATER = 1.1

#: Relative and absolute error per step that DOP853 is asked for.
_RELATIVE, _ABSOLUTE = 1e-12, 1e-15

#: Parameters that the file holds as scalar coordinates; the start is the first sample.
_FIXED = (*(name for name in arrays.PARAMETERS if name not in arrays.STATE), "mass", "friction")

_SUMMARY = (
    "One motion of a thin rigid disk that rolls without slipping on a horizontal plane: tilt and rates, path of the "
    "contact point, energy, vertical angular momentum with its balance law, and contact forces."
)


def simulate(
    spec: TrajectorySpec | None = None, *, command: str = "sweep.simulate", **words: Any
) -> "xr.Dataset":
    """Compute one motion.

    Parameters
    ----------
    spec : TrajectorySpec, optional
        The request; if not given, it is read from `words`.
    command : str
        The command of the user, for the attribute history.
    **words
        As in `TrajectorySpec.read`, for example ``roll_rate=3, tilt_rate="1deg/s", duration="10s"``.

    Returns
    -------
    xarray.Dataset
        Dimension elapsed_time [s]; tilt, rates, path, energy, momentum, contact forces. A motion that falls ends
        with the sample at the moment of its fall. ``sweep.save`` writes it.

    Raises
    ------
    RequestError
        If the request cannot be read or carried out, or the motion is too fast to be resolved.
    """
    spec = TrajectorySpec.read(**words) if spec is None else spec
    start, times = _start(spec), spec.times
    integrate = _by_rk4 if spec.method == "rk4" else _by_dop853
    samples, fall_time = integrate(spec, start, times)
    if spec.interval == AUTOMATIC and (closer := _closer(times, samples, fall_time))[1] < times[1]:
        again, fell_at = integrate(spec, start, closer)
        if fall_time is None or fell_at is not None:
            times, samples, fall_time = closer, again, fell_at
    times = times[: samples.shape[1]].copy()
    if fall_time is not None:
        times[-1] = fall_time
    values = _variables(spec, start, samples, _derived(start, samples))
    values["ending"] = np.array(HORIZON if fall_time is None else FELL, np.int8)
    values["fall_time"] = np.array(np.nan if fall_time is None else fall_time)
    return _dataset(spec, times, values, command)


def _start(spec: TrajectorySpec) -> Array:
    """Return the start, shape (len(PARAMETERS),), with the rate that keeps the tilt where the request asks for it."""
    values = complete(spec, {name: getattr(spec, name) for name in arrays.PARAMETERS})
    rate = computed_rate(spec)
    if rate is not None and not np.isfinite(values[rate]):
        given = "precession_rate" if rate == "roll_rate" else "roll_rate"
        raise RequestError(
            f"No {rate} keeps this tilt constant; got {rate}={getattr(spec, rate)} with {given}="
            f"{getattr(spec, given):.6g} tilt={math.degrees(spec.tilt):.6g}deg.",
            hint=f"Give a larger {given}, a tilt other than 0, or a number for {rate}.",
            where=rate,
        )
    return np.array([values[name] for name in arrays.PARAMETERS], dtype=np.float64)


def _closer(times: Array, samples: Array, fall_time: float | None) -> Array:
    """Return evenly spaced times, close enough for the fastest turn that samples show, and as many until a fall."""
    turning = samples[[arrays.TILT, motion_arrays.HEADING, motion_arrays.ROLL_ANGLE]]
    turns = np.abs(np.diff(turning)).max(initial=0.0)
    last = times[-1] if fall_time is None else fall_time
    count = max(times.size - 1, last / times[1] * turns / _TURN)
    count = math.ceil(min(count, _MOST_SAMPLES))
    if fall_time is None:
        return np.linspace(0.0, times[-1], count + 1)
    # half an interval, so that no sample comes to lie at the fall itself, which is one
    return np.asarray(last / (count - 0.5) * np.arange(math.ceil(_LATER * count) + 1))


def _by_rk4(spec: TrajectorySpec, start: Array, times: Array) -> tuple[Array, float | None]:
    """Integrate one start by the kernels, with a step that keeps the energy.

    Returns the samples, shape (9, m), rows as in `motion_arrays.SAMPLES`, and the fall time [s], that of the
    last sample, or None if the disk did not fall.
    """
    samples = np.empty((len(motion_arrays.SAMPLES), times.size))
    step = 0.0 if isinstance(spec.step, str) else spec.step
    for refinement in range(_MOST_REFINEMENTS + 1):
        settings = np.array([step, _RELATIVE_STEP / 2**refinement, spec.fall_tilt])
        ending, filled, last, _ = _TRAJECTORY.load()(start, settings, times, samples)
        if ending == UNRESOLVED:
            continue
        drift = np.abs(_derived(start, samples[:, :filled])[motion_arrays.DERIVED_ENERGY_DRIFT]).max()
        if drift <= _DRIFT or step > 0.0 or refinement == _MOST_REFINEMENTS:
            return samples[:, :filled], (last if ending == FELL else None)
    raise RequestError(
        "This motion could not be resolved: its state must stay finite, and it may take at most "
        f"{MOST_STEPS} steps; gave up at {last:.6g} s.",
        hint="Give a shorter step or duration, slower rates, or a smaller fall_tilt.",
    )


def _by_dop853(spec: TrajectorySpec, start: Array, times: Array) -> tuple[Array, float | None]:
    """Integrate one start by SciPy, as `_by_rk4` does: the independent method that RK4 is compared with.

    Shares nothing with the kernels: tilt and rates with their sines and cosines, the heading, the roll angle, the
    contact point and the gain of vertical momentum, all integrated together from the textbook equations.
    """
    from scipy.integrate import solve_ivp

    def fall(_: float, y: Array, *system: float) -> float:
        return abs(float(y[0])) - float(spec.fall_tilt)

    fall.terminal = True  # type: ignore[attr-defined]  # read by solve_ivp
    system = tuple(start[[arrays.ALPHA, arrays.RADIUS, arrays.GRAVITY]])
    first = np.concatenate([start[: len(arrays.STATE)], np.zeros(5)])
    problem = None
    try:
        with np.errstate(over="raise", invalid="raise"):
            run = solve_ivp(
                _slope, (0.0, times[-1]), first, "DOP853", times,
                events=fall, args=system, rtol=_RELATIVE, atol=_ABSOLUTE,
            )  # fmt: skip
        problem = run.message if run.status < 0 else None
    except ArithmeticError as error:
        problem = error
    if problem is not None:
        raise RequestError(
            f"DOP853 could not resolve this motion: {problem}.",
            hint="Give a shorter duration, slower rates, or a smaller fall_tilt; or method=rk4.",
        )
    if not run.t_events[0].size:
        return run.y, None
    time = float(run.t_events[0][0])
    return np.column_stack([run.y[:, run.t < time], run.y_events[0][0]]), time


def _slope(_: float, y: Array, alpha: float, radius: float, gravity: float) -> list[float]:
    tilt, tilting, turning, rolling, heading = (float(each) for each in y[:5])
    sin, cos = math.sin(tilt), math.cos(tilt)
    push = 2.0 * gravity * sin + 2.0 * (1.0 + alpha) * radius * rolling * turning * cos
    push += (2.0 + alpha) * radius * turning**2 * sin * cos
    spin_up = tilting * (2.0 * (1.0 + alpha) * rolling * sin - (2.0 + alpha) * turning * cos**2)
    return [
        tilting,
        push / ((2.0 + alpha) * radius),
        -2.0 * rolling * tilting / cos,
        spin_up / ((1.0 + alpha) * cos),
        turning,
        rolling,
        -radius * rolling * math.sin(heading),
        radius * rolling * math.cos(heading),
        radius**2 * rolling * tilting * cos,
    ]


def _derived(start: Array, samples: Array) -> Array:
    results = np.empty((len(motion_arrays.DERIVED), samples.shape[1]))
    _DERIVED.load()(start, np.ascontiguousarray(samples[: len(arrays.STATE)]), results)
    return results


def _variables(
    spec: TrajectorySpec, start: Array, samples: Array, derived: Array
) -> dict[str, npt.NDArray[Any]]:
    values = dict(zip(motion_arrays.SAMPLES, samples, strict=True))
    gained = values.pop("momentum_gained")
    energy, drift, momentum, momentum_rate, normal, across, along, needed = derived
    radius, weight = spec.radius, spec.mass * spec.gravity
    lean = radius * np.sin(values["tilt"])
    slips = np.where(needed > spec.friction, SLIPS, ROLLS)
    return values | {
        "centre_x": values["contact_x"] + lean * np.cos(values["heading"]),
        "centre_y": values["contact_y"] + lean * np.sin(values["heading"]),
        "centre_z": radius * np.cos(values["tilt"]),
        "energy": weight * radius * energy,
        "energy_drift": drift,
        "vertical_momentum": spec.mass * momentum,
        "vertical_momentum_rate": spec.mass * momentum_rate,
        "vertical_momentum_residual": spec.mass * (momentum - momentum[0] - gained),
        "normal_force": weight * normal,
        "friction_across": weight * across,
        "friction_along": weight * along,
        "friction_needed": needed,
        "contact": np.where(normal > 0.0, slips, LIFTS).astype(np.int8),
    }


def _dataset(
    spec: TrajectorySpec, times: Array, values: dict[str, npt.NDArray[Any]], command: str
) -> "xr.Dataset":
    import xarray as xr

    fixed = {
        name: _variable(MOTION_INPUTS[name], getattr(spec, name), (), coordinate=True) for name in _FIXED
    }
    variables = {
        name: _variable(TRAJECTORY[name], value, (TIME.name,) if value.ndim else ())
        for name, value in values.items()
    }
    time = _variable(TIME, times, (TIME.name,), coordinate=True)
    return xr.Dataset(variables, {TIME.name: time} | fixed, _attributes(spec, command))


def _variable(
    quantity: Quantity, values: Any, dims: tuple[str, ...], coordinate: bool = False
) -> "xr.Variable":
    import xarray as xr

    measured = quantity.dtype.startswith("f") and not coordinate
    encoding: dict[str, Any] = {"dtype": quantity.dtype, "_FillValue": FILL if measured else None}
    attributes = quantity.attributes()
    if dims:
        encoding |= {"zlib": True, "complevel": COMPRESSION, "shuffle": True}
    if not coordinate:
        encoding["coordinates"] = " ".join(_FIXED)
        attributes |= CONTENT
    if quantity.flags is not None:
        attributes["standard_name"] = "status_flag"
    if dims and not coordinate:
        attributes["cell_methods"] = f"{TIME.name}: point"
    return xr.Variable(dims, values, attributes, encoding)


def _attributes(spec: TrajectorySpec, command: str) -> dict[str, Any]:
    from importlib.metadata import version

    now = created()
    return {
        "Conventions": CONVENTIONS,
        "title": ascii_text(spec.title or "Motion of a rolling disk"),
        "summary": _SUMMARY,
        "keywords": "rolling disk, Euler's disk, nonholonomic dynamics, trajectory, contact forces",
        "references": DISK.words.references,
        "source": f"eulerdisk {__version__}, method {spec.method}",
        "software": SOFTWARE,
        "license": LICENSE,
        "citation": CITATION,
        "history": ascii_text(f"{now} {command}"),
        "date_created": now,
        "eulerdisk_trajectory_format": np.int32(FORMAT),
        "trajectory_request": spec.canonical(),
        "method": spec.method,
        "kernel_hash": code_hash([_MODULE]),
        "versions": json.dumps(
            {name: version(name) for name in ("numba", "llvmlite", "numpy", "scipy", "xarray", "netCDF4")},
            sort_keys=True,
        ),
    }
