"""Motions of a user's system: their words and variables, and how they are integrated, by the passes of a sweep.

A sample is what a sweep would find of a cell that is followed until then: so each has the stated errors of a cell.
"""

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from kernels.system.endings import DIFFERENT, FAILURES, FIRST_EVENT, RUNS_ON, UNRESOLVED
from sweep.errors import NoMotionError
from sweep.model.kernel import Kernel
from sweep.model.quantity import ERROR_GAUGE, Array, Quantity, Tolerance, Word, table
from sweep.model.system import tables
from sweep.model.system.definition import Definition
from sweep.model.system.model import SystemModel
from sweep.model.system.passes import PASSES, Passes
from sweep.model.system.spelling import spelled
from sweep.motion.request import MotionRequest
from sweep.motion.tables import MOTION_INPUTS, TIME, MotionKind
from sweep.request.words import AUTOMATIC

#: No kernel belongs to all systems.
KERNELS: tuple[Kernel, ...] = ()

#: With interval=auto: samples for each step of the last pass, and their largest number. A step at the tolerance of the
#: default turns a circle by some 0.6 rad, so that samples are about 0.12 rad apart.
_IN_A_STEP, _MOST_SAMPLES = 5, 200_000

#: Share of the steps of all passes that the last one makes: each takes 100^(1/12) times as many as the one before.
_OF_LAST = 0.42


def motion_of_system(model: SystemModel) -> MotionKind:
    """Return the kind of the motions of a system, from its definition."""
    definition = model.definition
    time = replace(TIME, units=definition.time_units)
    interval = replace(MOTION_INPUTS["interval"], units=time.units)
    endings = {each.name.replace("_", " "): each.name.replace("_", " ") for each in definition.ends}
    title = model.words.summary.partition(":")[0]
    return MotionKind(
        model=model,
        inputs=table(*model.parameters.values(), *model.settings.values(), interval),
        words=table(
            Word("title", "what the motion is, in one line", ""),
            Word("method", "how the motion is integrated", "taylor", ("taylor",)),
        ),
        variables=_variables(definition, model),
        fixed=tuple(each.name for each in definition.parameters),
        largest_tilt="",
        ending_time=tables.END_TIME,
        endings=endings,
        headline=f"Motion: {definition.title}" if definition.title else f"Motion of the system {model.name}",
        summary=f"One motion of the system {title}: its states and measures in time, each with its stated error.",
        path=__name__,
        kernels="kernels.system.path",
        figure="sweep.figures.system_motion:figure",
        peaks=(),
        results=(*(each.name for each in definition.measures), *(["label"] if definition.labels else [])),
        turning=(),
        keywords="ordinary differential equations, trajectory",
        # what the passes find, and what follows from it
        sample_size=16 * len(model.measures),
        time=time,
        called="system",
    )


def _variables(definition: Definition, model: SystemModel) -> dict[str, Quantity]:
    states = [(each.name, each.units, each.name) for each in definition.states]
    measures = [(each.name, each.units, f"{each.text} until then") for each in definition.measures]
    rows = []
    for name, units, words in (*states, *measures):
        within = Tolerance(0.0, 1e-9, "each value is within its stated error", tables.stated(name))
        rows.append(Quantity(name, "", units, words.replace("_", " "), within))
        error = f"stated error of {name.replace('_', ' ')}"
        rows.append(Quantity(tables.stated(name), "", units, error, ERROR_GAUGE, "", "f4"))
    if definition.conserved:
        words = "largest relative change of what is conserved, since the start"
        rows.append(Quantity("conserved_change", "", "1", words, ERROR_GAUGE, "", "f4"))
    if definition.labels:
        rows.append(model.variables["label"])
    end = model.variables[tables.END_TIME]
    missing = f"missing where nothing ended it: ending is {tables.RUNNING}"
    rows += [
        model.endings.quantity,
        replace(end, long_name="time of the ending", description=missing),
        model.variables[tables.stated(tables.END_TIME)],
        Quantity(
            "sensitive_from", "", end.units, "time from which the motion is too sensitive to its start to be known",
            ERROR_GAUGE, "passes with different tolerances are apart from then on; missing where they stay together",
        ),
    ]  # fmt: skip
    return dict(table(*rows))


def follow(spec: MotionRequest, start: Array) -> tuple[Array, dict[str, npt.NDArray[Any]]]:
    """Return the times of the samples [time], shape (n,), and the variables of the file.

    Parameters
    ----------
    spec : MotionRequest
    start : array
        That of `start_of`.

    Raises
    ------
    RequestError
        If the motion has ended before it starts, or cannot be followed.
    """
    times = spec.times
    measured = _followed(spec, start, times)
    _check_goes_on(spec, measured)
    if spec.interval == AUTOMATIC:
        last = _end(measured)
        # at the end itself is the last column, which stands at the duration
        count = max(times.size - 1, min(_MOST_SAMPLES, int(_IN_A_STEP * _OF_LAST * measured["steps"][-1])))
        times = np.append(np.linspace(0.0, last, count + 1)[:-1], spec.duration)
        measured = _followed(spec, start, times)
    end = _end(measured)
    shown = np.append(times[:-1] < end, True)
    measured = {name: each[shown] for name, each in measured.items()}
    times = np.append(times[shown][:-1], end)
    return times, _columns(spec, start, times, measured)


def _followed(spec: MotionRequest, start: Array, times: Array) -> dict[str, npt.NDArray[Any]]:
    """Return what the passes find until each time; the last column is their own end."""
    model = spec.kind.model
    told = f"motions of the system {model.name}"
    kernel = replace(model.integrate, module=spec.kind.kernels, seconds=4.0, told=told)
    measures = np.full((len(model.measures), times.size), np.nan)
    counts = np.full((len(model.counts), times.size), UNRESOLVED, np.int32)
    step = 0.0 if isinstance(spec.step, str) else spec.step
    settings = np.array([spec.duration, step, spec.tolerance])
    kernel.load()(start[:, np.newaxis].copy(), settings, times, measures, counts)
    return dict(zip((*model.measures, *model.counts), (*measures, *counts), strict=True))


def _end(measured: dict[str, npt.NDArray[Any]]) -> float:
    return float(measured[f"{PASSES[-1]}: {tables.END_TIME}"][-1])


def _check_goes_on(spec: MotionRequest, measured: dict[str, npt.NDArray[Any]]) -> None:
    """Refuse a motion that ends where it begins, and one that cannot be followed to its end."""
    definition: Definition = spec.kind.model.definition  # type: ignore[attr-defined]  # of a SystemModel
    last = [measured[f"{name}: ending"] for name in PASSES[-2:]]
    failed = [np.isin(each, FAILURES) for each in last]
    if failed[0][-1] or failed[1][-1]:
        which = 1 if failed[1][-1] else 0
        until = float(measured[f"{PASSES[which - 2]}: {tables.END_TIME}"][-1])
        why = spec.kind.model.endings.of(last[which][-1])
        beyond = f" beyond {spec.kind.time.spell(until, 6)}" if until > 0.0 else " from its start on"
        shorter = "" if "shorter duration" in why.help else ", or give a shorter duration"
        raise NoMotionError(
            f"This motion could not be followed{beyond}: {why.reason}.",
            hint=f"{why.help}{shorter}.",
        )
    if _end(measured) == 0.0:
        event = definition.ends[last[1][-1] - FIRST_EVENT]
        condition = " or ".join(f"{spelled(each)} > 0" for each in event.any_positive)
        given = " ".join(f"{each.name}={getattr(spec, each.name):.6g}" for each in definition.states)
        raise NoMotionError(
            f"This motion has ended before it starts: a motion ends with {event.name} where {condition}; got {given} "
            "in SI.",
            hint="Start elsewhere.",
        )


def _columns(
    spec: MotionRequest, start: Array, times: Array, measured: dict[str, npt.NDArray[Any]]
) -> dict[str, npt.NDArray[Any]]:
    """Return the variables of the file: what a sweep would say of a cell that is followed until each sample."""
    model: SystemModel = spec.kind.model  # type: ignore[assignment]  # no other model has this path
    starts = {name: np.full(times.size, value) for name, value in zip(model.parameters, start, strict=True)}
    passes = Passes(model.definition, model.endings, starts, measured, spec.duration, spec.tolerance)
    found = dict(passes.columns())
    for each in model.definition.states:
        at_end = each.name + tables.AT_END
        found |= {each.name: found[at_end], tables.stated(each.name): found[tables.stated(at_end)]}
    same = np.flatnonzero(found["ending"] != DIFFERENT)
    # the passes may part on the way and meet again
    since = same[-1] + 1 if same.size else 0
    runs_on = measured[f"{PASSES[-1]}: ending"][-1] == RUNS_ON
    found |= {
        "sensitive_from": np.array(times[since] if since < times.size else np.nan),
        tables.END_TIME: np.array(np.nan if runs_on else times[-1]),
    }
    for name in ("ending", "label", tables.stated(tables.END_TIME)):
        if name in found:
            found[name] = np.asarray(found[name][-1])
    return {name: np.asarray(found[name], quantity.dtype) for name, quantity in spec.kind.variables.items()}
