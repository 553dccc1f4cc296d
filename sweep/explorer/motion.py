"""What the page draws of one motion: its samples in time, its ledger, and the words beside them.

The answer is a head, which JSON can hold, and float64 arrays. Those with one value for each sample:

``time`` [s]; ``tilt``, ``heading``, ``roll_angle`` [rad]; ``tilt_rate``, ``precession_rate``, ``roll_rate`` [rad/s];
``contact_x``, ``contact_y`` [m]; ``normal_force``, ``friction_across``, ``friction_along`` over the weight;
``friction_needed`` [1], NaN where the normal force is not positive; ``energy`` over m g R; with losses also
``rolling_loss``, ``pivoting_loss``, ``contour_loss``, ``damping_loss``, ``air_loss``: what each has taken since the
start, over m g R.

The head: ``title``, ``ending`` and ``note`` in words; ``start``, ``radius``, ``gravity``, ``alpha``; ``ended`` (whether
the disk fell or stopped), ``lossy``; of a motion without losses ``turns`` (pairs of a turning point and its words),
``period`` [s] and ``fall_tilt``, to which the page draws the potential; ``losses`` (the controls,
`sweep.explorer.losses`); ``ledger`` (words of each loss); ``quantities`` (label, unit and factor of each array).
"""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.errors import NoMotionError, RequestError
from sweep.explorer.losses import controls, has_motions, loss_words
from sweep.explorer.waiting import KERNELS
from sweep.model.disk.exact import EXTREMES
from sweep.model.disk.model import DISK
from sweep.model.lossy_disk.tables import NO_AIR
from sweep.model.quantity import Array
from sweep.motion import disk_path, lossy_path
from sweep.motion.request import MotionRequest, start_of
from sweep.motion.tables import DISK_MOTION, LAWS, LOSSY_MOTION, TRAJECTORY
from sweep.request.spec import SweepSpec

#: Periods that a motion without losses is followed, the shortest and the longest time [s].
_PERIODS, _SHORTEST, _LONGEST = 3.0, 6.0, 60.0

#: One with losses is followed to its end, but no longer than this [s].
_TO_THE_END = 120.0

#: Angle [rad] that the disk may turn in all at the rates of its start: a fast one is shown for a shorter time. Two
#: thousand samples without losses, and ten times as many on the way to a stop.
_TURNS, _TURNS_TO_THE_END = 400.0, 4000.0

#: Likewise the most units of its own time, sqrt(R/g): a coin at rest swings as often in a second as a wheel in ten.
_UNITS, _UNITS_TO_THE_END = 4e3, 4e4

#: Rates over sqrt(g/R) are smaller: the energy has their squares.
_LARGEST = 1e100

#: Values of words that a spec does not have.
_NONE = (None, 0.0, NO_AIR)

#: The least time [s] of a motion.
_LEAST = 1e-3

#: What the contact needs for the disk to roll all the time.
_LIFTS_OFF = "A real disk would leave the table on the way: its normal force vanishes."
_NEEDS = "Rolling without slipping needs a friction coefficient of"

_STATE = ("tilt", "tilt_rate", "precession_rate", "roll_rate")
_SAMPLES = (*_STATE, "heading", "roll_angle", "contact_x", "contact_y")
_FORCES = ("normal_force", "friction_across", "friction_along")

_WEIGHT_TIMES_RADIUS = "weight \u00d7 radius"

#: Arrays whose unit is not that of their variable in a file of one motion -> label and unit.
_SCALED: Mapping[str, tuple[str, str]] = {
    "normal_force": ("normal force", "weight"),
    "friction_across": ("friction across the track", "weight"),
    "friction_along": ("friction along the track", "weight"),
    "energy": ("energy", _WEIGHT_TIMES_RADIUS),
    "potential": ("potential \u2212 energy", _WEIGHT_TIMES_RADIUS),
    **{name: (words, _WEIGHT_TIMES_RADIUS) for name, words in LAWS.items()},
}


def motion(
    spec: SweepSpec,
    start: Mapping[str, float],
    duration: float | None = None,
    losses: Mapping[str, float | str] | None = None,
    begun: Callable[[Array], None] = lambda times: None,
) -> tuple[dict[str, Any], dict[str, Array]]:
    """Return what the page draws of one motion.

    Parameters
    ----------
    spec : SweepSpec
        Of the cells of the window: it has the settings.
    start : mapping of str to float
        Every parameter of its model [SI].
    duration : float, optional
        Time [s] to follow it; by default some periods, or to its fall or stop.
    losses : mapping of str to number or text, optional
        Words of losses, in SI: with any of them the motion is one with losses.
    begun : callable
        As that of `sweep.motion.disk_path.follow`.

    Returns
    -------
    (head, arrays)
        See the module.

    Raises
    ------
    NoMotionError
        If the start has no motion.
    RequestError
        If a word or a number is not possible.

    Notes
    -----
    It calls kernels, beside the maps: those that follow one motion have one thread.
    """
    check_start(spec, start)
    words = words_of(spec, start, losses or {})
    lossy = is_lossy(spec, losses or {})
    exact = {} if lossy else _exact(spec, start)
    request = MotionRequest.read(**words, duration=_duration(start, exact, duration, lossy))
    path = lossy_path if lossy else disk_path
    times, values = path.follow(request, start_of(request), begun)
    arrays = _arrays(request, times, values)
    head = _head(spec, request, start, values, float(times[-1]))
    head |= {"losses": controls(spec, start, losses or {}), "ledger": LAWS if lossy else None}
    return head | _turns(request, exact), arrays


def make_ready(spec: SweepSpec, losses: Mapping[str, Any]) -> None:
    """Compile what `motion` calls with these words, if it is not kept on disk; raises as `check_start` does."""
    _check_model(spec)
    lossy = is_lossy(spec, losses)
    for kernel in lossy_path.KERNELS if lossy else (EXTREMES, *disk_path.KERNELS):
        kernel.make_ready()


def is_lossy(spec: SweepSpec, losses: Mapping[str, Any]) -> bool:
    """Return whether a motion has losses: those of its cells, or words that ask for some."""
    return spec.model is LOSSY_MOTION.model or bool(loss_words(losses))


def words_of(spec: SweepSpec, start: Mapping[str, float], losses: Mapping[str, Any]) -> dict[str, Any]:
    """Return the words of a request for the motion of a cell, all but its duration.

    Parameters
    ----------
    spec : SweepSpec
        It has the settings: the tilt at which the disk has fallen, or is flat, among them.
    start : mapping of str to float
        Every parameter of its model [SI].
    losses : mapping of str to number or text
        As for `motion`.

    Raises
    ------
    RequestError
        If a name is none of a loss.
    """
    words: dict[str, Any] = dict(start) | {name: getattr(spec, name) for name in spec.constants}
    lost = loss_words(losses)
    has_losses = spec.model is LOSSY_MOTION.model
    if has_losses:
        words |= {name: getattr(spec, name) for name in spec.model.options}
    fall = (LOSSY_MOTION if has_losses or lost else DISK_MOTION).largest_tilt
    if hasattr(spec, fall):
        words[fall] = getattr(spec, fall)
    if has_losses and losses:
        lost = lost or dict(losses)
        # what a law needs is added where the cells have none of it
        lost = {name: each for name, each in lost.items() if name in losses or words.get(name) in _NONE}
        if lost.get("air_law", words.get("air_law")) == NO_AIR:
            words |= dict.fromkeys(("air_viscosity", "air_density"), 0.0)
    return words | lost


def quantities() -> dict[str, dict[str, Any]]:
    """Return the label, the unit as people read it, and the factor from SI of every array of a motion."""
    found: dict[str, dict[str, Any]] = {
        "time": {"label": "time", "unit": "s", "factor": 1.0},
        "friction_needed": {"label": "friction needed", "unit": "", "factor": 1.0},
    }
    found |= {name: {"label": label, "unit": unit, "factor": 1.0} for name, (label, unit) in _SCALED.items()}
    for name in _SAMPLES:
        each = TRAJECTORY[name]
        label = name.replace("_", " ")
        found[name] = {
            "label": label,
            "unit": each.shown_units.replace(" s-1", "/s"),
            "factor": each.plot_scale,
        }
    return found


def stored_motions(spec: SweepSpec) -> dict[str, Any] | None:
    """Return what an exported page needs to integrate motions itself; None but for the disk without losses."""
    if spec.model is not DISK_MOTION.model:
        return None
    words = {"lifts_off": _LIFTS_OFF, "needs": _NEEDS}
    return {"fall_tilt": spec.fall_tilt, "quantities": quantities(), "words": words}


def check_start(spec: SweepSpec, start: Mapping[str, float]) -> None:
    """Refuse a start that has no motion.

    Raises
    ------
    NoMotionError
        If the model has no motions in time, a rate was to keep the tilt constant and none does, or a parameter is
        beyond its limits, as some at the border of a map are.
    RequestError
        If the energy of it is no number.
    """
    _check_model(spec)
    none = [name for name in _STATE if not math.isfinite(start[name])]
    if none:
        raise NoMotionError(
            f"Here is no motion: no {none[0]} keeps this tilt constant.",
            hint="Choose another place of the map.",
            where=none[0],
        )
    for name, known in DISK.parameters.items():
        if not known.allows(np.array([start[name]]))[0]:
            raise NoMotionError(
                f"Here is no motion: it needs {known.rule}; got {known.spell(start[name])}.",
                hint="Choose another place of the map.",
                where=name,
            )
    unit = _unit(start)
    for name in _STATE:
        if not abs(start[name]) * (1.0 if name == "tilt" else unit) < _LARGEST:
            raise RequestError(
                f"Here is no motion: {name} is so large that its energy is no number.",
                hint="Choose another place of the map, or a smaller number.",
                where=name,
            )


def _check_model(spec: SweepSpec) -> None:
    if not has_motions(spec):
        raise NoMotionError(
            f"The model {spec.model.name} has no motions in time here; the disk has, with losses and without.",
            where="model",
        )


def _unit(start: Mapping[str, float]) -> float:
    """Return the disk's own unit of time, sqrt(R/g) [s]."""
    return math.sqrt(start["radius"]) / math.sqrt(start["gravity"])


def _exact(spec: SweepSpec, start: Mapping[str, float]) -> dict[str, float]:
    """Return what the exact reduction knows of a motion without losses."""
    rows = {name: np.array([value]) for name, value in start.items()}
    assert DISK.exact is not None
    with KERNELS:
        found = DISK.exact.measures(spec, rows)
    return {name: float(values[0]) for name, values in found.items()}


def _duration(
    start: Mapping[str, float], exact: Mapping[str, float], asked: float | None, lossy: bool
) -> float:
    rate = sum(abs(start[name]) for name in _STATE[1:])
    most = (_TURNS_TO_THE_END if lossy else _TURNS) / rate if rate > 0.0 else math.inf
    most = min(most, (_UNITS_TO_THE_END if lossy else _UNITS) * _unit(start))
    if asked is not None:
        return min(max(asked, _LEAST), most)
    if lossy:
        return min(_TO_THE_END, most)
    period = exact["nutation_period"]
    # a disk that falls is followed to its fall, whenever that is
    without = _LONGEST if exact["ending"] == DISK.endings.code("fell") else _SHORTEST
    wanted = _PERIODS * period if math.isfinite(period) else without
    return min(max(wanted, _SHORTEST), _LONGEST, most)


def _arrays(request: MotionRequest, times: Array, values: Mapping[str, npt.NDArray[Any]]) -> dict[str, Array]:
    """Return the arrays with one value for each sample."""
    mass = 1.0 if isinstance(request.mass, str) else request.mass
    weight = mass * request.gravity
    found = {"time": times} | {name: values[name] for name in _SAMPLES}
    found |= {name: values[name] / weight for name in _FORCES}
    found |= {"friction_needed": values["friction_needed"]}
    taken = ("energy", *(LAWS if request.kind is LOSSY_MOTION else ()))
    return found | {name: values[name] / (weight * request.radius) for name in taken}


def _head(
    spec: SweepSpec,
    request: MotionRequest,
    start: Mapping[str, float],
    values: Mapping[str, Any],
    last: float,
) -> dict[str, Any]:
    kind = request.kind
    ending = kind.variables["ending"].flag(float(values["ending"]))
    ended = ending in kind.endings
    at = ", ".join(
        f"{name.replace('_', ' ')} {kind.model.parameters[name].spell(start[name], 6)}"
        for name in spec.axes
        if name in start
    )
    return {
        "title": at,
        "ending": f"{kind.endings[ending]} at {last:.4g} s" if ended else f"followed for {last:.3g} s",
        "ended": ended,
        "note": _limit_words(values, values["normal_force"]),
        "lossy": kind is LOSSY_MOTION,
        "start": {name: start[name] for name in _STATE},
        **{name: start[name] for name in ("alpha", "radius", "gravity")},
        "quantities": quantities(),
    }


def _limit_words(values: Mapping[str, Any], normal: Array) -> str:
    """Return what the contact needs for the disk to roll all the time."""
    needed = values["friction_needed"]
    if not (normal > 0.0).all():
        return _LIFTS_OFF
    return f"{_NEEDS} {float(np.nanmax(needed)):.3g}."


def _turns(request: MotionRequest, exact: Mapping[str, float]) -> dict[str, Any]:
    """Return what the head says of the swing of a motion without losses, of which the reduction knows all."""
    if request.kind is LOSSY_MOTION:
        return {"turns": [], "period": None, "fall_tilt": None}
    bounded = exact["ending"] == DISK.endings.code("bounded")
    turns = [exact[name] for name in ("tilt_min", "tilt_max")] if bounded else []
    period = exact["nutation_period"]
    return {
        # as the numbers of the point beside it
        "turns": [[turn, TRAJECTORY["tilt"].spell(turn, 6)] for turn in turns],
        "period": period if math.isfinite(period) else None,
        "fall_tilt": request.fall_tilt,
    }
