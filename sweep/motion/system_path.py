"""Motions of a user's system: their words and variables, and their integration by the passes of a sweep.

A sample has the values of a cell of a sweep whose duration ends at that time, so it has the stated errors of a cell.
"""

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from kernels.system.endings import DIFFERENT, FAILURES, FIRST_EVENT, RUNS_ON, UNRESOLVED
from sweep.errors import NoMotionError
from sweep.model.quantity import ERROR_GAUGE, Array, Quantity, Tolerance, table
from sweep.model.system import tables
from sweep.model.system.definition import Definition
from sweep.model.system.model import SystemModel
from sweep.model.system.passes import PASSES, Passes
from sweep.model.system.spelling import spelled
from sweep.motion.request import MotionRequest
from sweep.motion.tables import MOTION_INPUTS, TIME, TITLE, MotionKind
from sweep.request.words import AUTOMATIC

_KERNELS = "kernels.system.path"

#: With interval=auto: number of samples per step of the last pass, and the largest number of samples. With the default
#: tolerance a step covers about 0.6 rad of a circle, so samples are about 0.12 rad apart.
_IN_A_STEP, _MOST_SAMPLES = 5, 200_000

#: Steps of the last pass over the steps of all passes: each takes 100^(1/12) times as many as the one before.
_OF_LAST = 0.42


def motion_of_system(model: SystemModel) -> MotionKind:
    """Return the kind of the motions of a system, from its definition."""
    definition = model.definition
    time = replace(TIME, units=definition.time_units)
    interval = replace(MOTION_INPUTS["interval"], units=time.units)
    endings = {event.name.replace("_", " "): event.name.replace("_", " ") for event in definition.ends}
    title = definition.title.rstrip(".") or model.name
    return MotionKind(
        model=model,
        inputs=table(*model.parameters.values(), *model.settings.values(), interval),
        words=table(TITLE),
        variables=_variables(definition, model),
        fixed=tuple(parameter.name for parameter in definition.parameters),
        largest_tilt="",
        ending_time=tables.END_TIME,
        endings=endings,
        headline=f"Motion: {definition.title}" if definition.title else f"Motion of the system {model.name}",
        summary=f"One motion of the system {title}: its states and measures in time, each with its stated error.",
        path=__name__,
        kernels=(_KERNELS,),
        figure="sweep.figures.system_motion:figure",
        method="taylor",
        peaks=(),
        results=(
            *(measure.name for measure in definition.measures),
            *(["label"] if definition.labels else []),
        ),
        turning=(),
        keywords="ordinary differential equations, trajectory",
        # the output of the passes, and the variables derived from it
        sample_size=16 * len(model.measures),
        time=time,
        called="system",
    )


def _variables(definition: Definition, model: SystemModel) -> dict[str, Quantity]:
    states = [(state.name, state.units, state.name, "") for state in definition.states]
    measures = [
        (measure.name, measure.units, f"{measure.text} so far", tables.comment(measure))
        for measure in definition.measures
    ]
    rows = []
    for name, units, words, description in (*states, *measures):
        within = Tolerance(0.0, 1e-9, "each value is within its stated error", tables.stated(name))
        rows.append(Quantity(name, "", units, words.replace("_", " "), within, description))
        error = f"stated error of {name.replace('_', ' ')}"
        rows.append(Quantity(tables.stated(name), "", units, error, ERROR_GAUGE, "", "f4"))
    if definition.conserved:
        words = "largest relative change of a conserved quantity since the start"
        rows.append(Quantity("conserved_change", "", "1", words, ERROR_GAUGE, "", "f4"))
    if definition.labels:
        rows.append(model.variables["label"])
    end = model.variables[tables.END_TIME]
    missing = f"missing if no event ended the motion: ending is {tables.RUNNING}"
    rows += [
        model.endings.quantity,
        replace(end, long_name="time of the ending", description=missing),
        model.variables[tables.stated(tables.END_TIME)],
        Quantity(
            "sensitive_from", "", end.units, "time from which the motion is too sensitive to its start to be known",
            ERROR_GAUGE, "passes with different tolerances differ from then on; missing if they agree to the end",
        ),
    ]  # fmt: skip
    return dict(table(*rows))


def follow(spec: MotionRequest, start: Array) -> tuple[Array, dict[str, npt.NDArray[Any]]]:
    """Return the times of the samples [time], shape (n,), and the variables of the file.

    Parameters
    ----------
    spec : MotionRequest
    start : array
        As from `start_of`.

    Raises
    ------
    RequestError
        If the motion has ended before it starts, or cannot be computed to its end.
    """
    times = spec.times
    measured = _integrate(spec, start, times)
    _check_resolved(spec, measured)
    if spec.interval == AUTOMATIC:
        last = _end(measured)
        # the last column is the end of the motion; its time in `times` is the duration
        count = max(times.size - 1, min(_MOST_SAMPLES, int(_IN_A_STEP * _OF_LAST * measured["steps"][-1])))
        times = np.append(np.linspace(0.0, last, count + 1)[:-1], spec.duration)
        measured = _integrate(spec, start, times)
    end = _end(measured)
    shown = np.append(times[:-1] < end, True)
    measured = {name: values[shown] for name, values in measured.items()}
    times = np.append(times[shown][:-1], end)
    return times, _columns(spec, start, times, measured)


def _integrate(spec: MotionRequest, start: Array, times: Array) -> dict[str, npt.NDArray[Any]]:
    """Return the output of the passes at each time; the last column is at their end."""
    model = spec.kind.model
    kernel = replace(
        model.integrate,
        module=_KERNELS,
        seconds=4.0,
        told=f"motions of the system {model.name}",
    )
    measures = np.full((len(model.measures), times.size), np.nan)
    counts = np.full((len(model.counts), times.size), UNRESOLVED, np.int32)
    step = 0.0 if isinstance(spec.step, str) else spec.step
    settings = np.array([spec.duration, step, spec.tolerance])
    kernel.load()(start[:, np.newaxis].copy(), settings, times, measures, counts)
    return dict(zip((*model.measures, *model.counts), (*measures, *counts), strict=True))


def _end(measured: dict[str, npt.NDArray[Any]]) -> float:
    return float(measured[f"{PASSES[-1]}: {tables.END_TIME}"][-1])


def _check_resolved(spec: MotionRequest, measured: dict[str, npt.NDArray[Any]]) -> None:
    """Refuse a motion that ends where it begins, or that cannot be computed to its end."""
    definition: Definition = spec.kind.model.definition  # type: ignore[attr-defined]  # of a SystemModel
    last = [measured[f"{name}: ending"] for name in PASSES[-2:]]
    failed = [np.isin(ending, FAILURES) for ending in last]
    if failed[0][-1] or failed[1][-1]:
        which = 1 if failed[1][-1] else 0
        until = float(measured[f"{PASSES[which - 2]}: {tables.END_TIME}"][-1])
        why = spec.kind.model.endings.of(last[which][-1])
        beyond = f" beyond {spec.kind.time.spell(until, 6)}" if until > 0.0 else " from its start on"
        shorter = "" if "shorter duration" in why.help else ", or give a shorter duration"
        raise NoMotionError(
            f"This motion could not be computed{beyond}: {why.reason}.",
            hint=f"{why.help}{shorter}.",
        )
    if _end(measured) == 0.0:
        event = definition.ends[last[1][-1] - FIRST_EVENT]
        condition = " or ".join(f"{spelled(node)} > 0" for node in event.any_positive)
        given = " ".join(f"{state.name}={getattr(spec, state.name):.6g}" for state in definition.states)
        raise NoMotionError(
            f"This motion has ended before it starts: the ending {event.name} has the condition {condition}; got "
            f"{given} in SI.",
            hint="Start elsewhere.",
        )


def _columns(
    spec: MotionRequest, start: Array, times: Array, measured: dict[str, npt.NDArray[Any]]
) -> dict[str, npt.NDArray[Any]]:
    """Return the variables of the file: each sample has the values of a cell with that duration."""
    model: SystemModel = spec.kind.model  # type: ignore[assignment]  # no other model has this path
    starts = {name: np.full(times.size, value) for name, value in zip(model.parameters, start, strict=True)}
    passes = Passes(model.definition, model.endings, starts, measured, spec.duration, spec.tolerance)
    columns = dict(passes.columns())
    for state in model.definition.states:
        at_end = state.name + tables.AT_END
        columns |= {state.name: columns[at_end], tables.stated(state.name): columns[tables.stated(at_end)]}
    same = np.flatnonzero(columns["ending"] != DIFFERENT)
    # the passes may differ for a while and agree again
    since = same[-1] + 1 if same.size else 0
    runs_on = measured[f"{PASSES[-1]}: ending"][-1] == RUNS_ON
    columns |= {
        "sensitive_from": np.array(times[since] if since < times.size else np.nan),
        tables.END_TIME: np.array(np.nan if runs_on else times[-1]),
    }
    for name in ("ending", "label", tables.stated(tables.END_TIME)):
        if name in columns:
            columns[name] = np.asarray(columns[name][-1])
    return {name: np.asarray(columns[name], quantity.dtype) for name, quantity in spec.kind.variables.items()}
