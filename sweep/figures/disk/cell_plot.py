"""The figure of one cell: its tilt over time with the extremes and the limit of the criterion, and its path."""

import math
import textwrap
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from sweep.checks.explain import departure
from sweep.checks.explanation import Explanation
from sweep.errors import RequestError
from sweep.figures.disk.captions import caption_of_start, length_unit
from sweep.figures.disk.motion_plots import STAYS
from sweep.figures.panels_in_time import write_head
from sweep.figures.sheet import sheet
from sweep.model.disk.model import DISK
from sweep.motion.origin import words_of_start
from sweep.motion.request import TrajectorySpec
from sweep.motion.sampling import kind_of
from sweep.motion.trajectory import simulate

if TYPE_CHECKING:
    import xarray as xr

#: Number of nutation periods that are drawn.
_PERIODS = 3.0

_SAMPLES = 2000

#: Largest number of characters in a line of the title of the tilt: more would run into the other title.
_TITLE = 48

#: Width and height [in]; the text of a journal's page is 7 wide.
_SIZE = (7.0, 3.3)

#: Okabe and Ito's blue and vermilion, which remain distinguishable for the colour-blind and in greyscale print.
_MOTION, _LIMIT = "#0072B2", "#D55E00"


def figure(explanation: Explanation) -> Figure:
    """Draw the motion of an explained cell by `sweep.simulate`, with the extremes stored in the atlas.

    Raises
    ------
    RequestError
        If the cell has no motion, or a motion that cannot be integrated.
    """
    motion = _motion(explanation)
    with sheet(*_SIZE) as drawn:
        left, right = drawn.subplots(1, 2, width_ratios=(1.7, 1.0))
        _draw_tilt(left, motion, explanation)
        _draw_path(right, motion)
        verdict = DISK.variables["stability"].flag(explanation.stored["stability"])
        left.set_title(textwrap.fill(f"{verdict} by {explanation.spec.criterion}", _TITLE))
        right.set_title("path of the contact point")
        spec = explanation.spec
        caption = caption_of_start(explanation.start, spec.body if "body" in spec.model.options else "")
        write_head(drawn, spec.title or "The motion of one cell", caption)
        # the layout depends on the ticks, and the ticks on the layout: without this, wide ones push the labels off the
        # sheet
        drawn.draw_without_rendering()
    return drawn


def _motion(explanation: Explanation) -> "xr.Dataset":
    start, spec = explanation.start, explanation.spec
    if not all(map(math.isfinite, start.values())):
        given = ", ".join(f"{name}={value:g}" for name, value in start.items() if not math.isfinite(value))
        raise RequestError(
            f"This cell has no motion to draw: a motion needs finite initial rates; got {given}.",
            hint="Leave out --plot, or name another cell.",
        )
    time = _shown_time(explanation)
    words = {"duration": time, "interval": time / _SAMPLES, "fall_tilt": spec.fall_tilt}
    return simulate(TrajectorySpec.read(**words_of_start(spec, start) | words))


def _shown_time(explanation: Explanation) -> float:
    """Return the duration [s] that is drawn of a motion: some periods, or until it falls."""
    stored, exact, duration = explanation.stored, explanation.exact, explanation.spec.duration
    if math.isfinite(stored.get("fall_time", math.nan)):
        # slightly longer than the fall time, because the fall itself ends the curve
        return 1.01 * stored["fall_time"]
    # the exact reduction gives a period even for a cell that reached its time limit or was not computed
    known = (each["nutation_period"] for each in (stored, exact) if math.isfinite(each["nutation_period"]))
    return float(min(_PERIODS * next(known, math.inf), duration))


def _draw_tilt(axes: Axes, motion: "xr.Dataset", explanation: Explanation) -> None:
    degrees = DISK.parameters["tilt"].plot_scale
    steady, limit = departure(explanation.spec, explanation.start)
    time = motion["elapsed_time"].values
    axes.plot(
        time, motion["tilt"].values * degrees, color=_MOTION, label=f"tilt of the {kind_of(motion).called}"
    )
    extremes = [explanation.stored[name] * degrees for name in ("tilt_min", "tilt_max")]
    for i, extreme in enumerate(each for each in extremes if math.isfinite(each)):
        label = "extremes in the atlas" if i == 0 else None
        axes.axhline(extreme, color="0.25", linestyle=":", linewidth=1.0, label=label)
    low, high = axes.get_ylim()
    for side in (-1.0, 1.0):
        edge = (steady + side * limit) * degrees
        label = "limit of the criterion" if side > 0.0 else None
        # a limit far outside would flatten the curve
        if low - (high - low) <= edge <= high + (high - low):
            axes.axhline(edge, color=_LIMIT, linestyle="--", linewidth=1.2, label=label)
    axes.ticklabel_format(axis="y", useOffset=False)
    axes.set(xlabel="time (s)", ylabel=r"tilt $\theta$ (deg)", xlim=(0.0, time[-1]))
    axes.margins(y=0.08)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=3, frameon=False, columnspacing=1.2)


def _draw_path(axes: Axes, motion: "xr.Dataset") -> None:
    x, y, radius = motion["contact_x"].values, motion["contact_y"].values, float(motion["radius"])
    unit, factor = length_unit(radius)
    axes.plot(factor * x, factor * y, color=_MOTION)
    axes.plot(factor * x[0], factor * y[0], "o", color="black", markersize=4.0, label="start")
    axes.set(xlabel=f"x ({unit})", ylabel=f"y ({unit})")
    axes.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), frameon=False)
    stays = max(np.ptp(x), np.ptp(y)) <= STAYS * radius
    if stays:
        # show a point that stays in place on the scale of the disk
        ends = (-factor * radius, factor * radius)
        axes.set(xlim=ends, ylim=ends)
    axes.set_aspect("equal", adjustable="box" if stays else "datalim")
