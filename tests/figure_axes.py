"""Small sweeps to draw, and the lines, points and words on their axes."""

import numpy as np
from matplotlib.container import ErrorbarContainer

import sweep

ROLLING = sweep.SweepSpec.preset("rolling").replace(roll_rate="2:4:41", tilt="0.01deg:4deg:30:log")
SPINNING = sweep.SweepSpec.preset("spinning").replace(precession_rate="3:6:41", tilt="0.01deg:4deg:30:log")
CIRCLING = sweep.SweepSpec.preset("circling").replace(tilt="1deg:30deg:30", precession_rate="0.05:5:41")


def line(axes, start):
    """Return x and y of the line whose label starts with `start`."""
    found = [each for each in axes.get_lines() if str(each.get_label()).startswith(start)]
    return found[0].get_xydata().T


def points(axes):
    """Return the error bars of an axes: (x, y, ends of the bars) of each set of points."""
    sets = [each for each in axes.containers if isinstance(each, ErrorbarContainer)]
    return [(*each[0].get_data(), np.array(each[2][0].get_segments())[:, :, 1].T) for each in sets]


def words(axes):
    """Return the texts of an axes and its legend."""
    legend = axes.get_legend()
    inside = [text.get_text() for text in axes.texts]
    found = inside + ([text.get_text() for text in legend.get_texts()] if legend else [])
    # Non-breaking spaces keep a number and its unit together.
    return [each.replace("\u00a0", " ") for each in found]


def said_in(drawn):
    """Return all texts and legends of a figure."""
    return [each for axes in drawn.axes for each in words(axes)]


def map_and_strip(axes):
    """Return the map, the strip below it and the second axis of a one-panel figure."""
    top, strip, *_ = axes
    assert "analytic" in strip.get_ylabel()
    return top, strip, top.child_axes[0]
