"""The figure of one cell: its tilt over time, with what the atlas and its criterion say, and its path on the plane."""

import math

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from sweep.checks.explain import Explanation, departure
from sweep.figures.plots import STYLE
from sweep.figures.swing import Swing, swing
from sweep.schema import PARAMETERS, VARIABLES

#: Of a motion that returns, this many periods are drawn.
_PERIODS = 3.0

#: Width and height [in]: a journal's page is 7 wide.
_SIZE = (7.0, 2.9)

#: Okabe and Ito's blue and vermilion: apart for the colour-blind, and in grey.
_MOTION, _LIMIT = "#0072B2", "#D55E00"


def figure(explanation: Explanation) -> Figure:
    """Draw the motion of an explained cell.

    Parameters
    ----------
    explanation : Explanation
        Of a cell that has a motion.

    Returns
    -------
    matplotlib.figure.Figure
        On an Agg canvas. The curve is integrated anew, by SciPy; the extremes drawn are those of the atlas.
    """
    motion = swing(explanation.start, _shown_time(explanation), explanation.spec.fall_tilt)
    with matplotlib.rc_context(STYLE):
        drawn = Figure(figsize=_SIZE, layout="constrained")
        FigureCanvasAgg(drawn)
        left, right = drawn.subplots(1, 2, width_ratios=(1.7, 1.0))
        _draw_tilt(left, motion, explanation)
        _draw_path(right, motion)
        verdict = (VARIABLES["stability"].flags or {})[int(explanation.stored["stability"])]
        left.set_title(f"{verdict} by {explanation.spec.criterion}")
        right.set_title("path of the point of contact")
    return drawn


def _shown_time(explanation: Explanation) -> float:
    period, fall = explanation.stored["nutation_period"], explanation.stored["fall_time"]
    if np.isfinite(fall):
        # a little longer: the fall itself ends the curve
        return 1.01 * float(fall)
    if np.isfinite(period):
        return min(_PERIODS * float(period), explanation.spec.duration)
    return explanation.spec.duration


def _draw_tilt(axes: Axes, motion: Swing, explanation: Explanation) -> None:
    degrees = PARAMETERS["tilt"].plot_scale
    steady, limit = departure(explanation)
    axes.plot(motion.time, motion.tilt * degrees, color=_MOTION, label="tilt of the disk")
    for i, name in enumerate(("tilt_min", "tilt_max")):
        label = "extremes in the atlas" if i == 0 else None
        axes.axhline(
            explanation.stored[name] * degrees, color="0.25", linestyle=":", linewidth=1.0, label=label
        )
    low, high = axes.get_ylim()
    for side in (-1.0, 1.0):
        edge = (steady + side * limit) * degrees
        label = "limit of the criterion" if side > 0.0 else None
        # a limit far outside would flatten the curve
        if low - (high - low) <= edge <= high + (high - low):
            axes.axhline(edge, color=_LIMIT, linestyle="--", linewidth=1.2, label=label)
    axes.ticklabel_format(axis="y", useOffset=False)
    axes.set_xlabel("time (s)")
    axes.set_ylabel(r"tilt $\theta$ (deg)")
    axes.set_xlim(0.0, motion.time[-1])
    axes.margins(y=0.08)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=3, frameon=False, columnspacing=1.2)


def _draw_path(axes: Axes, motion: Swing) -> None:
    axes.plot(motion.x, motion.y, color=_MOTION)
    axes.plot(motion.x[0], motion.y[0], "o", color="black", markersize=4.0, label="start")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("x (m)")
    axes.set_ylabel("y (m)")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), frameon=False)
    span = max(float(np.ptp(motion.x)), float(np.ptp(motion.y)))
    if span == 0.0 or math.isnan(span):
        axes.set_xlim(-1.0, 1.0)
