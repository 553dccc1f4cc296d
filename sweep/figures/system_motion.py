"""Figures of motions of systems: every state over time, a phase portrait if there are few states, and how it ended."""

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from sweep.checks.explanation import Explanation
from sweep.errors import plain_text
from sweep.figures.panels_in_time import (
    MOTION,
    SHADE,
    label_axes,
    label_times,
    thin_panels,
    widened,
    write_head,
)
from sweep.figures.sheet import sheet
from sweep.model.description import Model
from sweep.model.system.cell_values import evaluated
from sweep.model.system.definition import TIME as CLOCK
from sweep.model.system.definition import Definition, Node, symbols
from sweep.motion.request import MotionRequest
from sweep.motion.sampling import closely_sampled, end_of, ending_of, kind_of, peaks_of
from sweep.motion.tables import TIME, MotionKind
from sweep.motion.trajectory import simulate

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

#: Width of a figure, height of its heading, of the time axis below its panels, and of each panel [in].
_WIDTH, _HEAD, _FOOT, _PANEL = 7.2, 0.9, 0.45, 1.25

#: Least total height of the panels [in]: the height of a portrait, or of the panel of a single state.
_LEAST = 2.6

#: Largest number of states for which the first two get a phase portrait.
_FEW = 4

#: How far beyond the motion an event is still shown, as a share of the height of the motion.
_NEAR = 0.25

#: A power in a unit as files write it, and superscript digits for print.
_POWER = re.compile(r"(?<=[A-Za-z])-?\d")
_RAISED = str.maketrans("-0123456789", "\u207b\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079")

_EVENT: dict[str, Any] = {"color": "#c8380a", "linewidth": 0.9, "linestyle": (0, (4, 2))}
_END: dict[str, Any] = {"marker": "o", "linestyle": "", "color": "#c8380a", "markersize": 4.0, "zorder": 4}
_START: dict[str, Any] = {**_END, "color": "black", "markerfacecolor": "white"}


def figure(dataset: "xr.Dataset") -> Figure:
    """Draw the motion of a system: its states over time, and a phase portrait of the first two if there are few.

    Parameters
    ----------
    dataset : xarray.Dataset
        A motion of a system, as `sweep.simulate` returns it, or an interval of it.

    Returns
    -------
    matplotlib.figure.Figure
        A figure on an Agg canvas, not registered with pyplot.

    Raises
    ------
    RequestError
        If the dataset is not a motion.
    """
    motion = closely_sampled(dataset)
    kind = kind_of(motion)
    definition: Definition = kind.model.definition  # type: ignore[attr-defined]  # of a SystemModel
    names = [each.name for each in definition.states]
    portrait = 2 <= len(names) <= _FEW
    columns = 2 if len(names) > _FEW else 1
    rows = -(-len(names) // columns)
    with sheet(_WIDTH, _HEAD + _FOOT + max(_LEAST, rows * _PANEL)) as drawn:
        grid = drawn.add_gridspec(
            rows, 2 if portrait else columns, width_ratios=(1.15, 1.0) if portrait else None
        )
        panels: list[Axes] = []
        for number, name in enumerate(names):
            lowest = number // columns == rows - 1 or number + columns >= len(names)
            panels.append(drawn.add_subplot(grid[number // columns, number % columns]))
            _draw_state(panels[-1], motion, kind, name, lowest)
        if portrait:
            panels.append(drawn.add_subplot(grid[:, 1]))
            _draw_portrait(panels[-1], motion, kind, names[0], names[1])
        drawn.align_ylabels(panels[: len(names)])
        write_head(drawn, plain_text(motion.attrs.get("title", "")), _caption(motion, kind, names))
        thin_panels(panels)
    return drawn


def figure_of_cell(explanation: Explanation) -> Figure:
    """Draw the motion of an explained cell by `sweep.simulate`, with its verdict in the title.

    Raises
    ------
    RequestError
        If the cell has no motion.
    """
    spec = explanation.spec
    verdict = spec.model.variables["stability"].flag(explanation.stored["stability"])
    settings = {name: getattr(spec, name) for name in spec.model.settings}
    title = f"{spec.title or 'The motion of one cell'}: {verdict} by {spec.criterion}"
    words = {**explanation.start, **settings, "title": title, "model": spec.model}
    return figure(simulate(MotionRequest.read(**words)))


def _draw_state(axes: "Axes", motion: "xr.Dataset", kind: MotionKind, name: str, lowest: bool) -> None:
    """Draw a state over time, the levels of events that only this state decides, and the end."""
    first = next(iter(kind.model.parameters))
    quantity, times = kind.variables[name], motion[TIME.name].values
    values = motion[name].values * quantity.plot_scale
    axes.plot(times, values, **MOTION)
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    room = _NEAR * (high - low)
    seen = [
        (event, level * quantity.plot_scale)
        for event, level in _levels(motion, kind.model, name)
        if low - room <= level * quantity.plot_scale <= high + room
    ]
    for number, (event, level) in enumerate(seen):
        axes.axhline(level, label=event if event not in dict(seen[:number]) else None, **_EVENT)
    since = float(motion["sensitive_from"])
    if since <= times[-1]:
        shade: dict[str, Any] = {"color": SHADE, "linewidth": 0.0, "zorder": 0}
        axes.axvspan(
            max(since, times[0]),
            widened(times)[1],
            label="too sensitive to its start" if name == first else None,
            **shade,
        )
    if _has_ended(motion):
        axes.plot(times[-1], values[-1], **_END)
    label_times(axes, motion, quantity.plot_label)
    axes.set_xlabel(
        f"{TIME.name.replace('_', ' ')} ({kind.time.shown_units})".removesuffix(" ()") if lowest else ""
    )
    axes.tick_params(axis="x", labelbottom=lowest)


def _draw_portrait(axes: "Axes", motion: "xr.Dataset", kind: MotionKind, across: str, up: str) -> None:
    """Draw one state against another, with start and end."""
    one, other = kind.variables[across], kind.variables[up]
    x, y = motion[across].values * one.plot_scale, motion[up].values * other.plot_scale
    axes.plot(x, y, **{**MOTION, "linewidth": 0.8})
    axes.plot(x[0], y[0], label="start", **_START)
    axes.plot(x[-1], y[-1], label=_end(motion, kind), **_END)
    if one.units == other.units:
        axes.set_aspect("equal", adjustable="datalim")
    label_axes(axes, one.plot_label, other.plot_label)


def _has_ended(motion: "xr.Dataset") -> bool:
    return bool(float(motion["end_time"]) <= motion[TIME.name].values[-1])


def _end(motion: "xr.Dataset", kind: MotionKind) -> str:
    """Return what the last sample is: the end of the motion, or the moment up to which it was followed."""
    if _has_ended(motion) and ending_of(motion) in kind.endings:
        return end_of(motion)
    return f"at {kind.time.spell(float(motion[TIME.name].values[-1]), 6)}"


def _levels(motion: "xr.Dataset", model: Model, name: str) -> Iterator[tuple[str, float]]:
    """Yield the events that only one state decides, linearly, and the value of the state at which they occur."""
    definition: Definition = model.definition  # type: ignore[attr-defined]  # of a SystemModel
    names = {each.name for each in definition.states}
    fixed = {each.name: float(motion[each.name]) for each in definition.parameters}

    def at(node: Node, value: float) -> float:
        return float(evaluated([node], {**fixed, name: value})[0])

    for event in definition.ends:
        for node in event.any_positive:
            if (names | {CLOCK}) & {*symbols(node)} != {name}:
                continue
            first, slope = at(node, 0.0), at(node, 1.0) - at(node, 0.0)
            if slope != 0.0 and abs(at(node, 2.0) - first - 2.0 * slope) <= 1e-12 * (abs(first) + abs(slope)):
                yield event.name, -first / slope


def _caption(motion: "xr.Dataset", kind: MotionKind, names: list[str]) -> str:
    """Return the parameters, the start, the extremes and the end of the motion, in one line."""
    times = motion[TIME.name].values
    fixed = [_spell(name, kind.inputs[name].spell(float(motion[name]), 6)) for name in kind.fixed]
    start = [_spell(name, kind.variables[name].spell(float(motion[name][0]), 6)) for name in names]
    reached = [_spell(name, value) for name, value in peaks_of(motion)]
    if "conserved_change" in motion:
        reached.append(f"conserved to {float(motion['conserved_change'].max()):.1g}")
    reached.append(end_of(motion) or _spell("runs on after", kind.time.spell(float(times[-1]), 6)))
    when = "start" if times[0] == 0.0 else "first sample"
    return "; ".join(filter(None, (", ".join(fixed), f"{when}: {', '.join(start)}", ", ".join(reached))))


def _spell(name: str, value: str) -> str:
    """Return a name with its value, with powers in units as in print."""
    value = _POWER.sub(lambda power: power[0].translate(_RAISED), value)
    return f"{name.replace('_', ' ')} {value}"
