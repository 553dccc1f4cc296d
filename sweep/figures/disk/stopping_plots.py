"""Figures of a motion that loses energy: how it ends, and which loss takes the energy when."""

import math
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from sweep.checks.explanation import Explanation
from sweep.errors import RequestError
from sweep.figures.disk.captions import spell_length
from sweep.figures.disk.losses_map import COLOURS
from sweep.figures.disk.motion_plots import draw_panels, draw_picture
from sweep.figures.panels_in_time import label_times, legend_above
from sweep.figures.scales import set_log_ticks
from sweep.figures.sheet import sheet
from sweep.figures.texts import number
from sweep.model.lossy_disk.model import LOSSY_DISK
from sweep.model.quantity import Array, Truths
from sweep.motion.lossy_tables import COEFFICIENTS, LAWS, LOSSY_TRAJECTORY
from sweep.motion.origin import words_of_start
from sweep.motion.request import MotionRequest
from sweep.motion.sampling import closely_sampled, end_of, ending_of, is_of_body, kind_of, request_of
from sweep.motion.tables import TIME
from sweep.motion.theory import WobbleLoss, flat_time, wobble_losses, wobbles
from sweep.motion.trajectory import simulate

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

#: Colour of the remaining energy.
_LEFT = "0.9"

_MOTION: dict[str, Any] = {"color": "black", "linewidth": 1.0}
_OTHER: dict[str, Any] = {"color": "#c8380a", "linewidth": 1.0}

#: Least share of the lost energy that a law must have taken to appear in the figure.
_LEAST_SHARE = 1e-3

#: Largest path of the centre, in radii, for which the picture shows only the start and the end.
_NEAR = 1.0

#: Largest number of decades of the remaining time on an axis.
_DECADES = 6.0

#: Length of a guide on either side of the place where its law takes most [decades], and the distance of its text from
#: the curve, as a factor.
_REACH, _BESIDE = 0.55, 1.25

#: Least part of the power that a law must take somewhere to get a guide; the margin around the curve, as a factor.
_LEAST_PART, _ROOM = 0.1, 2.0

#: Inclination [rad] above which a disk does not wobble; the panels of the end start after it.
_UPRIGHT = 1.0


def figure(dataset: "xr.Dataset") -> Figure:
    """Draw one motion with losses: the disk, tilt and rates over time, where its energy went, and how it ended.

    Parameters
    ----------
    dataset : xarray.Dataset
        A motion with losses, as `sweep.simulate` returns it, or an interval of it.

    Returns
    -------
    matplotlib.figure.Figure
        A figure on an Agg canvas, not registered with pyplot. It has no panels of the end for motions that do not
        become flat in a wobble, and for bodies other than a thin disk.

    Raises
    ------
    RequestError
        If the dataset is not a motion.
    """
    motion = closely_sampled(dataset)
    draws = [draw_inclination, draw_rates, draw_ledger]
    # for thick bodies, the end has no power law, and the remaining time no closed form
    if wobbles(motion) and not is_of_body(motion):
        draws += [
            partial(_draw_end, name="inclination", share=Fraction(1)),
            partial(_draw_end, name="precession_rate", share=Fraction(-1, 2)),
        ]
    rows = (len(draws) + 1) // 2
    with sheet(7.2, 7.6 if rows == 3 else 5.4) as drawn:
        grid = drawn.add_gridspec(rows, 2)
        draw_picture(drawn.add_subplot(grid[0, 0]), motion, _moments(motion))
        draw_panels(drawn, [grid[i // 2, i % 2] for i in range(1, 2 * rows)], draws, motion)
    return drawn


def _moments(dataset: "xr.Dataset") -> Array | None:
    """Return the start and the end time of a motion that stays in its place; None if the disk travels."""
    radius, times = float(dataset["radius"]), dataset[TIME.name].values
    spread = max(float(np.ptp(dataset[name].values)) for name in ("centre_x", "centre_y"))
    return times[[0, -1]] if spread < _NEAR * radius else None


def laws_of(dataset: "xr.Dataset") -> list[str]:
    """Return the losses that took energy in a motion, in the order of the ledger."""
    lost = {name: float(dataset[name][-1] - dataset[name][0]) for name in LAWS}
    return [name for name, energy in lost.items() if energy > _LEAST_SHARE * max(sum(lost.values()), 0.0)]


def draw_inclination(axes: "Axes", dataset: "xr.Dataset") -> None:
    """Draw the inclination over time; for a disk that does not become flat, the tilt, which has a sign."""
    quantity = LOSSY_TRAJECTORY["inclination" if ending_of(dataset) == "flat" else "tilt"]
    values = dataset[quantity.name].values * quantity.plot_scale
    axes.plot(dataset[TIME.name].values, values, label=end_of(dataset) or "not at its end yet", **_MOTION)
    if quantity.name == "inclination":
        axes.set_ylim(bottom=0.0)
    label_times(axes, dataset, quantity.plot_label)


def draw_rates(axes: "Axes", dataset: "xr.Dataset") -> None:
    """Draw the rates over time; if the disk becomes flat, the rate of the wobble and the disk's own turning rate.

    Near flat, the roll rate is minus the precession rate, and their small sum is the turning of the disk.
    """
    times = dataset[TIME.name].values
    tilt, precession, roll = (dataset[name].values for name in ("tilt", "precession_rate", "roll_rate"))
    axes.plot(
        times, precession, label=rf"precession ${LOSSY_TRAJECTORY['precession_rate'].symbol}$", **_MOTION
    )
    if ending_of(dataset) == "flat":
        label = f"turning of the {kind_of(dataset).called} itself about the vertical"
        axes.plot(times, precession + roll * np.sin(tilt), label=label, **_OTHER)
    else:
        axes.plot(times, roll, label=rf"roll ${LOSSY_TRAJECTORY['roll_rate'].symbol}$", **_OTHER)
    label_times(axes, dataset, r"rate (rad s$^{-1}$)")


def draw_ledger(axes: "Axes", dataset: "xr.Dataset") -> None:
    """Draw the energy that each law has taken over time, stacked on the remaining energy: the sum is constant."""
    times, laws = dataset[TIME.name].values, laws_of(dataset)
    lost = [dataset[name].values - dataset[name].values[0] for name in laws]
    energy = dataset["energy"].values
    unit, factor = _energy_unit(float(energy[0]))
    total = max(sum(each[-1] for each in lost), 1e-300)
    labels = [
        f"{_law(dataset, name)}: {100.0 * each[-1] / total:.0f} %"
        for name, each in zip(laws, lost, strict=True)
    ]
    axes.stackplot(
        times, [factor * each for each in (*lost, energy)], labels=[*labels, "left"],
        colors=[*(COLOURS[name] for name in laws), _LEFT], linewidth=0.0,
    )  # fmt: skip
    axes.axhline(factor * energy[0], label="energy and losses together", color="black", linewidth=1.0)
    axes.set_ylim(0.0, 1.06 * factor * float(energy[0]))
    label_times(axes, dataset, f"energy ({unit})")


def _draw_end(axes: "Axes", dataset: "xr.Dataset", name: str, share: Fraction) -> None:
    """Draw a variable of the wobble against the remaining time, with the slope of each law.

    `share` is the variable's exponent divided by the exponent of the inclination.
    """
    quantity = LOSSY_TRAJECTORY[name]
    end = _end_of_wobble(dataset)
    left = flat_time(end) - end[TIME.name].values
    values = np.abs(end[name].values) * quantity.plot_scale
    shown = (left > left[0] * 10.0**-_DECADES) & (values > 0.0)
    left, values = left[shown], values[shown]
    axes.plot(left, values, label="motion", **_MOTION)
    axes.set(xscale="log", yscale="log", xlabel=r"remaining time $t_f - t$ (s)", ylabel=quantity.plot_label)
    # the axis need not show the guides completely
    axes.set_ylim(values.min() / _ROOM, values.max() * _ROOM)
    for loss, parts in _parts_of_power(end, shown):
        if parts.max() >= _LEAST_PART:
            _draw_guide(axes, loss, parts, left, values, share)
    for axis, (low, high) in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
        set_log_ticks(axis, high / low)
    legend_above(axes)


def _end_of_wobble(dataset: "xr.Dataset") -> "xr.Dataset":
    """Return the part of a motion in which its disk is no longer upright."""
    upright = np.flatnonzero(dataset["inclination"].values > _UPRIGHT)
    first = int(upright[-1]) + 1 if upright.size else 0
    return dataset.isel({TIME.name: slice(min(first, dataset.sizes[TIME.name] - 2), None)})


def _parts_of_power(dataset: "xr.Dataset", shown: Truths) -> list[tuple[WobbleLoss, Array]]:
    """Return each law with its part of the total power at the samples that are shown, by the closed forms."""
    inclination = dataset["inclination"].values[shown]
    losses = [each for each in wobble_losses(dataset) if each.name in laws_of(dataset)]
    powers = [each.coefficient * inclination ** -float(each.power) for each in losses]
    return [(each, power / sum(powers)) for each, power in zip(losses, powers, strict=True)]


def _draw_guide(
    axes: "Axes", loss: WobbleLoss, parts: Array, left: Array, values: Array, share: Fraction
) -> None:
    """Draw the slope of a law next to the curve, where the law takes its largest part of the power."""
    strong = np.flatnonzero(parts >= 0.999 * parts.max())
    # the middle, on the axis, of the interval in which the law is about equally strong
    at = math.sqrt(left[strong[0]] * left[strong[-1]])
    slope = loss.exponent * share
    ends = (at * 10.0 ** np.array([-_REACH, _REACH])).clip(left.min(), left.max())
    near = (left >= ends[0]) & (left <= ends[1])
    # above all oscillations of the curve
    level = float((values[near] / (left[near] / at) ** float(slope)).max())
    words = f"slope {slope} of {LAWS[loss.name]}".replace("-", "\u2212")
    beside = _BESIDE * level * (ends / at) ** float(slope)
    axes.plot(ends, beside, color=COLOURS[loss.name], linewidth=1.6, linestyle=(0, (4, 1.5)), label=words)


def _energy_unit(energy: float) -> tuple[str, float]:
    """Return the unit in which energies of this size [J] are shown, and the factor from joules to the unit."""
    return ("J", 1.0) if energy >= 1.0 else ("mJ", 1e3) if energy >= 1e-3 else ("\u00b5J", 1e6)


def _law(dataset: "xr.Dataset", name: str) -> str:
    """Return a loss law with its coefficient, as text."""
    if name == "air_loss":
        return f"{LAWS[name]} ({request_of(dataset).air_law.capitalize()})"
    parameter, unit = COEFFICIENTS[name]
    value = float(dataset[parameter])
    return f"{LAWS[name]} {spell_length(value) if unit == 'm' else f'{number(value)} {unit}'}"


def figure_of_cell(explanation: Explanation) -> Figure:
    """Draw the motion of an explained cell by `sweep.simulate`, with its verdict in the title.

    Raises
    ------
    RequestError
        If the cell has no motion, or a motion that cannot be integrated.
    """
    return figure(motion_of(explanation))


def motion_of(explanation: Explanation) -> "xr.Dataset":
    """Return the motion of an explained cell, at most for the duration of its atlas; raises as `figure_of_cell`."""
    spec = explanation.spec
    verdict = LOSSY_DISK.variables["stability"].flag(explanation.stored["stability"])
    start = words_of_start(spec, explanation.start)
    impossible = [name for name in ("precession_rate", "roll_rate") if not abs(start[name]) < float("inf")]
    if impossible:
        raise RequestError(
            f"This cell has no motion to draw: no {' and no '.join(impossible)} keeps its tilt constant.",
            hint="Leave out --plot, or name another cell.",
        )
    settings = {name: getattr(spec, name) for name in ("duration", "step", "flat_tilt")}
    title = f"{spec.title or 'The motion of one cell'}: {verdict} by {spec.criterion}"
    return simulate(MotionRequest.read(**start, **settings, title=title))
