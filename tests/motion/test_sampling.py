"""Figures of motions use close samples, even if the dataset has coarse ones."""

import json

import numpy as np
import pytest
import xarray as xr
from messages import refused

import sweep
from sweep.motion.sampling import check_motion, closely_sampled, is_motion

pytestmark = pytest.mark.compiled

WORDS = {"tilt_rate": 0.01, "roll_rate": 2.0}


@pytest.fixture(scope="module")
def motion():
    """Return a motion with the default samples."""
    return sweep.simulate(**WORDS)


def test_close_samples_are_left_alone(motion):
    """A default motion, a fall, and a motion with closer samples are drawn as they are."""
    for each in (motion, sweep.simulate(tilt="1deg"), sweep.simulate(**WORDS, interval=0.002)):
        assert closely_sampled(each) is each


def test_samples_are_far_where_the_disk_turns_by_more_than_a_quarter_between_them():
    """An upright spinning disk turns evenly: 0.24 rad between samples is close, 0.26 rad is recomputed."""
    for rate, is_close in ((2.4, True), (2.6, False)):
        spun = sweep.simulate(precession_rate=rate, duration="100s", interval=0.1)
        assert (closely_sampled(spun) is spun) == is_close, rate


def test_far_samples_are_computed_again(motion):
    """One sample per second, or every fiftieth sample, becomes the default sampling of the same motion."""
    coarse = sweep.simulate(**WORDS, interval=1.0)
    for each in (coarse, motion.isel(elapsed_time=slice(None, None, 50))):
        found = closely_sampled(each)
        np.testing.assert_array_equal(found["elapsed_time"], motion["elapsed_time"])
        np.testing.assert_array_equal(found["tilt"], motion["tilt"])


def test_a_few_samples_are_too_few():
    """Six samples that hardly differ would still be drawn as a polygon: a thousand are computed."""
    coarse = sweep.simulate(tilt_rate=0.5, roll_rate=2.0, duration=0.1, interval=0.02)
    assert coarse.sizes["elapsed_time"] == 6
    assert closely_sampled(coarse).sizes["elapsed_time"] == 1001


def test_a_period_between_samples_is_not_taken_for_rest():
    """If a nutation returns at every sample, all tilts are equal, but it is still resampled."""
    atlas = sweep.run(sweep.SweepSpec(tilt="1deg", roll_rate=3.0))
    period = float(atlas["nutation_period"])
    coarse = sweep.simulate(tilt="1deg", roll_rate=3.0, duration=40.0 * period, interval=period)
    assert np.abs(np.diff(coarse["tilt"].values)).max() < 1e-6
    assert np.ptp(closely_sampled(coarse)["tilt"].values) > 0.9 * float(atlas["tilt_max"] - atlas["tilt_min"])


def test_a_stretch_stays_one(motion):
    """A part with coarse samples gets close ones between its first and last time; close ones are kept."""
    part = sweep.simulate(**WORDS, interval=0.5).isel(elapsed_time=slice(4, 8))
    found = closely_sampled(part)
    assert found["elapsed_time"].values[[0, -1]].tolist() == [2.0, 3.5]
    assert found.sizes["elapsed_time"] == 151
    short = motion.isel(elapsed_time=slice(100, 103))
    assert closely_sampled(short) is short


def test_a_file_is_a_motion(motion, tmp_path):
    """A saved and reopened motion is still recognized."""
    sweep.save(motion, tmp_path / "path.nc")
    with xr.open_dataset(tmp_path / "path.nc") as read:
        assert is_motion(read)
        assert closely_sampled(read) is read


def test_what_cannot_be_drawn_is_refused(motion):
    """Each refusal says what is missing."""
    for change, facts in [
        (lambda motion: motion.drop_attrs(), ["motion"]),
        (lambda motion: motion.drop_vars(["contact_x", "radius"]), ["missing", "contact_x, radius"]),
        (lambda motion: motion.isel(elapsed_time=0), ["two samples", "1"]),
        (lambda motion: motion.isel(elapsed_time=[]), ["two samples", "0"]),
        (lambda motion: motion.assign_attrs(trajectory_request="{"), ["trajectory_request"]),
        (
            lambda motion: motion.assign_attrs(trajectory_request="[1]"),
            ["trajectory_request"],
        ),
    ]:
        with refused(*facts):
            closely_sampled(change(motion))


def test_an_atlas_is_no_motion():
    """An atlas has no motion request."""
    atlas = sweep.run(sweep.SweepSpec(roll_rate="2:4:3"))
    assert not is_motion(atlas)
    with refused("motion", "dataset of"):
        check_motion(atlas)
    assert json.loads(sweep.simulate(**WORDS).attrs["trajectory_request"])["roll_rate"] == 2.0
