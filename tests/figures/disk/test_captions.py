"""The captions of motions: disk, start, and lengths in suitable units."""

import math
import re

import pytest
from messages import assert_facts

import sweep
from sweep.figures.disk.captions import caption, caption_of_start, length_unit, nice_length, spell_length

pytestmark = pytest.mark.compiled


def test_a_motion_says_disk_and_start():
    """Zero rates are left out, even with rounding errors; gravity is given only if unusual."""
    for words, facts in (
        ({"radius": "12mm", "tilt": "1deg"}, ["R = 12 mm", "α = 0.5", "tilt 1 deg", "rest"]),
        (
            {"alpha": 1.0, "roll_rate": 6.0, "tilt_rate": 0.5},
            ["R = 0.5 m", "α = 1", "tilt 0 deg", "tilt rate 0.5 rad/s", "roll rate 6 rad/s"],
        ),
        (
            {"radius": "50m", "gravity": 1.62, "precession_rate": -0.25, "tilt": "-3deg"},
            ["R = 50 m", "α = 0.5", "g = 1.62 m/s²", "tilt -3 deg", "precession rate -0.25 rad/s"],
        ),
    ):
        motion = sweep.simulate(**words, duration=0.2)
        text = caption(motion)
        assert_facts(text, *facts)
        # there are no other numbers
        assert len(re.findall(r"\d+(?:\.\d+)?", text)) == len([each for each in facts if each != "rest"])
        start = {name: float(motion[name]) for name in ("alpha", "radius", "gravity")}
        state = {
            name: float(motion[name][0]) for name in ("tilt", "tilt_rate", "precession_rate", "roll_rate")
        }
        assert caption_of_start(start | state) == text


def test_a_stretch_says_where_it_begins():
    """The caption of a part of a motion gives the state at its first sample."""
    motion = sweep.simulate(roll_rate=3.0, duration=4.0).isel(elapsed_time=slice(500, None))
    assert_facts(caption(motion), "R = 0.5 m", "α = 0.5", "from 2 s", "tilt 0 deg", "roll rate 3 rad/s")
    assert "start" not in caption(motion)


def test_lengths_have_the_unit_that_suits_them():
    """Units range from micrometers to kilometers."""
    for value, text in (
        (0.012, "12 mm"),
        (0.5, "0.5 m"),
        (50.0, "50 m"),
        (1e-3, "1 mm"),
        (2e-5, "20 µm"),
        (2e4, "20 km"),
        (0.0, "0 µm"),
    ):
        assert spell_length(value) == text
        assert length_unit(-value) == length_unit(value)


def test_squares_have_round_sides():
    """Sides of squares are 1, 2 or 5 times a power of ten, and at most the requested length."""
    for most, length in ((0.0137, 0.01), (2.0, 2.0), (4.99, 2.0), (7.0, 5.0), (123.0, 100.0)):
        assert math.isclose(nice_length(most), length)
