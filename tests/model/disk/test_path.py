"""The path of the contact point of a thin disk: whether it closes, and after how many nutations."""

import math

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

import sweep
from sweep.model.disk.path import CLOSED_PATH, MOST_NUTATIONS

#: A disk that nutates by tens of degrees.
SPEC = sweep.SweepSpec(tilt="20deg", tilt_rate=0.3, roll_rate=5.0, path="yes", method="exact")


def nutation(precession, alpha=0.5):
    """Return the atlas of one start."""
    return sweep.run(SPEC.replace(precession_rate=precession, alpha=alpha))


def test_a_disk_goes_where_a_motion_in_time_does():
    """The ring's radii match a motion in time, for a disk and a hoop; path=yes changes no other result."""
    for alpha in (0.5, 1.0):
        ring, plain = (
            nutation(1.5, alpha),
            sweep.run(SPEC.replace(precession_rate=1.5, alpha=alpha, path="no")),
        )
        assert plain.tilt_max.item() == ring.tilt_max.item()
        assert "path_class" not in plain
        motion = sweep.simulate(
            tilt="20deg", tilt_rate=0.3, roll_rate=5.0, precession_rate=1.5, alpha=alpha, duration="60s"
        )
        apart = np.hypot(*(motion[f"contact_{axis}"].values - ring[f"ring_{axis}"].item() for axis in "xy"))
        assert apart.min() == pytest.approx(ring.ring_inner.item(), abs=1e-4)
        assert apart.max() == pytest.approx(ring.ring_outer.item(), abs=1e-4)
        period = ring.nutation_period.item()
        turned = CubicSpline(motion.elapsed_time.values, motion.heading.values)([0.0, period])
        assert turned[1] - turned[0] == pytest.approx(ring.heading_per_nutation.item(), abs=1e-6)


def test_a_path_that_closes_is_told_with_its_ratio():
    """At a rate found by root search it closes after five nutations and two turns; nearby it is annular."""

    def off(precession):
        return nutation(precession).heading_per_nutation.item() + 0.8 * math.pi

    rate = brentq(off, 6.0, 7.9, xtol=1e-14)
    atlas = nutation(rate)
    told = [atlas[name].item() for name in ("path_class", "closing_nutations", "closing_turns")]
    assert told == [CLOSED_PATH, 5, -2]
    period = atlas.nutation_period.item()
    motion = sweep.simulate(
        tilt="20deg",
        tilt_rate=0.3,
        roll_rate=5.0,
        precession_rate=rate,
        duration=6 * period,
        interval=period / 1000,
    )
    for k in (0, 300, 700):
        places = [[motion[f"contact_{axis}"].values[k + each] for axis in "xy"] for each in (0, 2000, 5000)]
        assert math.dist(places[0], places[2]) < 1e-6
        assert math.dist(places[0], places[1]) > 1e-2
    beside = nutation(rate + 1e-5)
    assert beside.path_class.item() == 1
    assert beside.closing_nutations.item() == 5
    gained = beside.heading_per_nutation.item()
    assert beside.closing_angle.item() == pytest.approx(abs(5.0 * gained + 4.0 * math.pi), abs=1e-12)
    assert beside.closing_angle.item() > 1e-7


def test_the_nearest_whole_turns():
    """The number of nutations is the one with the smallest angle, by brute force; 0 if nothing nutates."""
    atlas = sweep.run(SPEC.replace(precession_rate="-3:12:60"))
    for cell in range(60):
        gained, count, turns, angle = (
            atlas[name].values[cell]
            for name in ("heading_per_nutation", "closing_nutations", "closing_turns", "closing_angle")
        )
        if atlas.path_class.values[cell] == 0:
            assert (count, turns) == (0, 0)
            assert np.isnan(angle)
            continue
        left = {q: abs(math.remainder(q * gained, 2.0 * math.pi)) for q in range(1, MOST_NUTATIONS + 1)}
        assert count == min(left, key=left.get)
        assert angle == pytest.approx(left[count], abs=1e-12)
        assert turns == round(count * gained / (2.0 * math.pi))
    assert (atlas.path_class == 0).any()
    assert (atlas.path_class == 1).any()
    assert sweep.findings(sweep.verify(atlas)).agreeing == 60
