"""The boundary points on a map and in the strip below it: which are drawn, where, and the legend."""

import math
import re

import numpy as np
import pytest
from figure_axes import ROLLING, map_and_strip, points, said_in
from messages import with_facts

import sweep
from sweep.figures import plots
from sweep.figures.drawing import MOST_POINTS, evenly, joined
from sweep.figures.look import Look

G_OVER_3R = 6.54


def test_boundary_is_the_atlas_s(atlases, panels):
    """Points and bars are the bracket's middle and ends, at the grid's tilts in degrees."""
    atlas = atlases["rolling"]
    rate, half = atlas["boundary_roll_rate"].values, atlas["boundary_roll_rate_halfwidth"].values
    has = np.isfinite(rate)
    [(x, y, bars)] = points(map_and_strip(panels["rolling"])[0])
    shown = np.isin(np.degrees(atlas["tilt"].values[has]), x)
    assert 10 < len(x) <= MOST_POINTS
    assert shown.sum() == len(x)
    np.testing.assert_allclose(y, rate[has][shown], rtol=1e-14)
    np.testing.assert_allclose(bars[0], (rate - half)[has][shown], rtol=1e-12)
    np.testing.assert_allclose(bars[1], (rate + half)[has][shown], rtol=1e-12)


def test_points_are_thinned_evenly():
    """Only as many points as can be distinguished are drawn, evenly spaced, including the first and the last."""
    for count in (*range(2, 8), MOST_POINTS, MOST_POINTS + 1, 39, 60, 90, 500):
        places = evenly(count)
        gaps = np.diff(places)
        assert len(places) == count or len(places) > MOST_POINTS / 2 - 1
        assert len(places) <= MOST_POINTS
        assert (places[0], places[-1]) == (0, count - 1)
        assert len(set(gaps[:-1])) <= 1
        assert gaps[-1] == pytest.approx(gaps[0], abs=gaps[0] / 2)


@pytest.mark.slow_lane
def test_the_legend_says_that_points_are_thinned():
    """A fine grid shows every fourth point, and the legend says so; a coarse one shows all."""
    spec = ROLLING.replace(tilt="0.01deg:0.5deg:90:log")
    drawn = plots.figure([sweep.run(spec)])
    [(x, _, _)] = points(drawn.axes[0])
    assert len(x) <= MOST_POINTS
    np.testing.assert_allclose(x[[0, -1]], [0.01, 0.5], rtol=1e-12)
    np.testing.assert_allclose(x[:-1], np.degrees(spec.tilt.array())[::4][: len(x) - 1], rtol=1e-12)
    assert with_facts(said_in(drawn), "RK4", "bracket", "every 4th")
    coarse = plots.figure([sweep.run(spec.replace(tilt="0.1deg:1deg:9"))])
    assert with_facts(said_in(coarse), "RK4", "bracket")
    assert not with_facts(said_in(coarse), "every")
    family = plots.figure([sweep.run(spec.replace(alpha="0.3,0.5"))], look=Look(family=True))
    assert with_facts(said_in(family), "bracket", "every 4th")


@pytest.mark.slow_lane
def test_a_strip_shows_its_points():
    """If the boundary is far from the analytic line, at a seventh of it, the strip follows the boundary."""
    for time in ("1.2s", "2s"):
        spec = ROLLING.replace(roll_rate="0.05:2:40", tilt="0.1deg:5deg:20")
        _, strip, _ = map_and_strip(
            plots.figure([sweep.reclassify(sweep.run(spec), f"fall_time < {time}")]).axes
        )
        [(_, ratio, bars)] = points(strip)
        low, high = strip.get_ylim()
        assert len(ratio) > 5
        assert low < bars.min() < bars.max() < high < 0.3


def test_a_point_far_from_the_line_does_not_stretch_the_strip():
    """If most of the boundary is near the analytic line, a point at half of it is outside the strip."""
    atlas = sweep.run(ROLLING.replace(tilt="0.01deg:0.2deg:10:log"))
    atlas["boundary_roll_rate"].values[0] *= 0.5
    _, strip, _ = map_and_strip(plots.figure([atlas]).axes)
    low, high = strip.get_ylim()
    assert 0.9 < low < 1.0 < high < 1.1


def test_strip_shows_the_deviation_from_the_line(panels):
    """In the strip, the analytic line is at 1, and the points are divided by it."""
    top, strip, _ = map_and_strip(panels["rolling"])
    [(x, y, _)], [(strip_x, ratio, _)] = points(top), points(strip)
    assert (x == strip_x).all()
    np.testing.assert_allclose(ratio, y / math.sqrt(G_OVER_3R), rtol=1e-12)
    assert strip.get_ylim()[0] < 1.0 < strip.get_ylim()[1]


def test_circling_shows_both_edges(atlases, panels):
    """The upper and the lower edge are distinguishable, and the lower one has enough height."""
    top, _, _ = map_and_strip(panels["circling"])
    (_, upper, _), (x, lower, _) = points(top)
    slow = atlases["circling"]["boundary_lower_precession_rate"].dropna("tilt")
    np.testing.assert_allclose(np.interp(np.degrees(slow["tilt"]), x, lower), slow.values, rtol=1e-12)
    assert upper.min() > lower.max()
    height = top.transData.transform([(0.0, value) for value in (0.0, 1.0, *top.get_ylim()[1:])])[:, 1]
    assert height[1] - height[0] > 0.15 * (height[2] - height[0])


def test_points_that_are_thinned_differently_have_one_entry():
    """The common legend of several maps has one entry for differently thinned points."""
    found = joined({"points, every 3rd": 1, "points, every 12th": 2, "other": 3})
    assert [*found.values()] == [1, 3]
    (label,) = with_facts(found, "points")
    assert not re.search(r"\d", label)
    assert joined({"points, every 3rd": 1, "other": 3}) == {"points, every 3rd": 1, "other": 3}
